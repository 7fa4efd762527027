#include "cli/sequence_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "chart/point_file.h"
#include "cli/output.h"
#include "core/error.h"

namespace sheen::cli {
namespace {

// None where the text is no such file.
std::optional<Sequence> parseSequence(const std::string& text) {
    try {
        const Json json = Json::parse(text);
        Sequence sequence{.key = {.program = json.at("program").get<std::string>(),
                                  .scene = json.at("scene").get<std::string>(),
                                  .options = json.at("options").get<std::string>()}};
        if (json.at("exposure").is_number()) {
            sequence.exposure = json.at("exposure").get<float>();
        }
        return sequence;
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

const char* differenceOf(const SequenceKey& a, const SequenceKey& b) {
    return a.scene != b.scene       ? "of another scene"
           : a.options != b.options ? "with other options"
                                    : "by another version of the program";
}

}  // namespace

std::string ownProgram() {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
    if (error) {
        throwEnvironment("/proc/self/exe: cannot find the program: {}", error.message());
    }
    return path.filename() == "sheen-mpi"
               ? std::filesystem::path(path).replace_filename("sheen").string()
               : path.string();
}

std::string optionsText(const CLI::App& app) {
    std::string text;
    const CLI::Option* view = app.get_option_no_throw("--view");
    const bool viewed = view != nullptr && view->count() > 0;
    for (const CLI::Option* option : app.get_options()) {
        const std::string name = option->get_name();
        if (name == "--ocio") {
            // Of the environment, perhaps; what is in it counts, where it is used.
            text += viewed ? fmt::format("{}--ocio={}", text.empty() ? "" : " ",
                                         fileHash(option->results().front()))
                           : "";
            continue;
        }
        const bool of_images = name != "SCENE" && name != "--output" && name != "--frames" &&
                               name != "--threads" && name != "--json" && name != "--quiet";
        if (option->count() > 0 && of_images) {
            text += fmt::format("{}{}={}", text.empty() ? "" : " ", name,
                                fmt::join(option->results(), ","));
        }
    }
    return text;
}

SequenceKey keyOf(const CLI::App& app, const Scene& scene) {
    std::string files;
    for (const std::string& file : scene.files) {
        files += fileHash(file);
    }
    return {.program = "sheen " SHEEN_VERSION, .scene = files, .options = optionsText(app)};
}

std::string jobText(const SequenceKey& key, const std::string& output) {
    return fmt::format("{}\n{}\n{}\n{}", key.program, key.scene, key.options, output);
}

std::string sequenceFile(const FrameNames& names) { return names.beside("sequence.json"); }

std::optional<Sequence> findSequence(const FrameNames& names, const FrameRange& frames,
                                     const SequenceKey& key) {
    const std::string path = sequenceFile(names);
    std::ifstream in(path, std::ios::binary);
    if (in) {
        const std::string text{std::istreambuf_iterator<char>(in),
                               std::istreambuf_iterator<char>()};
        const std::optional<Sequence> sequence = parseSequence(text);
        if (!sequence || !(sequence->key == key)) {
            throwUsage("{}: the frames beside it were made {}; choose another -o, or remove them",
                       path, sequence ? differenceOf(sequence->key, key) : "otherwise");
        }
        return sequence;
    }
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        if (std::filesystem::exists(names(frame))) {
            throwUsage(
                "{}: is there, but {}, which says how it was made, is not; choose another -o, or "
                "remove it",
                names(frame), path);
        }
    }
    return std::nullopt;
}

void writeSequence(const FrameNames& names, const Sequence& sequence) {
    Json json = {{"program", sequence.key.program},
                 {"scene", sequence.key.scene},
                 {"options", sequence.key.options},
                 {"exposure", nullptr}};
    if (sequence.exposure) {
        json["exposure"] = *sequence.exposure;
    }
    writeJson(sequenceFile(names), json);
}

}  // namespace sheen::cli
