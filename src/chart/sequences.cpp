#include "chart/sequences.h"

#include <nlohmann/json.hpp>

#include "chart/point_file.h"
#include "core/error.h"

namespace sheen {
namespace {

double figureOf(const Json& json, const char* name) {
    const auto value = json.at(name).get<double>();
    if (!(value >= 0.0)) {
        throwInput("{} is {}", name, value);
    }
    return value;
}

SequencePoint pointOf(const Json& json) {
    return {.scene = json.at("scene").get<std::string>(),
            .method = json.at("method").get<std::string>(),
            .error = figureOf(json, "error"),
            .flicker = figureOf(json, "flicker"),
            .resolution = figureOf(json, "resolution"),
            .seconds = figureOf(json, "seconds")};
}

}  // namespace

Sequences readSequences(const std::string& path) {
    const std::optional<std::string> text = readText(path);
    if (!text) {
        throwInput("{}: cannot be read", path);
    }
    try {
        const Json json = Json::parse(*text);
        Sequences sequences{.measured = json.at("measured").get<std::string>(), .points = {}};
        for (const Json& point : json.at("points")) {
            sequences.points.push_back(pointOf(point));
        }
        return sequences;
    } catch (const std::exception& error) {  // of JSON, or of a figure
        throwInput("{}: is no file of bench/sequences.py --json: {}", path, error.what());
    }
}

}  // namespace sheen
