// parsePoint() on any text, as the chart reads back from its folder what it may not have written: a
// point that survives being written and read again, or none.
#include <cmath>

#include "chart/point_file.h"
#include "fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace sheen;
    const std::string text(reinterpret_cast<const char*>(data), size);
    const std::optional<StoredPoint> point = parsePoint(text);
    if (!point) {
        return 0;
    }
    const Measurement& m = point->measured;
    fuzz::require(!m.runs.empty(), "a point was run");
    fuzz::require(m.seconds() > 0.0 && std::isfinite(m.seconds()), "a point takes time");
    const std::string written = jsonText(*point);
    const std::optional<StoredPoint> again = parsePoint(written);
    fuzz::require(again.has_value(), "a written point can be read", written);
    fuzz::require(
        sameImage(again->key, point->key) && shortHash(again->key) == shortHash(point->key),
        "it is of the same image", written);
    fuzz::require(jsonText(*again) == written, "nothing is lost", written);
    return 0;
}
