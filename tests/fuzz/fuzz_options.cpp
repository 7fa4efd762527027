// Option values of any text: a value in its range, or a usage error.
#include <cmath>

#include "cli/options.h"
#include "core/error.h"
#include "fuzz/fuzz.h"

namespace sheen::fuzz {
namespace {

template <class Parse>
void check(const Parse& parse) {
    try {
        parse();
    } catch (const Error& error) {
        require(error.code() == ExitCode::kUsage, "an odd option has exit code 2", error.what());
    }
}

}  // namespace
}  // namespace sheen::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace sheen;
    using namespace sheen::cli;
    const std::string text(reinterpret_cast<const char*>(data), size);
    fuzz::check([&] {
        const ivec2 side = parseSize(text);
        fuzz::require(side.x >= 1 && side.x <= 16384 && side.y >= 1 && side.y <= 16384,
                      "a size is in range", text);
    });
    fuzz::check([&] {
        const std::optional<float> stops = parseExposure(text);
        fuzz::require(!stops || std::abs(*stops) <= 50.0f, "an exposure is in range", text);
    });
    fuzz::check([&] {
        const int order = parseShOrder(text);
        fuzz::require(order == 0 || (order >= 2 && order <= 10), "an order is in range", text);
    });
    fuzz::check([&] {
        const Crop crop = parseCrop(text);
        fuzz::require(glm::all(glm::greaterThanEqual(glm::min(crop.first, crop.size), ivec2(0))) &&
                          glm::all(glm::lessThan(glm::max(crop.first, crop.size), ivec2(1000000))),
                      "a part is in range", text);
    });
    fuzz::check([&] { imageKind(text); });
    std::string number = text;
    if (numberIn(0.5, 8.0)(number).empty()) {
        const double value = std::strtod(number.c_str(), nullptr);
        fuzz::require(value >= 0.5 && value <= 8.0, "a number is in range", text);
    }
    return 0;
}
