// Which pixels records serve: bounds in the image.
#include <gtest/gtest.h>

#include "receivers/served.h"
#include "test_scenes.h"

namespace sheen {
namespace {

struct Sphere {
    vec3 center;
    float radius;
};

PixelRect sphereBounds(const PixelGrid& image, const vec3& center, float radius) {
    return slabBounds(image, center, radius, vec3(0, 1, 0), kInfinity);
}

// Whether the ray through a pixel's centre meets the sphere.
bool meets(const Camera& camera, int width, int height, int x, int y, const Sphere& sphere) {
    const CameraRay ray =
        cameraRay(camera, width, height, static_cast<float>(x), static_cast<float>(y));
    const glm::dvec3 d = glm::normalize(glm::dvec3(ray.direction));
    const glm::dvec3 to = glm::dvec3(sphere.center) - glm::dvec3(ray.origin);
    const double along = glm::dot(d, to);
    const glm::dvec3 aside = to - along * d;
    const double inside = static_cast<double>(sphere.radius) * sphere.radius;
    const double miss2 = glm::dot(aside, aside);
    return miss2 < inside && along + std::sqrt(inside - miss2) > 0.0;
}

// Every pixel whose centre's ray meets the sphere lies in the rectangle. Returns how many do.
int expectConservative(const Camera& camera, int width, int height, const vec3& center,
                       float radius) {
    const PixelGrid image = pixelGrid(camera, width, height);
    const PixelRect rect = sphereBounds(image, center, radius);
    EXPECT_TRUE(rect.x0 >= 0 && rect.x1 <= width && rect.y0 >= 0 && rect.y1 <= height);
    int seen = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            if (meets(camera, width, height, x, y, {center, radius})) {
                ++seen;
                EXPECT_TRUE(x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1)
                    << "pixel " << x << " " << y << " radius " << radius << " rect " << rect.x0
                    << " " << rect.y0 << " " << rect.x1 << " " << rect.y1;
            }
        }
    }
    return seen;
}

// The same for images too large to try every pixel: those around points of the sphere's outline.
int expectConservativeAtOutline(const Camera& camera, int size, const Sphere& sphere) {
    constexpr int kPoints = 300;
    const PixelGrid image = pixelGrid(camera, size, size);
    const View& view = image.view;
    const PixelRect rect = sphereBounds(image, sphere.center, sphere.radius);
    const glm::dmat3 image_from_world = glm::inverse(
        glm::dmat3(glm::dvec3(view.right), glm::dvec3(view.up), glm::dvec3(view.forward)));
    const glm::dvec3 d(sphere.center - view.origin);
    // Where rays from the eye touch the sphere: a circle across the line to its centre.
    const double sine2 = std::pow(sphere.radius, 2) / glm::dot(d, d);
    if (sine2 >= 1.0) {
        return 0;  // the eye is inside
    }
    const mat3 frame = tangentFrame(glm::normalize(vec3(d)));
    const double circle = sphere.radius * std::sqrt(1.0 - sine2);
    int seen = 0;
    for (int i = 0; i < kPoints; ++i) {
        const double phi = 2.0 * M_PI * i / kPoints;
        const glm::dvec3 p = image_from_world *
                             ((1.0 - sine2) * d + circle * (std::cos(phi) * glm::dvec3(frame[0]) +
                                                            std::sin(phi) * glm::dvec3(frame[1])));
        const glm::dvec2 pixel = (0.5 * glm::dvec2(p) / p.z + 0.5) * static_cast<double>(size);
        if (p.z <= 0.0 || std::min(pixel.x, pixel.y) < 0.0 || std::max(pixel.x, pixel.y) >= size) {
            continue;
        }
        for (int k = 0; k < 9; ++k) {
            const int x = glm::clamp(static_cast<int>(pixel.x) + k % 3 - 1, 0, size - 1);
            const int y = glm::clamp(static_cast<int>(pixel.y) + k / 3 - 1, 0, size - 1);
            if (meets(camera, size, size, x, y, sphere)) {
                ++seen;
                EXPECT_TRUE(x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1)
                    << "pixel " << x << " " << y << " radius " << sphere.radius << " rect "
                    << rect.x0 << " " << rect.y0 << " " << rect.x1 << " " << rect.y1;
            }
        }
    }
    return seen;
}

// A sphere at a depth, at (u, v) of the image in [-1, 1]^2 or beyond.
Sphere sphereAt(const Camera& camera, float depth, const vec2& uv, float radius) {
    const mat4& m = camera.world_from_camera;
    const float t = depth * std::tan(0.5f * camera.y_fov);
    return {vec3(m * vec4(uv.x * t, uv.y * t, -depth, 1.0f)), radius};
}

Camera randomCamera(Random& random, float least_fov, float greatest_fov) {
    Camera camera = lookAt(random.point(-1.0f, 1.0f), random.point(-1.0f, 1.0f));
    camera.y_fov = random.uniform(least_fov, greatest_fov);
    return camera;
}

TEST(SphereBounds, ConservativeForRandomSpheres) {
    Random random(5);
    for (int i = 0; i < 400; ++i) {
        const Camera camera = randomCamera(random, 0.1f, 2.8f);
        expectConservative(camera, 48, i % 2 == 0 ? 32 : 64, random.point(-3.0f, 3.0f),
                           std::pow(10.0f, random.uniform(-3.0f, 0.5f)));
    }
}

TEST(SphereBounds, ConservativeAroundTheEyeAndItsPlane) {
    const Camera camera = lookAt(vec3(0), vec3(0, 0, -1));
    for (float z : {-1.0f, -0.5f, 0.0f, 0.5f, 0.999f, 1.0f, 1.000001f, 1.001f, 2.0f}) {
        for (float x : {0.0f, 0.5f, 1.0f, 3.0f, -3.0f}) {
            expectConservative(camera, 32, 32, vec3(x, 0.2f * x, -z), 1.0f);
        }
    }
}

// A hair in front of the eye's plane one side of the outline is nearly at infinity.
TEST(SphereBounds, ConservativeWhereTheSphereAlmostTouchesTheEyesPlane) {
    Random random(6);
    int seen = 0;
    for (int i = 0; i < 1500; ++i) {
        const Camera camera = randomCamera(random, 0.05f, 1.5f);
        const float radius = std::pow(10.0f, random.uniform(-2.0f, 1.0f));
        const float depth = radius * (1.0f + std::pow(10.0f, random.uniform(-4.5f, -1.0f)));
        // Aside by so much that the near side of its outline crosses the image.
        const float tangent = std::tan(0.5f * camera.y_fov);
        const auto aside = [&] {
            const float edge = random.uniform(-1.5f, 1.5f);
            return edge + std::copysign(1.0f / tangent, edge);
        };
        const vec2 uv = i % 2 == 0 ? vec2(aside(), random.uniform(-1.0f, 1.0f))
                                   : vec2(random.uniform(-1.0f, 1.0f), aside());
        seen += expectConservativeAtOutline(camera, 4096, sphereAt(camera, depth, uv, radius));
    }
    EXPECT_GT(seen, 10000);
}

TEST(SphereBounds, ConservativeForTinySpheres) {
    Random random(7);
    int seen = 0, seen_outline = 0;
    for (int i = 0; i < 300; ++i) {
        const Camera camera = randomCamera(random, 0.1f, 2.0f);
        const vec2 uv(random.uniform(-1.1f, 1.1f), random.uniform(-1.1f, 1.1f));
        const float depth = random.uniform(0.1f, 5.0f);
        // Less than a pixel: seen by at most one of them.
        const float pixel = 2.0f * std::tan(0.5f * camera.y_fov) * depth / 24.0f;
        const Sphere sphere = sphereAt(camera, depth, uv, random.uniform(0.0f, 0.5f) * pixel);
        seen += expectConservative(camera, 24, 24, sphere.center, sphere.radius);
        const float radius = depth * std::pow(10.0f, random.uniform(-7.0f, -2.0f));
        seen_outline += expectConservativeAtOutline(camera, 4096, {sphere.center, radius});
    }
    EXPECT_GT(seen, 20);
    EXPECT_GT(seen_outline, 1000);
}

TEST(SphereBounds, ConservativeOffAxisAtWideFieldsOfView) {
    Random random(8);
    int seen = 0, seen_outline = 0;
    for (int i = 0; i < 200; ++i) {
        const Camera camera = randomCamera(random, 2.4f, 3.1f);
        const auto off = [&random] {
            return random.uniform(0.5f, 1.2f) * (random.uniform(-1.0f, 1.0f) < 0.0f ? -1.0f : 1.0f);
        };
        const float depth = random.uniform(0.1f, 2.0f);
        const Sphere sphere =
            sphereAt(camera, depth, {off(), off()}, depth * random.uniform(0.01f, 3.0f));
        seen += expectConservative(camera, 32, 32, sphere.center, sphere.radius);
        seen_outline += expectConservativeAtOutline(camera, 1024, sphere);
    }
    EXPECT_GT(seen, 1000);
    EXPECT_GT(seen_outline, 1000);
}

TEST(SphereBounds, ConservativeForSpheresThroughTheEyesPlane) {
    Random random(9);
    int seen = 0;
    for (int i = 0; i < 200; ++i) {
        const Camera camera = randomCamera(random, 0.3f, 2.8f);
        // The centre in front of the plane or behind it, the eye beside the sphere or inside.
        const float depth = random.uniform(-1.0f, 1.0f);
        const mat4& m = camera.world_from_camera;
        const vec3 center(
            m * vec4(random.uniform(-2.0f, 2.0f), random.uniform(-2.0f, 2.0f), -depth, 1.0f));
        seen += expectConservative(camera, 24, 24, center, 1.0f);
    }
    EXPECT_GT(seen, 1000);
}

// Points of a slab, on its rim and inside, fall into its rectangle, which is seldom much larger.
TEST(SlabBounds, HoldTheSlabAndLittleElse) {
    constexpr int kPoints = 2000;
    constexpr int kImage = 400;
    Random random(11);
    double slab_area = 0.0, sphere_area = 0.0, hull_area = 0.0;
    for (int i = 0; i < 200; ++i) {
        const Camera camera = randomCamera(random, 0.3f, 2.0f);
        const PixelGrid image = pixelGrid(camera, kImage, kImage);
        const View& view = image.view;
        const float radius = random.uniform(0.05f, 0.6f);
        const float height = radius * random.uniform(0.0f, 0.3f);
        const vec3 center = view.origin +
                            random.uniform(1.0f, 4.0f) * glm::normalize(view.forward) +
                            0.3f * random.direction();
        const vec3 n = random.direction();
        const mat3 frame = tangentFrame(n);
        const PixelRect rect = slabBounds(image, center, radius, n, height);
        const PixelRect sphere = sphereBounds(image, center, radius);
        EXPECT_TRUE(rect.x0 >= sphere.x0 && rect.x1 <= sphere.x1 && rect.y0 >= sphere.y0 &&
                    rect.y1 <= sphere.y1);
        const mat3 image_from_world = glm::inverse(mat3(view.right, view.up, view.forward));
        vec2 low(kInfinity), high(-kInfinity);
        for (int k = 0; k < kPoints; ++k) {
            const float h = height * random.uniform(-1.0f, 1.0f);
            const float rim = std::sqrt(radius * radius - h * h);
            const float share = k % 2 == 0 ? 1.0f : std::sqrt(random.uniform(0.0f, 1.0f));
            const float phi = random.uniform(0.0f, 2.0f * kPi);
            const vec3 p =
                center + frame * vec3(share * rim * std::cos(phi), share * rim * std::sin(phi), h);
            const vec3 q = image_from_world * (p - view.origin);
            const vec2 pixel = (0.5f * vec2(q) / q.z + 0.5f) * static_cast<float>(kImage);
            low = glm::min(low, pixel);
            high = glm::max(high, pixel);
            const bool in_image = q.z > 0.0f && std::min(pixel.x, pixel.y) >= 0.0f &&
                                  std::max(pixel.x, pixel.y) < kImage;
            if (in_image) {
                EXPECT_TRUE(pixel.x > static_cast<float>(rect.x0) - 0.01f &&
                            pixel.x < static_cast<float>(rect.x1) + 0.01f &&
                            pixel.y > static_cast<float>(rect.y0) - 0.01f &&
                            pixel.y < static_cast<float>(rect.y1) + 0.01f)
                    << pixel.x << " " << pixel.y << " of " << i;
            }
        }
        const auto area = [](const PixelRect& r) {
            return static_cast<double>(r.x1 - r.x0) * (r.y1 - r.y0);
        };
        const vec2 size(kImage);
        const vec2 hull = glm::clamp(high, vec2(0.0f), size) - glm::clamp(low, vec2(0.0f), size);
        slab_area += area(rect);
        sphere_area += area(sphere);
        hull_area += hull.x * hull.y;
    }
    EXPECT_LT(slab_area, 1.15 * hull_area);
    EXPECT_LT(slab_area, 0.8 * sphere_area);
}

// Wherever a record has weight, on whatever surface, the pixel lies in its rectangle.
TEST(ServedBounds, HoldWhatHasWeight) {
    constexpr int kRecords = 300;
    constexpr int kPoints = 2000;
    Random random(12);
    int served = 0, outside_flat = 0;
    for (int i = 0; i < kRecords; ++i) {
        const Camera camera = randomCamera(random, 0.3f, 2.0f);
        const PixelGrid image = pixelGrid(camera, 1000, 1000);
        const View& view = image.view;
        const WeightParams weight{.accuracy = random.uniform(0.1f, 1.5f),
                                  .normal_weight = random.uniform(1.0f, 6.0f),
                                  .slab = random.uniform(0.0f, 0.2f)};
        Record k{};
        k.position = view.origin + random.uniform(1.0f, 4.0f) * glm::normalize(view.forward);
        k.normal = random.direction();
        k.radius = random.uniform(0.05f, 0.5f) / weight.accuracy;
        const float reach = weight.accuracy * k.radius;
        const PixelRect rect = servedBounds(image, k, weight);
        const PixelRect flat = slabBounds(image, k.position, reach, k.normal, weight.slab * reach);
        const mat3 image_from_world = glm::inverse(mat3(view.right, view.up, view.forward));
        const auto holds = [](const PixelRect& r, const vec2& pixel) {
            return pixel.x > static_cast<float>(r.x0) && pixel.x < static_cast<float>(r.x1) &&
                   pixel.y > static_cast<float>(r.y0) && pixel.y < static_cast<float>(r.y1);
        };
        for (int j = 0; j < kPoints; ++j) {
            const vec3 p = k.position + reach * random.uniform(0.0f, 1.0f) * random.direction();
            const vec3 n =
                glm::normalize(k.normal + random.uniform(0.0f, 0.6f) * random.direction());
            if (shared::recordWeight(weight, k.position, k.normal, k.radius, p, n, 1e-4f) <= 0.0f) {
                continue;
            }
            const vec3 q = image_from_world * (p - view.origin);
            const vec2 pixel = (0.5f * vec2(q) / q.z + 0.5f) * 1000.0f;
            if (q.z <= 0.0f || std::min(pixel.x, pixel.y) < 0.0f ||
                std::max(pixel.x, pixel.y) >= 1000.0f) {
                continue;
            }
            ++served;
            EXPECT_TRUE(holds(rect, pixel)) << pixel.x << " " << pixel.y << " of " << i;
            outside_flat += holds(flat, pixel) ? 0 : 1;
        }
    }
    EXPECT_GT(served, 10 * kRecords);
    EXPECT_GT(outside_flat, 0);  // on tilted surfaces the slab alone would not do
}

TEST(SphereBounds, TheWholeImageAroundTheEyeAndNothingBehindIt) {
    Random random(10);
    for (int i = 0; i < 200; ++i) {
        const Camera camera = randomCamera(random, 0.1f, 3.0f);
        const PixelGrid image = pixelGrid(camera, 40, 30);
        const View& view = image.view;
        const float radius = std::pow(10.0f, random.uniform(-3.0f, 3.0f));
        const vec3 toward = random.uniform(0.0f, 0.99f) * radius * random.direction();
        const PixelRect all = sphereBounds(image, view.origin + toward, radius);
        EXPECT_TRUE(all.x0 == 0 && all.x1 == 40 && all.y0 == 0 && all.y1 == 30);
        // Behind, however far aside.
        const vec3 back(camera.world_from_camera[2]);
        const vec3 aside = random.uniform(0.0f, 50.0f) * vec3(camera.world_from_camera[i % 2]);
        const PixelRect none = sphereBounds(
            image, view.origin + radius * (random.uniform(1.01f, 9.0f) * back + aside), radius);
        EXPECT_TRUE(none.x0 >= none.x1 || none.y0 >= none.y1);
    }
}

TEST(SphereBounds, TightInFrontAndEmptyBehindOrBeside) {
    const Camera camera = lookAt(vec3(0), vec3(0, 0, -1));
    const PixelGrid image = pixelGrid(camera, 100, 100);
    const PixelRect front = sphereBounds(image, vec3(0, 0, -10), 0.1f);
    EXPECT_LE(front.x1 - front.x0, 6);
    EXPECT_LE(front.y1 - front.y0, 6);
    EXPECT_EQ(sphereBounds(image, vec3(0, 0, 10), 1.0f).x1, 0);
    EXPECT_EQ(sphereBounds(image, vec3(100, 0, -10), 1.0f).x1, 0);
    const PixelRect all = sphereBounds(image, vec3(0), 1.0f);
    EXPECT_EQ(all.x1 - all.x0, 100);
}

TEST(Serves, ItsOwnClassAndLowerOnes) {
    EXPECT_TRUE(serves(4, 4));
    EXPECT_TRUE(serves(4, 3));
    EXPECT_TRUE(serves(4, shared::DIFFUSE_ORDER));
    EXPECT_FALSE(serves(3, 4));
    EXPECT_FALSE(serves(shared::DIFFUSE_ORDER, 3));
    EXPECT_TRUE(serves(shared::DIFFUSE_ORDER, shared::DIFFUSE_ORDER));
    EXPECT_FALSE(serves(10, kNoOrder));
}

}  // namespace
}  // namespace sheen
