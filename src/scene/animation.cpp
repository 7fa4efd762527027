#include "scene/animation.h"

#include <cstring>

#include "scene/gltf_animation.h"

namespace sheen {
namespace {

// Of a scene what time may change.
struct Places {
    std::vector<vec3> positions, normals;
    std::vector<vec2> uvs, second_uvs, lightmap_uvs;
    std::vector<vec4> colors, tangents;
    std::vector<uvec3> triangles;
    std::vector<uint32_t> materials_of;
    std::vector<PunctualLight> lights;
    std::vector<std::string> light_names;
    std::vector<Camera> cameras;
    Bounds bounds;
    std::vector<Scene::Object> objects;
    std::vector<Scene::Source> sources;
    std::vector<uvec4> source_corners;
};

void exchange(Places& places, Scene& scene) {
    std::swap(places.positions, scene.positions);
    std::swap(places.normals, scene.normals);
    std::swap(places.uvs, scene.uvs);
    std::swap(places.second_uvs, scene.second_uvs);
    std::swap(places.lightmap_uvs, scene.lightmap_uvs);
    std::swap(places.colors, scene.colors);
    std::swap(places.tangents, scene.tangents);
    std::swap(places.triangles, scene.triangles);
    std::swap(places.materials_of, scene.materials_of);
    std::swap(places.lights, scene.lights);
    std::swap(places.light_names, scene.light_names);
    std::swap(places.cameras, scene.cameras);
    std::swap(places.bounds, scene.bounds);
    std::swap(places.objects, scene.objects);
    std::swap(places.sources, scene.sources);
    std::swap(places.source_corners, scene.source_corners);
}

template <class T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
    static_assert(std::is_trivially_copyable_v<T>);
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool sameScene(const Places& a, const Scene& b) {
    return sameBits(a.positions, b.positions) && sameBits(a.normals, b.normals) &&
           sameBits(a.uvs, b.uvs) && sameBits(a.second_uvs, b.second_uvs) &&
           sameBits(a.lightmap_uvs, b.lightmap_uvs) && sameBits(a.colors, b.colors) &&
           sameBits(a.tangents, b.tangents) && sameBits(a.triangles, b.triangles) &&
           sameBits(a.materials_of, b.materials_of) && sameBits(a.lights, b.lights);
}

bool sameCamera(const Camera& a, const Camera& b) {
    return a.world_from_camera == b.world_from_camera && a.y_fov == b.y_fov && a.near == b.near &&
           a.aspect == b.aspect && a.name == b.name;
}

bool sameCameras(const std::vector<Camera>& a, const std::vector<Camera>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), sameCamera);
}

}  // namespace

struct AnimatedScene::Parts {
    gltf::File file;
    gltf::Animation animation;
    gltf::Additions additions = {};
    gltf::Notes said = {};  // in the scene's warnings
    Scene scene = {};
};

AnimatedScene::AnimatedScene(const std::string& path, const LoadParams& params,
                             const std::string& animation)
    : parts_(new Parts{
          .file = {.path = path, .model = {}, .keeps_sources = params.sources, .notes = {}},
          .animation = {}}) {
    Parts& p = *parts_;
    p.additions = gltf::load(p.file, params, p.scene);
    p.animation = gltf::readAnimation(p.file, animation);
    p.said = p.file.notes;
    p.scene.warnings = p.said.lines();
}

AnimatedScene::~AnimatedScene() = default;

const Scene& AnimatedScene::scene() const { return parts_->scene; }

double AnimatedScene::seconds() const { return parts_->animation.seconds; }

SceneChange AnimatedScene::moveTo(double seconds) {
    Parts& p = *parts_;
    gltf::pose(p.animation, seconds, p.file.model);
    Places before;
    exchange(before, p.scene);
    p.file.notes = {};
    gltf::placeAgain(p.file, p.additions, p.scene);
    const gltf::Notes news = p.file.notes.without(p.said);
    for (const std::string& line : news.lines()) {
        p.scene.warnings.push_back(line);
    }
    p.said.add(news);
    if (!sameScene(before, p.scene)) {
        return SceneChange::kScene;
    }
    const bool moved = !sameCameras(before.cameras, p.scene.cameras);
    std::swap(before.cameras, p.scene.cameras);
    exchange(before, p.scene);
    return moved ? SceneChange::kCameras : SceneChange::kNothing;
}

std::optional<std::vector<vec3>> AnimatedScene::positionsAt(double seconds) {
    Parts& p = *parts_;
    gltf::pose(p.animation, seconds, p.file.model);
    Places now;
    exchange(now, p.scene);
    gltf::placeAgain(p.file, p.additions, p.scene);
    exchange(now, p.scene);  // what it would be
    if (!sameBits(now.triangles, p.scene.triangles)) {
        return std::nullopt;
    }
    return std::move(now.positions);
}

Scene sceneAt(const std::string& path, double seconds, const LoadParams& params,
              const std::string& animation) {
    AnimatedScene animated(path, params, animation);
    animated.moveTo(seconds);
    return animated.scene();
}

}  // namespace sheen
