// What the program prints: text for people on stdout, the same figures as JSON where asked.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/math.h"

namespace sheen::cli {

/// Keeps the keys in the order they were given.
using Json = nlohmann::ordered_json;

/// Whether to print text: not where stdout carries the JSON, which holds the same figures.
inline bool wantsText(const std::string& json_path) { return json_path != "-"; }

/// Ends printing: environment error where text was lost.
void flushOutput();

/// A file that a command is to write: what its option is called, and the name it was given. An
/// empty name, and "-" for standard output, is no file.
struct OutputFile {
    const char* option;
    std::string path;
};

/// Before long work: usage error where an output is one of the files that are read or another
/// output, by the files' identity; environment error where one cannot be written.
void checkOutputs(const std::vector<OutputFile>& outputs, const std::vector<std::string>& inputs);

/// Writes `json` to `json_path`, see above, a value a line or, `compact`, all in one. Environment
/// error where it cannot be written.
void writeJson(const std::string& json_path, const Json& json, bool compact = false);

Json jsonFrom(const dvec3& v);

}  // namespace sheen::cli
