// A room in surroundings far larger than it is, far from the file's origin, tiny or huge: as good
// as the plain room, by every method. Before surfaces were left by steps of their own, and world
// space had its origin near the camera, all of these failed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "case_scenes.h"
#include "core/error.h"
#include "metrics/compare.h"
#include "raster/gbuffer.h"
#include "rays/tracer.h"
#include "render/render.h"
#include "scenes/shapes.h"
#include "test_folder.h"
#include "test_scenes.h"

namespace sheen {
namespace {

using scenes::Model;
using Point = scenes::dvec3;

constexpr int kWidth = 48, kHeight = 36;

// What of the plain room differs.
struct Place {
    const char* name;
    double scale = 1.0;
    Point moved{0.0};     // by nodes
    double dome = 0.0;    // radius of a black sphere around the file's origin; 0: none
    double stray = 0.0;   // how far off a quad lies; 0: there is none
    double ground = 0.0;  // half-width of a black quad below the room; 0: there is none
    bool sun = false;     // instead of a lamp
    bool card = false;    // a centimetre before the camera
    double shade = 0.03;  // how far below the lamp a small black quad hangs
};
void PrintTo(const Place& place, std::ostream* out) { *out << place.name; }

// A square of half-width `half` about `center`, facing +z or +y.
scenes::Mesh square(const Point& center, double half, bool upward) {
    const Point u(half, 0, 0), v = upward ? Point(0, 0, -half) : Point(0, half, 0);
    scenes::Mesh mesh;
    scenes::addQuad(mesh, {center - u - v, center + u - v, center + u + v, center - u + v});
    return mesh;
}

// Open to the camera: coloured walls, a box, a sphere with some gloss; a lamp with a shade, or a
// sun.
Model roomAt(const Place& place) {
    Model model;
    const int white = model.add({.name = "white", .base_color = Point(0.7), .specular = 0.0});
    const int red = model.add({.name = "red", .base_color = {0.6, 0.1, 0.1}, .specular = 0.0});
    const int green = model.add({.name = "green", .base_color = {0.1, 0.5, 0.1}, .specular = 0.0});
    const int plastic = model.add({.name = "plastic", .base_color = Point(0.6), .roughness = 0.6});
    const int black = model.add({.name = "black", .base_color = Point(0.0), .specular = 0.0});
    const auto add = [&](const char* name, const scenes::Mesh& mesh, int material) {
        model.add(name, mesh, material, {scenes::placement(place.moved)});
    };
    const std::array<scenes::Mesh, 6> walls = scenes::roomWalls(Point(-2, 0, -2), Point(2, 2.5, 2));
    const int colours[] = {red, green, white, white, white};
    for (size_t i = 0; i < 5; ++i) {
        add("wall", walls[i], colours[i]);
    }
    scenes::Mesh box;
    scenes::addBox(box, Point(-1.2, 0, -1), Point(-0.3, 1.2, -0.1));
    add("box", box, white);
    scenes::Mesh sphere;
    scenes::addSphere(sphere, Point(0.8, 0.6, 0.2), 0.6, 3);
    add("sphere", sphere, plastic);
    const Point lamp = Point(0.5, 2.1, 0.3);
    add("shade", square(lamp - Point(0, place.shade, 0), place.shade, true), black);
    if (place.card) {
        add("card", square(Point(0.002, 1.3, 4.99), 0.001, false), white);
    }
    if (place.dome > 0.0) {
        scenes::Mesh sky;
        scenes::addSphere(sky, Point(0.0), place.dome, 2, true);
        model.add("sky", sky, black);
    }
    if (place.ground > 0.0) {
        scenes::Mesh ground;
        const double g = place.ground;
        scenes::addQuad(ground, {Point(-g, -0.5, g), Point(g, -0.5, g), Point(g, -0.5, -g),
                                 Point(-g, -0.5, -g)});
        model.add("ground", ground, black);
    }
    if (place.stray > 0.0) {
        model.add("stray", square(Point(place.stray, 0, place.stray), 1.0, false), white);
    }
    model.lights.push_back({.name = "light",
                            .type = place.sun ? "directional" : "point",
                            .position = lamp + place.moved,
                            .target = lamp + place.moved + Point(-0.5, -1.0, -1.2),
                            .intensity = place.sun ? 5.0 : 20.0});
    const Point eye = Point(0, 1.3, 5) + place.moved;
    model.cameras.push_back(
        {.name = "camera", .position = eye, .target = eye - Point(0, 0.02, 1), .y_fov = 0.7});
    return model;
}

Scene load(const Place& place) {
    const TestFolder folder;
    const std::filesystem::path path = folder.path() / "room.glb";
    writeScene(roomAt(place), path);
    return loadScene(path.string());
}

RenderParams paramsFor(Method method, int spp) {
    RenderParams params;
    params.method = method;
    params.width = kWidth;
    params.height = kHeight;
    params.bounces = 1;
    params.caustics = 0;
    params.spp = spp;
    params.all_layers = true;
    params.quiet = true;
    return params;
}

struct Way {
    const char* name;
    RenderParams params;
};

std::vector<Way> waysToRender() {
    std::vector<Way> ways = {{"rays", paramsFor(Method::kRadiance, 0)},
                             {"hemicube", paramsFor(Method::kRadiance, 0)},
                             {"border", paramsFor(Method::kRadiance, 0)},
                             {"octree", paramsFor(Method::kOctree, 0)},
                             {"reference", paramsFor(Method::kReference, 256)}};
    ways[1].params.gather_road = ways[2].params.gather_road = GatherRoad::kRaster;
    ways[2].params.gather.kind = HemisphereKind::kBorder;
    return ways;
}

struct Errors {
    double indirect = 0.0, direct = 0.0;  // rel_rmse
};

Errors errorsOf(const Frame& test, const Frame& truth, bool diffuse_only) {
    const auto compare = [&](const Image<vec3>& a, const Image<vec3>& b,
                             const Image<vec3>* variance) {
        return compareImages({.test = a,
                              .reference = b,
                              .reference_variance = variance,
                              .test_primitive = &test.primitive,
                              .reference_primitive = &truth.primitive})
            .rel_rmse;
    };
    return {.indirect = diffuse_only
                            ? compare(test.indirect_diffuse, truth.indirect_diffuse,
                                      &truth.indirect_diffuse_variance)
                            : compare(test.indirect, truth.indirect, &truth.indirect_variance),
            .direct = compare(test.direct, truth.direct, nullptr)};
}

// The room's corner at -2, 0, -2, as a user is told of it.
TEST(FarScene, NodesCostNoDigitAndUsersSeeTheFilesCoordinates) {
    const Point moved(1e7 + 0.25, 3.0, -1e7 + 0.125);
    const Scene plain = load({.name = "plain"});
    const Scene far = load({.name = "far", .moved = moved});
    EXPECT_EQ(plain.origin, dvec3(0.0));
    ASSERT_EQ(far.positions.size(), plain.positions.size());
    for (size_t i = 0; i < far.positions.size(); ++i) {
        EXPECT_LT(glm::distance(far.inFile(far.positions[i]), dvec3(plain.positions[i]) + moved),
                  1e-6);
    }
    EXPECT_LT(
        glm::distance(far.inFile(far.lights[0].position), dvec3(plain.lights[0].position) + moved),
        1e-6);
    EXPECT_LT(glm::distance(far.inFile(vec3(far.cameras[0].world_from_camera[3])),
                            dvec3(vec3(plain.cameras[0].world_from_camera[3])) + moved),
              1e-6);
    RenderParams params = paramsFor(Method::kReference, 4);
    params.width = params.height = 8;
    const Frame here = renderFrame(plain, params).frame;
    const Frame there = renderFrame(far, params).frame;
    for (size_t i = 0; i < here.position.pixels.size(); ++i) {
        if (here.primitive.pixels[i] != kNoPrimitive) {
            EXPECT_LT(glm::distance(dvec3(there.position.pixels[i]),
                                    dvec3(here.position.pixels[i]) + moved),
                      2.0);  // floats there are whole
        }
    }
}

// Two rooms, and a camera in each: world space is about the one that is asked for.
TEST(FarScene, TheChosenCamerasPlaceDecides) {
    Model both = roomAt({.name = "near"});
    const Model other = roomAt({.name = "far", .moved = {3e6, 0.0, 0.0}});
    both.objects.insert(both.objects.end(), other.objects.begin(), other.objects.end());
    both.cameras.push_back(other.cameras[0]);
    both.cameras[1].name = "far camera";
    const TestFolder folder;
    const std::filesystem::path path = folder.path() / "rooms.glb";
    writeScene(both, path);
    EXPECT_EQ(loadScene(path.string()).origin, dvec3(0.0));
    const Scene far = loadScene(path.string(), {.camera = "far camera"});
    EXPECT_LT(glm::distance(far.origin, dvec3(both.cameras[1].position)), 1.0);
    EXPECT_LT(glm::length(vec3(findCamera(far, "far camera").world_from_camera[3])), 1.0f);
    EXPECT_THROW(loadScene(path.string(), {.camera = "no such"}), Error);
}

std::vector<Bounds> boxesOf(const Place& place) {
    const Scene scene = load(place);
    const Tracer tracer(scene);
    return nearBoxes(scene, renderGBuffer(tracer, scene.cameras[0], kWidth, kHeight));
}

TEST(NearBoxes, NoneWhereARoomIsTheScene) {
    EXPECT_TRUE(boxesOf({.name = "plain"}).empty());
    EXPECT_TRUE(boxesOf({.name = "scaled", .moved = {1e6, 0.0, 0.0}}).empty());
}

TEST(NearBoxes, HoldTheRoomWhateverIsAroundIt) {
    const Place places[] = {{.name = "dome", .dome = 1e5},
                            {.name = "ground", .ground = 1e5},
                            {.name = "stray", .stray = 1e5}};
    for (const Place& place : places) {
        const std::vector<Bounds> boxes = boxesOf(place);
        ASSERT_FALSE(boxes.empty()) << place.name;
        for (size_t i = 0; i < boxes.size(); ++i) {
            const Bounds& within = boxes[i];
            EXPECT_TRUE(glm::all(glm::lessThanEqual(within.lower, vec3(-2, 0, -2)))) << place.name;
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(within.upper, vec3(2, 2.5, 2))))
                << place.name;
            EXPECT_TRUE(i == 0 || within.size() > 2.0f * boxes[i - 1].size()) << place.name;
        }
        EXPECT_LT(boxes[0].size(), 100.0f) << place.name;
    }
}

class Far : public testing::TestWithParam<Place> {};

TEST_P(Far, AsGoodAsThePlainRoom) {
    constexpr double kFactor = 1.2;
    // A pixel of the image on whose edge of a shadow rays disagree.
    constexpr double kOnEdges = 0.002;
    Place plain = GetParam();
    plain.scale = 1.0;
    plain.moved = Point(0.0);
    plain.dome = plain.stray = plain.ground = 0.0;
    const Scene room = load(plain);
    const Scene scene = GetParam().scale == 1.0
                            ? load(GetParam())
                            : scaled(room, static_cast<float>(GetParam().scale));
    RenderParams best = paramsFor(Method::kReference, 1024);
    best.seed = 9;
    const Frame truth = renderFrame(room, best).frame;
    for (const Way& way : waysToRender()) {
        const bool diffuse_only = way.params.method == Method::kOctree;
        const Errors before = errorsOf(renderFrame(room, way.params).frame, truth, diffuse_only);
        const RenderResult result = renderFrame(scene, way.params);
        const Errors errors = errorsOf(result.frame, truth, diffuse_only);
        std::printf("%s, %s: indirect %.2f%%, plain %.2f%%; direct %.2f%%, plain %.2f%%\n",
                    GetParam().name, way.name, 100.0 * errors.indirect, 100.0 * before.indirect,
                    100.0 * errors.direct, 100.0 * before.direct);
        EXPECT_LE(errors.indirect, kFactor * before.indirect) << way.name;
        EXPECT_LE(errors.direct, kFactor * before.direct + kOnEdges) << way.name;
        EXPECT_EQ(result.stats.nonfinite_pixels, 0);
        // Nothing is cut away: what the plain room shows is there.
        int gone = 0;
        for (size_t i = 0; i < truth.primitive.pixels.size(); ++i) {
            const uint32_t expected = truth.primitive.pixels[i];
            gone +=
                expected != kNoPrimitive && result.frame.primitive.pixels[i] != expected ? 1 : 0;
        }
        EXPECT_LE(gone, 2) << way.name;  // on edges
    }
}

INSTANTIATE_TEST_SUITE_P(
    Rooms, Far,
    testing::Values(Place{.name = "dome_1e5", .dome = 1e5},
                    Place{.name = "aside_in_dome", .moved = {4e4, 10.0, -3e4}, .dome = 1e5},
                    Place{.name = "card_in_dome", .dome = 1e5, .card = true},
                    Place{.name = "stray_1e5", .stray = 1e5},
                    Place{.name = "nodes_at_1e6", .moved = {1e6, 3.0, -1e6}},
                    Place{.name = "nodes_at_1e7", .moved = {-1e7, 35.0, 1e7}},
                    Place{.name = "scaled_1e-3", .scale = 1e-3},
                    Place{.name = "scaled_1e5", .scale = 1e5},
                    Place{.name = "sun_stray_1e5", .stray = 1e5, .sun = true},
                    Place{.name = "ground_1e5", .ground = 1e5},
                    Place{.name = "sun_ground_1e5", .ground = 1e5, .sun = true}),
    [](const testing::TestParamInfo<Place>& info) {
        std::string name = info.param.name;
        std::replace(name.begin(), name.end(), '-', '_');
        return name;
    });

}  // namespace
}  // namespace sheen
