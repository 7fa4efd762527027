#include "library/requests.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace sheen::library {
namespace {

// Options that say how a file is loaded, and those by which it is seen.
constexpr std::array<std::string_view, 5> kOfScene = {
    "variant", "environment", "environment-rotation", "environment-strength", "transparent"};
constexpr std::array<std::string_view, 4> kOfView = {"camera", "camera-at", "look-at", "fov"};
constexpr std::array<std::string_view, 4> kOfWriting = {"exposure", "tone", "view", "ocio"};
constexpr std::array<std::string_view, 3> kOfPoints = {"accuracy", "bounces", "threads"};
constexpr std::array<std::string_view, 3> kOfProgram = {"help", "output", "json"};

template <size_t N>
bool isIn(const std::array<std::string_view, N>& names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

bool belongs(Call call, std::string_view name) {
    switch (call) {
        case Call::kScene:
            return isIn(kOfScene, name) || isIn(kOfView, name);
        case Call::kRender:
            return !isIn(kOfScene, name) && !isIn(kOfWriting, name) && !isIn(kOfProgram, name);
        case Call::kWrite:
            return isIn(kOfWriting, name);
        case Call::kPoints:
            return isIn(kOfPoints, name);
    }
    throw std::logic_error("unknown call");
}

// Long names of the options that a call has.
std::vector<std::string> namesOf(Call call, const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) {
            if (belongs(call, name)) {
                names.push_back(name);
            }
        }
    }
    return names;
}

[[noreturn]] void failUnknown(const std::string& name, const std::vector<std::string>& known,
                              Call call) {
    std::string list = call == Call::kRender ? "width, height" : "";
    for (const std::string& other : known) {
        list += (list.empty() ? "" : ", ") + other;
    }
    throwUsage("option {}: there is none of that name here; there are {}", oneLine(name), list);
}

// As the command line has them.
std::vector<std::string> argumentsOf(Call call, std::span<const sheen_option> options,
                                     const CLI::App& app) {
    constexpr const char* kDefaultSide = "512";
    const std::vector<std::string> known = namesOf(call, app);
    std::vector<std::string> arguments, given;
    std::string width, height;
    for (const sheen_option& option : options) {
        if (option.name == nullptr || option.value == nullptr) {
            throwUsage("options: a name or value is NULL");
        }
        const std::string name = option.name;
        const bool is_side = call == Call::kRender && (name == "width" || name == "height");
        if (!is_side && std::find(known.begin(), known.end(), name) == known.end()) {
            failUnknown(name, known, call);
        }
        if (std::find(given.begin(), given.end(), name) != given.end()) {
            throwUsage("option {}: is given twice", name);
        }
        given.push_back(name);
        const std::string value = option.value;
        if (value.empty()) {
            continue;
        }
        if (is_side) {
            (name == "width" ? width : height) = value;
        } else {
            arguments.push_back(fmt::format("--{}={}", name, value));
        }
    }
    if (!width.empty() || !height.empty()) {
        arguments.push_back(fmt::format("--size={}x{}", width.empty() ? kDefaultSide : width,
                                        height.empty() ? kDefaultSide : height));
    }
    return arguments;
}

}  // namespace

std::vector<NamedValue> namedValues(std::span<const sheen_option> options) {
    std::vector<NamedValue> all;
    for (const sheen_option& option : options) {
        all.push_back({option.name, option.value});
    }
    return all;
}

std::unique_ptr<Request> requestOf(Call call, std::span<const sheen_option> options,
                                   std::span<const NamedValue> of_scene) {
    auto request = std::make_unique<Request>();
    cli::addRenderOptions(request->app, request->options);
    std::vector<std::string> arguments = argumentsOf(call, options, request->app);
    for (const NamedValue& option : of_scene) {
        if (isIn(kOfScene, option.name) && !option.value.empty()) {
            arguments.push_back(fmt::format("--{}={}", option.name, option.value));
        }
    }
    arguments.push_back("scene");                      // which the program must be told
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
    try {
        request->app.parse(arguments);
    } catch (const CLI::ParseError& error) {
        throwUsage("{}", oneLine(error.what()));
    }
    cli::understandFrame(request->options);
    return request;
}

}  // namespace sheen::library
