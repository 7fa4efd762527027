// Thin films over surfaces (KHR_materials_iridescence).
#include <cmath>

#include "scene/brdf_albedo.h"
#include "scene_test_gltf.h"
#include "test_scenes.h"

namespace sheen {
namespace {

using glm::dvec2;

// One side of a bell is another's than the other.
double bell(double x, double middle, double below, double above) {
    const double t = (x - middle) / (x < middle ? below : above);
    return std::exp(-0.5 * t * t);
}

// What the eye makes of light of a wavelength, nanometres: X, Y, Z of CIE 1931 [WSS13], which the
// film's Gaussians do not know.
dvec3 seenAs(double l) {
    return {1.056 * bell(l, 599.8, 37.9, 31.0) + 0.362 * bell(l, 442.0, 16.0, 26.7) -
                0.065 * bell(l, 501.1, 20.4, 26.2),
            0.821 * bell(l, 568.8, 46.9, 40.5) + 0.286 * bell(l, 530.9, 16.3, 31.1),
            1.217 * bell(l, 437.0, 11.8, 36.0) + 0.681 * bell(l, 459.0, 26.0, 13.8)};
}

dvec3 rec709(const dvec3& xyz) {
    return {3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
            -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
            0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z};
}

double indexOf(double f0) { return (1.0 + std::sqrt(f0)) / (1.0 - std::sqrt(f0)); }

// Of amplitudes reflected between media of these indices.
double amplitude(double from, double to) { return (from - to) / (from + to); }

// All orders of interference at normal incidence, wavelength by wavelength [Airy's sum]; what of
// them has no colour is white.
vec3 airy(double index, double nanometres, double f0) {
    const double a = amplitude(1.0, index), b = amplitude(index, indexOf(f0));
    const double plain = a * a + (1 - a * a) * (1 - a * a) * b * b / (1 - a * a * b * b);
    dvec3 sum(0.0);
    double all = 0.0;
    for (double l = 380.0; l <= 780.0; l += 1.0) {
        const double wave = 2.0 * a * b * std::cos(4.0 * double{kPi} * index * nanometres / l);
        const double reflected = (a * a + b * b + wave) / (1.0 + a * a * b * b + wave);
        sum += (reflected - plain) * seenAs(l);
        all += seenAs(l).y;
    }
    return glm::clamp(vec3(plain + rec709(sum / all)), 0.0f, 1.0f);
}

TEST(ThinFilm, ReflectsAtNormalIncidenceAsAirysSum) {
    constexpr float kError = 0.03f;  // two orders, and the eye by Gaussians
    for (const float index : {1.3f, 1.8f}) {
        for (const float f0 : {0.04f, 0.3f, 0.9f}) {
            for (float nanometres = 50.0f; nanometres < 1000.0f; nanometres += 25.0f) {
                const vec3 seen = shared::filmReflectance(index, nanometres, 1.0f, vec3(f0));
                EXPECT_LT(maxAbs(seen - airy(index, nanometres, f0)), kError)
                    << "index " << index << " F0 " << f0 << " thickness " << nanometres;
            }
        }
    }
}

// A film a quarter of a wave thick whose index is the root of the glass's lets no green back.
TEST(ThinFilm, TakesReflectionsFromLenses) {
    const float index = std::sqrt(1.5f);
    const vec3 seen = shared::filmReflectance(index, 550.0f / (4.0f * index), 1.0f, vec3(0.04f));
    EXPECT_LT(seen.y, 0.004f);
    EXPECT_LT(luminance(seen), 0.2f * 0.04f);
}

TEST(ThinFilm, IsWhiteAtTheEdgeAndNeverMoreThanAllLight) {
    const vec3 metal(0.9f, 0.6f, 0.3f);
    EXPECT_LT(maxAbs(shared::filmReflectance(1.5f, 400.0f, 0.0f, metal) - 1.0f), 1e-3f);
    Random random(5);
    for (int i = 0; i < 1000; ++i) {
        MaterialParams params = glossyParams(
            vec3(random.uniform(0.0f, 1.0f), random.uniform(0.0f, 1.0f), 1.0f),
            random.uniform(-1.0f, 1.0f) > 0.0f ? 1.0f : 0.0f, random.uniform(0.03f, 1.0f));
        params.film = vec3(1.0f, random.uniform(1.0f, 2.5f), random.uniform(0.0f, 1200.0f));
        const float NoV = random.uniform(0.01f, 1.0f);
        const vec2 ab = brdfAlbedo(NoV, params.roughness);
        const Brdf brdf = shared::makeBrdf(params, NoV, ab);
        const vec3 all = brdf.diffuse + brdf.f0 * ab.x + brdf.f90 * ab.y;
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(brdf.diffuse[c], -1e-6f);
            EXPECT_GE(brdf.f0[c], 0.0f);
            EXPECT_LE(all[c], 1.01f);
        }
    }
}

// Seen mirrored, a surface reflects what its film does, at each angle.
TEST(ThinFilm, IsSeenByTheMirrorsAngle) {
    MaterialParams params = glossyParams(vec3(0.9f, 0.7f, 0.5f), 1.0f, 0.0f);
    params.film = vec3(1.0f, 1.4f, 300.0f);
    const MaterialParams bare = glossyParams(params.base_color, 1.0f, 0.0f);
    for (const float NoV : {1.0f, 0.7f, 0.4f, 0.2f}) {
        const Brdf brdf = shared::makeBrdf(params, NoV, vec2(1.0f, 0.0f));
        const vec3 seen = glm::mix(brdf.f0, vec3(1.0f), shared::schlickWeight(NoV));
        const vec3 film = shared::filmReflectance(1.4f, 300.0f, NoV, params.base_color);
        EXPECT_LT(maxAbs(seen - film), 1e-4f) << "NoV " << NoV;
    }
    params.film.x = 0.0f;
    EXPECT_EQ(shared::makeBrdf(params, 0.5f, vec2(0.9f, 0.1f)).f0,
              shared::makeBrdf(bare, 0.5f, vec2(0.9f, 0.1f)).f0);
    params.film = vec3(1.0f, 1.4f, 0.0f);
    EXPECT_EQ(shared::makeBrdf(params, 0.5f, vec2(0.9f, 0.1f)).f0,
              shared::makeBrdf(bare, 0.5f, vec2(0.9f, 0.1f)).f0);
}

TEST(MaterialIridescence, IsReadWithItsTextures) {
    GltfFile file = textured();
    Json& film = file.json["materials"][0]["extensions"]["KHR_materials_iridescence"];
    film["iridescenceFactor"] = 0.5;
    const auto at = [&] { return materialAt(file.load(), 0, vec3(1, 0, 0)).film; };
    EXPECT_EQ(at(), vec3(0.5f, 1.3f, 400.0f));
    EXPECT_FALSE(warnsOf(file.load(), "iridescence"));
    film["iridescenceIor"] = 1.5;
    film["iridescenceTexture"]["index"] = addPicture(file, {1, 1, {{{51, 0, 0}}}});
    const int thickness = addPicture(file, {1, 1, {{{0, 51, 0}}}});
    for (const dvec2& bounds : {dvec2(200, 700), dvec2(700, 200)}) {
        const double lower = bounds.x, upper = bounds.y;
        film["iridescenceThicknessMinimum"] = lower;
        film["iridescenceThicknessMaximum"] = upper;
        film.erase("iridescenceThicknessTexture");
        EXPECT_NEAR(at().z, upper, 1e-3);
        film["iridescenceThicknessTexture"]["index"] = thickness;
        EXPECT_NEAR(at().x, 0.1f, 1e-6f);
        EXPECT_NEAR(at().z, lower + 0.2 * (upper - lower), 700.0 / 255.0);
    }
    film["iridescenceIor"] = 0.5;
    EXPECT_TRUE(warnsOf(file.load(), "iridescenceIor"));
    EXPECT_EQ(at().y, 1.0f);
}

}  // namespace
}  // namespace sheen
