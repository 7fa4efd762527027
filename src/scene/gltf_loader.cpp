// The glTF loader: parses the file, then walks its nodes, appending meshes, lights and cameras in
// world space, about an origin that suits the camera. Never trusts the file: see gltf_parts.h.
// Based on: the glTF 2.0 specification.
#include <algorithm>
#include <cmath>

#include "scene/defaults.h"
#include "scene/gltf_parts.h"
#include "scene/scene_bytes.h"
#include "scene/sun.h"

namespace sheen {
namespace gltf {
namespace {

// Where world space should begin, in its present coordinates: where the camera stands, if what is
// nearest to it lies so much nearer than the present origin that floats would lose it; else there.
vec3 betterOrigin(const Scene& scene, const LoadParams& params) {
    constexpr float kFarthest = 256.0f;
    vec3 eye = scene.bounds.center();
    float nearest = scene.bounds.size();  // a camera is made that frames them
    if (!scene.cameras.empty() || params.view.at) {
        eye = params.view.at ? vec3(*params.view.at - scene.origin)
                             : vec3(findCamera(scene, params.camera).world_from_camera[3]);
        nearest = kInfinity;
        for (const vec3& p : scene.positions) {
            nearest = std::min(nearest, glm::distance(p, eye));
        }
    }
    const bool lost = !scene.bounds.empty() && maxAbs(eye) > kFarthest * nearest;
    return lost ? eye : vec3(0.0f);
}

// Fills geometry, lights and cameras.
void flatten(File& file, const LoadParams& params, Scene& scene) {
    const Notes notes = file.notes;
    appendNodes(file, scene);
    const vec3 origin = betterOrigin(scene, params);
    if (origin == vec3(0.0f)) {
        return;
    }
    // Anew from doubles, since what is there has lost digits.
    file.notes = notes;
    file.parallel_cameras.clear();
    Scene again;
    again.materials = std::move(scene.materials);
    again.textures = std::move(scene.textures);
    again.images = std::move(scene.images);
    again.origin = dvec3(origin);
    scene = std::move(again);
    appendNodes(file, scene);
}

void checkExtent(const File& file, const Scene& scene) {
    const Bounds& b = scene.bounds;
    if (b.empty()) {
        return;
    }
    const double farthest =
        std::max(glm::length(scene.inFile(b.lower)), glm::length(scene.inFile(b.upper)));
    if (farthest > kLargestExtent) {
        file.fail("meshes", "reach {} m from the origin, more than {}; move or scale them",
                  farthest, kLargestExtent);
    }
    const double size = glm::length(glm::dvec3(b.upper) - glm::dvec3(b.lower));
    if (size > kLargestExtent) {
        file.fail("meshes", "together they extend over {} m, more than {}; scale or mend them",
                  size, kLargestExtent);
    }
}

// A sky of the user's or the file's, whose sun shines as a light of its own.
void addEnvironment(File& file, const EnvironmentParams& environment, Scene& scene) {
    std::vector<std::string> warnings;
    scene.environment = environment.source.empty()
                            ? loadSky(file)
                            : loadEnvironment(environment, file.read, warnings);
    scene.environment.visible = !environment.transparent;
    for (const std::string& warning : warnings) {
        file.notes.add(warning);
    }
    if (scene.lightmapped) {
        return;  // the sun's light is in them: it is seen where it is, and lights nothing
    }
    if (const auto sun = takeOutSun(scene.environment)) {
        scene.lights.push_back(*sun);
        scene.light_names.push_back("sun");
        file.notes.add(fmt::format(
            "{}: its sun, {:.3g} lux, is taken out of the image and shines as a directional light",
            environment.source.empty() ? "the file's sky" : environment.source,
            luminance(sun->intensity)));
    }
}

// Light for a scene without any.
void addStudio(File& file, const EnvironmentParams& environment, Scene& scene) {
    scene.lights.push_back(keyLight(scene.cameras.front()));
    scene.light_names.push_back("default");
    if (!environment.no_sky) {
        scene.environment = studioSky(scene.cameras.front());
        scene.environment.visible = !environment.transparent;
    }
    file.notes.add(
        environment.no_sky
            ? "the scene has no light and nothing that emits: lit by a key light from above, "
              "to the left of its first view; --gather ray lights it by a studio's sky as well"
            : "the scene has no light and nothing that emits: lit by a studio's grey sky and a "
              "key light from above, to the left of its first view; --environment lights it by "
              "another sky or, by none, not at all");
}

// What is to hold of a scene wherever its nodes stand.
void finishPlaces(File& file, Scene& scene) {
    checkExtent(file, scene);
    placeParallelCameras(file, scene);
    checkLightLevel(file, scene);
}

// A view of the user's that looks at what stays in place.
LoadParams fixedView(const LoadParams& params, const Scene& scene) {
    LoadParams fixed = params;
    if (fixed.view.at && !fixed.view.look_at) {
        fixed.view.look_at = scene.inFile(scene.bounds.center());
    }
    return fixed;
}

void addView(const LoadParams& params, Scene& scene) {
    if (params.view.given()) {
        scene.cameras.insert(scene.cameras.begin(), seenFrom(scene, params));
    }
}

void read(File& file, const LoadParams& params, Scene& scene) {
    parse(file);
    chooseVariant(file, params.variant);
    loadMaterials(file, params.lightmaps, scene);
    checkMeshMemory(file);
    flatten(file, params, scene);
    finishPlaces(file, scene);
    dropIdleBlending(scene);
    settleLightmaps(file, params.lightmaps, scene);
    separateCoplanar(file, scene);
}

}  // namespace

Additions load(File& file, const LoadParams& params, Scene& scene) {
    const EnvironmentParams& environment = params.environment;
    try {
        read(file, params, scene);
    } catch (const std::bad_alloc&) {
        throwEnvironment("{}: not enough memory to load it", file.path);
    }
    const auto of_nodes = static_cast<std::ptrdiff_t>(scene.lights.size());
    noteIgnoredParts(file);
    listFeatures(file, scene);
    addEnvironment(file, environment, scene);
    if (scene.triangles.empty()) {
        file.notes.add("the scene has no geometry");
    }
    Additions additions;
    if (scene.cameras.empty()) {
        additions.camera = framingCamera(scene);
        scene.cameras.push_back(*additions.camera);
        if (!scene.triangles.empty() && !params.view.at) {
            file.notes.add(
                "the scene has no camera: seen from the front and the side, all of it in view; "
                "--camera-at and --look-at see it from elsewhere");
        }
    }
    if (!scene.triangles.empty() && environment.source != "none" && isDark(scene)) {
        addStudio(file, environment, scene);
    }
    additions.lights.assign(scene.lights.begin() + of_nodes, scene.lights.end());
    additions.light_names.assign(scene.light_names.begin() + of_nodes, scene.light_names.end());
    additions.params = fixedView(params, scene);
    addView(params, scene);
    scene.files = std::move(file.read);
    scene.files.push_back(file.path);
    return additions;
}

void placeAgain(File& file, const Additions& additions, Scene& scene) {
    file.parallel_cameras.clear();
    appendNodes(file, scene);
    finishPlaces(file, scene);
    separateCoplanar(file, scene);
    scene.lights.insert(scene.lights.end(), additions.lights.begin(), additions.lights.end());
    scene.light_names.insert(scene.light_names.end(), additions.light_names.begin(),
                             additions.light_names.end());
    if (scene.cameras.empty() && additions.camera) {
        scene.cameras.push_back(*additions.camera);
    }
    addView(additions.params, scene);
}

}  // namespace gltf

namespace {

Scene atRest(gltf::File& file, const LoadParams& params) {
    Scene scene;
    gltf::load(file, params, scene);
    if (file.animated()) {
        file.notes.add(
            "the file is animated: shown at rest; sheen animate shows it as time passes");
    }
    scene.warnings = file.notes.lines();
    return scene;
}

}  // namespace

Scene loadScene(const std::string& path, const LoadParams& params) {
    gltf::File file{.path = path, .model = {}, .keeps_sources = params.sources, .notes = {}};
    return atRest(file, params);
}

Scene sceneFromBytes(const std::string& name, std::string bytes, const LoadParams& params) {
    if (bytes.empty()) {
        throwInput("{}: is empty", name);
    }
    gltf::File file{.path = name,
                    .bytes = std::move(bytes),
                    .model = {},
                    .keeps_sources = params.sources,
                    .notes = {}};
    return atRest(file, params);
}

}  // namespace sheen
