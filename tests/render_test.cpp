// Whole renders of scenes with closed forms, and of scenes that hardly are any.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "core/parallel.h"
#include "scene/brdf_albedo.h"
#include "test_render.h"

namespace sheen {
namespace {

// Furnaces: 1% of the closed form, in every pixel.
constexpr float kFurnaceError = 0.01f;

void expectSane(const RenderResult& result, int width, int height) {
    const Frame& frame = result.frame;
    ASSERT_EQ(frame.width(), width);
    ASSERT_EQ(frame.height(), height);
    for (const Image<vec3>* image :
         {&frame.direct, &frame.indirect, &frame.indirect_diffuse, &frame.emission}) {
        if (image != &frame.emission || !image->empty()) {  // where nothing emits there is none
            ASSERT_EQ(image->count(), width * height);
        }
        for (const vec3& v : image->pixels) {
            ASSERT_TRUE(std::isfinite(v.x + v.y + v.z));
            ASSERT_GE(std::min({v.x, v.y, v.z}), 0.0f);
        }
    }
    EXPECT_EQ(result.stats.pixels_uncovered, 0);
    EXPECT_EQ(result.stats.nonfinite_pixels, 0);
}

// ---- Closed forms -------------------------------------------------------------------------------

TEST(Furnace, DiffuseSurfacesReflectTheirAlbedo) {
    const vec3 albedo(0.8f, 0.5f, 0.2f), Le(1.0f, 2.0f, 3.0f);
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        for (Method method : {Method::kRadiance, Method::kIrradiance}) {
            const RenderResult result = renderFrame(furnace(diffuseParams(albedo), Le, road),
                                                    smallRender(48, 48, method, road));
            expectSane(result, 48, 48);
            for (size_t i = 0; i < result.frame.indirect.pixels.size(); ++i) {
                const bool seen = result.frame.primitive.pixels[i] != kNoPrimitive;
                for (int c = 0; c < 3; ++c) {
                    const float expected = seen ? albedo[c] * Le[c] : 0.0f;
                    EXPECT_NEAR(result.frame.indirect.pixels[i][c], expected,
                                kFurnaceError * expected);
                    const bool shows = !seen || road == GatherRoad::kRaster;
                    EXPECT_NEAR(result.frame.emission.pixels[i][c], shows ? Le[c] : 0.0f, 1e-5f);
                }
            }
        }
    }
}

TEST(Furnace, GlossySurfacesReflectTheirWholeAlbedo) {
    const vec3 base(0.8f, 0.5f, 0.2f), Le(1.0f, 2.0f, 3.0f);
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        // The last three are left to rays in part or whole.
        for (const auto& [metallic, roughness] :
             {std::pair(0.0f, 0.5f), std::pair(1.0f, 0.4f), std::pair(1.0f, 0.8f),
              std::pair(0.5f, 0.3f), std::pair(1.0f, 0.0f), std::pair(0.0f, 0.1f)}) {
            const Scene scene = furnace(glossyParams(base, metallic, roughness), Le, road);
            const RenderResult result =
                renderFrame(scene, smallRender(40, 40, Method::kRadiance, road));
            expectSane(result, 40, 40);
            const vec3 eye(scene.cameras[0].world_from_camera[3]);
            for (size_t i = 0; i < result.frame.indirect.pixels.size(); ++i) {
                if (result.frame.primitive.pixels[i] == kNoPrimitive) {
                    continue;
                }
                const vec3 wo = glm::normalize(eye - result.frame.position.pixels[i]);
                const vec2 ab = brdfAlbedo(glm::dot(result.frame.normal.pixels[i], wo), roughness);
                const Brdf brdf = shared::makeBrdf(scene.materials[0].params, 1.0f, ab);
                const vec3 expected = Le * (brdf.diffuse + brdf.f0 * ab.x + vec3(brdf.f90 * ab.y));
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(result.frame.indirect.pixels[i][c], expected[c],
                                kFurnaceError * expected[c])
                        << "metallic " << metallic << " roughness " << roughness << " pixel " << i;
                }
            }
        }
    }
}

// Lamps all around light directly, and once more by way of each other: by a sample for each ray of
// a record, whose noise is several percent and leans to no side.
TEST(Furnace, WhiteSurfacesReflectEverything) {
    const float Le = 2.0f;
    for (const float metallic : {0.0f, 1.0f}) {
        for (const float roughness : {0.1f, 0.45f, 0.7f, 1.0f}) {
            const Scene scene =
                furnace(glossyParams(vec3(1.0f), metallic, roughness), vec3(Le), GatherRoad::kRays);
            const RenderResult result = renderFrame(scene, smallRender(32, 32));
            for (size_t i = 0; i < result.frame.indirect.pixels.size(); ++i) {
                if (result.frame.primitive.pixels[i] != kNoPrimitive) {
                    EXPECT_NEAR(result.frame.indirect.pixels[i].x, Le, kFurnaceError * Le)
                        << "metallic " << metallic << " roughness " << roughness << " pixel " << i;
                }
            }
        }
    }
}

TEST(Furnace, CoatedSurfacesReflectEverythingToo) {
    const float Le = 2.0f;
    for (const float metallic : {0.0f, 1.0f}) {
        Scene scene =
            furnace(glossyParams(vec3(1.0f), metallic, 0.6f), vec3(Le), GatherRoad::kRays);
        scene.materials[0].layers = {.coat = 1.0f, .coat_roughness = 0.1f};
        for (const Method method : {Method::kRadiance, Method::kReference}) {
            RenderParams params = smallRender(24, 24, method);
            params.spp = 4096;
            const RenderResult result = renderFrame(scene, params);
            for (size_t i = 0; i < result.frame.indirect.pixels.size(); ++i) {
                if (result.frame.primitive.pixels[i] != kNoPrimitive) {
                    EXPECT_NEAR(result.frame.indirect.pixels[i].x, Le, 2.0f * kFurnaceError * Le)
                        << "metallic " << metallic << " pixel " << i;
                }
            }
        }
    }
}

TEST(Furnace, LampsAllAroundLightDirectly) {
    constexpr double kDirect = 0.02, kIndirect = 0.08,
                     kMean = 0.02;  // of the light, the first two rms
    const vec3 albedo(0.8f, 0.5f, 0.2f), Le(1.0f, 2.0f, 3.0f);
    const RenderResult result =
        renderFrame(glowingRoom(diffuseParams(albedo), Le), smallRender(16, 16, Method::kRadiance));
    const auto expectNear = [kMean](const Image<vec3>& image, const vec3& expected, double rms) {
        for (int c = 0; c < 3; ++c) {
            double sum = 0.0, squares = 0.0;
            for (const vec3& pixel : image.pixels) {
                const double off = pixel[c] / expected[c] - 1.0;
                sum += off;
                squares += off * off;
            }
            const auto count = static_cast<double>(image.pixels.size());
            EXPECT_LT(std::sqrt(squares / count), rms);
            EXPECT_LT(std::abs(sum / count), kMean);
        }
    };
    expectNear(result.frame.direct, albedo * Le, kDirect);
    expectNear(result.frame.indirect, albedo * albedo * Le, kIndirect);
}

// A mirror shows what a ray finds: each pixel of it is the emission of the wall it reflects.
TEST(TooGlossy, MirrorShowsTheRoom) {
    Scene scene;
    uint32_t walls[6];
    for (int i = 0; i < 6; ++i) {
        walls[i] = addMaterial(
            scene, diffuseParams(vec3(0.0f), vec3(static_cast<float>(i + 1), 1.0f, 0.5f)));
    }
    addBox(scene, vec3(-1), vec3(1), {walls[0], walls[1], walls[2], walls[3], walls[4], walls[5]},
           true);
    const float f0 = 0.9f;
    const uint32_t mirror = addMaterial(scene, glossyParams(vec3(f0), 1.0f, 0.0f));
    addQuad(scene, vec3(-0.9f, -0.95f, -0.9f), vec3(0, 0, 1.8f), vec3(1.8f, 0, 0), mirror);
    scene.cameras.push_back(lookAt(vec3(0.1f, 0.0f, 0.8f), vec3(0.0f, -0.9f, -0.2f)));
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        const RenderResult result =
            renderFrame(scene, smallRender(48, 48, Method::kRadiance, road));
        expectSane(result, 48, 48);
        const vec3 eye(scene.cameras[0].world_from_camera[3]);
        int mirrored = 0, agree = 0;
        for (size_t i = 0; i < result.frame.indirect.pixels.size(); ++i) {
            const vec3 reflected = result.frame.direct.pixels[i] + result.frame.indirect.pixels[i];
            if (result.frame.primitive.pixels[i] < 12u) {
                EXPECT_EQ(reflected, vec3(0.0f));  // black walls
                continue;
            }
            // Where the reflected ray leaves the box.
            const vec3 p = result.frame.position.pixels[i];
            const vec3 d = glm::reflect(glm::normalize(p - eye), vec3(0, 1, 0));
            const vec3 t = (glm::sign(d) - p) / d;
            const int axis = t.x < t.y && t.x < t.z ? 0 : (t.y < t.z ? 1 : 2);
            const vec3 hit = p + t[axis] * d;
            float seen = 0.0f;
            for (size_t k = 0; k < 12; k += 2) {
                const vec3 n = geometricNormal(scene, static_cast<int>(k));
                const vec3& corner = scene.positions[scene.triangles[k].x];
                if (std::abs(glm::dot(hit - corner, n)) < 1e-4f) {
                    seen = scene.materials[scene.materials_of[k]].params.emission.x;
                }
            }
            const float fresnel = f0 + (1.0f - f0) * shared::schlickWeight(d.y);
            ++mirrored;
            // Pixels whose narrow lobe crosses an edge between two walls see both.
            agree += std::abs(reflected.x - fresnel * seen) < 0.02f * seen;
        }
        EXPECT_GT(mirrored, 48 * 48 / 4);
        EXPECT_GT(agree, mirrored * 97 / 100);
        EXPECT_NEAR(result.stats.too_glossy_share, mirrored / (48.0 * 48.0), 1e-9);
    }
}

// A given order asks for its truncation: counted, and nothing is left to rays.
TEST(TooGlossy, GivenOrderIsKept) {
    const Scene scene = glossyRoom(0.1f, 0.1f);
    RenderParams params = smallRender(32, 32);
    const RenderResult by_rays = renderFrame(scene, params);
    params.sh_order = 4;
    const RenderResult truncated = renderFrame(scene, params);
    EXPECT_GT(by_rays.stats.too_glossy_share, 0.1);
    EXPECT_NEAR(truncated.stats.too_glossy_share, by_rays.stats.too_glossy_share, 0.05);
    EXPECT_NE(truncated.frame.indirect.pixels, by_rays.frame.indirect.pixels);
    params.method = Method::kIrradiance;
    params.sh_order = 0;
    EXPECT_EQ(renderFrame(scene, params).stats.too_glossy_share, 0.0);
}

TEST(SphereWithLightInside, OneBounceHasItsClosedForm) {
    // Direct: albedo I / (pi R^2) everywhere; one bounce more: times the albedo.
    const float R = 2.0f, albedo = 0.6f, I = 5.0f;
    Scene scene;
    addSphere(scene, vec3(0), R, 40, addMaterial(scene, diffuseParams(vec3(albedo))));
    scene.lights.push_back(pointLight(vec3(0), vec3(I)));
    scene.cameras.push_back(lookAt(vec3(0.5f, 0.3f, 1.0f), vec3(0, 0, -1)));
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        const RenderResult result =
            renderFrame(scene, smallRender(48, 48, Method::kRadiance, road));
        expectSane(result, 48, 48);
        const float direct = albedo * I / (kPi * R * R);
        for (size_t i = 0; i < result.frame.indirect.pixels.size(); ++i) {
            // Forty rings of facets: 0.2% off the sphere; shading normals 2 degrees off the
            // facets'.
            EXPECT_NEAR(result.frame.direct.pixels[i].x, direct, 0.01f * direct);
            // By raster, records see facets at coarser levels of detail, nearer to the light.
            EXPECT_NEAR(result.frame.indirect.pixels[i].x, albedo * direct,
                        0.01f * albedo * direct);
        }
    }
}

// ---- The same image -----------------------------------------------------------------------------

std::vector<char> bytesOf(const Frame& frame) {
    std::vector<char> bytes;
    for (const Image<vec3>* image : {&frame.direct, &frame.indirect, &frame.indirect_diffuse}) {
        const auto* first = reinterpret_cast<const char*>(image->pixels.data());
        bytes.insert(bytes.end(), first, first + image->pixels.size() * sizeof(vec3));
    }
    return bytes;
}

TEST(RenderFrame, TheSameBitsRunToRunAndForAnyThreads) {
    const Scene scene = glossyRoom();
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        const RenderParams params = smallRender(64, 130, Method::kRadiance, road);
        setThreadCount(1);
        const std::vector<char> first = bytesOf(renderFrame(scene, params).frame);
        for (int threads : {1, 2, 3}) {
            setThreadCount(threads);
            EXPECT_TRUE(bytesOf(renderFrame(scene, params).frame) == first)
                << threads << " threads";
        }
        setThreadCount(0);
    }
}

// The software rasteriser's own threads are decided once a process: one process each.
TEST(RenderFrameDeathTest, TheSameBitsInProcessesOfAnyThreads) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto path = [](GatherRoad road, int threads) {
        return std::filesystem::path(testing::TempDir()) /
               fmt::format("sheen_render_threads_{}_{}", static_cast<int>(road), threads);
    };
    // A child runs this test up to its own statement, so nothing may be checked in between.
    for (GatherRoad road : kRoads) {
        for (int threads : {1, 2, 3}) {
            EXPECT_EXIT(
                {
                    setThreadCount(threads);
                    const RenderParams params = smallRender(48, 40, Method::kRadiance, road);
                    const std::vector<char> bytes =
                        bytesOf(renderFrame(glossyRoom(), params).frame);
                    std::ofstream(path(road, threads), std::ios::binary)
                        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
                    std::_Exit(0);
                },
                testing::ExitedWithCode(0), "");
        }
    }
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        std::vector<char> images[3];
        for (int threads : {1, 2, 3}) {
            std::ifstream file(path(road, threads), std::ios::binary);
            images[threads - 1].assign(std::istreambuf_iterator<char>(file), {});
            std::filesystem::remove(path(road, threads));
        }
        ASSERT_FALSE(images[0].empty());
        EXPECT_TRUE(images[1] == images[0]);
        EXPECT_TRUE(images[2] == images[0]);
    }
}

TEST(RenderFrame, ScalingTheSceneChangesNoPixel) {
    // A record may fall on another pixel where rounding decides, and shadow maps and rays round
    // otherwise at edges: the images agree on average, not bit for bit.
    constexpr double kMeanDifference = 0.01;
    const Scene scene = glossyRoom();
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        const RenderParams params = smallRender(64, 64, Method::kRadiance, road);
        const Frame one = renderFrame(scene, params).frame;
        double total = 0.0;
        for (const vec3& v : one.indirect.pixels) {
            total += v.x + v.y + v.z;
        }
        for (float s : {1000.0f, 0.001f}) {
            const RenderResult other = renderFrame(scaled(scene, s), params);
            expectSane(other, 64, 64);
            double difference = 0.0;
            for (size_t i = 0; i < one.indirect.pixels.size(); ++i) {
                const vec3 d = glm::abs(other.frame.indirect.pixels[i] - one.indirect.pixels[i]);
                difference += d.x + d.y + d.z;
            }
            EXPECT_LT(difference, kMeanDifference * total) << "scale " << s;
        }
    }
}

// ---- Hardly a scene -----------------------------------------------------------------------------

TEST(RenderFrame, CoarseAccuraciesDoNotFillCreases) {
    Scene scene = glowingRoom(diffuseParams(vec3(0.5f)), vec3(0.0f));
    scene.lights.push_back(pointLight(vec3(0.2f, 0.6f, 0.3f), vec3(1.0f)));
    for (int i = 0; i < 12; ++i) {  // steps too low to be seen but as creases
        const float z = -0.9f + 0.15f * static_cast<float>(i);
        addBox(scene, vec3(-1.0f, -1.01f, z), vec3(1.0f, -0.98f, z + 0.08f), 0, false);
    }
    const auto records = [&scene](float accuracy, float min_pixels) {
        RenderParams params = smallRender(128, 128);
        params.gather.size = 8;
        params.placement.accuracy = accuracy;
        params.placement.min_pixels = min_pixels;
        const RenderResult result = renderFrame(scene, params);
        expectSane(result, 128, 128);
        return result.stats.records;
    };
    const float by_accuracy = RenderParams{}.placement.min_pixels;
    EXPECT_EQ(records(0.5f, by_accuracy), records(0.5f, PlacementParams{}.min_pixels));
    EXPECT_EQ(records(1.0f, by_accuracy), records(1.0f, 1.0f));
    EXPECT_EQ(records(2.0f, by_accuracy), records(2.0f, std::sqrt(2.0f)));
    EXPECT_LT(records(2.0f, by_accuracy), 0.8f * records(2.0f, 1.0f));
}

TEST(RenderFrame, EmptySceneIsBlack) {
    Scene scene;
    scene.lights.push_back(pointLight(vec3(0), vec3(1)));
    scene.cameras.push_back(lookAt(vec3(0, 0, 1), vec3(0)));
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        for (Method method : {Method::kRadiance, Method::kIrradiance}) {
            const RenderResult result = renderFrame(scene, smallRender(20, 10, method, road));
            expectSane(result, 20, 10);
            EXPECT_EQ(result.stats.records, 0);
            EXPECT_EQ(result.stats.pixels_geometry, 0);
            for (const vec3& v : beauty(result.frame).pixels) {
                EXPECT_EQ(v, vec3(0.0f));
            }
        }
    }
}

// Every pixel of a view full of geometry is at most `limit`, by both roads.
void expectDark(const Scene& scene, float limit) {
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        const RenderResult result =
            renderFrame(scene, smallRender(32, 32, Method::kRadiance, road));
        expectSane(result, 32, 32);
        EXPECT_EQ(result.stats.pixels_geometry, 32 * 32);
        for (const vec3& v : beauty(result.frame).pixels) {
            EXPECT_LE(std::max({v.x, v.y, v.z}), limit);
            EXPECT_GE(std::min({v.x, v.y, v.z}), 0.0f);
        }
    }
}

TEST(RenderFrame, NoLightsIsBlack) {
    Scene scene = glossyRoom();
    scene.lights.clear();
    expectDark(scene, 0.0f);
}

TEST(RenderFrame, CameraInsideAnObject) {
    Scene scene = glossyRoom();
    scene.cameras[0] = lookAt(vec3(-0.3f, -0.7f, -0.2f), vec3(0.5f, 0, 0));  // in the box
    expectDark(scene, std::nextafter(0.02f, 0.0f));  // the gather's eye is lifted off the walls
}

TEST(RenderFrame, OnePixelVeryWideAndVeryTall) {
    const Scene scene = glossyRoom();
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(600, 3), std::pair(2, 300)}) {
        const RenderResult result = renderFrame(scene, smallRender(width, height));
        expectSane(result, width, height);
        EXPECT_EQ(result.stats.pixels_geometry, width * height);
        EXPECT_GT(result.stats.records, 0);
    }
}

TEST(RenderFrame, OpenSceneWithSkyAndInfiniteDistances) {
    // A floor under nothing: records see no geometry at all.
    Scene scene;
    addQuad(scene, vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10),
            addMaterial(scene, glossyParams(vec3(0.5f), 0.0f, 0.5f)));
    scene.lights.push_back(directionalLight(vec3(-0.2f, -1, 0), vec3(3)));
    scene.cameras.push_back(lookAt(vec3(0, 1, 4), vec3(0, 0.8f, 0)));
    for (GatherRoad road : kRoads) {
        SCOPED_TRACE(nameOf(road));
        const RenderResult result =
            renderFrame(scene, smallRender(48, 48, Method::kRadiance, road));
        expectSane(result, 48, 48);
        EXPECT_LT(result.stats.pixels_geometry, 48 * 48);
        EXPECT_GT(result.stats.pixels_geometry, 48 * 10);
        for (const vec3& v : result.frame.indirect.pixels) {
            EXPECT_EQ(v, vec3(0.0f));
        }
    }
}

TEST(RenderFrame, SmoothAndRoughEndsAndCrookedNormals) {
    // What is seen does not depend on roughness: once is enough for the dearer road.
    for (const auto& [road, roughness] :
         {std::pair(GatherRoad::kRays, 0.0f), std::pair(GatherRoad::kRays, 0.05f),
          std::pair(GatherRoad::kRays, 1.0f), std::pair(GatherRoad::kRaster, 0.05f)}) {
        SCOPED_TRACE(nameOf(road));
        Scene scene = cornellRoom(glossyParams(vec3(0.9f), 1.0f, roughness),
                                  glossyParams(vec3(0.5f), 0.0f, roughness));
        Random random(3);
        for (vec3& n : scene.normals) {
            n = glm::normalize(n + 0.8f * random.direction());
        }
        expectSane(renderFrame(scene, smallRender(32, 32, Method::kRadiance, road)), 32, 32);
    }
}

TEST(RenderFrame, RefusesAnUnknownCamera) {
    RenderParams params = smallRender(8, 8);
    params.camera = "nobody";
    EXPECT_THROW(renderFrame(glossyRoom(), params), Error);
}

}  // namespace
}  // namespace sheen
