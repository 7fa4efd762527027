// A scene that changes over time, by an animation of its file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace sheen {

/// What differs between a scene at one time and at another.
enum class SceneChange {
    kNothing,  ///< all bits are the same
    kCameras,  ///< nothing else is different
    kScene,    ///< geometry or lights are
};

/// A file that is read once, and its scene at any time. Nodes move, and with them meshes, skins,
/// lights and cameras; morph targets, by weights; lights and fields of view as
/// KHR_animation_pointer says. Materials, textures, sky, the studio of files without light and the
/// camera of those without any stay as they are; so does the origin of world space, which is that
/// of the scene at rest.
class AnimatedScene {
  public:
    /// At rest, as loadScene() has it. `animation`: its name or index; empty: the file's first.
    /// Errors as loadScene(), and: usage error where there is no such animation; input error where
    /// it is broken.
    explicit AnimatedScene(const std::string& path, const LoadParams& params = {},
                           const std::string& animation = {});
    ~AnimatedScene();
    AnimatedScene(const AnimatedScene&) = delete;
    AnimatedScene& operator=(const AnimatedScene&) = delete;

    /// As it was moved last. Its place in memory stays the same; where a move is of cameras alone,
    /// that of its geometry, too, so that what was made of it holds.
    const Scene& scene() const;

    /// Moves it to a time, and says what that changed. Before the animation's first key it stands
    /// as there, after its last likewise. Warnings of a new kind are appended to Scene::warnings.
    /// Input error where the scene cannot be rendered then; it must not be used any more.
    SceneChange moveTo(double seconds);

    /// Where vertices would lie at a time, without moving anything; none where the scene would have
    /// other triangles than it has now. Errors as moveTo().
    std::optional<std::vector<vec3>> positionsAt(double seconds);

    /// Of the animation, up to its last key; 0: the file has none, or one that moves nothing.
    double seconds() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// The scene of a file at a time.
Scene sceneAt(const std::string& path, double seconds, const LoadParams& params = {},
              const std::string& animation = {});

}  // namespace sheen
