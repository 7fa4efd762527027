// Two images that are compared, and what of them.
#pragma once

#include <string>

#include "cli/output.h"
#include "image/exr.h"
#include "metrics/compare.h"

namespace sheen::cli {

/// What the layers of indirect light and of caustics hold together; of a file without the second,
/// the first holds it.
constexpr const char* kGlobal = "indirect+caustic";

struct ComparedPair {
    LoadedExr test, reference;
    Image<vec3> of_test, of_reference;
    Image<vec3> variance;  ///< of the reference; empty where it does not know it

    /// Input error for files that cannot be read, lack the layer, or have other light in it.
    ComparedPair(const std::string& test_path, const std::string& reference_path,
                 const std::string& layer);
    /// Refers to this.
    CompareInput input() const;
};

/// Input error where it says more of the reference than of the image.
void checkJudged(const Comparison& comparison, const std::string& test,
                 const std::string& reference);

Json comparisonJson(const Comparison& c);

}  // namespace sheen::cli
