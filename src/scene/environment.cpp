#include "scene/environment.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>

#include "core/error.h"
#include "image/exr.h"
#include "image/hdr.h"

namespace sheen {
namespace {

// As of a scene's other lights: squares of radiances beyond leave the range of floats.
constexpr float kBrightest = 1e12f;

// "R,G,B", or none where `text` is no three numbers.
std::optional<vec3> parseColor(const std::string& text) {
    vec3 color;
    const char* at = text.data();
    const char* const end = at + text.size();
    for (int c = 0; c < 3; ++c) {
        const auto [stop, error] = std::from_chars(at, end, color[c]);
        const bool ends_well = c < 2 ? stop != end && *stop == ',' : stop == end;
        if (error != std::errc() || !ends_well) {
            return std::nullopt;
        }
        at = stop + 1;
    }
    return color;
}

Image<vec3> readImage(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (extension == ".hdr") {
        return readHdr(path);
    }
    if (extension == ".exr") {
        return colorLayer(readExr(path), "beauty");
    }
    throwInput("{}: not an environment: use a .hdr or .exr file, a colour as 1,1,1, or none", path);
}

// Makes every texel a radiance of a sky of that strength, and says what is odd about the image.
void mend(const std::string& path, float strength, Image<vec3>& texels,
          std::vector<std::string>& warnings) {
    int64_t bad = 0;
    float brightest = 0.0f;
    for (vec3& texel : texels.pixels) {
        const bool good = texel.x >= 0.0f && texel.y >= 0.0f && texel.z >= 0.0f &&
                          texel.x < kInfinity && texel.y < kInfinity && texel.z < kInfinity;
        bad += good ? 0 : 1;
        texel = good ? texel * strength : vec3(0.0f);
        brightest = std::max(brightest, maxAbs(texel));
    }
    if (brightest > kBrightest) {
        throwInput("{}: shines with {:.3g} nits, more than {:g}; make it dimmer", path, brightest,
                   kBrightest);
    }
    if (bad > 0) {
        warnings.push_back(
            fmt::format("{}: {} texels are negative or not finite and count as black", path, bad));
    }
    if (brightest == 0.0f) {
        warnings.push_back(fmt::format("{}: is black and gives no light", path));
    }
    if (texels.width != 2 * texels.height) {
        warnings.push_back(fmt::format(
            "{}: {}x{} texels; an image by latitude and longitude is twice as wide as high: "
            "stretched to all directions",
            path, texels.width, texels.height));
    }
}

}  // namespace

vec3 Environment::radiance(const vec3& direction) const {
    if (texels.count() <= 1) {
        return texels.empty() ? vec3(0.0f) : texels.pixels.front();
    }
    const vec2 size(texels.width, texels.height);
    const vec2 at = imageFromDirection(direction) * size - 0.5f;
    const vec2 corner = glm::floor(at);
    const vec2 fraction = at - corner;
    const int x0 = static_cast<int>(corner.x), y0 = static_cast<int>(corner.y);
    const int left = (x0 + texels.width) % texels.width;
    const int right = (x0 + 1) % texels.width;
    const int upper = std::max(y0, 0);
    const int lower = std::min(y0 + 1, texels.height - 1);
    return glm::mix(glm::mix(texels.at(left, upper), texels.at(right, upper), fraction.x),
                    glm::mix(texels.at(left, lower), texels.at(right, lower), fraction.x),
                    fraction.y);
}

vec2 Environment::imageFromDirection(const vec3& direction) const {
    const float turned = std::atan2(direction.x, -direction.z) + rotation;
    const float u = 0.5f + turned / (2.0f * kPi);
    // Not the arc cosine, which is coarse about the poles.
    const float theta = std::atan2(glm::length(vec2(direction.x, direction.z)), direction.y);
    return {u - std::floor(u), theta / kPi};
}

vec3 Environment::directionFromImage(const vec2& uv) const {
    const float phi = 2.0f * kPi * (uv.x - 0.5f) - rotation;
    const float theta = kPi * uv.y;
    return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

Environment loadEnvironment(const EnvironmentParams& params, std::vector<std::string>& files,
                            std::vector<std::string>& warnings) {
    Environment environment{
        .texels = {}, .rotation = glm::radians(params.rotation), .visible = !params.transparent};
    const std::string& source = params.source;
    if (source.empty() || source == "none") {
        return environment;
    }
    if (const std::optional<vec3> color = parseColor(source)) {
        const vec3 radiance = *color * params.strength;
        for (int c = 0; c < 3; ++c) {
            if (!(radiance[c] >= 0.0f && radiance[c] <= kBrightest)) {
                throwUsage("--environment {}: a colour's numbers must be 0..{:g} nits", source,
                           kBrightest);
            }
        }
        environment.texels = Image<vec3>(1, 1, radiance);
        return environment;
    }
    environment.texels = readImage(source);
    files.push_back(source);
    mend(source, params.strength, environment.texels, warnings);
    return environment;
}

}  // namespace sheen
