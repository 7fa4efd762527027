// Parts of images against the whole.
#include <gtest/gtest.h>

#include "render/crop.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kWidth = 48;
constexpr int kHeight = 40;

template <class T>
void expectSame(const Image<T>& part, const Image<T>& whole, const Crop& crop, const char* of) {
    ASSERT_EQ(part.width, crop.size.x);
    ASSERT_EQ(part.height, crop.size.y);
    for (int y = 0; y < crop.size.y; ++y) {
        for (int x = 0; x < crop.size.x; ++x) {
            EXPECT_EQ(part.at(x, y), whole.at(x + crop.first.x, y + crop.first.y))
                << of << " at " << x << ", " << y;
        }
    }
}

RenderResult partOf(const Scene& scene, const RenderParams& params, const Crop& crop) {
    Session session(scene);
    return renderPart(session, params, crop);
}

TEST(Crop, WhatIsSeenAndItsDirectLightAreTheWholesBits) {
    const Scene scene = glossyRoom();
    RenderParams params = smallRender(kWidth, kHeight);
    const RenderResult whole = renderFrame(scene, params);
    for (const Crop& crop :
         {Crop{{19, 11}, {17, 9}}, Crop{{0, 0}, {5, kHeight}},
          Crop{{kWidth - 1, kHeight - 1}, {1, 1}}, Crop{{0, 0}, {kWidth, kHeight}}}) {
        const RenderResult part = partOf(scene, params, crop);
        expectSame(part.frame.primitive, whole.frame.primitive, crop, "primitive");
        expectSame(part.frame.position, whole.frame.position, crop, "position");
        expectSame(part.frame.normal, whole.frame.normal, crop, "normal");
        expectSame(part.frame.direct, whole.frame.direct, crop, "direct");
        // Records lie elsewhere.
        double difference = 0.0;
        double light = 0.0;
        for (int y = 0; y < crop.size.y; ++y) {
            for (int x = 0; x < crop.size.x; ++x) {
                const float of_whole =
                    luminance(whole.frame.indirect.at(x + crop.first.x, y + crop.first.y));
                difference += std::abs(luminance(part.frame.indirect.at(x, y)) - of_whole);
                light += of_whole;
            }
        }
        EXPECT_LT(difference, 0.03 * light);
    }
}

// All layers are of the part's size, those of caustics too.
TEST(Crop, TakesCausticsAlong) {
    Scene scene = glossyRoom();
    addQuad(scene, vec3(-0.9f, -0.9f, -0.9f), vec3(0, 1.2f, 0), vec3(0, 0, 1.2f),
            addMaterial(scene, glossyParams(vec3(0.9f), 1.0f, 0.0f)));
    RenderParams params = smallRender(kWidth, kHeight);
    params.caustics = 2000;
    const Crop crop{{19, 11}, {17, 9}};
    for (const Method method : {Method::kRadiance, Method::kReference}) {
        params.method = method;
        params.spp = 16;
        const RenderResult part = partOf(scene, params, crop);
        EXPECT_EQ(part.frame.caustic.width, crop.size.x);
        EXPECT_EQ(part.frame.caustic.height, crop.size.y);
        EXPECT_EQ(beauty(part.frame).height, crop.size.y);
    }
}

TEST(Crop, OfTheReferenceIsTheWholesBits) {
    const Scene scene = glossyRoom();
    RenderParams params = smallRender(kWidth, kHeight, Method::kReference);
    params.spp = 16;
    const Crop crop{{21, 13}, {9, 8}};
    for (const int aa : {1, 16}) {
        params.aa = aa;
        const RenderResult whole = renderFrame(scene, params);
        const RenderResult part = partOf(scene, params, crop);
        expectSame(part.frame.indirect, whole.frame.indirect, crop, "indirect");
        expectSame(part.frame.direct, whole.frame.direct, crop, "direct");
        expectSame(part.frame.indirect_variance, whole.frame.indirect_variance, crop, "variance");
    }
}

TEST(Crop, MustLieInTheImage) {
    const Scene scene = glossyRoom();
    const RenderParams params = smallRender(kWidth, kHeight);
    for (const Crop& crop :
         {Crop{{kWidth - 4, 0}, {5, 5}}, Crop{{0, 0}, {0, 5}}, Crop{{-1, 0}, {5, 5}},
          Crop{{0, 0}, {5, kHeight + 1}}, Crop{{1 << 30, 0}, {1 << 30, 5}}}) {
        EXPECT_THROW(partOf(scene, params, crop), Error);
    }
}

}  // namespace
}  // namespace sheen
