#include "cli/animate_frames.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cli/render_report.h"
#include "core/progress.h"
#include "image/decode.h"
#include "image/exr.h"
#include "image/png.h"
#include "image/tonemap.h"

namespace sheen::cli {
namespace {

// Whether a frame is there, and can be read to its end.
bool isWhole(const std::string& path, FileKind kind) {
    if (!std::filesystem::exists(path)) {
        return false;
    }
    try {
        if (kind == FileKind::kExr) {
            readExr(path);
        } else {
            std::ifstream in(path, std::ios::binary);
            const std::vector<char> bytes{std::istreambuf_iterator<char>(in),
                                          std::istreambuf_iterator<char>()};
            decodeImage({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
        }
        return true;
    } catch (const std::runtime_error& error) {  // of either reader
        warn(fmt::format("{}: rendered again: {}", path, error.what()));
        return false;
    }
}

const char* nameOf(SceneChange change) {
    switch (change) {
        case SceneChange::kNothing:
            return "nothing";
        case SceneChange::kCameras:
            return "cameras";
        case SceneChange::kScene:
            return "scene";
    }
    throw std::logic_error("unknown change");
}

}  // namespace

std::vector<int> missingFrames(const FrameFiles& files, const FrameRange& frames) {
    std::vector<int> missing;
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        if (!isWhole(files.names(frame), files.kind)) {
            missing.push_back(frame);
        }
    }
    return missing;
}

FrameMaker::FrameMaker(const RenderOptions& options, const FrameFiles& files, AnimatedScene& scene,
                       const SequenceParams& params, const Sequence& sequence)
    : options_(options),
      files_(files),
      scene_(scene),
      sequence_(sequence),
      renderer_(scene, options.params, params),
      warnings_said_(scene.scene().warnings.size()) {}

std::vector<Json> FrameMaker::make(Ranks& ranks, const std::string& job,
                                   const std::vector<int>& frames) {
    Progress progress("frames", static_cast<int64_t>(frames.size()));
    std::vector<Json> reports;
    const auto work = [this](const std::string& unit) { return makeOne(unit); };
    const auto done = [&](size_t, const std::string& answer) {
        reports.push_back(Json::parse(answer));
        progress.advance();
    };
    std::vector<std::string> units;
    const auto share = [&](auto first, auto end) {
        units.clear();
        std::transform(first, end, std::back_inserter(units),
                       [this](int frame) { return unitOf(frame); });
        ranks.share(job, units, work, done);
    };
    auto first = frames.begin();
    if (files_.kind == FileKind::kPng && !sequence_.exposure && first != frames.end()) {
        share(first, first + 1);
        sequence_.exposure = reports.front().at("exposure").get<float>();
        reports.front().erase("exposure");
        ++first;
    }
    share(first, frames.end());
    std::sort(reports.begin(), reports.end(),
              [](const Json& a, const Json& b) { return a.at("frame") < b.at("frame"); });
    return reports;
}

void FrameMaker::serve(Ranks& ranks, const std::string& job) {
    ranks.serve(job, [this](const std::string& unit) { return makeOne(unit); }, {});
}

std::string FrameMaker::unitOf(int frame) const {
    Json unit = {{"frame", frame}};
    if (sequence_.exposure) {
        unit["exposure"] = *sequence_.exposure;
    }
    return unit.dump();
}

std::string FrameMaker::makeOne(const std::string& unit) {
    const Json json = Json::parse(unit);
    const int frame = json.at("frame").get<int>();
    if (json.contains("exposure")) {
        sequence_.exposure = json.at("exposure").get<float>();
    }
    const std::string record = sequenceFile(files_.names);
    if (!std::filesystem::exists(record)) {
        throwEnvironment("{}: is not seen here; the folder of -o must be one for all ranks",
                         record);
    }
    const RenderResult& result = renderer_.render(frame);
    sayNewWarnings();
    options_.output = files_.names(frame);
    fixExposure(result.frame);
    write(result);
    if (renderer_.change() != SceneChange::kNothing) {
        warnOf(options_, scene_.scene(), result, options_.params.time_limit);
    }
    Json report = {{"frame", frame}, {"changed", nameOf(renderer_.change())}};
    report.update(statsJson(options_, result.stats));
    if (files_.kind == FileKind::kPng && !json.contains("exposure")) {
        report["exposure"] = *sequence_.exposure;
    }
    // Names come from scene files and need not be valid UTF-8.
    return report.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Of the scene as it moves: each once.
void FrameMaker::sayNewWarnings() {
    const std::vector<std::string>& warnings = scene_.scene().warnings;
    for (; warnings_said_ < warnings.size(); ++warnings_said_) {
        warn(warnings[warnings_said_]);
    }
}

// Brightness must not change from frame to frame by itself: the first frame's is that of all.
void FrameMaker::fixExposure(const Frame& frame) {
    if (files_.kind == FileKind::kPng && !sequence_.exposure) {
        sequence_.exposure = autoExposure(beauty(frame));
        writeSequence(files_.names, sequence_);
    }
}

void FrameMaker::write(const RenderResult& result) const {
    if (files_.kind == FileKind::kPng) {
        writePng(options_.output, result.frame, sequence_.exposure, options_.to_display);
    } else {
        writeFrameExr(options_, scene_.scene(), result);
    }
}

}  // namespace sheen::cli
