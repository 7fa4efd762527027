// Sites, and what was found there, as bytes for another process of the same build, or for later.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gather/gatherer.h"

namespace sheen {

std::string bytesOf(std::span<const RecordSite> sites);
std::vector<RecordSite> sitesOf(const std::string& bytes);

/// Records that do not live for some frames (Gatherer::lookAheadBy()).
std::string bytesOf(std::span<const GatheredRecord> records);
std::vector<GatheredRecord> recordsOf(const std::string& bytes);

}  // namespace sheen
