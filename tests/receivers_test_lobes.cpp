// The lobes of receivers in spherical harmonics.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "receivers/receivers.h"
#include "scene/brdf_albedo.h"
#include "sh/brdf_sh.h"
#include "test_scenes.h"
#include "test_stage.h"

namespace sheen {
namespace {

TEST(Lobes, AConstantEnvironmentGivesTheAlbedo) {
    // Coefficients of constant radiance L: sqrt(4 pi) L in band 0. Convolved with the lobe and
    // scaled, that is the specular albedo of each channel times L.
    const Scene scene = glossyRoom(0.5f, 0.4f);
    TestStage stage(scene);
    const Receivers r = receiversOf(scene, stage.gbuffer(48, 48), 5, false);
    int glossy = 0;
    for (size_t i = 0; i < 48 * 48; ++i) {
        if (r.orders[i] <= shared::DIFFUSE_ORDER) {
            EXPECT_EQ(r.lobes.first[i], -1);
            continue;
        }
        ++glossy;
        const float convolved = r.lobes.at(i, r.orders[i]).c[0] * std::sqrt(4.0f * kPi);
        const vec3 found = r.lobes.scale[i] * convolved;
        const vec3 wo = glm::normalize(r.image.view.origin - r.positions[i]);
        const vec2 ab = brdfAlbedo(glm::dot(r.normals[i], wo), r.roughness[i]);
        const vec3 expected = r.f0[i] * ab.x + vec3(r.f90[i] * ab.y);
        // Two interpolated tables.
        EXPECT_LT(glm::length(found - expected), 0.005f * glm::length(expected));
    }
    EXPECT_GT(glossy, 200);
}

TEST(Lobes, KeepCoefficientsToHalfAStepAndZerosBehindThem) {
    const Scene scene = glossyRoom(0.5f, 0.4f);
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(40, 40);
    for (int order : {2, 4, 5, 10}) {
        const Receivers r = receiversOf(scene, g, order, false);
        const int stored = shared::lobeGroupFirst(shared::lobeGroups(order));
        ASSERT_GE(stored, order * order);
        int glossy = 0;
        for (size_t i = 0; i < 40 * 40; ++i) {
            const int first = r.lobes.first[i];
            if (first < 0) {
                continue;
            }
            ASSERT_EQ(first, glossy * stored);
            ++glossy;
            const vec3& n = r.normals[i];
            const vec3 wo = glm::normalize(r.image.view.origin - r.positions[i]);
            const vec3& f0 = r.f0[i];
            shared::ShVector exact;
            BrdfRotator(order).rotate(brdfSh(glm::dot(n, wo), r.roughness[i]),
                                      (f0.x + f0.y + f0.z) / 3.0f, r.f90[i], n, wo, exact.c);
            const float greatest =
                std::abs(*std::max_element(exact.c, exact.c + order * order, [](float a, float b) {
                    return std::abs(a) < std::abs(b);
                }));
            const shared::ShVector kept = r.lobes.at(i, order);
            // Half a step, and single precision at thousands of steps.
            const float rounding = 0.51f / shared::LOBE_STEPS;
            for (int k = 0; k < order * order; ++k) {
                ASSERT_NEAR(kept.c[k], exact.c[k] / greatest, rounding);
            }
            for (int k = order * order; k < stored; ++k) {
                ASSERT_EQ(r.lobes.steps[static_cast<size_t>(first + k)], 0);
            }
        }
        EXPECT_EQ(r.lobes.steps.size(), static_cast<size_t>(glossy * stored));
        EXPECT_GT(glossy, 100);
    }
}

}  // namespace
}  // namespace sheen
