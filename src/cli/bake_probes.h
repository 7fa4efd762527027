// sheen bake --probes: light around points of a lattice, as files that three.js has a use for.
#pragma once

#include "cli/bake_options.h"
#include "core/ranks.h"
#include "rays/tracer.h"

namespace sheen::cli {

/// Usage error for outputs and options that are of lightmaps, and for what says no lattice.
void checkProbeOptions(const BakeOptions& o);

/// Bakes and writes them, on the job's first rank; `load`: seconds that loading took.
void runProbes(const BakeOptions& o, const Tracer& tracer, const RankedJob& job, double load);

}  // namespace sheen::cli
