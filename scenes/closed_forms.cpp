// Two rooms whose light is known in closed form.
#include "scenes/all_scenes.h"
#include "scenes/shapes.h"

namespace sheen::scenes {

// Everything emits the radiance 1, so that every point sees 1 from every direction: reflected light
// is the directional albedo, at every pixel.
Model furnace() {
    constexpr double kRadius = 0.32;
    const dvec3 emission(1.0);
    Model model;
    const auto sphere = [&](const char* name, const dvec3& center, const MaterialSpec& material) {
        Mesh mesh;
        addSphere(mesh, center, kRadius, 4);
        model.add(name, mesh, model.add(material));
    };
    Mesh walls;
    for (const Mesh& wall : roomWalls(dvec3(-2, 0, -2), dvec3(2, 3, 2))) {
        walls.append(wall);
    }
    model.add(
        "walls", walls,
        model.add(
            {.name = "walls", .base_color = dvec3(0.5), .specular = 0.0, .emission = emission}));
    sphere("diffuse sphere", dvec3(-1.2, 0.5, -0.6),
           {.name = "diffuse",
            .base_color = dvec3(0.7, 0.5, 0.3),
            .specular = 0.0,
            .emission = emission});
    sphere("plastic sphere", dvec3(-0.4, 0.5, -0.6),
           {.name = "plastic, alpha 0.3",
            .base_color = dvec3(0.5, 0.2, 0.2),
            .roughness = roughnessFromAlpha(0.3),
            .emission = emission});
    sphere("metal sphere", dvec3(0.4, 0.5, -0.6),
           {.name = "metal, alpha 0.4",
            .base_color = dvec3(0.9, 0.7, 0.4),
            .metallic = 1.0,
            .roughness = roughnessFromAlpha(0.4),
            .emission = emission});
    sphere("rough metal sphere", dvec3(1.2, 0.5, -0.6),
           {.name = "metal, alpha 0.6",
            .base_color = dvec3(0.8),
            .metallic = 1.0,
            .roughness = roughnessFromAlpha(0.6),
            .emission = emission});
    model.cameras.push_back({.name = "inside",
                             .position = dvec3(0.0, 1.1, 1.7),
                             .target = dvec3(0.0, 0.6, -0.6),
                             .y_fov = 60.0 * kDegree});
    return model;
}

// A diffuse sphere of radius 1 and albedo 0.5 with a point light of pi candela at its centre. All
// walls receive E = pi; leave E * albedo / pi = 0.5 directly, and after one bounce 0.25,
// everywhere.
Model sphereRoom() {
    Model model;
    Mesh mesh;
    addSphere(mesh, dvec3(0.0), 1.0, 5, true);
    model.add("sphere", mesh,
              model.add({.name = "grey", .base_color = dvec3(0.5), .specular = 0.0}));
    model.lights.push_back({.name = "centre", .type = "point", .intensity = kPi});
    model.cameras.push_back({.name = "inside",
                             .position = dvec3(0.3, -0.2, 0.55),
                             .target = dvec3(-0.2, 0.1, -1.0),
                             .y_fov = 60.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
