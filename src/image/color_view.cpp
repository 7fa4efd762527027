#include "image/color_view.h"

#include <OpenColorIO/OpenColorIO.h>

#include "core/error.h"

namespace ocio = OCIO_NAMESPACE;

namespace sheen {
namespace {

// Names of one space in the configurations that are in use.
constexpr const char* kLinearRec709[] = {"lin_rec709", "Linear Rec.709 (sRGB)",
                                         "Utility - Linear - sRGB", "lin_srgb"};

const char* spaceOf(const ocio::Config& config) {
    for (const char* name : kLinearRec709) {
        if (config.getColorSpace(name) != nullptr) {
            return name;
        }
    }
    return ocio::ROLE_SCENE_LINEAR;
}

std::string viewsOf(const ocio::Config& config) {
    std::string names;
    for (int d = 0; d < config.getNumDisplays(); ++d) {
        const char* display = config.getDisplay(d);
        for (int v = 0; v < config.getNumViews(display); ++v) {
            names += fmt::format("{}{}/{}", names.empty() ? "" : ", ", display,
                                 config.getView(display, v));
        }
    }
    return names;
}

bool hasView(const ocio::Config& config, const std::string& display, const std::string& view) {
    for (int v = 0; v < config.getNumViews(display.c_str()); ++v) {
        if (view == config.getView(display.c_str(), v)) {
            return true;
        }
    }
    return false;
}

ocio::ConstCPUProcessorRcPtr processorOf(const std::string& path, const std::string& name) {
    const ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(path.c_str());
    config->validate();
    const size_t slash = name.find('/');
    const bool of_default = slash == std::string::npos;
    const std::string display = of_default ? config->getDefaultDisplay() : name.substr(0, slash);
    const std::string view = of_default ? name : name.substr(slash + 1);
    if (!hasView(*config, display, view)) {
        throwUsage("--view {}: {} has no such view, but {}", name, path, viewsOf(*config));
    }
    const auto transform = ocio::DisplayViewTransform::Create();
    transform->setSrc(spaceOf(*config));
    transform->setDisplay(display.c_str());
    transform->setView(view.c_str());
    return config->getProcessor(transform)->getDefaultCPUProcessor();
}

}  // namespace

ToDisplay colorView(const std::string& config, const std::string& view) {
    ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);  // what is wrong is said by one line
    try {
        return [processor = processorOf(config, view)](const vec3& color) {
            vec3 shown = color;
            processor->applyRGB(&shown.x);
            return shown;
        };
    } catch (const ocio::Exception& error) {
        throwInput("{}: not a configuration of OpenColorIO that can be used: {}", config,
                   oneLine(error.what()));
    }
}

}  // namespace sheen
