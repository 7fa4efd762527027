#include "cli/mattes.h"

#include <fmt/format.h>

#include <set>

namespace sheen::cli {
namespace {

// As it is, or with the first number that makes it one of its own.
std::string onlyName(const std::string& name, std::set<std::string>& taken) {
    std::string own = name;
    for (int i = 2; !taken.insert(own).second; ++i) {
        own = fmt::format("{} {}", name, i);
    }
    return own;
}

MatteNames materialsOf(const Scene& scene) {
    MatteNames mattes{.layer = "CryptoMaterial", .names = {}, .of = scene.materials_of};
    std::set<std::string> taken;
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const std::string& name = scene.materials[i].name;
        mattes.names.push_back(
            onlyName(name.empty() ? fmt::format("material {}", i) : name, taken));
    }
    return mattes;
}

MatteNames objectsOf(const Scene& scene) {
    MatteNames mattes{.layer = "CryptoObject", .names = {}, .of = {}};
    std::set<std::string> taken;
    for (const Scene::Object& object : scene.objects) {
        mattes.of.resize(object.first_triangle, static_cast<uint32_t>(mattes.names.size()) - 1);
        mattes.names.push_back(onlyName(object.name, taken));
    }
    mattes.of.resize(static_cast<size_t>(scene.triangleCount()),
                     static_cast<uint32_t>(mattes.names.size()) - 1);
    return mattes;
}

}  // namespace

std::vector<Matte> mattesOf(const Scene& scene, const Frame& frame) {
    return {makeMatte(frame, materialsOf(scene)), makeMatte(frame, objectsOf(scene))};
}

}  // namespace sheen::cli
