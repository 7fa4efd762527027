// loadScene() on any bytes: a scene that keeps what scene.h says of it, or one line of input error.
#include <cmath>

#include "fuzz/fuzz.h"
#include "scene/scene.h"

namespace sheen::fuzz {
namespace {

constexpr float kUnitTolerance = 1e-3f;

bool finite(const vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool unit(const vec3& v) { return std::abs(glm::length(v) - 1.0f) < kUnitTolerance; }
bool within(float value, float lower, float upper) { return value >= lower && value <= upper; }
bool within(const vec3& v, float lower, float upper) {
    return within(v.x, lower, upper) && within(v.y, lower, upper) && within(v.z, lower, upper);
}

void checkGeometry(const Scene& scene) {
    const size_t vertices = scene.positions.size();
    require(scene.normals.size() == vertices && scene.uvs.size() == vertices,
            "every vertex has a normal and a uv");
    for (size_t i = 0; i < vertices; ++i) {
        require(finite(scene.positions[i]), "positions are finite");
        require(unit(scene.normals[i]), "normals are unit vectors");
        require(std::isfinite(scene.uvs[i].x) && std::isfinite(scene.uvs[i].y), "uvs are finite");
    }
    require((scene.second_uvs.empty() || scene.second_uvs.size() == vertices) &&
                (scene.colors.empty() || scene.colors.size() == vertices) &&
                (scene.tangents.empty() || scene.tangents.size() == vertices),
            "every vertex has what one has");
    require(scene.materials_of.size() == scene.triangles.size(), "every triangle has a material");
    for (int i = 0; i < scene.triangleCount(); ++i) {
        const uvec3& t = scene.triangles[static_cast<size_t>(i)];
        require(t.x < vertices && t.y < vertices && t.z < vertices, "indices are in range");
        require(unit(geometricNormal(scene, i)), "no triangle is degenerate");
        require(scene.materials_of[static_cast<size_t>(i)] < scene.materials.size(),
                "materials are in range");
    }
    require(scene.bounds.empty() == scene.triangles.empty(), "the bounds are those of triangles");
    require(std::isfinite(scene.bounds.size()), "the scene's size is finite");
}

void checkMaterials(const Scene& scene) {
    const float largest = std::numeric_limits<float>::max();
    for (const Material& material : scene.materials) {
        const MaterialParams& p = material.params;
        require(within(p.base_color, 0, 1) && within(p.metallic, 0, 1) &&
                    within(p.roughness, 0, 1) && within(p.specular, 0, 1) &&
                    within(p.specular_color, 0, largest) && within(p.emission, 0, largest),
                "material factors are in range", material.name);
        for (const TextureUse& use : material.textures) {
            require(use.texture >= -1 && use.texture < static_cast<int>(scene.textures.size()) &&
                        (use.uv_set == 0 || use.uv_set == 1),
                    "textures are in range", material.name);
        }
        requireOneLine(material.name);
    }
    for (const Texture& texture : scene.textures) {
        require(texture.image >= 0 && texture.image < static_cast<int>(scene.images.size()),
                "images are in range");
    }
    for (const TextureImage& image : scene.images) {
        const size_t texels = 4 * image.texelCount();
        require(image.width > 0 && image.height > 0 &&
                    image.bytes.size() + image.words.size() == texels &&
                    (image.bytes.empty() || image.words.empty()),
                "images have the texels of their size");
    }
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const MaterialParams p = materialAt(scene, static_cast<uint32_t>(i), vec3(1, 0, 0));
        const float most = 1.0f + kUnitTolerance;
        require(within(p.base_color, 0, most) && within(p.metallic, 0, most) &&
                    within(p.roughness, 0, most) && within(p.specular, 0, most),
                "textured materials are in range");
        require(p.emission == emissionAt(scene, static_cast<uint32_t>(i), vec3(1, 0, 0)),
                "emission is emission");
        require(within(meanEmission(scene, static_cast<uint32_t>(i)), 0, largest),
                "mean emission is in range");
    }
}

void checkLights(const Scene& scene) {
    require(scene.light_names.size() == scene.lights.size(), "every light has a name");
    const float largest = std::numeric_limits<float>::max();
    for (const PunctualLight& light : scene.lights) {
        require(finite(light.position) && unit(light.direction), "lights are somewhere");
        require(within(light.intensity, 0, largest) && within(light.inverse_range, 0, largest) &&
                    std::isfinite(light.spot_scale) && std::isfinite(light.spot_offset) &&
                    within(light.cos_outer, -1, 1),
                "light factors are in range");
    }
    for (const std::string& name : scene.light_names) {
        requireOneLine(name);
    }
}

void checkCameras(const Scene& scene) {
    require(!scene.cameras.empty(), "there is a camera");
    for (const Camera& camera : scene.cameras) {
        const mat4& m = camera.world_from_camera;
        require(finite(vec3(m[3])), "cameras are somewhere", camera.name);
        require(unit(vec3(m[0])) && unit(vec3(m[1])) && unit(vec3(m[2])) &&
                    std::abs(glm::dot(m[0], m[1])) < kUnitTolerance &&
                    std::abs(glm::determinant(mat3(m)) - 1.0f) < 10 * kUnitTolerance,
                "cameras are rigid", camera.name);
        require(std::isfinite(camera.aspect) && camera.aspect >= 0.0f, "an aspect is a ratio");
        const CameraRay left = cameraRay(camera, 4, 4, 0, 0);
        const CameraRay right = cameraRay(camera, 4, 4, 3, 0);
        require(unit(left.direction) && unit(right.direction), "camera rays have a direction");
        require(glm::dot(right.direction - left.direction, vec3(m[0])) > -kUnitTolerance,
                "x grows to the right in the image", camera.name);
        requireOneLine(camera.name);
    }
}

}  // namespace

// With the buffer beside it that a seed names.
const InputFile& inputFile() {
    static const InputFile file("scene.glb");
    static const bool made = (file.addNeighbour("data.bin", std::string(36, '?')), true);
    (void)made;
    return file;
}

}  // namespace sheen::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace sheen;
    static const fuzz::InputFile& file = fuzz::inputFile();
    const std::string& path = file.write(data, size);
    try {
        const Scene scene = loadScene(path);
        fuzz::checkGeometry(scene);
        fuzz::checkMaterials(scene);
        fuzz::checkLights(scene);
        fuzz::checkCameras(scene);
        for (const std::string& warning : scene.warnings) {
            fuzz::requireOneLine(warning);
        }
    } catch (const Error& error) {
        fuzz::requireInputError(error, path);
    }
    return 0;
}
