// The sky that a file brings along: a cube map, made an image by latitude and longitude.
// Based on: EXT_lights_image_based. What it brings besides, the cube map blurred and its
// irradiance, follows from the sharpest images, which alone are read.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "core/memory.h"
#include "core/parallel.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr const char* kSkyExtension = "EXT_lights_image_based";
constexpr size_t kFaces = 6;
constexpr int kLargestFace = 2048;
// Texels divided by their least alpha stay below what a scene's lights may bring.
constexpr double kBrightest = 1e9;

using Faces = std::array<TextureImage, kFaces>;

// Where a face lies: its middle, and where its columns and rows run, as seen from inside.
struct Face {
    vec3 middle, right, down;
};
constexpr std::array<Face, kFaces> kCube = {{{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                             {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                             {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}},
                                             {{0, -1, 0}, {-1, 0, 0}, {0, 0, -1}},
                                             {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}},
                                             {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}}}};

// Radiance of a texel: colours are sRGB, and where there is an alpha it divides them (RGBD).
vec3 radianceOf(const TextureImage& face, int x, int y) {
    const vec4 texel =
        texelOf(face, true, std::clamp(x, 0, face.width - 1), std::clamp(y, 0, face.height - 1));
    return vec3(texel) / std::max(texel.w, 1.0f / 255.0f);
}

// From a direction of the cube's space: bilinear within a face.
vec3 lookUp(const Faces& faces, const vec3& direction) {
    size_t at = 0;
    for (size_t i = 1; i < kFaces; ++i) {
        at = glm::dot(direction, kCube[i].middle) > glm::dot(direction, kCube[at].middle) ? i : at;
    }
    const Face& face = kCube[at];
    const vec2 uv =
        0.5f + 0.5f * vec2(glm::dot(direction, face.right), glm::dot(direction, face.down)) /
                   glm::dot(direction, face.middle);
    const TextureImage& image = faces[at];
    const vec2 place = uv * vec2(image.width, image.height) - 0.5f;
    const vec2 corner = glm::floor(place);
    const vec2 f = place - corner;
    const int x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
    return glm::mix(glm::mix(radianceOf(image, x, y), radianceOf(image, x + 1, y), f.x),
                    glm::mix(radianceOf(image, x, y + 1), radianceOf(image, x + 1, y + 1), f.x),
                    f.y);
}

// The rotation that a light says, or an input error.
glm::quat rotationOf(const File& file, const tinygltf::Value& light, const std::string& where) {
    if (!light.Has("rotation")) {
        return {1.0f, 0.0f, 0.0f, 0.0f};
    }
    const tinygltf::Value& source = light.Get("rotation");
    double q[4], largest = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (source.ArrayLen() != 4 || !source.Get(i).IsNumber()) {
            file.fail(where, "rotation must hold four numbers");
        }
        q[i] = source.Get(i).GetNumberAsDouble();
        largest = std::max(largest, std::abs(q[i]));
    }
    if (!(largest > 0.0 && largest <= std::numeric_limits<double>::max())) {
        file.fail(where, "rotation must be finite and not zero");
    }
    for (double& part : q) {
        part /= largest;
    }
    return glm::quat(glm::normalize(glm::dquat(q[3], q[0], q[1], q[2])));
}

// The sharpest images; none, with notes, where one of them cannot be read.
std::optional<Faces> facesOf(File& file, const tinygltf::Value& light, const std::string& where) {
    const tinygltf::Value images =
        light.Has("specularImages") ? light.Get("specularImages") : tinygltf::Value();
    if (!images.IsArray() || images.ArrayLen() == 0 || !images.Get(0).IsArray() ||
        images.Get(0).ArrayLen() != kFaces) {
        file.fail(where, "specularImages must hold six images for each size");
    }
    Faces faces;
    for (size_t i = 0; i < kFaces; ++i) {
        const tinygltf::Value& index = images.Get(0).Get(static_cast<int>(i));
        if (!index.IsInt()) {
            file.fail(where, "specularImages must hold indices of images");
        }
        file.at(file.images, index.GetNumberAsInt(), where, "image");
        auto face = loadImage(file, index.GetNumberAsInt(), "the sky is left out", kLargestFace);
        if (!face) {
            return std::nullopt;
        }
        if (face->width != face->height || (i > 0 && face->width != faces[0].width)) {
            file.fail(where, "face {} has {} x {} texels; make all six square and alike", i,
                      face->width, face->height);
        }
        faces[i] = std::move(*face);
    }
    return faces;
}

Environment skyOf(File& file, const tinygltf::Value& light, const std::string& where) {
    const double intensity = numberMember(file, light, "intensity", 1.0, where);
    if (!(intensity >= 0.0) || intensity > kBrightest) {
        file.fail(where, "intensity must be 0..{:g}", kBrightest);
    }
    const glm::quat cube_from_world = glm::conjugate(rotationOf(file, light, where));
    const auto faces = facesOf(file, light, where);
    Environment sky;
    if (!faces) {
        return sky;
    }
    // As fine at the horizon as the faces are at their middles.
    const int height = 2 * faces->front().width;
    checkMemory(
        {.bytes = 2 * sizeof(vec3) * static_cast<uint64_t>(height) * static_cast<uint64_t>(height)},
        fmt::format("{}: {}", file.path, where), "use smaller images");
    sky.texels = Image<vec3>(2 * height, height);
    parallelFor(sky.texels.height, [&](int y) {
        for (int x = 0; x < sky.texels.width; ++x) {
            const vec2 uv = (vec2(x, y) + 0.5f) / vec2(sky.texels.width, sky.texels.height);
            sky.texels.at(x, y) = static_cast<float>(intensity) *
                                  lookUp(*faces, cube_from_world * sky.directionFromImage(uv));
        }
    });
    return sky;
}

}  // namespace

Environment loadSky(File& file) {
    const int shown = shownScene(file);
    if (shown < 0) {
        return {};
    }
    const auto& own = file.model.scenes[static_cast<size_t>(shown)].extensions;
    if (own.count(kSkyExtension) == 0) {
        return {};
    }
    const std::string where = "the scene's image-based light";
    try {
        const int index = integerMember(file, own.at(kSkyExtension), "light", -1, where);
        const auto root = file.model.extensions.find(kSkyExtension);
        const bool any = root != file.model.extensions.end() && root->second.Has("lights");
        const tinygltf::Value lights = any ? root->second.Get("lights") : tinygltf::Value();
        const int count = lights.IsArray() ? static_cast<int>(lights.ArrayLen()) : 0;
        if (index < 0 || index >= count) {
            file.fail(where, "refers to light {}, but the file has {}; export it again", index,
                      count);
        }
        return skyOf(file, lights.Get(index), where);
    } catch (const Error& error) {
        if (error.code() != ExitCode::kInput) {
            throw;
        }
        // What fails names the file first, which notes need not.
        file.notes.add(fmt::format("{}: shown without it",
                                   std::string(error.what()).substr(file.path.size() + 2)));
        return {};
    }
}

}  // namespace sheen::gltf
