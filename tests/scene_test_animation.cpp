// Files that move: what of a scene follows, and what is refused.
#include <cmath>

#include "scene/animation.h"
#include "scene_test_gltf.h"

namespace sheen {
namespace {

constexpr float kPoseRounding = 1e-6f;

// A triangle, a camera and a light, each by a node; the triangle's moves from x = 0 to 4 in 2 s.
GltfFile moving() {
    GltfFile file = oneTriangle();
    file.json["cameras"] =
        Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}});
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] =
        Json::array({{{"type", "point"}, {"intensity", 5.0}}});
    file.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
    file.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return file;
}

// Adds a channel of its own sampler to the file's animation.
Json& addChannel(GltfFile& file, const std::vector<float>& times, const std::vector<float>& values,
                 int components, const Json& target) {
    Json& animations = file.json["animations"];
    if (animations.is_null()) {
        animations = Json::array(
            {{{"name", "go"}, {"samplers", Json::array()}, {"channels", Json::array()}}});
    }
    const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const int input = file.addAccessor(times, kFloat, "SCALAR", 1);
    const int output = file.addAccessor(values, kFloat, types[components], components);
    animations[0]["channels"].push_back(
        {{"sampler", animations[0]["samplers"].size()}, {"target", target}});
    animations[0]["samplers"].push_back({{"input", input}, {"output", output}});
    return animations[0]["samplers"].back();
}

Json ofNode(int node, const char* path) { return {{"node", node}, {"path", path}}; }

Json ofPointer(const std::string& pointer) {
    return {{"path", "pointer"},
            {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
}

TEST(Animation, ANodeMovesItsMesh) {
    GltfFile file = moving();
    addChannel(file, {0, 2}, {0, 0, 0, 4, 0, 0}, 3, ofNode(0, "translation"));
    AnimatedScene animated(file.write());
    EXPECT_EQ(animated.seconds(), 2.0);
    EXPECT_EQ(animated.moveTo(0.5), SceneChange::kScene);
    EXPECT_NEAR(animated.scene().positions[0].x, 1.0f, kPoseRounding);
    EXPECT_NEAR(animated.scene().bounds.lower.x, 1.0f, kPoseRounding);
    EXPECT_EQ(animated.moveTo(9.0), SceneChange::kScene);
    EXPECT_NEAR(animated.scene().positions[0].x, 4.0f, kPoseRounding);
    EXPECT_EQ(animated.moveTo(10.0), SceneChange::kNothing) << "after the last key it stands";
    EXPECT_EQ(animated.moveTo(0.0), SceneChange::kScene);
    EXPECT_EQ(animated.scene().positions[0].x, 0.0f);
}

TEST(Animation, PositionsAreToldWithoutMoving) {
    GltfFile file = moving();
    addChannel(file, {0, 2}, {0, 0, 0, 4, 0, 0}, 3, ofNode(0, "translation"));
    AnimatedScene animated(file.write());
    animated.moveTo(0.5);
    const std::vector<vec3> before = animated.scene().positions;
    const auto then = animated.positionsAt(1.0);
    ASSERT_TRUE(then);
    ASSERT_EQ(then->size(), before.size());
    EXPECT_NEAR((*then)[0].x, 2.0f, kPoseRounding);
    EXPECT_EQ(animated.scene().positions, before);
    EXPECT_EQ(animated.moveTo(0.5), SceneChange::kNothing);
}

TEST(Animation, NoPositionsOfOtherTriangles) {
    GltfFile file = moving();
    addChannel(file, {0, 1}, {1, 1, 1, 0, 0, 0}, 3, ofNode(0, "scale"));
    AnimatedScene animated(file.write());
    EXPECT_TRUE(animated.positionsAt(0.5));
    EXPECT_FALSE(animated.positionsAt(1.0)) << "scaled to nothing, it has none";
}

TEST(Animation, TheOrderOfTimesDoesNotMatter) {
    GltfFile file = moving();
    addChannel(file, {0, 2}, {0, 0, 0, 4, 1, 0}, 3, ofNode(0, "translation"));
    addChannel(file, {0, 2}, {0, 0, 0, 1, 0, 1, 0, 0}, 4, ofNode(0, "rotation"));
    const std::string path = file.write();
    AnimatedScene animated(path);
    for (const double seconds : {1.3, 0.2, 5.0, 0.7}) {
        animated.moveTo(seconds);
    }
    const Scene alone = sceneAt(path, 0.7);
    ASSERT_EQ(alone.positions.size(), animated.scene().positions.size());
    for (size_t i = 0; i < alone.positions.size(); ++i) {
        EXPECT_EQ(alone.positions[i], animated.scene().positions[i]);
        EXPECT_EQ(alone.normals[i], animated.scene().normals[i]);
    }
}

TEST(Animation, ACameraThatMovesLeavesGeometryInPlace) {
    GltfFile file = moving();
    addChannel(file, {0, 1}, {0, 0, 5, 0, 2, 5}, 3, ofNode(1, "translation"));
    AnimatedScene animated(file.write());
    const vec3* positions = animated.scene().positions.data();
    EXPECT_EQ(animated.moveTo(0.5), SceneChange::kCameras);
    EXPECT_NEAR(animated.scene().cameras[0].world_from_camera[3].y, 1.0f, kPoseRounding);
    EXPECT_EQ(animated.scene().positions.data(), positions);
    EXPECT_EQ(animated.moveTo(0.5), SceneChange::kNothing);
    EXPECT_EQ(animated.scene().positions.data(), positions);
}

TEST(Animation, AViewOfOnesOwnStaysWhereTheSceneMoves) {
    GltfFile file = moving();
    addChannel(file, {0, 1}, {0, 0, 0, 9, 0, 0}, 3, ofNode(0, "translation"));
    LoadParams params;
    params.view.at = dvec3(0, 0, 3);
    AnimatedScene animated(file.write(), params);
    const mat4 before = animated.scene().cameras[0].world_from_camera;
    animated.moveTo(1.0);
    EXPECT_EQ(animated.scene().cameras[0].world_from_camera, before);
    EXPECT_EQ(animated.scene().cameras.size(), 2u);
}

TEST(Animation, LightsMoveAndChange) {
    GltfFile file = moving();
    file.json["extensionsUsed"].push_back("KHR_animation_pointer");
    addChannel(file, {0, 1}, {0, 0, 0, 0, 3, 0}, 3, ofNode(2, "translation"));
    const std::string lights = "/extensions/KHR_lights_punctual/lights/0/";
    addChannel(file, {0, 1}, {5, 9}, 1, ofPointer(lights + "intensity"));
    addChannel(file, {0, 1}, {1, 1, 1, 1, 0.5, 0}, 3, ofPointer(lights + "color"));
    addChannel(file, {0, 1}, {0.8f, 1.0f}, 1, ofPointer("/cameras/0/perspective/yfov"));
    AnimatedScene animated(file.write());
    EXPECT_EQ(animated.moveTo(1.0), SceneChange::kScene);
    const PunctualLight& light = animated.scene().lights[0];
    EXPECT_NEAR(light.position.y, 3.0f, kPoseRounding);
    EXPECT_NEAR(light.intensity.x, 9.0f, kPoseRounding);
    EXPECT_NEAR(light.intensity.y, 4.5f, kPoseRounding);
    EXPECT_EQ(light.intensity.z, 0.0f);
    EXPECT_NEAR(animated.scene().cameras[0].y_fov, 1.0f, kPoseRounding);
    EXPECT_TRUE(animated.scene().warnings.empty())
        << testing::PrintToString(animated.scene().warnings);
}

TEST(Animation, WhatIsNotFollowedIsSaid) {
    GltfFile file = moving();
    addChannel(file, {0, 1}, {0, 0, 0, 1, 1, 1}, 3,
               ofPointer("/materials/0/pbrMetallicRoughness/baseColorFactor"));
    addChannel(file, {0, 1}, {0, 1}, 1, {{"path", "translation"}});
    const AnimatedScene animated(file.write());
    EXPECT_TRUE(warnsOf(animated.scene(), "baseColorFactor) stays at rest"));
    EXPECT_TRUE(warnsOf(animated.scene(), "no node"));
}

TEST(Animation, MorphTargetsFollowWeights) {
    GltfFile file = moving();
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    for (const float height : {1.0f, 10.0f}) {
        primitive["targets"].push_back(
            {{"POSITION", file.addAccessor<float>({0, 0, height, 0, 0, height, 0, 0, height},
                                                  kFloat, "VEC3", 3)}});
    }
    addChannel(file, {0, 1}, {0, 0, 1, 0.5}, 1, ofNode(0, "weights"));
    AnimatedScene animated(file.write());
    animated.moveTo(0.5);
    EXPECT_NEAR(animated.scene().positions[0].z, 0.5f + 2.5f, kPoseRounding);
}

TEST(Animation, SkinsFollowTheirJoints) {
    GltfFile file = moving();
    Json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] =
        file.addAccessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, kUnsignedByte, "VEC4", 4);
    attributes["WEIGHTS_0"] =
        file.addAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kFloat, "VEC4", 4);
    file.json["nodes"].push_back({{"name", "joint"}});
    file.json["skins"] = Json::array({{{"joints", {3}}}});
    file.json["nodes"][0]["skin"] = 0;
    addChannel(file, {0, 1}, {0, 0, 0, 0, 6, 0}, 3, ofNode(3, "translation"));
    AnimatedScene animated(file.write());
    animated.moveTo(0.5);
    EXPECT_NEAR(animated.scene().positions[0].y, 3.0f, kPoseRounding);
}

TEST(Animation, CubicSplinesAndStepsComeFromTheFile) {
    GltfFile file = moving();
    // From 0 to 0 in 2 s, leaving and arriving at 4 m/s: x = (s - 3 s^2 + 2 s^3) 2 s * 4 at s =
    // t/2.
    addChannel(file, {0, 2}, {0, 0, 0, 0, 0, 0, 4, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0}, 3,
               ofNode(0, "translation"))["interpolation"] = "CUBICSPLINE";
    addChannel(file, {0, 1}, {0, 0, 5, 0, 7, 5}, 3, ofNode(1, "translation"))["interpolation"] =
        "STEP";
    AnimatedScene animated(file.write());
    animated.moveTo(0.5);
    const float s = 0.25f;
    EXPECT_NEAR(animated.scene().positions[0].x, 8.0f * (s - 3 * s * s + 2 * s * s * s),
                kPoseRounding);
    EXPECT_EQ(animated.scene().cameras[0].world_from_camera[3].y, 0.0f);
}

TEST(Animation, AFileWithoutAnimationStandsStill) {
    AnimatedScene animated(moving().write());
    EXPECT_EQ(animated.seconds(), 0.0);
    EXPECT_EQ(animated.moveTo(0.0), SceneChange::kNothing);
    EXPECT_EQ(animated.moveTo(7.0), SceneChange::kNothing);
}

TEST(Animation, OneOfSeveralIsChosen) {
    GltfFile file = moving();
    addChannel(file, {0, 1}, {1, 0, 0, 1, 0, 0}, 3, ofNode(0, "translation"));
    file.json["animations"].push_back(file.json["animations"][0]);
    file.json["animations"][1]["name"] = "come";
    file.json["animations"][1]["channels"] = Json::array();
    const std::string path = file.write();
    const AnimatedScene first(path);
    EXPECT_EQ(first.seconds(), 1.0);
    EXPECT_TRUE(warnsOf(first.scene(), "2 animations, go, come"));
    for (const char* name : {"come", "1"}) {
        const AnimatedScene second(path, {}, name);
        EXPECT_EQ(second.seconds(), 0.0);
        EXPECT_FALSE(warnsOf(second.scene(), "animations"));
    }
    for (const char* name : {"leave", "2", "-1"}) {
        try {
            AnimatedScene(path, {}, name);
            ADD_FAILURE() << name;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::kUsage) << error.what();
        }
    }
}

// The scenes that come with Sheen: those that do not move are the same at any time.
TEST(Animation, AtRestIsWhatLoadSceneHas) {
    for (const char* name : {"cornell_glossy.glb", "venus_glossy.glb", "lamp_room.glb"}) {
        AnimatedScene animated(std::string(SHEEN_SCENES) + "/" + name);
        EXPECT_EQ(animated.moveTo(1.0), SceneChange::kNothing) << name;
    }
}

TEST(Animation, FilesWithoutLightOrCameraKeepTheirs) {
    GltfFile file = oneTriangle();
    addChannel(file, {0, 1}, {0, 0, 0, 3, 0, 0}, 3, ofNode(0, "translation"));
    AnimatedScene animated(file.write());
    const mat4 camera = animated.scene().cameras[0].world_from_camera;
    const vec3 key = animated.scene().lights[0].direction;
    animated.moveTo(1.0);
    ASSERT_EQ(animated.scene().cameras.size(), 1u);
    ASSERT_EQ(animated.scene().lights.size(), 1u);
    EXPECT_EQ(animated.scene().cameras[0].world_from_camera, camera);
    EXPECT_EQ(animated.scene().lights[0].direction, key);
    EXPECT_FALSE(animated.scene().environment.empty());
}

struct Broken {
    const char* name;
    void (*apply)(GltfFile&);
    const char* part;  // of the message
};

Json& animationOf(GltfFile& file) { return file.json["animations"][0]; }

const Broken kBroken[] = {
    {"TimesOutOfOrder",
     [](GltfFile& f) {
         addChannel(f, {0, 2, 1}, {0, 0, 0, 1, 0, 0, 2, 0, 0}, 3, ofNode(1, "translation"));
     },
     "times must grow"},
    {"TimesThatRepeat",
     [](GltfFile& f) {
         addChannel(f, {1, 1}, {0, 0, 0, 1, 0, 0}, 3, ofNode(1, "translation"));
     },
     "times must grow"},
    {"TimeNotANumber",
     [](GltfFile& f) {
         addChannel(f, {0, NAN}, {0, 0, 0, 1, 0, 0}, 3, ofNode(1, "translation"));
     },
     "nan"},
    {"ValueNotANumber",
     [](GltfFile& f) {
         addChannel(f, {0, 1}, {0, NAN, 0, 1, 0, 0}, 3, ofNode(1, "translation"));
     },
     "nan"},
    {"ZeroRotation",
     [](GltfFile& f) {
         addChannel(f, {0, 1}, {0, 0, 0, 1, 0, 0, 0, 0}, 4, ofNode(1, "rotation"));
     },
     "zero quaternion"},
    {"NoSampler", [](GltfFile& f) { animationOf(f)["channels"][0]["sampler"] = 7; }, "sampler 7"},
    {"SamplerLeftOut", [](GltfFile& f) { animationOf(f)["channels"][0].erase("sampler"); },
     "sampler -1"},
    {"NoSamplers", [](GltfFile& f) { animationOf(f).erase("samplers"); }, "no list of samplers"},
    {"NoChannels", [](GltfFile& f) { animationOf(f)["channels"] = 3; }, "no list of channels"},
    {"NoTarget", [](GltfFile& f) { animationOf(f)["channels"][0].erase("target"); }, "no target"},
    {"NoInput", [](GltfFile& f) { animationOf(f)["samplers"][0].erase("input"); }, "no input"},
    {"NoOutput", [](GltfFile& f) { animationOf(f)["samplers"][0].erase("output"); }, "no output"},
    {"NoAccessor", [](GltfFile& f) { animationOf(f)["samplers"][0]["output"] = 99; },
     "accessor 99"},
    {"OddIndex", [](GltfFile& f) { animationOf(f)["samplers"][0]["output"] = "x"; },
     "not an index"},
    {"NoNode", [](GltfFile& f) { animationOf(f)["channels"][0]["target"]["node"] = 44; },
     "node 44"},
    {"OddInterpolation",
     [](GltfFile& f) { animationOf(f)["samplers"][0]["interpolation"] = "BOUNCE"; }, "BOUNCE"},
    {"TooFewValues",
     [](GltfFile& f) {
         addChannel(f, {0, 1, 2}, {0, 0, 0, 1, 0, 0}, 3, ofNode(1, "translation"));
     },
     "6 numbers for 3 keys"},
    {"SplineWithoutTangents",
     [](GltfFile& f) { animationOf(f)["samplers"][0]["interpolation"] = "CUBICSPLINE"; },
     "6 numbers for 2 keys, which take 9 each"},
    {"OddType",
     [](GltfFile& f) {
         addChannel(f, {0, 1}, {0, 0, 0, 1}, 2, ofNode(1, "translation"));
     },
     "must be VEC3"},
    {"MovedTwice",
     [](GltfFile& f) {
         addChannel(f, {0, 1}, {0, 0, 0, 1, 0, 0}, 3, ofNode(0, "translation"));
     },
     "another channel"},
    {"MatrixMoved",
     [](GltfFile& f) {
         f.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
     },
     "has a matrix"},
    {"WeightsOfNoTargets",
     [](GltfFile& f) {
         addChannel(f, {0, 1}, {0, 1}, 1, ofNode(0, "weights"));
     },
     "has none"},
    {"NoSuchLight",
     [](GltfFile& f) {
         addChannel(f, {0, 1}, {0, 1}, 1,
                    ofPointer("/extensions/KHR_lights_punctual/lights/5/intensity"));
     },
     "light 5"},
    {"NotAnAnimation", [](GltfFile& f) { f.json["animations"][0] = 12; }, "no list of samplers"},
};

class BrokenAnimation : public testing::TestWithParam<Broken> {};

TEST_P(BrokenAnimation, IsOneLineThatNamesIt) {
    GltfFile file = moving();
    addChannel(file, {0, 1}, {0, 0, 0, 4, 0, 0}, 3, ofNode(0, "translation"));
    GetParam().apply(file);
    const std::string path = file.write();
    try {
        const AnimatedScene animated(path);
        ADD_FAILURE() << "nothing thrown";
    } catch (const Error& error) {
        const std::string what = error.what();
        EXPECT_EQ(error.code(), ExitCode::kInput) << what;
        EXPECT_NE(what.find(path), std::string::npos) << what;
        EXPECT_NE(what.find("animation 0"), std::string::npos) << what;
        EXPECT_NE(what.find(GetParam().part), std::string::npos) << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
    EXPECT_EQ(loadScene(path).triangleCount(), 1) << "at rest it is as good as any";
}

INSTANTIATE_TEST_SUITE_P(All, BrokenAnimation, testing::ValuesIn(kBroken),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace sheen
