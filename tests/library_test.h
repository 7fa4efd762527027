// Scenes and frames of the library's tests, which see nothing but the public header.
#pragma once

#include <gtest/gtest.h>
#include <sheen/sheen.h>

#include <cstring>
#include <string>

namespace sheen {

constexpr float kPi = 3.14159265f;

inline std::string scenePath(const char* name) {
    return std::string(SHEEN_SCENES) + "/" + name + ".glb";
}

// Milliseconds.
inline Options small(Options more = {}) {
    Options options = {{"size", "24x20"}, {"aa", 1}, {"accuracy", 2.0}, {"bounces", 1}};
    options.insert(options.end(), more.begin(), more.end());
    return options;
}

// The light of the scene and the surface below it, seen from straight above.
inline Arrays floorBelow(const Light& light) {
    Arrays scene;
    scene.materials = {{.name = "floor", .base_color = {0.5f, 0.4f, 0.3f}, .roughness = 0.7f}};
    scene.meshes = {{.name = "floor",
                     .positions = {-5, 0, -5, -5, 0, 5, 5, 0, 5, 5, 0, -5},
                     .indices = {0, 1, 2, 0, 2, 3},
                     .material = 0}};
    scene.lights = {light};
    scene.cameras = {{.name = "above", .position = {0, 3, 0}, .up = {0, 0, -1}, .fov = 30.0f}};
    return scene;
}

// Fails where a layer differs in a bit.
inline void expectSame(const Frame& a, const Frame& b) {
    ASSERT_EQ(a.layers(), b.layers());
    for (const std::string& name : a.layers()) {
        const Layer of_a = a.layer(name);
        const Layer of_b = b.layer(name);
        ASSERT_EQ(of_a.width, of_b.width);
        ASSERT_EQ(of_a.height, of_b.height);
        const auto values = static_cast<size_t>(of_a.width * of_a.height * of_a.channels);
        EXPECT_EQ(std::memcmp(of_a.values, of_b.values, values * sizeof(float)), 0) << name;
    }
}

// call() must throw one line of that kind which has `part` in it.
template <class Call>
void expectError(ErrorKind kind, const std::string& part, const Call& call) {
    try {
        call();
        ADD_FAILURE() << "nothing was thrown; expected: " << part;
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(kind)) << message;
        EXPECT_NE(message.find(part), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

}  // namespace sheen
