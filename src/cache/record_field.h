// Records as they were gathered.
#pragma once

#include <vector>

#include "gather/gatherer.h"

namespace sheen {

/// All that was gathered for a view. It outlives passes: how far its records reach, and so by how
/// much their gradients may change what they say, is each pass's own.
struct RecordField {
    std::vector<GatheredRecord> records;  ///< as gathered
    std::vector<int> pixels;              ///< that they lie at
};

}  // namespace sheen
