// A small scene that moves, for the program to render.
#pragma once

#include "cli_test.h"

namespace sheen {

class CliAnimate : public CliTest {
  protected:
    // The scene with a lamp that rises from the start to 1 s and then stands, and a camera `eye`
    // that moves for 1 s longer.
    void SetUp() override {
        CliTest::SetUp();
        writeScene([](Json&) {});
    }

    template <class Change>
    void writeScene(const Change& change) {
        Json json = Json::parse(kScene);
        json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", sizeof(kKeys)}});
        json["buffers"].push_back({{"uri", "keys.bin"}, {"byteLength", sizeof(kKeys)}});
        const auto accessor = [&](size_t first, int count, const char* type) {
            json["accessors"].push_back({{"bufferView", 1},
                                         {"byteOffset", first * sizeof(float)},
                                         {"componentType", 5126},
                                         {"count", count},
                                         {"type", type}});
            return json["accessors"].size() - 1;
        };
        const size_t lamp = accessor(0, 2, "SCALAR"), places = accessor(2, 2, "VEC3");
        const size_t eye = accessor(8, 3, "SCALAR"), views = accessor(11, 3, "VEC3");
        json["animations"] = Json::array(
            {{{"samplers",
               {{{"input", lamp}, {"output", places}}, {{"input", eye}, {"output", views}}}},
              {"channels",
               {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}},
                {{"sampler", 1}, {"target", {{"node", 2}, {"path", "translation"}}}}}}}});
        change(json);
        std::ofstream(file("scene.gltf")) << json.dump();
        std::ofstream(file("keys.bin"), std::ios::binary)
            .write(reinterpret_cast<const char*>(kKeys), sizeof(kKeys));
    }

    static constexpr float kKeys[] = {0, 1, 0.5f, 1, 1, 0.5f, 2, 1,               // the lamp
                                      0, 1, 2,    0, 1, 4,    0, 1, 4, 0, 1, 5};  // the eye
};

}  // namespace sheen
