// What the chart's folder remembers of a measured point or a reference, as JSON beside its EXR.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "chart/measurement.h"
#include "scene/scene.h"

namespace sheen {

/// Keeps the keys in the order they were given.
using Json = nlohmann::ordered_json;

/// Hash of everything in the scene that an image depends on, 16 hexadecimal digits.
std::string contentHash(const Scene& scene);

/// Hash of a file's bytes, 16 hexadecimal digits. Environment error where it cannot be read.
std::string fileHash(const std::string& path);

/// `name` with everything but ASCII letters, digits, - and _ replaced, 40 characters at most.
std::string fileNamePart(const std::string& name);

/// The image that a stored file describes: everything that decides its pixels.
struct ImageKey {
    std::string scene;  ///< contentHash()
    int camera = 0;
    int width = 0, height = 0;
    std::vector<std::string> arguments;  ///< settingArguments()
    std::string gl;                      ///< the OpenGL backend asked for (--gl)
};

/// 12 hexadecimal digits that stand for the key in file names.
std::string shortHash(const ImageKey& key);

struct StoredPoint {
    ImageKey key;
    Measurement measured;  ///< a run or more
};

/// An object of seconds by stage.
Json jsonFromStages(const StageTimes& stages);

std::string jsonText(const StoredPoint& point);

/// Adds a run that took `wall_seconds` and printed `render_json` (`sheen render --json -`).
void addRun(Measurement& measured, double wall_seconds, const std::string& render_json);

/// The point that `text` holds; none where it is not such a file.
std::optional<StoredPoint> parsePoint(const std::string& text);

bool sameImage(const ImageKey& a, const ImageKey& b);

/// The whole file; none where there is none.
std::optional<std::string> readText(const std::string& path);

/// Valid UTF-8 and ASCII only, whatever bytes the strings in `json` hold: names come from files.
std::string asciiText(const Json& json, int indent);

}  // namespace sheen
