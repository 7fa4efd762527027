// sheen info: what a scene file holds, as Sheen reads it.
#include <memory>

#include "cli/commands.h"
#include "cli/options.h"
#include "cli/output.h"
#include "receivers/classes.h"
#include "record/record.h"
#include "scene/scene.h"

namespace sheen::cli {
namespace {

constexpr float kDegreesPerRadian = 180.0f / kPi;

struct InfoOptions {
    std::string scene;
    std::string json;
};

const char* lightKind(int kind) {
    switch (kind) {
        case shared::LIGHT_POINT:
            return "point";
        case shared::LIGHT_SPOT:
            return "spot";
        default:
            return "directional";
    }
}

Json materialJson(const Scene& scene, const Material& material) {
    const MaterialParams& params = material.params;
    return {{"name", material.name},
            {"roughness", params.roughness},
            {"alpha", shared::alphaFromRoughness(params.roughness)},
            {"metallic", params.metallic},
            {"base_color", jsonFrom(params.base_color)},
            {"textured", material.textured()},
            {"sh_order", materialOrder(scene, material, 0)},
            {"emission", jsonFrom(params.emission)}};
}

Json sceneJson(const std::string& path, const Scene& scene) {
    Json json = {{"scene", path},
                 {"triangles", scene.triangles.size()},
                 {"vertices", scene.positions.size()},
                 {"materials", Json::array()},
                 {"textures", Json::array()},
                 {"lights", Json::array()},
                 {"cameras", Json::array()},
                 {"features", Json::array()},
                 {"bounds", nullptr},
                 {"warnings", scene.warnings}};
    for (const Scene::Feature& feature : scene.features) {
        json["features"].push_back({{"name", feature.name}, {"treatment", feature.treatment}});
    }
    for (const Material& material : scene.materials) {
        json["materials"].push_back(materialJson(scene, material));
    }
    for (const Texture& texture : scene.textures) {
        const TextureImage& image = scene.images[static_cast<size_t>(texture.image)];
        json["textures"].push_back({{"size", {image.width, image.height}}});
    }
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        const PunctualLight& light = scene.lights[i];
        json["lights"].push_back({{"name", scene.light_names[i]},
                                  {"kind", lightKind(light.kind)},
                                  {"intensity", jsonFrom(light.intensity)}});
    }
    for (const Camera& camera : scene.cameras) {
        json["cameras"].push_back(
            {{"name", camera.name},
             {"position", jsonFrom(scene.inFile(vec3(camera.world_from_camera[3])))},
             {"vertical_fov_degrees", camera.y_fov * kDegreesPerRadian}});
    }
    if (!scene.bounds.empty()) {
        json["bounds"] = {{"lower", jsonFrom(scene.inFile(scene.bounds.lower))},
                          {"upper", jsonFrom(scene.inFile(scene.bounds.upper))}};
    }
    return json;
}

std::string textFrom(const vec3& v) { return fmt::format("({:.4g} {:.4g} {:.4g})", v.x, v.y, v.z); }

// A point, in the file's coordinates: to the millimetre, far from their origin.
std::string placeFrom(const Scene& scene, const vec3& p) {
    const dvec3 place = scene.inFile(p);
    return scene.origin == dvec3(0.0)
               ? textFrom(p)
               : fmt::format("({:.3f} {:.3f} {:.3f})", place.x, place.y, place.z);
}

void printScene(const std::string& path, const Scene& scene) {
    fmt::print(
        "{}: {} triangles, {} vertices, {} materials, {} textures, {} lights, "
        "{} cameras\n",
        path, scene.triangles.size(), scene.positions.size(), scene.materials.size(),
        scene.textures.size(), scene.lights.size(), scene.cameras.size());
    if (!scene.bounds.empty()) {
        fmt::print("bounds {} to {}\n", placeFrom(scene, scene.bounds.lower),
                   placeFrom(scene, scene.bounds.upper));
    }
    for (const Scene::Feature& feature : scene.features) {
        fmt::print("uses {}: {}\n", feature.name, feature.treatment);
    }
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& material = scene.materials[i];
        const MaterialParams& params = material.params;
        const int order = materialOrder(scene, material, 0);
        fmt::print(
            "material {} {}: roughness {:.3g} (alpha {:.3g}), metallic {:.3g}{}{}; {}\n", i,
            material.name, params.roughness, shared::alphaFromRoughness(params.roughness),
            params.metallic, material.textured() ? ", textured" : "",
            params.emission == vec3(0.0f) ? "" : ", emits " + textFrom(params.emission),
            order == shared::DIFFUSE_ORDER
                ? "cached as irradiance"
                : fmt::format("cached at SH order {}, by rays where that is too few", order));
    }
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        const PunctualLight& light = scene.lights[i];
        fmt::print("light {} {}: {}, {} {}\n", i, scene.light_names[i], lightKind(light.kind),
                   textFrom(light.intensity),
                   light.kind == shared::LIGHT_DIRECTIONAL ? "lux" : "candela");
    }
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
        const Camera& camera = scene.cameras[i];
        fmt::print("camera {} {}: at {}, {:.4g} degrees high\n", i, camera.name,
                   placeFrom(scene, vec3(camera.world_from_camera[3])),
                   camera.y_fov * kDegreesPerRadian);
    }
}

ExitCode runInfo(const InfoOptions& o) {
    const Scene scene = loadScene(o.scene);
    checkOutputs({{"--json", o.json}}, scene.files);
    for (const std::string& warning : scene.warnings) {
        warn(warning);
    }
    writeJson(o.json, sceneJson(o.scene, scene));
    if (wantsText(o.json)) {
        printScene(o.scene, scene);
    }
    return ExitCode::kDone;
}

}  // namespace

Command addInfo(CLI::App& program) {
    CLI::App* app = program.add_subcommand("info", "Tell what a scene holds");
    const auto options = std::make_shared<InfoOptions>();
    addSceneOption(*app, options->scene);
    app->add_option("--json", options->json, "File for all figures as JSON; -: standard output")
        ->type_name("FILE")
        ->check(fileName());
    return {app, [options] { return runInfo(*options); }};
}

}  // namespace sheen::cli
