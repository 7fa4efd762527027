#include "cli/options.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/bounces.h"
#include "core/error.h"

namespace sheen::cli {
namespace {

constexpr int kMaxSide = 16384;
constexpr float kMaxStops = 50.0f;
constexpr double kFarthest = 1e15;  // of a point, each way
constexpr int kFewestPhotons = 1000, kMostPhotons = 100'000'000;
constexpr int kMostBounces = 64;
constexpr int kMinShOrder = 2;
constexpr int kMaxShOrder = 10;

// The whole of `text` as a number, or none.
template <class T>
std::optional<T> parseNumber(std::string_view text) {
    T value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && stop == end ? std::optional<T>(value) : std::nullopt;
}

// CLI11 reads 010 as eight.
bool startsAsOctal(const std::string& number) {
    const size_t first = number.find_first_of("0123456789.");
    return first != std::string::npos && number[first] == '0' && first + 1 < number.size() &&
           std::isdigit(static_cast<unsigned char>(number[first + 1])) != 0;
}

}  // namespace

CLI::Validator numberIn(double lower, double upper) {
    const std::string range = fmt::format("{}..{}", lower, upper);
    return CLI::Validator(
        [lower, upper, range](const std::string& text) -> std::string {
            const std::optional<double> value = parseNumber<double>(text);
            const bool inside = value && !startsAsOctal(text) && *value >= lower && *value <= upper;
            return inside ? "" : fmt::format("{} is not a number in {}", text, range);
        },
        range);
}

CLI::Validator fileName() {
    return CLI::Validator(
        [](const std::string& text) -> std::string { return text.empty() ? "name is empty" : ""; },
        "");
}

ivec2 parseSize(const std::string& text) {
    const size_t cross = text.find_first_of("xX");
    if (cross != std::string::npos) {
        const std::optional<int> width = parseNumber<int>(text.substr(0, cross));
        const std::optional<int> height = parseNumber<int>(text.substr(cross + 1));
        const auto valid = [](int side) { return side >= 1 && side <= kMaxSide; };
        if (width && height && valid(*width) && valid(*height)) {
            return {*width, *height};
        }
    }
    throwUsage("--size {}: must be WIDTHxHEIGHT, each 1..{}, as in 640x480", text, kMaxSide);
}

std::optional<float> parseExposure(const std::string& text) {
    if (text == "auto") {
        return std::nullopt;
    }
    const std::optional<float> stops = parseNumber<float>(text);
    if (!stops || !(std::abs(*stops) <= kMaxStops)) {
        throwUsage("--exposure {}: must be auto or stops in {}..{}", text, -kMaxStops, kMaxStops);
    }
    return stops;
}

Crop parseCrop(const std::string& text) {
    constexpr int kMost = 1000000;
    std::array<int, 4> numbers{};
    std::string_view rest = text;
    for (int c = 0; c < 4; ++c) {
        const size_t comma = c < 3 ? rest.find(',') : rest.size();
        const std::optional<int> number = comma == std::string_view::npos
                                              ? std::nullopt
                                              : parseNumber<int>(rest.substr(0, comma));
        if (!number || *number < 0 || *number >= kMost) {
            throwUsage("--crop {}: must be X,Y,W,H in pixels, as in 100,50,64,64", text);
        }
        numbers[static_cast<size_t>(c)] = *number;
        rest = rest.substr(std::min(comma + 1, rest.size()));
    }
    return {.first = {numbers[0], numbers[1]}, .size = {numbers[2], numbers[3]}};
}

dvec3 parsePoint(const char* option, const std::string& text) {
    dvec3 point(0.0);
    std::string_view rest = text;
    for (int c = 0; c < 3; ++c) {
        const size_t comma = c < 2 ? rest.find(',') : rest.size();
        const std::optional<double> number = comma == std::string_view::npos
                                                 ? std::nullopt
                                                 : parseNumber<double>(rest.substr(0, comma));
        if (!number || !(std::abs(*number) <= kFarthest)) {
            throwUsage("{} {}: must be X,Y,Z, as in 1.5,0,-2", option, text);
        }
        point[c] = *number;
        rest = rest.substr(std::min(comma + 1, rest.size()));
    }
    return point;
}

ProbeSpacing parseProbes(const std::string& text) {
    constexpr int kMostAlongAxis = 4096;
    const std::optional<float> space = parseNumber<float>(text);
    if (space && *space > 0.0f && std::isfinite(*space)) {
        return {.counts = std::nullopt, .space = *space};
    }
    ivec3 counts(0);
    std::string_view rest = text;
    for (int axis = 0; axis < 3; ++axis) {
        const size_t end = std::min(axis < 2 ? rest.find_first_of("xX") : rest.size(), rest.size());
        counts[axis] = parseNumber<int>(rest.substr(0, end)).value_or(0);
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (counts[axis] < 1 || counts[axis] > kMostAlongAxis) {
            throwUsage(
                "--probes {}: must be NxNxN, each 1..{}, as in 8x4x8, or the space between probes, "
                "above 0",
                text, kMostAlongAxis);
        }
    }
    return {.counts = counts};
}

int parseShOrder(const std::string& text) {
    if (text == "auto") {
        return 0;
    }
    const std::optional<int> order = parseNumber<int>(text);
    if (!order || *order < kMinShOrder || *order > kMaxShOrder) {
        throwUsage("--sh-order {}: must be auto or {}..{}", text, kMinShOrder, kMaxShOrder);
    }
    return *order;
}

int parseBounces(const std::string& text) {
    if (text == "all") {
        return kAllBounces;
    }
    const std::optional<int> bounces = parseNumber<int>(text);
    if (!bounces || *bounces < 1 || *bounces > kMostBounces) {
        throwUsage("--bounces {}: must be all or 1..{}", text, kMostBounces);
    }
    return *bounces;
}

int parseCaustics(const std::string& text) {
    if (text == "none") {
        return 0;
    }
    const std::optional<int> photons = parseNumber<int>(text);
    if (!photons || *photons < kFewestPhotons || *photons > kMostPhotons) {
        throwUsage("--caustics {}: must be none or {}..{} photons", text, kFewestPhotons,
                   kMostPhotons);
    }
    return *photons;
}

void addSceneOption(CLI::App& app, std::string& scene) {
    app.add_option("SCENE", scene, "glTF scene, .glb or .gltf")
        ->type_name("FILE")
        ->required()
        ->check(fileName());
}

void addEnvironmentOptions(CLI::App& app, EnvironmentParams& params) {
    CLI::Option* environment =
        app.add_option("--environment", params.source,
                       "Sky that lights the scene and shows behind it: an image by latitude and "
                       "longitude (.hdr, .exr), a colour R,G,B in nits, or none; default: the "
                       "file's own, or a studio where it has no light at all")
            ->type_name("FILE|R,G,B|none")
            ->check(fileName());
    app.add_option("--environment-rotation", params.rotation,
                   "Degrees by which the sky is turned, counter-clockwise seen from above")
        ->check(numberIn(-360, 360))
        ->needs(environment)
        ->capture_default_str();
    app.add_option("--environment-strength", params.strength, "Factor of the sky's radiance")
        ->check(numberIn(0, 1e6))
        ->needs(environment)
        ->capture_default_str();
    app.add_flag("--transparent", params.transparent,
                 "The sky only lights: where no surface is seen the image stays transparent");
}

void addThreadsOption(CLI::App& app, int& threads) {
    app.add_option("--threads", threads, "Threads to use; 0: one a hardware thread")
        ->check(numberIn(0, 256))
        ->capture_default_str();
}

void addGlOption(CLI::App& app, std::string& gl) {
    gl = gl::kDefaultBackend == gl::Backend::kOsmesa ? "osmesa" : "egl";
    app.add_option("--gl", gl,
                   "OpenGL by osmesa (software, in the program) or egl (a GPU, else software)")
        ->check(CLI::IsMember({"osmesa", "egl"}))
        ->capture_default_str();
}

gl::Backend parseGl(const std::string& gl) {
    return gl == "osmesa" ? gl::Backend::kOsmesa : gl::Backend::kEgl;
}

FileKind imageKind(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (extension == ".exr") {
        return FileKind::kExr;
    }
    if (extension == ".png") {
        return FileKind::kPng;
    }
    throwUsage("{}: the name of an image must end in .exr or .png", path);
}

void addViewpointOptions(CLI::App& app, std::string& camera, std::string& camera_at,
                         std::string& look_at, double& fov) {
    app.add_option("--camera", camera, "Name or number of a camera; default: the first");
    app.add_option("--camera-at", camera_at,
                   "Where to see the scene from, in the file's coordinates")
        ->type_name("X,Y,Z")
        ->check(fileName());
    app.add_option("--look-at", look_at,
                   "A point to look at; with --camera-at, default: the scene's middle")
        ->type_name("X,Y,Z")
        ->check(fileName());
    app.add_option("--fov", fov, "Vertical field of view, degrees; default: the camera's")
        ->check(numberIn(0.1, 179));
}

void parseViewpoint(const std::string& camera_at, const std::string& look_at, double fov,
                    std::string& camera, LoadParams& load) {
    Viewpoint& view = load.view;
    if (!camera_at.empty()) {
        view.at = parsePoint("--camera-at", camera_at);
    }
    if (!look_at.empty()) {
        view.look_at = parsePoint("--look-at", look_at);
    }
    if (fov > 0.0) {
        view.y_fov = static_cast<float>(glm::radians(fov));
    }
    load.camera = camera;
    if (view.given()) {
        camera.clear();  // it becomes the first
    }
}

}  // namespace sheen::cli
