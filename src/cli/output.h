// What the program prints: text for people on stdout, the same figures as JSON where asked.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/math.h"

namespace sheen::cli {

/// Keeps the keys in the order they were given.
using Json = nlohmann::ordered_json;

/// Whether to print text: not where stdout carries the JSON, which holds the same figures.
inline bool wantsText(const std::string& json_path) { return json_path != "-"; }

/// Ends printing: environment error where text was lost.
void flushOutput();

/// Fails early if `json_path` (a file; "-" is stdout; empty: none) cannot be written.
void checkJsonWritable(const std::string& json_path);

/// Writes `json` to `json_path`, see above. Environment error where it cannot be written.
void writeJson(const std::string& json_path, const Json& json);

Json jsonFrom(const vec3& v);

}  // namespace sheen::cli
