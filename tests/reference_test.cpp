// The path tracer against closed forms, its samplers against their densities, and its variance
// against what repeated runs show.
#include "reference/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "core/parallel.h"
#include "reference/guide.h"
#include "reference/ray_scene.h"
#include "reference/sampling.h"
#include "reference/sobol.h"
#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

// ---- Scenes -------------------------------------------------------------------------------------

Material makeMaterial(const vec3& base_color, float metallic, float specular, float roughness,
                      const vec3& emission = vec3(0.0f)) {
    Material m;
    m.params = {.base_color = base_color,
                .metallic = metallic,
                .specular_color = vec3(1.0f),
                .specular = specular,
                .emission = emission,
                .roughness = roughness};
    return m;
}

Material diffuseMaterial(const vec3& albedo, const vec3& emission = vec3(0.0f)) {
    return makeMaterial(albedo, 0.0f, 0.0f, 1.0f, emission);
}

uint32_t addMaterial(Scene& scene, const Material& material) {
    scene.materials.push_back(material);
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

void addVertex(Scene& scene, const vec3& p, const vec3& n) {
    scene.positions.push_back(p);
    scene.normals.push_back(n);
    scene.uvs.emplace_back(0.0f);
    scene.bounds.add(p);
}

// A parallelogram with corner p; normals by winding unless given.
void addQuad(Scene& scene, const vec3& p, const vec3& u, const vec3& v, uint32_t material,
             const vec3* normal = nullptr) {
    const auto base = static_cast<uint32_t>(scene.positions.size());
    const vec3 n = normal != nullptr ? *normal : glm::normalize(glm::cross(u, v));
    for (const vec3& corner : {p, p + u, p + u + v, p + v}) {
        addVertex(scene, corner, n);
    }
    scene.triangles.emplace_back(base, base + 1, base + 2);
    scene.triangles.emplace_back(base, base + 2, base + 3);
    scene.materials_of.insert(scene.materials_of.end(), 2, material);
}

// The six faces of a box, normals inward; materials in the order -x +x -y +y -z +z.
void addRoom(Scene& scene, const vec3& lower, const vec3& upper,
             const std::array<uint32_t, 6>& materials) {
    const vec3 d = upper - lower;
    const vec3 dx(d.x, 0, 0), dy(0, d.y, 0), dz(0, 0, d.z);
    addQuad(scene, lower, dy, dz, materials[0]);
    addQuad(scene, lower + dx, dz, dy, materials[1]);
    addQuad(scene, lower, dz, dx, materials[2]);
    addQuad(scene, lower + dy, dx, dz, materials[3]);
    addQuad(scene, lower, dx, dy, materials[4]);
    addQuad(scene, lower + dz, dy, dx, materials[5]);
}

void addRoom(Scene& scene, const vec3& lower, const vec3& upper, uint32_t material) {
    addRoom(scene, lower, upper, {material, material, material, material, material, material});
}

void addSphere(Scene& scene, float radius, int rings, uint32_t material) {
    const auto base = static_cast<uint32_t>(scene.positions.size());
    const int sectors = 2 * rings;
    for (int i = 0; i <= rings; ++i) {
        const float theta = kPi * static_cast<float>(i) / static_cast<float>(rings);
        for (int j = 0; j <= sectors; ++j) {
            const float phi = kPi * static_cast<float>(j) / static_cast<float>(rings);
            const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta),
                         std::sin(theta) * std::sin(phi));
            addVertex(scene, radius * n, n);
        }
    }
    const auto index = [&](int i, int j) {
        return base + static_cast<uint32_t>(i * (sectors + 1) + j);
    };
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < sectors; ++j) {
            if (i > 0) {
                scene.triangles.emplace_back(index(i, j), index(i, j + 1), index(i + 1, j + 1));
                scene.materials_of.push_back(material);
            }
            if (i + 1 < rings) {
                scene.triangles.emplace_back(index(i, j), index(i + 1, j + 1), index(i + 1, j));
                scene.materials_of.push_back(material);
            }
        }
    }
}

PunctualLight pointLight(const vec3& position, const vec3& intensity) {
    return {.position = position,
            .inverse_range = 0.0f,
            .direction = vec3(0, -1, 0),
            .spot_scale = 0.0f,
            .intensity = intensity,
            .spot_offset = 1.0f,
            .kind = shared::LIGHT_POINT,
            .first_view = 0,
            .cos_outer = -1.0f,
            .pad = 0};
}

PunctualLight directionalLight(const vec3& direction, const vec3& illuminance) {
    PunctualLight light = pointLight(vec3(0.0f), illuminance);
    light.kind = shared::LIGHT_DIRECTIONAL;
    light.direction = glm::normalize(direction);
    return light;
}

Camera lookAt(const vec3& eye, const vec3& target) {
    const vec3 back = glm::normalize(eye - target);
    const vec3 up = std::abs(back.y) < 0.99f ? vec3(0, 1, 0) : vec3(0, 0, 1);
    const vec3 right = glm::normalize(glm::cross(up, back));
    Camera camera;
    camera.world_from_camera = mat4(vec4(right, 0.0f), vec4(glm::cross(back, right), 0.0f),
                                    vec4(back, 0.0f), vec4(eye, 1.0f));
    return camera;
}

// A lit room with a glossy box in it: something of everything.
Scene litRoom(float scale = 1.0f) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseMaterial(vec3(0.7f)));
    const uint32_t red = addMaterial(scene, diffuseMaterial(vec3(0.6f, 0.1f, 0.1f)));
    const uint32_t plastic = addMaterial(scene, makeMaterial(vec3(0.5f), 0.0f, 1.0f, 0.4f));
    const uint32_t metal =
        addMaterial(scene, makeMaterial(vec3(0.9f, 0.8f, 0.6f), 1.0f, 1.0f, 0.3f));
    const uint32_t lamp = addMaterial(scene, diffuseMaterial(vec3(0.5f), vec3(4.0f)));
    addRoom(scene, vec3(-1), vec3(1), {red, white, plastic, white, white, white});
    addRoom(scene, vec3(-0.6f, -1.0f, -0.5f), vec3(0.1f, -0.3f, 0.2f), metal);
    addQuad(scene, vec3(0.3f, 0.99f, -0.2f), vec3(0.4f, 0, 0), vec3(0, 0, 0.4f), lamp);
    scene.lights.push_back(pointLight(vec3(0.5f, 0.4f, 0.6f), vec3(1.0f)));
    for (vec3& p : scene.positions) {
        p *= scale;
    }
    scene.bounds = {.lower = scale * scene.bounds.lower, .upper = scale * scene.bounds.upper};
    for (PunctualLight& light : scene.lights) {
        light.position *= scale;
        light.intensity *= scale * scale;
    }
    return scene;
}

Camera litRoomCamera(float scale = 1.0f) {
    return lookAt(scale * vec3(0.2f, 0.1f, 0.95f), scale * vec3(-0.2f, -0.6f, -0.2f));
}

ReferenceParams smallParams(const Camera& camera, int size, int spp) {
    return {.width = size, .height = size, .camera = camera, .spp = spp, .quiet = true};
}

// ---- Statistics ---------------------------------------------------------------------------------

// All channels of all pixels lie within `sigmas` standard errors, plus a share `bias` of the value
// that the comparison itself cannot resolve.
void expectWithin(const Image<vec3>& values, const Image<vec3>& variance,
                  const std::function<vec3(int)>& expected, double sigmas, double bias) {
    ASSERT_EQ(values.count(), variance.count());
    for (int i = 0; i < values.count(); ++i) {
        const vec3 truth = expected(i);
        for (int c = 0; c < 3; ++c) {
            const auto pixel = static_cast<size_t>(i);
            const double error = std::abs(values.pixels[pixel][c] - truth[c]);
            EXPECT_LE(error, sigmas * std::sqrt(variance.pixels[pixel][c]) + bias * truth[c])
                << "pixel " << i << " channel " << c << " expected " << truth[c];
        }
    }
}

// 64 pixels x 3 channels from 16 replicates each (Student's t with 15 degrees of freedom): 7
// standard errors are exceeded by chance once in a thousand runs of such a test.
constexpr double kSigmas = 7.0;
// The albedo table is tabulated and interpolated.
constexpr double kTableError = 3e-3;

// Upper quantile of chi-square with k degrees of freedom where the normal deviate is z.
double chiSquareQuantile(double k, double z) {
    const double a = 2.0 / (9.0 * k);  // Wilson and Hilferty 1931
    return k * std::pow(1.0 - a + z * std::sqrt(a), 3.0);
}

// Draws directions (local frame, z up; z <= 0 means "no sample") and compares their histogram over
// (cos theta, phi) with the density per solid angle.
void expectDistribution(const std::function<vec3(const vec2&)>& draw,
                        const std::function<double(const vec3&)>& pdf) {
    constexpr int kTheta = 16, kPhi = 32, kSub = 24, kSamples = 1 << 18;
    constexpr double kZ = 4.0;  // false alarm: 3e-5
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0.0f, 0x1.fffffep-1f);
    std::vector<double> seen(kTheta * kPhi + 1, 0.0), expected(kTheta * kPhi + 1, 0.0);
    for (int i = 0; i < kSamples; ++i) {
        const float u = uniform(random), v = uniform(random);
        const vec3 w = draw(vec2(u, v));
        if (w.z <= 0.0f) {
            seen.back() += 1.0;
            continue;
        }
        double phi = std::atan2(w.y, w.x) / (2.0 * M_PI);
        phi -= std::floor(phi);
        const int t = std::min(static_cast<int>(w.z * kTheta), kTheta - 1);
        seen[static_cast<size_t>(t * kPhi + std::min(static_cast<int>(phi * kPhi), kPhi - 1))] += 1;
    }
    double total = 0.0;
    for (int bin = 0; bin < kTheta * kPhi; ++bin) {
        double sum = 0.0;
        for (int s = 0; s < kSub * kSub; ++s) {
            const double z = (bin / kPhi + (s / kSub + 0.5) / kSub) / kTheta;
            const double phi = 2.0 * M_PI * (bin % kPhi + (s % kSub + 0.5) / kSub) / kPhi;
            const double r = std::sqrt(1.0 - z * z);
            sum += pdf(vec3(r * std::cos(phi), r * std::sin(phi), z));
        }
        const double probability = sum * 2.0 * M_PI / (kTheta * kPhi * kSub * kSub);
        expected[static_cast<size_t>(bin)] = probability * kSamples;
        total += probability;
    }
    expected.back() = std::max(0.0, 1.0 - total) * kSamples;
    EXPECT_LT(total, 1.002);

    // Merge bins until each expects five.
    double chi2 = 0.0, o = 0.0, e = 0.0;
    int cells = 0;
    for (size_t bin = 0; bin < seen.size(); ++bin) {
        o += seen[bin];
        e += expected[bin];
        if (e >= 5.0) {
            chi2 += (o - e) * (o - e) / e;
            ++cells;
            o = e = 0.0;
        }
    }
    EXPECT_LT(chi2, chiSquareQuantile(cells - 1, kZ)) << cells << " cells";
}

// ---- Sample points ------------------------------------------------------------------------------

TEST(Sobol, SecondDimensionIsSobols) {
    for (uint32_t index : {0u, 1u, 2u, 3u, 77u, 0x80000000u, 0xdeadbeefu, 0xffffffffu}) {
        uint32_t direct = 0;  // the loop of Kollig and Keller 2002, "Efficient multidimensional
        for (uint32_t i = index, v = 1u << 31; i != 0; i >>= 1, v ^= v >> 1) {  // sampling"
            direct ^= (i & 1u) != 0 ? v : 0u;
        }
        EXPECT_EQ(sobolBits(index).y, direct);
        EXPECT_EQ(sobolBits(index).x, reverseBits(index));
    }
}

TEST(Sobol, OnePointInEachElementaryInterval) {
    for (uint32_t seed : {0u, 1u, 12345u, 0xffffffffu}) {
        for (int k = 0; k <= 8; ++k) {
            const uint32_t count = 1u << k;
            for (uint32_t block : {0u, 5u}) {
                for (int a = 0; a <= k; ++a) {
                    std::vector<int> hits(count, 0);
                    for (uint32_t i = 0; i < count; ++i) {
                        const vec2 u = owenSobol(block * count + i, seed);
                        const auto x = static_cast<uint32_t>(std::ldexp(u.x, a));
                        const auto y = static_cast<uint32_t>(std::ldexp(u.y, k - a));
                        ++hits[(y << a) + x];
                    }
                    EXPECT_EQ(std::count(hits.begin(), hits.end(), 1), count)
                        << "k " << k << " a " << a << " seed " << seed;
                }
            }
        }
    }
}

TEST(Sobol, EachPointIsUniformOverSeeds) {
    constexpr int kSeeds = 20000;
    vec2 sum(0.0f);
    float product = 0.0f;
    for (int seed = 0; seed < kSeeds; ++seed) {
        const vec2 u = owenSobol(3, hash32(static_cast<uint32_t>(seed)));
        sum += u;
        product += (u.x - 0.5f) * (u.y - 0.5f);
    }
    // Standard errors 1/sqrt(12 n) and 1/(12 sqrt(n)).
    EXPECT_NEAR(sum.x / kSeeds, 0.5, 4.0 / std::sqrt(12.0 * kSeeds));
    EXPECT_NEAR(sum.y / kSeeds, 0.5, 4.0 / std::sqrt(12.0 * kSeeds));
    EXPECT_NEAR(product / kSeeds, 0.0, 4.0 / (12.0 * std::sqrt(1.0 * kSeeds)));
}

TEST(Sampling, FrameIsARotationOntoTheNormal) {
    for (const vec3& n : {vec3(0, 0, 1), vec3(0, 0, -1), vec3(1, 0, 0), vec3(0, -1, 0),
                          glm::normalize(vec3(1e-4f, -1e-4f, -1)), glm::normalize(vec3(1, 2, 3))}) {
        const mat3 m = worldFromLocal(n);
        EXPECT_NEAR(glm::determinant(m), 1.0f, 1e-5f);
        EXPECT_NEAR(glm::length(m * vec3(0, 0, 1) - n), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::dot(m[0], m[1]), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::dot(m[0], m[2]), 0.0f, 1e-6f);
    }
}

TEST(Sampling, CosineFollowsItsDensity) {
    expectDistribution([](const vec2& u) { return sampleCosine(u); },
                       [](const vec3& w) { return w.z / M_PI; });
}

TEST(Sampling, GgxReflectionFollowsItsDensity) {
    const vec3 n(0, 0, 1);
    for (const float alpha : {0.2f, 0.7f}) {
        for (const float NoV : {0.95f, 0.3f}) {
            const vec3 wo(std::sqrt(1.0f - NoV * NoV), 0.0f, NoV);
            expectDistribution(
                [&](const vec2& u) {
                    const vec3 h = sampleGgxVisibleNormal(wo, alpha, u);
                    return 2.0f * glm::dot(wo, h) * h - wo;
                },
                [&](const vec3& w) { return ggxReflectionPdf(n, wo, w, alpha); });
        }
    }
}

// The mixture and plain cosine sampling estimate the same integral of a lopsided environment.
TEST(Sampling, MixtureAgreesWithCosineSampling) {
    constexpr uint32_t kSamples = 1u << 17;
    const auto radiance = [](const vec3& w) { return w.x > 0.2f ? 1.0f : 0.1f * w.z; };
    const vec3 n = glm::normalize(vec3(0.2f, 0.3f, 1.0f));
    const vec3 wo = glm::normalize(vec3(-0.7f, 0.1f, 0.5f));
    for (const float metallic : {0.0f, 0.5f, 1.0f}) {
        for (const float roughness : {0.3f, 0.6f, 1.0f}) {
            const Material m = makeMaterial(vec3(0.8f), metallic, 1.0f, roughness);
            const vec2 ab = brdfAlbedo(glm::dot(n, wo), roughness);
            const Brdf brdf = shared::makeBrdf(m.params, ab);
            const BrdfSampler sampler(brdf, brdf.f0 * ab.x + vec3(brdf.f90 * ab.y), n, wo);
            double mixed = 0.0, diffuse = 0.0, cosine = 0.0, cosine_diffuse = 0.0;
            for (uint32_t i = 0; i < kSamples; ++i) {
                const vec2 u = owenSobol(i, 99);
                const DirectionSample s = sampleBrdf(sampler, brdf, n, wo, u);
                mixed += s.weight.x * radiance(s.wi);
                diffuse += s.diffuse.x * radiance(s.wi);
                const vec3 wi = glm::normalize(sampler.world_from_local * sampleCosine(u));
                cosine += shared::evalBrdf(brdf, n, wo, wi).x * M_PI * radiance(wi);
                cosine_diffuse += brdf.diffuse.x * radiance(wi);
            }
            // Stratified in two dimensions with one jump: far below 1/sqrt(kSamples) = 0.3%.
            EXPECT_NEAR(mixed / cosine, 1.0, 3e-3) << metallic << " " << roughness;
            if (metallic < 1.0f) {
                EXPECT_NEAR(diffuse / cosine_diffuse, 1.0, 3e-3) << metallic << " " << roughness;
            }
        }
    }
}

// ---- The guide ----------------------------------------------------------------------------------

// Contributions of an 8 x 8 grid: all in one cell.
Guide cornerGuide() {
    std::vector<float> contributions(64, 0.0f);
    contributions[7 * 8 + 7] = 5.0f;
    return Guide(8, contributions);
}

TEST(Guide, KeepsIntegralsAndFollowsWhatItLearned) {
    constexpr uint32_t kSamples = 1u << 16;
    const Guide guide = cornerGuide();
    double ones = 0.0, integral = 0.0;
    int learned = 0;
    for (uint32_t i = 0; i < kSamples; ++i) {
        const GuidedPoint p = guide.warp(owenSobol(i, 5));
        ASSERT_TRUE(p.u.x >= 0.0f && p.u.x < 1.0f && p.u.y >= 0.0f && p.u.y < 1.0f);
        EXPECT_LE(p.weight, 1.0f / 0.3f + 1e-3f);
        ones += p.weight;
        integral += p.weight * p.u.x * p.u.x * p.u.y;
        learned += p.u.x >= 0.75f && p.u.y >= 0.75f ? 1 : 0;
    }
    EXPECT_NEAR(ones / kSamples, 1.0, 1e-3);
    EXPECT_NEAR(integral / kSamples, 1.0 / 6.0, 1e-3);
    // The blur spreads the one cell over four: seven tenths of the samples and their uniform share.
    EXPECT_NEAR(1.0 * learned / kSamples, 0.7 + 0.3 / 16.0, 1e-3);
}

TEST(Guide, ItsWeightsAreItsDensity) {
    constexpr int kSamples = 1 << 16;
    const Guide guide = cornerGuide();
    std::vector<double> seen(64, 0.0), expected(64, 0.0);
    for (uint32_t i = 0; i < kSamples; ++i) {
        const GuidedPoint p = guide.warp(owenSobol(i, 9));
        const auto cell = static_cast<size_t>(p.u.y * 8.0f) * 8 + static_cast<size_t>(p.u.x * 8.0f);
        seen[cell] += 1.0;
        expected[cell] = kSamples / (64.0 * p.weight);
    }
    for (size_t i = 0; i < 64; ++i) {
        EXPECT_NEAR(seen[i], expected[i], 0.02 * expected[i] + 4.0) << i;
    }
}

TEST(Guide, ThatLearnedNothingIsUniform) {
    for (const Guide& guide : {Guide(), Guide(4, std::vector<float>(16, 0.0f))}) {
        const GuidedPoint p = guide.warp(vec2(0.3f, 0.9f));
        EXPECT_EQ(p.u, vec2(0.3f, 0.9f));
        EXPECT_EQ(p.weight, 1.0f);
    }
    EXPECT_THROW(Guide(3, std::vector<float>(9, 1.0f)), std::logic_error);
    EXPECT_THROW(Guide(4, std::vector<float>(9, 1.0f)), std::logic_error);
}

// ---- Closed forms -------------------------------------------------------------------------------

// In a closed room of constant radiance Le, indirect light is the directional albedo times Le.
void expectFurnace(Scene& scene, const Camera& camera, const vec3& radiance) {
    const ReferenceResult r = renderReference(scene, smallParams(camera, 8, 256));
    const RayScene rays(scene);
    std::vector<vec3> all(64), diffuse(64);
    for (int i = 0; i < 64; ++i) {
        const CameraRay ray =
            cameraRay(camera, 8, 8, static_cast<float>(i % 8), static_cast<float>(i / 8));
        const Surface s = rays.surfaceAt(rays.intersect(ray.origin, ray.direction), -ray.direction);
        diffuse[static_cast<size_t>(i)] = s.brdf.diffuse * radiance;
        all[static_cast<size_t>(i)] = (s.brdf.diffuse + s.specular_albedo) * radiance;
    }
    const auto at = [](const std::vector<vec3>& v) {
        return [&v](int i) { return v[static_cast<size_t>(i)]; };
    };
    expectWithin(r.frame.indirect, r.frame.indirect_variance, at(all), kSigmas, kTableError);
    expectWithin(r.frame.indirect_diffuse, r.frame.indirect_diffuse_variance, at(diffuse), kSigmas,
                 1e-4);
    EXPECT_EQ(r.nonfinite_samples, 0);
}

TEST(Reference, FurnaceGivesDirectionalAlbedo) {
    const vec3 radiance(2.0f, 1.0f, 0.5f);
    const Camera camera = lookAt(vec3(0.1f, 0.2f, 0.7f), vec3(-0.4f, -1.0f, -0.3f));
    for (const Material& material :
         {diffuseMaterial(vec3(0.8f), radiance),
          makeMaterial(vec3(0.6f), 0.0f, 1.0f, 0.5f, radiance),
          makeMaterial(vec3(1.0f, 0.8f, 0.3f), 1.0f, 1.0f, 1.0f, radiance),
          makeMaterial(vec3(0.9f), 0.5f, 1.0f, 0.2f, radiance),
          makeMaterial(vec3(0.9f), 1.0f, 1.0f, 0.0f, radiance)}) {
        Scene scene;
        addRoom(scene, vec3(-1), vec3(1), addMaterial(scene, material));
        expectFurnace(scene, camera, radiance);
    }
}

// Directions below a tilted normal's surface are traced from its other side: nothing is lost.
TEST(Reference, FurnaceHoldsWithTiltedShadingNormals) {
    Scene scene;
    const vec3 radiance(1.0f);
    addRoom(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseMaterial(vec3(0.5f), radiance)));
    const vec3 tilted = glm::normalize(vec3(1.0f, 1.0f, 0.0f));
    addQuad(scene, vec3(-0.9f, 0, -0.9f), vec3(0, 0, 1.8f), vec3(1.8f, 0, 0),
            addMaterial(scene, makeMaterial(vec3(0.7f), 0.0f, 1.0f, 0.6f, radiance)), &tilted);
    expectFurnace(scene, lookAt(vec3(0.05f, 0.8f, 0.1f), vec3(0.0f)), radiance);
}

TEST(Reference, FurnaceOfSeveralBounces) {
    Scene scene;
    const float rho = 0.8f;
    addRoom(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseMaterial(vec3(rho), vec3(1.0f))));
    ReferenceParams params = smallParams(lookAt(vec3(0, 0, 0.5f), vec3(0, -1, -1)), 8, 32);
    float expected = 0.0f;
    for (params.bounces = 0; params.bounces <= 4; ++params.bounces) {
        const ReferenceResult r = renderReference(scene, params);
        for (const vec3& pixel : r.frame.indirect.pixels) {
            EXPECT_NEAR(pixel.x, expected, 1e-4f * (1.0f + expected)) << params.bounces;
        }
        expected = rho * (1.0f + expected);
    }
}

// A diffuse sphere around a point light: direct E/pi*rho with E = I/r^2 everywhere, and indirect
// rho times that, since every direction sees the same radiance.
TEST(Reference, SphereAroundAPointLight) {
    const float rho = 0.5f, radius = 3.0f, intensity = 7.0f;
    // The mesh of 64 rings lies up to 1 - cos(pi/128)^2 = 0.06% inside the sphere: 0.12% in E.
    constexpr double kMeshError = 2e-3;
    Scene scene;
    addSphere(scene, radius, 64, addMaterial(scene, diffuseMaterial(vec3(rho))));
    scene.lights.push_back(pointLight(vec3(0.0f), vec3(intensity)));
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(1, 0.5f, 0), vec3(-1, 0.2f, 0.4f)), 8, 64));
    const float direct = rho / kPi * intensity / (radius * radius);
    for (const vec3& pixel : r.frame.direct.pixels) {
        EXPECT_NEAR(pixel.x, direct, kMeshError * direct);
    }
    expectWithin(
        r.frame.indirect, r.frame.indirect_variance, [&](int) { return vec3(rho * direct); },
        kSigmas, kMeshError);
}

// The shading of a flat surface point from one direction, without rays.
Surface flatSurface(const vec3& p, const vec3& n, const vec3& wo, const Material& material) {
    Surface s;
    s.position = p;
    s.n = s.n_g = n;
    s.wo = wo;
    s.brdf =
        shared::makeBrdf(material.params, brdfAlbedo(glm::dot(n, wo), material.params.roughness));
    return s;
}

// A floor point under a square panel that glows and is lit by a lamp: the integral over the panel's
// area instead of the hemisphere, by the midpoint rule, without rays.
TEST(Reference, PanelAgreesWithIntegralOverItsArea) {
    constexpr float kHalf = 0.5f, kHeight = 0.8f;
    constexpr int kCells = 200;
    const float radiance = 2.0f;
    const vec3 eye(1.5f, 0.7f, 0.4f), lamp(0.3f, 0.1f, -0.2f);
    for (const float roughness : {0.25f, 0.6f}) {
        for (const float metallic : {0.0f, 1.0f}) {
            Scene scene;
            const Material floor = makeMaterial(vec3(0.8f, 0.6f, 0.4f), metallic, 1.0f, roughness);
            const Material panel = makeMaterial(vec3(0.5f), 0.0f, 1.0f, 0.5f, vec3(radiance));
            addQuad(scene, vec3(-4, 0, -4), vec3(0, 0, 8), vec3(8, 0, 0),
                    addMaterial(scene, floor));
            addQuad(scene, vec3(-kHalf, kHeight, -kHalf), vec3(2 * kHalf, 0, 0),
                    vec3(0, 0, 2 * kHalf), addMaterial(scene, panel));
            scene.lights.push_back(pointLight(lamp, vec3(0.6f)));

            const vec3 up(0, 1, 0);
            const Surface p = flatSurface(vec3(0), up, glm::normalize(eye), floor);
            glm::dvec3 expected(0.0), expected_diffuse(0.0);
            for (int cell = 0; cell < kCells * kCells; ++cell) {
                const float x = (2.0f * (cell % kCells + 0.5f) / kCells - 1.0f) * kHalf;
                const float z = (2.0f * (cell / kCells + 0.5f) / kCells - 1.0f) * kHalf;
                const vec3 point(x, kHeight, z);
                const float d2 = glm::dot(point, point);
                const vec3 wi = point / std::sqrt(d2);
                const Surface q = flatSurface(point, -up, -wi, panel);
                const vec3 to_lamp = lamp - point;
                const float lamp_d2 = glm::dot(to_lamp, to_lamp);
                const vec3 wl = to_lamp / std::sqrt(lamp_d2);
                const vec3 leaving = vec3(radiance) + shared::evalBrdf(q.brdf, q.n, q.wo, wl) *
                                                          (0.6f / lamp_d2 * glm::dot(q.n, wl));
                const float form = wi.y * wi.y / d2 * (4.0f * kHalf * kHalf / (kCells * kCells));
                expected += glm::dvec3(shared::evalBrdf(p.brdf, p.n, p.wo, wi) * leaving * form);
                expected_diffuse += glm::dvec3(p.brdf.diffuse / kPi * leaving * form);
            }
            // One pixel, whose centre sees the origin.
            const Frame frame =
                renderReference(scene, smallParams(lookAt(eye, vec3(0)), 1, 1 << 16)).frame;
            ASSERT_NEAR(glm::length(frame.position.at(0, 0)), 0.0f, 1e-6f);
            expectWithin(
                frame.indirect, frame.indirect_variance, [&](int) { return vec3(expected); },
                kSigmas, 1e-3);
            expectWithin(
                frame.indirect_diffuse, frame.indirect_diffuse_variance,
                [&](int) { return vec3(expected_diffuse); }, kSigmas, 1e-3);
            EXPECT_LT(frame.indirect_variance.at(0, 0).x, 1e-5 * expected.x * expected.x);
        }
    }
}

TEST(Reference, DirectLightOnAPlane) {
    const float rho = 0.6f, height = 2.0f;
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseMaterial(vec3(rho)));
    addQuad(scene, vec3(-5, 0, -5), vec3(0, 0, 10), vec3(10, 0, 0), white);
    scene.lights.push_back(pointLight(vec3(0, height, 0), vec3(3.0f)));
    scene.lights.push_back(directionalLight(vec3(0, -1, 1), vec3(0.5f)));
    // A spot whose cone's centre meets the origin; outside 30 degrees it gives nothing.
    PunctualLight spot = pointLight(vec3(0, 1, 0), vec3(2.0f));
    spot.kind = shared::LIGHT_SPOT;
    spot.cos_outer = std::cos(kPi / 6.0f);
    spot.spot_scale = 1.0f / (1.0f - spot.cos_outer);
    spot.spot_offset = -spot.cos_outer * spot.spot_scale;
    scene.lights.push_back(spot);
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(0, 1.5f, 3), vec3(0)), 16, 16));
    for (int i = 0; i < r.frame.direct.count(); ++i) {
        const auto pixel = static_cast<size_t>(i);
        if (r.frame.primitive.pixels[pixel] == kNoPrimitive) {
            continue;
        }
        const vec3 p = r.frame.position.pixels[pixel];
        const float d2 = p.x * p.x + p.z * p.z;
        const float point = 3.0f * height / std::pow(d2 + height * height, 1.5f);
        const float sun = 0.5f * std::sqrt(0.5f);
        const float cosine = 1.0f / std::sqrt(d2 + 1.0f);
        const float cone =
            glm::clamp((cosine - spot.cos_outer) / (1.0f - spot.cos_outer), 0.0f, 1.0f);
        const float expected =
            rho / kPi * (point + sun + 2.0f * cone * cone * cosine / (d2 + 1.0f));
        EXPECT_NEAR(r.frame.direct.pixels[pixel].x, expected, 1e-4f * expected);
        EXPECT_EQ(r.frame.direct_variance.pixels[pixel], vec3(0.0f));
    }
}

TEST(Reference, ShadowsAreTraced) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseMaterial(vec3(0.5f)));
    addQuad(scene, vec3(-5, 0, -5), vec3(0, 0, 10), vec3(10, 0, 0), white);
    addQuad(scene, vec3(-1, 1, -1), vec3(0, 0, 2), vec3(2, 0, 0), white);
    scene.lights.push_back(pointLight(vec3(0, 2, 0), vec3(3.0f)));
    // From below the blocker: its shadow on the floor is 4 wide.
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(0, 0.9f, 4.5f), vec3(0)), 16, 16));
    int lit = 0, dark = 0;
    for (int i = 0; i < r.frame.direct.count(); ++i) {
        const auto pixel = static_cast<size_t>(i);
        const uint32_t primitive = r.frame.primitive.pixels[pixel];
        if (primitive == kNoPrimitive) {
            continue;
        }
        const vec3 p = r.frame.position.pixels[pixel];
        const bool in_shadow = primitive >= 2 || std::max(std::abs(p.x), std::abs(p.z)) < 2.0f;
        EXPECT_EQ(r.frame.direct.pixels[pixel].x > 0.0f, !in_shadow);
        (in_shadow ? dark : lit) += 1;
    }
    EXPECT_GT(lit, 10);
    EXPECT_GT(dark, 10);
}

TEST(Reference, GBufferAtPixelCentres) {
    Scene scene;
    const uint32_t paint = addMaterial(scene, diffuseMaterial(vec3(0.2f, 0.4f, 0.6f), vec3(3.0f)));
    // Wound and shaded away from the camera: both normals turn.
    addQuad(scene, vec3(-10, -10, -4), vec3(0, 20, 0), vec3(20, 0, 0), paint);
    Camera camera;
    const ReferenceResult r = renderReference(scene, smallParams(camera, 5, 16));
    const float tan_half = std::tan(0.5f * camera.y_fov);
    for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 5; ++x) {
            const vec3 p((x - 2) / 2.5f * tan_half * 4.0f, (2 - y) / 2.5f * tan_half * 4.0f, -4.0f);
            EXPECT_NEAR(glm::distance(r.frame.position.at(x, y), p), 0.0f, 1e-5f);
            EXPECT_NEAR(r.frame.depth.at(x, y), 4.0f, 1e-5f);
            EXPECT_NEAR(glm::distance(r.frame.normal.at(x, y), vec3(0, 0, 1)), 0.0f, 1e-6f);
            EXPECT_EQ(r.frame.albedo.at(x, y), vec3(0.2f, 0.4f, 0.6f));
            EXPECT_EQ(r.frame.emission.at(x, y), vec3(3.0f));
            EXPECT_EQ(r.frame.roughness.at(x, y), 1.0f);
        }
    }
    // The image's rows run downward: its top right pixel lies on the triangle with +x or +y.
    EXPECT_LT(r.frame.primitive.at(4, 0), 2u);
}

// ---- Variance and reproducibility ---------------------------------------------------------------

// Mean over the pixels of the ratio of the variance seen between runs to the one they report.
double varianceRatio(int spp) {
    constexpr int kRuns = 48, kSize = 8;
    const Scene scene = litRoom();
    ReferenceParams params = smallParams(litRoomCamera(), kSize, spp);
    std::vector<double> sum(kSize * kSize, 0.0), squares = sum, reported = sum;
    for (int run = 0; run < kRuns; ++run) {
        params.seed = static_cast<uint32_t>(run);
        const Frame frame = renderReference(scene, params).frame;
        for (size_t i = 0; i < sum.size(); ++i) {
            const double v = frame.indirect.pixels[i].y;
            sum[i] += v;
            squares[i] += v * v;
            reported[i] += frame.indirect_variance.pixels[i].y;
        }
    }
    double ratio = 0.0;
    for (size_t i = 0; i < sum.size(); ++i) {
        const double mean = sum[i] / kRuns;
        const double seen = (squares[i] - kRuns * mean * mean) / (kRuns - 1);
        ratio += seen / (reported[i] / kRuns) / static_cast<double>(sum.size());
    }
    return ratio;
}

TEST(Reference, VarianceIsThatOfRepeatedRuns) {
    // Each pixel's ratio scatters by sqrt(2/47) = 21% or, with heavy tails, more; the mean of 64
    // pixels by about 3%.
    EXPECT_NEAR(varianceRatio(32), 1.0, 0.15);
    EXPECT_NEAR(varianceRatio(256), 1.0, 0.15);  // guided
}

// Pixels that see a caustic are found by few paths, so that single ones stray further than a normal
// distribution would; the image's mean does not.
TEST(Reference, ErrorOfTheMeanIsWhatTheVarianceSays) {
    const Scene scene = litRoom();
    const Frame truth = renderReference(scene, smallParams(litRoomCamera(), 8, 8192)).frame;
    ReferenceParams params = smallParams(litRoomCamera(), 8, 64);
    for (uint32_t seed = 1; seed <= 8; ++seed) {
        params.seed = seed;
        params.spp = seed % 2 == 0 ? 64 : 256;  // without and with the guide
        const Frame frame = renderReference(scene, params).frame;
        double error = 0.0, variance = 0.0;
        for (size_t i = 0; i < truth.indirect.pixels.size(); ++i) {
            error += frame.indirect.pixels[i].y - truth.indirect.pixels[i].y;
            variance += frame.indirect_variance.pixels[i].y + truth.indirect_variance.pixels[i].y;
        }
        EXPECT_LT(std::abs(error), 4.0 * std::sqrt(variance)) << "seed " << seed;
    }
}

void expectSameBits(const Image<vec3>& a, const Image<vec3>& b) {
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    EXPECT_EQ(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec3)), 0);
}

TEST(Reference, ThreadCountChangesNoBit) {
    const Scene scene = litRoom();
    const ReferenceParams params = smallParams(litRoomCamera(), 16, 256);  // guided
    setThreadCount(1);
    const Frame one = renderReference(scene, params).frame;
    for (const int threads : {2, 5}) {
        setThreadCount(threads);
        const Frame many = renderReference(scene, params).frame;
        expectSameBits(one.indirect, many.indirect);
        expectSameBits(one.indirect_variance, many.indirect_variance);
        expectSameBits(one.direct, many.direct);
        EXPECT_EQ(one.primitive.pixels, many.primitive.pixels);
    }
    setThreadCount(0);
}

TEST(Reference, ScaleChangesNothing) {
    const Frame metre = renderReference(litRoom(), smallParams(litRoomCamera(), 16, 64)).frame;
    // Powers of two round alike: the same bits.
    for (const float scale : {1024.0f, 1.0f / 1024.0f}) {
        const Frame other =
            renderReference(litRoom(scale), smallParams(litRoomCamera(scale), 16, 64)).frame;
        expectSameBits(metre.indirect, other.indirect);
        expectSameBits(metre.direct, other.direct);
    }
    // Others round differently; the paths are the same but for the rare one that passes an edge.
    for (const float scale : {1000.0f, 0.001f}) {
        const Frame other =
            renderReference(litRoom(scale), smallParams(litRoomCamera(scale), 16, 64)).frame;
        EXPECT_EQ(metre.primitive.pixels, other.primitive.pixels);
        double difference = 0.0, total = 0.0;
        for (size_t i = 0; i < metre.indirect.pixels.size(); ++i) {
            difference += std::abs(metre.indirect.pixels[i].y - other.indirect.pixels[i].y);
            total += metre.indirect.pixels[i].y;
        }
        EXPECT_LT(difference, 1e-3 * total) << scale;
    }
}

// Far from the origin, where coordinates are coarse, nothing shadows itself.
TEST(Reference, NoSelfShadowingFarFromTheOrigin) {
    for (const float far : {0.0f, 100.0f, 10000.0f}) {
        Scene scene;
        addQuad(scene, vec3(far - 5, 0.3f * far, far - 5), vec3(0.1f, 0.7f, 10),
                vec3(10, 0.2f, 0.3f), addMaterial(scene, diffuseMaterial(vec3(0.5f))));
        scene.lights.push_back(directionalLight(vec3(1, -0.05f, 0.2f), vec3(1.0f)));
        const vec3 target(far, 0.3f * far + 0.4f, far);
        const Frame frame =
            renderReference(scene, smallParams(lookAt(target + vec3(0, 4, 1), target), 32, 16))
                .frame;
        const float expected = frame.direct.at(16, 16).x;
        EXPECT_GT(expected, 0.0f);
        for (const vec3& pixel : frame.direct.pixels) {
            EXPECT_NEAR(pixel.x, expected, 1e-3f * expected) << far;
        }
        // An open plane sees nothing of itself.
        for (const vec3& pixel : frame.indirect.pixels) {
            EXPECT_EQ(pixel, vec3(0.0f)) << far;
        }
    }
}

// ---- Degenerate scenes --------------------------------------------------------------------------

TEST(Reference, NoLightsIsBlack) {
    Scene scene = litRoom();
    scene.lights.clear();
    for (Material& material : scene.materials) {
        material.params.emission = vec3(0.0f);
    }
    const Frame frame = renderReference(scene, smallParams(litRoomCamera(), 8, 16)).frame;
    for (size_t i = 0; i < frame.direct.pixels.size(); ++i) {
        EXPECT_EQ(frame.direct.pixels[i], vec3(0.0f));
        EXPECT_EQ(frame.indirect.pixels[i], vec3(0.0f));
        EXPECT_EQ(frame.indirect_variance.pixels[i], vec3(0.0f));
        EXPECT_NE(frame.primitive.pixels[i], kNoPrimitive);
    }
}

TEST(Reference, NoGeometry) {
    Scene scene;
    scene.lights.push_back(pointLight(vec3(0), vec3(1)));
    const ReferenceResult r = renderReference(scene, smallParams(Camera{}, 4, 16));
    for (size_t i = 0; i < 16; ++i) {
        EXPECT_EQ(r.frame.primitive.pixels[i], kNoPrimitive);
        EXPECT_EQ(r.frame.depth.pixels[i], kInfinity);
        EXPECT_EQ(r.frame.indirect.pixels[i], vec3(0.0f));
        EXPECT_EQ(r.frame.direct.pixels[i], vec3(0.0f));
    }
    EXPECT_EQ(r.rays, 16);
}

// Inside a closed metal box the light outside does not reach; the back faces are surfaces too.
TEST(Reference, CameraInsideAnObject) {
    const Scene scene = litRoom();
    const Camera camera = lookAt(vec3(-0.25f, -0.65f, -0.1f), vec3(0.1f, -0.6f, 0.2f));
    const Frame frame = renderReference(scene, smallParams(camera, 8, 16)).frame;
    for (size_t i = 0; i < frame.direct.pixels.size(); ++i) {
        EXPECT_GE(frame.primitive.pixels[i], 12u);  // the box's, not the room's
        EXPECT_EQ(frame.direct.pixels[i], vec3(0.0f));
        EXPECT_EQ(frame.indirect.pixels[i], vec3(0.0f));
    }
}

TEST(Reference, WhatIsNotFiniteNeverReachesAnImage) {
    Scene scene = litRoom();
    scene.lights[0].intensity = vec3(kInfinity);
    const ReferenceResult r = renderReference(scene, smallParams(litRoomCamera(), 8, 16));
    EXPECT_GT(r.nonfinite_samples, 0);
    for (const Image<vec3>* layer : {&r.frame.direct, &r.frame.indirect, &r.frame.indirect_variance,
                                     &r.frame.indirect_diffuse_variance}) {
        for (const vec3& pixel : layer->pixels) {
            EXPECT_TRUE(std::isfinite(pixel.x + pixel.y + pixel.z));
        }
    }
}

TEST(Reference, SamplesAreRoundedUpToReplicates) {
    const Scene scene = litRoom();
    EXPECT_EQ(renderReference(scene, smallParams(litRoomCamera(), 2, 1)).spp, 16);
    EXPECT_EQ(renderReference(scene, smallParams(litRoomCamera(), 2, 17)).spp, 32);
}

TEST(Reference, RejectsSenselessParameters) {
    const Scene scene = litRoom();
    const ReferenceParams good = smallParams(litRoomCamera(), 2, 16);
    ReferenceParams params = good;
    params.width = 0;
    EXPECT_THROW(renderReference(scene, params), Error);
    params = good;
    params.spp = 0;
    EXPECT_THROW(renderReference(scene, params), Error);
    params = good;
    params.bounces = -1;
    EXPECT_THROW(renderReference(scene, params), Error);
    params = good;
    params.replicates = 1;
    EXPECT_THROW(renderReference(scene, params), std::logic_error);
}

}  // namespace
}  // namespace sheen
