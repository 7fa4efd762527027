#include "receivers/edges.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "receivers/coats.h"
#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

// One surface, over the way to a neighbouring pixel: about the same normal; no farther off the
// plane between both than this, and no farther away, in footprints (seen under its own tilt).
constexpr float kSameNormal = 0.9f;
constexpr float kOffPlane = 1.0f;
constexpr float kFarthest = 4.0f;
constexpr float kLeastTilt = 0.05f;
// Of a surface's pixels the one is taken that is nearest, where a difference of unit normals counts
// as so many pixels.
constexpr float kNormalCounts = 8.0f;
// What neighbouring pixels show may differ by this share without an edge between them.
constexpr float kContrast = 0.15f;
// Of a pixel's side: what samples see so near to a border may lie beyond it.
constexpr float kNearBorder = 0.25f;
// A pixel's strays: more surfaces than these in one pixel take each other's light.
constexpr size_t kMostStrays = 4;
// Samples that are held at a time, 100 bytes each.
constexpr size_t kTogether = 1u << 18u;

// A place that a ray found.
struct Place {
    vec3 position, normal;
    float footprint = 0;  // 0: nothing is seen
    int material = kNoMaterial;
    vec3 eye{0.0f};    // from where it is seen
    vec3 share{1.0f};  // of the light on the way there
};

Place placeOf(const Receivers& receivers, size_t i) {
    return {receivers.positions[i], receivers.normals[i], receivers.footprints[i],
            receivers.materials[i], receivers.viewer(i)};
}

Place placeOf(const Scene& scene, const GBuffer& gbuffer, size_t i) {
    Place place;
    if (gbuffer.seen(i)) {
        place = {gbuffer.position.pixels[i], gbuffer.normal.pixels[i],
                 gbuffer.depth.pixels[i] * gbuffer.image.pixel_angle,
                 static_cast<int>(scene.materials_of[gbuffer.primitive.pixels[i]]),
                 gbuffer.eyeOf(i)};
    }
    place.share = gbuffer.shareAt(i);
    return place;
}

// The way to a place over its footprint, seen under the tilt of its surface: in pixels, about.
float pixelsApart(const Place& from, const Place& to) {
    const float tilt = glm::dot(glm::normalize(to.eye - to.position), to.normal);
    return glm::length(to.position - from.position) * std::max(tilt, kLeastTilt) / to.footprint;
}

bool contrasts(float a, float b) { return std::abs(a - b) > kContrast * std::max(a, b); }

bool contrasts(const vec3& a, const vec3& b) { return contrasts(luminance(a), luminance(b)); }

// Of light on its way, in some channel.
bool sharesContrast(const vec3& a, const vec3& b) {
    return contrasts(a.x, b.x) || contrasts(a.y, b.y) || contrasts(a.z, b.z);
}

// Whether the light at one place serves the other, as records' weights judge surfaces.
bool isOneSurface(const Place& a, const Place& b) {
    const vec3 normals = a.normal + b.normal;
    return a.material == b.material && glm::dot(a.normal, b.normal) >= kSameNormal &&
           0.5f * std::abs(glm::dot(b.position - a.position, normals)) <= kOffPlane * b.footprint &&
           pixelsApart(a, b) <= kFarthest;
}

// Likewise, or nothing is seen at both.
bool seesTheSame(const Place& a, const Place& b) {
    return a.material == b.material && !sharesContrast(a.share, b.share) &&
           (a.material == kNoMaterial || isOneSurface(a, b));
}

class EdgeFinder {
  public:
    EdgeFinder(const Tracer& tracer, const SceneLights& lights, const Camera& camera,
               const Receivers& pixels, const Veil& veil, int count)
        : tracer_(tracer),
          lights_(lights),
          camera_(camera),
          pixels_(pixels),
          veil_(veil),
          grid_(pixels.image),
          samples_(pixelSamples(count)) {}

    Edges run(int sh_order) {
        Edges edges;
        edges.first_stray = grid_.count();
        findPixels();
        std::vector<vec2> strays;
        // Grows meanwhile: thin things are followed to where no corner and no middle sees them.
        for (size_t first = 0; first < found_.size();) {
            const size_t end = std::min(first + kTogether / samples_.size(), found_.size());
            look({found_.begin() + static_cast<std::ptrdiff_t>(first),
                  found_.begin() + static_cast<std::ptrdiff_t>(end)},
                 edges, strays);
            first = end;
        }
        // Seen again: rays cast alone find what they found.
        edges.strays =
            receiversOf(tracer_.scene(), see(strays, 1), sh_order, pixels_.irradiance_only);
        return edges;
    }

  private:
    // What samples of one pixel see, before its shares and strays have their numbers.
    struct Look {
        EdgePixel mean;
        std::vector<EdgeShare> shares;  // `receiver`: of strays, from first_stray on
        std::vector<EdgeTriangle> seen;
        std::vector<size_t> strays;  // samples that see them
        std::vector<size_t> next;    // pixels that what they see reaches
    };

    GBuffer see(std::span<const vec2> places, int columns) const {
        return renderSamples(tracer_, camera_, {grid_.width, grid_.height}, places, columns,
                             veil_.number);
    }
    Place middleOf(size_t pixel) const {
        Place place = placeOf(pixels_, pixel);
        place.share = veil_.share.empty() ? vec3(1.0f) : veil_.share.pixels[pixel];
        return place;
    }

    void add(size_t pixel);
    void findPixels();
    void look(const std::vector<size_t>& found, Edges& edges, std::vector<vec2>& strays);
    void noteNext(size_t pixel, const vec2& sample, const Place& place,
                  std::vector<size_t>& next) const;
    Look lookAt(size_t pixel, const GBuffer& seen, size_t first_sample) const;
    std::optional<size_t> pixelOfSurface(size_t pixel, const Place& place) const;

    const Tracer& tracer_;
    const SceneLights& lights_;
    const Camera& camera_;
    const Receivers& pixels_;
    const Veil& veil_;
    const PixelGrid& grid_;
    const std::vector<vec2> samples_;
    Image<uint8_t> known_;  // 1: in found_
    std::vector<size_t> found_;
};

void addTriangle(uint32_t triangle, float coverage, std::vector<EdgeTriangle>& seen) {
    const auto known = std::find_if(seen.begin(), seen.end(), [triangle](const EdgeTriangle& t) {
        return t.triangle == triangle;
    });
    if (known == seen.end()) {
        seen.push_back({triangle, coverage});
    } else {
        known->coverage += coverage;
    }
}

void EdgeFinder::add(size_t pixel) {
    if (known_.pixels[pixel] == 0) {
        known_.pixels[pixel] = 1;
        found_.push_back(pixel);
    }
}

void EdgeFinder::findPixels() {
    const Scene& scene = tracer_.scene();
    const int width = grid_.width;
    const int height = grid_.height;
    std::vector<vec2> places;
    for (int y = 0; y <= height; ++y) {
        for (int x = 0; x <= width; ++x) {
            places.emplace_back(x, y);
        }
    }
    const GBuffer corners = see(places, width + 1);
    Image<uint8_t> edge(width, height);
    const auto shows = [&](size_t i) {
        return pixels_.emission.empty() ? pixels_.direct[i]
                                        : pixels_.direct[i] + pixels_.emission[i];
    };
    parallelFor(height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const size_t i = grid_.index(x, y);
            const Place own = middleOf(i);
            bool found = false;
            for (const ivec2& corner : {ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(1, 1)}) {
                const size_t k = corners.image.index(x + corner.x, y + corner.y);
                found =
                    found || !seesTheSame(own, placeOf(scene, corners, k)) ||
                    (pixels_.seen(i) && (contrasts(corners.diffuse.pixels[k], pixels_.diffuse[i]) ||
                                         contrasts(corners.f0.pixels[k], pixels_.f0[i])));
            }
            for (const ivec2& way : {ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1)}) {
                const ivec2 at = ivec2(x, y) + way;
                if (!found && pixels_.seen(i) && at.x >= 0 && at.y >= 0 && at.x < width &&
                    at.y < height) {
                    const size_t k = grid_.index(at.x, at.y);
                    found = pixels_.seen(k) && contrasts(shows(i), shows(k));
                }
            }
            edge.pixels[i] = found ? 1 : 0;
        }
    });
    known_ = Image<uint8_t>(width, height);
    for (size_t i = 0; i < edge.pixels.size(); ++i) {
        if (edge.pixels[i] != 0) {
            add(i);
        }
    }
}

void EdgeFinder::look(const std::vector<size_t>& found, Edges& edges, std::vector<vec2>& strays) {
    const size_t count = samples_.size();
    std::vector<vec2> places;
    for (const size_t i : found) {
        const auto width = static_cast<size_t>(grid_.width);
        for (const vec2& sample : samples_) {
            places.push_back(vec2(i % width, i / width) + sample);
        }
    }
    GBuffer seen = see(places, static_cast<int>(count));
    seen.direct =
        directWithCoats(tracer_, lights_, seen, std::vector<uint32_t>(found.begin(), found.end()));
    std::vector<Look> looks(found.size());
    constexpr int kGrain = 16;
    parallelFor(
        static_cast<int>(found.size()),
        [&](int k) {
            const auto i = static_cast<size_t>(k);
            looks[i] = lookAt(found[i], seen, i * count);
        },
        kGrain);
    for (Look& look : looks) {
        look.mean.first_share = edges.shares.size();
        look.mean.first_seen = edges.seen.size();
        edges.seen.insert(edges.seen.end(), look.seen.begin(), look.seen.end());
        edges.pixels.push_back(look.mean);
        for (EdgeShare& share : look.shares) {
            share.receiver +=
                share.receiver >= edges.first_stray ? static_cast<int>(strays.size()) : 0;
            edges.shares.push_back(share);
        }
        for (const size_t sample : look.strays) {
            strays.push_back(places[sample]);
        }
        std::for_each(look.next.begin(), look.next.end(), [this](size_t i) { add(i); });
    }
}

// The pixel beside a sample near its own pixel's border, where its middle sees something else.
void EdgeFinder::noteNext(size_t pixel, const vec2& sample, const Place& place,
                          std::vector<size_t>& next) const {
    const auto width = static_cast<size_t>(grid_.width);
    const ivec2 own(pixel % width, pixel / width);
    for (int axis = 0; axis < 2; ++axis) {
        const int step = sample[axis] < kNearBorder ? -1 : sample[axis] > 1.0f - kNearBorder;
        ivec2 at = own;
        at[axis] += step;
        if (step == 0 || at.x < 0 || at.y < 0 || at.x >= grid_.width || at.y >= grid_.height) {
            continue;
        }
        const size_t i = grid_.index(at.x, at.y);
        if (known_.pixels[i] == 0 && !seesTheSame(middleOf(i), place)) {
            next.push_back(i);
        }
    }
}

EdgeFinder::Look EdgeFinder::lookAt(size_t pixel, const GBuffer& seen, size_t first_sample) const {
    const Scene& scene = tracer_.scene();
    const float all = 1.0f / static_cast<float>(samples_.size());
    Look look;
    look.mean.pixel = pixel;
    for (size_t i = first_sample; i < first_sample + samples_.size(); ++i) {
        const vec3 part = all * seen.shareAt(i);
        look.mean.direct += part * seen.direct.pixels[i];
        if (!seen.emission.empty()) {
            look.mean.emission += part * seen.emission.pixels[i];
        }
        const Place place = placeOf(scene, seen, i);
        noteNext(pixel, samples_[i - first_sample], place, look.next);
        look.mean.coverage += seen.seen(i) ? all : all - passingShare(part);
        if (!seen.seen(i)) {
            continue;
        }
        addTriangle(seen.primitive.pixels[i], all, look.seen);
        int receiver = 0;
        if (const std::optional<size_t> host = pixelOfSurface(pixel, place)) {
            receiver = static_cast<int>(*host);
        } else {
            const auto one_surface = [&](size_t k) {
                return isOneSurface(placeOf(scene, seen, k), place);
            };
            auto stray = std::find_if(look.strays.begin(), look.strays.end(), one_surface);
            if (stray == look.strays.end()) {
                if (look.strays.size() < kMostStrays) {
                    look.strays.push_back(i);
                }
                stray = std::prev(look.strays.end());
            }
            receiver = grid_.count() + static_cast<int>(stray - look.strays.begin());
        }
        auto share = std::find_if(look.shares.begin(), look.shares.end(),
                                  [&](const EdgeShare& s) { return s.receiver == receiver; });
        if (share == look.shares.end()) {
            share = look.shares.insert(share, {.receiver = receiver});
        }
        const vec3 toward = glm::normalize(place.eye - place.position);
        share->diffuse += part * seen.diffuse.pixels[i];
        share->specular +=
            part * specularAlbedo(glm::dot(seen.mappedNormalAt(i), toward),
                                  seen.roughness.pixels[i], seen.f0.pixels[i], seen.f90.pixels[i]);
    }
    return look;
}

// Of the pixel and those around that see the place's surface, the one that is most alike.
std::optional<size_t> EdgeFinder::pixelOfSurface(size_t pixel, const Place& place) const {
    const auto width = static_cast<size_t>(grid_.width);
    const ivec2 own(pixel % width, pixel / width);
    std::optional<size_t> best;
    float least = kInfinity;
    for (int y = std::max(own.y - 1, 0); y <= std::min(own.y + 1, grid_.height - 1); ++y) {
        for (int x = std::max(own.x - 1, 0); x <= std::min(own.x + 1, grid_.width - 1); ++x) {
            const size_t i = grid_.index(x, y);
            const Place at = placeOf(pixels_, i);
            if (!isOneSurface(at, place)) {
                continue;
            }
            const float apart =
                pixelsApart(at, place) + kNormalCounts * glm::length(at.normal - place.normal);
            if (apart < least) {
                best = i;
                least = apart;
            }
        }
    }
    return best;
}

}  // namespace

std::vector<vec2> pixelSamples(int count) {
    SHEEN_CHECK(count >= 1 && (count & (count - 1)) == 0);
    std::vector<vec2> samples;
    for (int k = 0; k < count; ++k) {
        int mirrored = 0;  // its binary digits, the last one first
        for (int bit = 1; bit < count; bit *= 2) {
            mirrored = 2 * mirrored + ((k & bit) != 0 ? 1 : 0);
        }
        samples.push_back((vec2(k, mirrored) + 0.5f) / static_cast<float>(count));
    }
    return samples;
}

Edges findEdges(const Tracer& tracer, const SceneLights& lights, const Camera& camera,
                const Receivers& pixels, const Veil& veil, int sh_order, int count) {
    return EdgeFinder(tracer, lights, camera, pixels, veil, count).run(sh_order);
}

}  // namespace sheen
