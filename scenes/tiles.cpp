// A room with a tiled floor and a bossed column, both by normal maps alone: what light a bump gets
// is told by records of the smooth surface below it.
#include <algorithm>
#include <cmath>

#include "scenes/all_scenes.h"
#include "scenes/png.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr int kSize = 256;             // texels of the map, a side
constexpr int kTile = 64;              // of a tile
constexpr double kRounded = 12.0;      // of its rim
constexpr double kRim = 4.2;           // its height: slopes up to 0.7
constexpr double kDome = 3.0;          // a tile's middle above its rim
constexpr double kColumn = 1.0 / kPi;  // radius: two maps, of a metre each, around

// Of the bumps, in texels; repeats.
double heightAt(int x, int y) {
    const auto within = [](int at) {
        return (static_cast<double>((at % kSize + kSize) % kTile) + 0.5) / kTile;
    };
    const double u = within(x), v = within(y);
    const double inward = kTile * std::min({u, 1.0 - u, v, 1.0 - v});
    const double rim = 1.0 - std::min(inward / kRounded, 1.0);
    return kRim * (1.0 - rim * rim) + 16.0 * kDome * u * (1.0 - u) * v * (1.0 - v);
}

std::vector<uint8_t> normalMap() {
    Picture map{kSize, kSize, {}};
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            const double along = 0.5 * (heightAt(x + 1, y) - heightAt(x - 1, y));
            const double down = 0.5 * (heightAt(x, y + 1) - heightAt(x, y - 1));
            const dvec3 normal = glm::normalize(dvec3(-along, down, 1.0));
            std::array<uint8_t, 3> texel{};
            for (int c = 0; c < 3; ++c) {
                texel[static_cast<size_t>(c)] =
                    static_cast<uint8_t>(std::lround(127.5 * (normal[c] + 1.0)));
            }
            map.pixels.push_back(texel);
        }
    }
    return encodePng(map);
}

}  // namespace

Model tiles() {
    Model model;
    model.textures = {normalMap()};
    const auto paint = [&](const char* name, const dvec3& color, int normal_texture) {
        return model.add(
            {.name = name, .base_color = color, .specular = 0.0, .normal_texture = normal_texture});
    };
    const int plaster = paint("plaster", {0.72, 0.70, 0.66}, -1);
    const int red = paint("red wall", {0.66, 0.30, 0.22}, -1);
    const int stone = paint("bossed stone", {0.70, 0.66, 0.58}, 0);
    const int glazed = model.add({.name = "glazed tiles",
                                  .base_color = {0.34, 0.42, 0.44},
                                  .roughness = 0.45,
                                  .normal_texture = 0});
    const std::array<Mesh, 6> walls = roomWalls(dvec3(-2.5, 0.0, -3.0), dvec3(2.5, 2.8, 3.0));
    model.add("left wall", walls[0], red);
    model.add("right wall", walls[1], plaster);
    model.add("floor", walls[2], glazed);
    model.add("ceiling", walls[3], plaster);
    model.add("far wall", walls[4], plaster);
    model.add("near wall", walls[5], plaster);
    Mesh column;
    addLathe(column, {{kColumn, 0.0}, {kColumn, 2.8}}, 48);
    model.add("column", column, stone, {placement(dvec3(0.9, 0.0, -0.8))});
    model.lights.push_back({.name = "uplight",
                            .type = "spot",
                            .position = dvec3(-1.8, 1.2, -1.8),
                            .target = dvec3(-2.5, 2.8, -2.4),
                            .color = dvec3(1.0, 0.94, 0.86),
                            .intensity = 160.0,
                            .inner_cone = 20.0 * kDegree,
                            .outer_cone = 60.0 * kDegree});
    model.lights.push_back({.name = "lamp",
                            .type = "point",
                            .position = dvec3(1.9, 2.3, 1.6),
                            .color = dvec3(1.0, 0.90, 0.78),
                            .intensity = 12.0});
    model.cameras.push_back({.name = "room",
                             .position = dvec3(-0.6, 1.25, 2.7),
                             .target = dvec3(0.2, 0.75, -1.0),
                             .y_fov = 52.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
