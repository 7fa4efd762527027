// Where triangles lie in a lightmap: the file's coordinates and charts.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "bake/charts.h"
#include "bake/seams.h"
#include "test_bake.h"

namespace sheen {
namespace {

// Two quads with coordinates of their own.
Scene twoQuads(const std::vector<vec2>& uvs) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(0), vec3(1, 0, 0), vec3(0, 0, -1), white);
    addQuad(scene, vec3(3, 0, 0), vec3(1, 0, 0), vec3(0, 0, -1), white);
    scene.second_uvs = uvs;
    return scene;
}
std::vector<vec2> square(const vec2& lower, const vec2& upper) {
    return {lower, {upper.x, lower.y}, upper, {lower.x, upper.y}};
}
std::vector<vec2> both(std::vector<vec2> a, const std::vector<vec2>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

TEST(Atlas, takesCoordinatesThatWillDo) {
    const Scene scene = twoQuads(both(square({0, 0}, {0.5f, 1}), square({0.5f, 0}, {1, 1})));
    std::string why;
    const Atlas atlas = atlasOfFile(scene, {.size = 16}, why);
    EXPECT_EQ(why, "");
    EXPECT_TRUE(atlas.of_file);
    EXPECT_EQ(atlas.charts, 2);
    EXPECT_EQ(atlas.corners[0][1], vec2(8, 0));
}

TEST(Atlas, refusesOverlap) {
    const Scene scene = twoQuads(both(square({0, 0}, {0.6f, 1}), square({0.4f, 0}, {1, 1})));
    std::string why;
    EXPECT_TRUE(atlasOfFile(scene, {.size = 16}, why).corners.empty());
    EXPECT_NE(why.find("lie over each other"), std::string::npos) << why;
}

TEST(Atlas, refusesCoordinatesOutsideOfTheSquare) {
    const Scene scene = twoQuads(both(square({0, 0}, {0.5f, 1}), square({0.6f, 0}, {1.2f, 1})));
    std::string why;
    EXPECT_TRUE(atlasOfFile(scene, {.size = 16}, why).corners.empty());
    EXPECT_NE(why.find("out of the unit square"), std::string::npos) << why;
}

TEST(Atlas, refusesTrianglesWithoutAreaAndFilesWithoutCoordinates) {
    std::string why;
    const Scene flat = twoQuads(both(square({0, 0}, {0.5f, 1}), square({0.6f, 0}, {0.6f, 1})));
    EXPECT_TRUE(atlasOfFile(flat, {.size = 16}, why).corners.empty());
    EXPECT_NE(why.find("no area"), std::string::npos) << why;
    EXPECT_TRUE(atlasOfFile(twoQuads({}), {.size = 16}, why).corners.empty());
    EXPECT_NE(why.find("none"), std::string::npos) << why;
    EXPECT_FALSE(atlasOf(twoQuads({}), {.size = 16}).of_file);
}

// In a corner of the square the file's coordinates would take more texels than there may be.
TEST(Atlas, makesChartsWhereTheFilesCoordinatesAreTooSmall) {
    const Scene scene =
        twoQuads(both(square({0, 0}, {0.001f, 0.001f}), square({0.002f, 0}, {0.003f, 0.001f})));
    std::string why;
    EXPECT_TRUE(atlasOfFile(scene, {.texels_per_metre = 20.0f}, why).corners.empty());
    EXPECT_NE(why.find("more than 8192"), std::string::npos) << why;
    const Atlas atlas = atlasOf(scene, {.texels_per_metre = 20.0f});
    EXPECT_FALSE(atlas.of_file);
    EXPECT_EQ(atlas.size, 64);
}

TEST(Atlas, rowsOfATriangle) {
    const std::array<vec2, 3> c = {vec2(1, 0), vec2(5, 2), vec2(1, 2)};
    EXPECT_EQ(rowSpan(c, 0), glm::dvec2(1, 3));
    EXPECT_EQ(rowSpan(c, 1), glm::dvec2(1, 5));
    EXPECT_EQ(rowSpan(c, 2), glm::dvec2(1, 5));  // the edge alone
    EXPECT_GT(rowSpan(c, 3).x, rowSpan(c, 3).y);
    EXPECT_GT(rowSpan(c, -2).x, rowSpan(c, -2).y);
}

// A square, a sliver 100,000 times as long beside it, and 20,000 triangles a hundredth as long:
// sizes as far apart as this take neither memory nor time.
TEST(Atlas, chartsOfTrianglesOfAllSizes) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    const auto triangle = [&](const vec2& a, const vec2& b, const vec2& c) {
        const auto first = static_cast<uint32_t>(scene.positions.size());
        for (const vec2& p : {a, b, c}) {
            addVertex(scene, vec3(p.x, 0, -p.y), vec3(0, 1, 0));
        }
        scene.triangles.emplace_back(first, first + 1, first + 2);
        scene.materials_of.push_back(white);
    };
    const auto rectangle = [&](const vec2& a, const vec2& b) {
        triangle(a, {b.x, a.y}, b);
        triangle(a, b, {a.x, b.y});
    };
    rectangle({-1, -1}, {0, 0});
    triangle({0, -1}, {1e-6f, 0}, {0, 0});
    triangle({0, 0}, {1e-6f, 0}, {1e5f, 1e5f});
    constexpr int kSide = 100;
    for (int i = 0; i < kSide * kSide; ++i) {
        const vec2 p(-2.0f + 0.01f * static_cast<float>(i % kSide),
                     -1.0f + 0.01f * static_cast<float>(i / kSide));
        rectangle(p, p + 0.01f);
    }
    std::vector<int> times(scene.triangles.size());
    for (const UvChart& chart : makeCharts(scene)) {
        for (const uint32_t i : chart.triangles) {
            ++times[i];
        }
    }
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<long>(times.size()));
}

TEST(Atlas, saysHowManyTexelsWouldDo) {
    const Scene scene = twoQuads({});
    for (const float width : {1.0f, 3.0f, 7.0f}) {
        Scene wide;
        addMaterial(wide, diffuseParams(vec3(0.5f)));
        addQuad(wide, vec3(0.0f), vec3(width, 0, 0), vec3(0, 0, -width), 0);
        try {
            makeAtlas(wide, {.size = 16, .texels_per_metre = 100.0f});
            FAIL();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::kUsage);
            const std::string text = error.what(), at_most = "ask for at most ";
            const size_t at = text.find(at_most);
            ASSERT_NE(at, std::string::npos) << text;
            const float would_do = std::stof(text.substr(at + at_most.size()));
            EXPECT_NO_THROW(makeAtlas(wide, {.size = 16, .texels_per_metre = would_do})) << text;
        }
    }
    EXPECT_THROW(makeAtlas(scene, {.size = 16, .texels_per_metre = 14.5f}), Error);
    EXPECT_EQ(makeAtlas(scene, {.size = 16, .texels_per_metre = 14.0f}).pages, 2);
    EXPECT_THROW(makeAtlas(scene, {.texels_per_metre = 1e5f}), Error);
    Scene many;
    for (int i = 0; i < 100; ++i) {
        addQuad(many, vec3(2.0f * static_cast<float>(i), 0, 0), vec3(1, 0, 0), vec3(0, 0, -1), 0);
    }
    addMaterial(many, diffuseParams(vec3(0.5f)));
    EXPECT_THROW(makeAtlas(many, {.size = 16}), Error);
    EXPECT_THROW(atlasOf(Scene{}, {.size = 16}), Error);
}

TEST(Atlas, densityIsWhatWasAskedFor) {
    const Scene scene = twoQuads({});
    const Atlas atlas = makeAtlas(scene, {.texels_per_metre = 10.0f});
    EXPECT_EQ(atlas.size, 64);
    for (const auto& corners : atlas.corners) {
        EXPECT_NEAR(std::abs(doubleArea(corners)), 100.0, 1e-3);
    }
}

// A row of quads: each is on one page, at its own density, and neighbours share pages.
void expectWithinPages(const Atlas& atlas) {
    for (size_t t = 0; t < atlas.corners.size(); ++t) {
        ASSERT_LT(atlas.page_of[t], atlas.pages);
        for (const vec2& corner : atlas.corners[t]) {
            const float row = corner.y - static_cast<float>(atlas.size * atlas.page_of[t]);
            EXPECT_GE(std::min(corner.x, row), kPadding);
            EXPECT_LE(std::max(corner.x, row), atlas.size - kPadding);
        }
    }
}

TEST(Atlas, severalPagesWhereOneIsTooSmall) {
    Scene scene;
    addMaterial(scene, diffuseParams(vec3(0.5f)));
    constexpr int kQuads = 10;
    for (int i = 0; i < kQuads; ++i) {
        addQuad(scene, vec3(2.0f * static_cast<float>(i), 0, 0), vec3(1, 0, 0), vec3(0, 0, -1), 0);
    }
    // Four of 14 texels and their free ones fill a page.
    const Atlas atlas = makeAtlas(scene, {.size = 32, .texels_per_metre = 14.0f});
    EXPECT_EQ(atlas.pages, 3);
    EXPECT_EQ(atlas.charts, kQuads);
    EXPECT_EQ(atlas.height(), 96);
    for (size_t t = 0; t < scene.triangles.size(); ++t) {
        EXPECT_EQ(atlas.page_of[t], static_cast<int>(t / 2 / 4));
        EXPECT_NEAR(std::abs(doubleArea(atlas.corners[t])), 14.0 * 14.0, 1e-2);
    }
    expectWithinPages(atlas);
    EXPECT_EQ(makeAtlas(scene, {.size = 64, .texels_per_metre = 14.0f}).pages, 1);
}

// A field of many triangles is cut where it would be larger than a page.
TEST(Atlas, surfacesLargerThanAPageAreCut) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    constexpr int kSide = 8;
    for (int i = 0; i < kSide * kSide; ++i) {
        addQuad(scene, vec3(i % kSide, 0, -(i / kSide)), vec3(1, 0, 0), vec3(0, 0, -1), white);
    }
    EXPECT_EQ(makeCharts(scene).size(), 1u);
    const Atlas atlas = makeAtlas(scene, {.size = 64, .texels_per_metre = 20.0f});
    EXPECT_GT(atlas.charts, 4);
    EXPECT_GT(atlas.pages, 4);
    for (const auto& corners : atlas.corners) {
        EXPECT_NEAR(std::abs(doubleArea(corners)), 400.0, 1.0);
    }
    expectWithinPages(atlas);
}

// The atlas would do as a file's own.
void expectNoneOverAnother(const Scene& scene, const Atlas& atlas) {
    Scene unrolled = scene;
    unrolled.positions.clear();
    unrolled.normals.clear();
    unrolled.uvs.clear();
    unrolled.triangles.clear();
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const uint32_t v = scene.triangles[i][c];
            addVertex(unrolled, scene.positions[v], scene.normals[v]);
            unrolled.second_uvs.push_back(atlas.corners[i][static_cast<size_t>(c)] /
                                          static_cast<float>(atlas.size));
        }
        const auto first = static_cast<uint32_t>(3 * i);
        unrolled.triangles.emplace_back(first, first + 1, first + 2);
    }
    std::string why;
    const Atlas again = atlasOfFile(unrolled, {.size = 512}, why);
    EXPECT_EQ(why, "");
    EXPECT_EQ(again.charts, atlas.charts);
}

// Charts hold every triangle once, at its own size and shape, no two over each other.
TEST(Atlas, chartsTakeEveryTriangleOnce) {
    Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    std::vector<int> times(scene.triangles.size());
    for (const UvChart& chart : makeCharts(scene)) {
        for (const uint32_t i : chart.triangles) {
            ++times[i];
        }
        for (const auto& corners : chart.corners) {
            for (const glm::dvec2& p : corners) {
                EXPECT_GT(p.x, -1e-6);
                EXPECT_GT(p.y, -1e-6);
                EXPECT_LT(p.x, chart.extent.x + 1e-6);
                EXPECT_LT(p.y, chart.extent.y + 1e-6);
            }
        }
    }
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<long>(times.size()));
    expectNoneOverAnother(scene, makeAtlas(scene, {.size = 128}));
}

// On a floor, of radius 1 and 3 high; it tapers by so much a unit.
Scene column(int sides, double taper = 0.0) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10), white);
    std::vector<uint32_t> rim;
    for (int i = 0; i < sides; ++i) {
        const double phi = 2.0 * kPi * i / sides;
        const vec3 out(std::cos(phi), 0, -std::sin(phi));
        for (const float y : {0.0f, 3.0f}) {
            const auto radius = static_cast<float>(1.0 - taper * y);
            rim.push_back(addVertex(scene, radius * out + vec3(0, y, 0), out));
        }
    }
    for (size_t i = 0; i < rim.size(); i += 2) {
        const uint32_t next = rim[(i + 2) % rim.size()], above = rim[(i + 3) % rim.size()];
        scene.triangles.emplace_back(rim[i], next, above);
        scene.triangles.emplace_back(rim[i], above, rim[i + 1]);
        scene.materials_of.insert(scene.materials_of.end(), 2, white);
    }
    return scene;
}

// Its sides in one row, each as long and as wide as it is, beside the floor.
TEST(Atlas, columnsAreUnrolled) {
    constexpr int kSides = 24;
    const double width = 2.0 * std::sin(kPi / kSides);
    const Scene scene = column(kSides);
    const std::vector<UvChart> charts = makeCharts(scene);
    ASSERT_EQ(charts.size(), 2u);
    EXPECT_EQ(charts[1].triangles.size(), 2u * kSides);
    EXPECT_NEAR(std::max(charts[1].extent.x, charts[1].extent.y), kSides * width, 1e-5);
    EXPECT_NEAR(std::min(charts[1].extent.x, charts[1].extent.y), 3.0, 1e-5);
    expectNoneOverAnother(scene, makeAtlas(scene, {.size = 64}));
    EXPECT_EQ(makeCharts(column(kSides, 0.005)).size(), 2u);  // it tapers
    // What is longer than a page is cut.
    for (const UvChart& chart : makeCharts(scene, 4.0)) {
        EXPECT_TRUE(chart.triangles.size() == 1 || std::max(chart.extent.x, chart.extent.y) <= 4.0);
    }
    // Sides that meet at more than 37 degrees are an edge.
    EXPECT_EQ(makeCharts(column(8)).size(), 9u);
}

// Where it closes there is a seam, though both sides are of one chart.
TEST(Seams, countWhereAChartMeetsItself) {
    const Scene scene = column(24);
    const Bench bench(scene, 64);
    ASSERT_EQ(bench.map.atlas.charts, 2);  // and the floor, which meets it at an edge
    const Seams seams = seamsOf(bench.map, Image<vec3>(64, 64, vec3(1.0f)));
    EXPECT_GT(seams.texels, 10);
    EXPECT_LT(seams.texels, 100);
    EXPECT_EQ(seams.across, 0.0);
}

// A strip that winds up: as seen from above it lies over itself.
TEST(Atlas, aWindingStairIsCutWhereItWouldLieOverItself) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    constexpr int kSteps = 48;  // two turns
    std::vector<uint32_t> rim;
    for (int i = 0; i <= kSteps; ++i) {
        const float phi = 2.0f * kPi * static_cast<float>(i) / (kSteps / 2);
        const float y = 0.02f * static_cast<float>(i);
        for (const float r : {1.0f, 2.0f}) {
            rim.push_back(
                addVertex(scene, vec3(r * std::cos(phi), y, -r * std::sin(phi)), vec3(0, 1, 0)));
        }
    }
    for (size_t i = 0; i + 2 < rim.size(); i += 2) {
        scene.triangles.emplace_back(rim[i], rim[i + 1], rim[i + 3]);
        scene.triangles.emplace_back(rim[i], rim[i + 3], rim[i + 2]);
        scene.materials_of.insert(scene.materials_of.end(), 2, white);
    }
    const std::vector<UvChart> charts = makeCharts(scene);
    EXPECT_GE(charts.size(), 2u);
    EXPECT_LE(charts.size(), 6u);
}

TEST(Lightmap, everyTexelThatATriangleTouchesLiesOnIt) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const Bench bench(scene, 64);
    const int size = bench.map.atlas.size;
    Random random(1);
    // Wherever a triangle is looked up, there is a texel of its chart.
    for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
        for (int k = 0; k < 20; ++k) {
            const float u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
            const auto& c = bench.map.atlas.corners[t];
            const vec2 p = (1 - u - v) * c[0] + u * c[1] + v * c[2];
            const ivec2 texel = glm::clamp(ivec2(glm::floor(p)), ivec2(0), ivec2(size - 1));
            const vec2 within = glm::fract(p);
            if (std::min({within.x, within.y, 1 - within.x, 1 - within.y}) < 0.01f) {
                continue;
            }
            const uint32_t own = bench.map.triangles.at(texel.x, texel.y);
            ASSERT_NE(own, kNoPrimitive);
            EXPECT_EQ(bench.map.atlas.chart_of[own], bench.map.atlas.chart_of[t]);
        }
    }
    bench.forSeen([&](size_t i) {
        const Receivers& r = bench.map.receivers;
        EXPECT_LT(distanceToTriangle(scene, r.triangles[i], r.positions[i]), 1e-6f);
        EXPECT_NEAR(glm::length(r.normals[i]), 1.0f, 1e-5f);
    });
}

}  // namespace
}  // namespace sheen
