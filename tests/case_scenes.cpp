#include "case_scenes.h"

#include <fstream>

#include "core/error.h"
#include "scenes/shapes.h"

namespace sheen {
namespace {

using scenes::dvec3;
using scenes::Model;

constexpr double kNear = 2.0, kFar = -20.0;  // the corridor's ends along z; the near one is open

// Two walls, a ceiling and an end wall, all diffuse, and a floor of gloss.
Model corridor(double half_width, double height, double floor_color, double floor_roughness) {
    Model model;
    const int plaster = model.add({.name = "plaster", .base_color = dvec3(0.7), .specular = 0.0});
    const int floor = model.add(
        {.name = "floor", .base_color = dvec3(floor_color), .roughness = floor_roughness});
    const double w = half_width;
    const double h = height;
    const auto quad = [&](const char* name, const std::array<dvec3, 4>& corners, int material) {
        scenes::Mesh mesh;
        scenes::addQuad(mesh, corners);
        model.add(name, mesh, material);
    };
    quad("left wall",
         {dvec3(-w, 0, kFar), dvec3(-w, h, kFar), dvec3(-w, h, kNear), dvec3(-w, 0, kNear)},
         plaster);
    quad("right wall",
         {dvec3(w, 0, kFar), dvec3(w, 0, kNear), dvec3(w, h, kNear), dvec3(w, h, kFar)}, plaster);
    quad("ceiling",
         {dvec3(-w, h, kFar), dvec3(w, h, kFar), dvec3(w, h, kNear), dvec3(-w, h, kNear)}, plaster);
    quad("end wall", {dvec3(-w, 0, kFar), dvec3(w, 0, kFar), dvec3(w, h, kFar), dvec3(-w, h, kFar)},
         plaster);
    quad("floor", {dvec3(-w, 0, kNear), dvec3(w, 0, kNear), dvec3(w, 0, kFar), dvec3(-w, 0, kFar)},
         floor);
    return model;
}

void look(Model& model, double height, double slope, double y_fov) {
    const dvec3 eye(0.0, height, kNear - 0.2);
    model.cameras.push_back({.name = "along",
                             .position = eye,
                             .target = eye + dvec3(0.0, -slope, -1.0),
                             .y_fov = y_fov});
}

}  // namespace

Model polishedCorridor(double floor_roughness) {
    Model model = corridor(1.2, 2.5, 0.3, floor_roughness);
    for (const double z : {-3.0, -8.0, -13.0, -18.0}) {
        const dvec3 lamp(0.0, 2.4, z);
        model.lights.push_back({.name = "spot",
                                .type = "spot",
                                .position = lamp,
                                .target = lamp + dvec3(0.9, -1.0, 0.0),
                                .intensity = 40.0,
                                .inner_cone = 0.2,
                                .outer_cone = 0.6});
    }
    look(model, 0.35, 0.05 / 11.8, 0.7);
    return model;
}

Model brightEndWall(double floor_roughness, double eye_height, double slope) {
    Model model = corridor(2.5, 3.0, 0.05, floor_roughness);
    const dvec3 lamp(0.0, 2.6, -17.0);
    model.lights.push_back({.name = "spot",
                            .type = "spot",
                            .position = lamp,
                            .target = lamp + dvec3(0.0, -0.35, -1.0),
                            .intensity = 400.0,
                            .inner_cone = 0.3,
                            .outer_cone = 0.9});
    look(model, eye_height, slope, 1.0);
    return model;
}

std::vector<CaseScene> caseScenes() {
    return {{"grazing", polishedCorridor(0.4)},
            {"corridor_r25", polishedCorridor(0.25)},
            {"corridor_r60", polishedCorridor(0.6)},
            {"seam_r80", brightEndWall(0.8, 1.2, 0.25)},
            {"seam_r100", brightEndWall(1.0, 1.5, 5.0 / 12.0)}};
}

void writeScene(const Model& model, const std::filesystem::path& path) {
    const std::vector<uint8_t> bytes = scenes::encodeGlb(model);
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
        throwEnvironment("{}: cannot be written", path.string());
    }
}

}  // namespace sheen
