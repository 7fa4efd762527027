// Gathering shared out over ranks: a site's record depends on the site alone, so that it does not
// matter who gathers it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/ranks.h"
#include "gather/gatherer.h"

namespace sheen {

/// On the first rank: what has sites gathered by all, `own` this rank's share; `own` itself where
/// there is one rank alone. `told`: asked for once, what the others make theirs of. Records that
/// live for some frames (lookAheadBy()) it does not know. The job must outlive it.
std::unique_ptr<Gatherer> gatherByAll(std::unique_ptr<Gatherer> own, const RankedJob& job,
                                      const std::function<std::string()>& told);

/// Makes what gathers of what the first rank told. The one before is gone by then.
using MakeGatherer = std::function<std::unique_ptr<Gatherer>(const std::string& told)>;

/// On the others: gathers what is asked for until the first rank ends.
void serveGathers(const RankedJob& job, const MakeGatherer& make);

}  // namespace sheen
