#include "chart/benches.h"

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

void read(const Json& json, SequencePoint& point) {
    point = {.scene = json.at("scene").get<std::string>(),
             .method = json.at("method").get<std::string>(),
             .error = figureOf(json, "error"),
             .flicker = figureOf(json, "flicker"),
             .resolution = figureOf(json, "resolution"),
             .seconds = figureOf(json, "seconds")};
}
Json jsonOf(const SequencePoint& point) {
    return {{"scene", point.scene},           {"method", point.method},
            {"error", point.error},           {"flicker", point.flicker},
            {"resolution", point.resolution}, {"seconds", point.seconds}};
}

void read(const Json& json, BakePoint& point) {
    point = {.scene = json.at("scene").get<std::string>(),
             .method = json.at("method").get<std::string>(),
             .setting = json.at("setting").get<std::string>(),
             .error = figureOf(json, "error"),
             .judged = json.at("judged").get<bool>(),
             .share = figureOf(json, "share"),
             .seconds = figureOf(json, "seconds")};
}
Json jsonOf(const BakePoint& point) {
    return {{"scene", point.scene},    {"method", point.method}, {"setting", point.setting},
            {"error", point.error},    {"judged", point.judged}, {"share", point.share},
            {"seconds", point.seconds}};
}

template <class Point>
BenchPoints<Point> readBench(const std::string& path, const char* program) {
    const std::optional<std::string> text = readText(path);
    if (!text) {
        throwInput("{}: cannot be read", path);
    }
    try {
        const Json json = Json::parse(*text);
        BenchPoints<Point> bench{.measured = json.at("measured").get<std::string>(), .points = {}};
        for (const Json& point : json.at("points")) {
            read(point, bench.points.emplace_back());
        }
        return bench;
    } catch (const std::exception& error) {  // of JSON, or of a figure
        throwInput("{}: is no file of {} --json: {}", path, program, error.what());
    }
}

template <class Point>
Json jsonOfBench(const std::optional<BenchPoints<Point>>& bench) {
    if (!bench) {
        return {};
    }
    Json json = {{"measured", bench->measured}, {"points", Json::array()}};
    for (const Point& point : bench->points) {
        json["points"].push_back(jsonOf(point));
    }
    return json;
}

}  // namespace

Sequences readSequences(const std::string& path) {
    return readBench<SequencePoint>(path, "bench/sequences.py");
}
Bakes readBakes(const std::string& path) { return readBench<BakePoint>(path, "bench/bake.py"); }

nlohmann::ordered_json jsonOf(const std::optional<Sequences>& sequences) {
    return jsonOfBench(sequences);
}
nlohmann::ordered_json jsonOf(const std::optional<Bakes>& bakes) { return jsonOfBench(bakes); }

}  // namespace sheen
