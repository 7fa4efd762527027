// Cameras, where their nodes put them.
#include <algorithm>
#include <cmath>

#include "scene/gltf_parts.h"

namespace sheen::gltf {

void appendCamera(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                  const std::string& where, Scene& scene) {
    const tinygltf::Camera& source = file.at(file.model.cameras, node.camera, where, "camera");
    const std::string camera_where = fmt::format("camera {}", node.camera);
    const bool parallel = source.type == "orthographic";
    const double y_fov = parallel ? Camera().y_fov : source.perspective.yfov;
    const bool in_range = y_fov > 0.0 && y_fov < 4.0;  // that a float holds
    if (!in_range || !(static_cast<float>(y_fov) > 0.0f) || !(static_cast<float>(y_fov) < kPi)) {
        file.fail(camera_where, "yfov must lie between 0 and pi radians, but is {}", y_fov);
    }
    if (parallel && !(source.orthographic.ymag > 0.0)) {
        file.fail(camera_where, "ymag must be positive, but is {}", source.orthographic.ymag);
    }
    // Only where it stands and looks: a camera's node may be scaled or mirrored.
    const glm::dvec3 back = glm::normalize(glm::dvec3(world_from_node[2]));
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(world_from_node[1]), back));
    const glm::dvec3 up = glm::cross(back, right);
    const glm::dmat4 rigid(glm::dvec4(right, 0.0), glm::dvec4(up, 0.0), glm::dvec4(back, 0.0),
                           world_from_node[3]);
    if (!std::isfinite(glm::dot(back, back) + glm::dot(right, right))) {
        file.notes.add("camera whose transform is singular left out");
        return;
    }
    scene.cameras.push_back(
        {.name = firstName(source.name, node.name, "camera", scene.cameras.size()),
         .world_from_camera = mat4(rigid),
         .y_fov = static_cast<float>(y_fov),
         .aspect = std::max(0.0f, finiteFloat(file, source.perspective.aspectRatio, camera_where,
                                              "aspectRatio"))});
    if (parallel) {
        file.parallel_cameras.push_back(
            {.camera = scene.cameras.size() - 1,
             .half_height = finiteFloat(file, source.orthographic.ymag, camera_where, "ymag"),
             .near = finiteFloat(file, source.orthographic.znear, camera_where, "znear")});
    }
}

void placeParallelCameras(File& file, Scene& scene) {
    constexpr float kDistance = 200.0f;  // of the scene's size: 1/400 larger or smaller at its ends
    for (const File::ParallelCamera& parallel : file.parallel_cameras) {
        Camera& camera = scene.cameras[parallel.camera];
        const float back = kDistance * std::max(scene.bounds.size(), parallel.half_height);
        const vec3 axis(camera.world_from_camera[2]);
        const float to_middle =
            scene.bounds.empty()
                ? 0.0f
                : glm::dot(axis, vec3(camera.world_from_camera[3]) - scene.bounds.center());
        camera.world_from_camera[3] += vec4(back * axis, 0.0f);
        camera.near = back + std::max(parallel.near, 0.0f);
        camera.y_fov = 2.0f * std::atan(parallel.half_height / (back + to_middle));
        file.notes.add(
            "orthographic camera is approximated: seen from afar, in perspective that converges "
            "by less than 1 in 200");
    }
}

}  // namespace sheen::gltf
