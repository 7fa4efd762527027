#include "light/caustics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "core/directions.h"
#include "core/parallel.h"
#include "light/punctual.h"
#include "light/sky.h"
#include "light/triangle_grid.h"
#include "rays/jitter.h"
#include "scene/brdf_albedo.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

constexpr int kPacket = Tracer::kPacket;

// Specular surfaces are divided into cells of this share of the scene, at most so many; each has
// two sides.
constexpr float kCellShare = 1.0f / 64.0f;
constexpr size_t kMostCells = 1u << 18u;
// A part of the photons finds out where others are worth while, by so many parts of all surfaces of
// about equal reflectance. They say it to within chance: a share of the photons starts anywhere.
constexpr int kPilots = 4;  // one in so many
constexpr size_t kParts = 2048;
constexpr double kAnywhere = 0.05;
// From surface to surface photons go on by chance, never surely.
constexpr float kLikeliest = 0.95f;

// Random numbers of a photon, by what they are for.
enum Use : uint32_t { kWhich, kWhere, kSource, kLamp, kLampPoint, kSky, kFirstLobe };

// A side of a piece of a specular triangle.
struct Patch {
    uint32_t triangle;
    bool back;
    std::array<vec2, 3> corners;  // Embree's barycentric coordinates
    double reflects;              // area times albedo
};

// Where photons start: patches, how likely each is.
struct Starts {
    std::vector<Patch> patches;
    std::vector<uint32_t> parts;  // [patch]
    std::vector<double> sums;     // [patch + 1], of likelihoods; ends in 1

    // By what they reflect, times a factor a part.
    void setLikelihoods(const std::vector<double>& factors);
    // By sums, a part, of the squares of what photons brought that started as they are now likely.
    void heed(const std::vector<double>& squares);
    struct Choice {
        size_t patch;
        double probability;
    };
    Choice choose(double u) const {
        const auto above = std::upper_bound(sums.begin() + 1, sums.end() - 1, u);
        const auto patch = static_cast<size_t>(above - sums.begin()) - 1;
        return {patch, sums[patch + 1] - sums[patch]};
    }
};

void Starts::setLikelihoods(const std::vector<double>& factors) {
    sums.assign(patches.size() + 1, 0.0);
    for (size_t i = 0; i < patches.size(); ++i) {
        sums[i + 1] = sums[i] + patches[i].reflects * factors[parts[i]];
    }
    for (double& sum : sums) {
        sum /= sums.back() > 0.0 ? sums.back() : 1.0;
    }
    sums.back() = 1.0;
}

void Starts::heed(const std::vector<double>& squares) {
    std::vector<double> likely(kParts, 0.0);
    for (size_t i = 0; i < patches.size(); ++i) {
        likely[parts[i]] += sums[i + 1] - sums[i];
    }
    std::vector<double> factors(kParts, 0.0);
    double mean = 0.0;
    for (size_t part = 0; part < kParts; ++part) {
        if (likely[part] > 0.0) {
            factors[part] = std::sqrt(squares[part] / likely[part]);
            mean += likely[part] * factors[part];
        }
    }
    for (double& factor : factors) {
        factor = mean > 0.0 ? factor + kAnywhere * mean : 1.0;
    }
    setLikelihoods(factors);
}

void addPatches(const Scene& scene, uint32_t triangle, const TriangleGrid& grid, bool back,
                std::vector<Patch>& patches) {
    constexpr float kTypicalCosine = 0.7f;
    const double area =
        TriangleEdges(scene, triangle).area() / static_cast<double>(grid.n * grid.n);
    const std::vector<vec2> corners = grid.corners();
    grid.forEachCell([&](uint32_t, const uvec3& c, const vec2& middle) {
        const MaterialParams material =
            materialAt(scene, triangle, vec3(1.0f - middle.x - middle.y, middle));
        const Brdf brdf =
            shared::makeBrdf(material, brdfAlbedo(kTypicalCosine, material.roughness));
        const vec3 albedo = specularAlbedo(kTypicalCosine, material.roughness, brdf.f0, brdf.f90);
        // A texture's middle does not tell of all of the cell.
        constexpr double kLeast = 1e-3;
        patches.push_back({.triangle = triangle,
                           .back = back,
                           .corners = {corners[c.x], corners[c.y], corners[c.z]},
                           .reflects = area * std::max<double>(luminance(albedo), kLeast)});
    });
}

Starts findStarts(const Scene& scene) {
    std::vector<uint8_t> specular(scene.materials.size());
    for (size_t i = 0; i < specular.size(); ++i) {
        specular[i] = maybeSpecular(scene, scene.materials[i]) ? 1 : 0;
    }
    Starts starts;
    const std::vector<uint32_t> divisions = gridDivisions(scene, {}, kCellShare, kMostCells);
    for (const bool back : {false, true}) {
        for (uint32_t t = 0; t < divisions.size(); ++t) {
            if (specular[scene.materials_of[t]] != 0) {
                addPatches(scene, t, {divisions[t]}, back, starts.patches);
            }
        }
    }
    double all = 0.0;
    for (const Patch& patch : starts.patches) {
        all += patch.reflects;
    }
    double sum = 0.0;
    for (const Patch& patch : starts.patches) {
        const double place = static_cast<double>(kParts) * sum / all;
        starts.parts.push_back(
            static_cast<uint32_t>(std::clamp(place, 0.0, static_cast<double>(kParts - 1))));
        sum += patch.reflects;
    }
    starts.setLikelihoods(std::vector<double>(kParts, 1.0));
    return starts;
}

// A photon on its way.
struct Flight {
    vec3 origin, direction;
    vec3 power;
    uint32_t seed;
    size_t start;  // number of the patch's part
};

class PhotonTracer {
  public:
    PhotonTracer(const Tracer& tracer, const LampSampler& lamps, const SeenSpace& seen, int bounces)
        : tracer_(tracer),
          scene_(tracer.scene()),
          lamps_(lamps),
          sky_(scene_.environment),
          seen_(seen),
          bounces_(bounces) {}

    // `count` photons in all, whose random numbers are those of `seed`. Calls land(photon, part of
    // its start) for each that lies where it is wanted.
    template <class Land>
    void trace(const Starts& starts, int first, int last, int count, uint32_t seed,
               const Land& land) const {
        std::vector<Flight> flights;
        for (int i = first; i < last; i += kPacket) {
            start(starts, i, std::min(i + kPacket, last), count, seed, flights);
        }
        for (int bounce = 1; !flights.empty(); ++bounce) {
            std::vector<Flight> next;
            for (size_t i = 0; i < flights.size(); i += kPacket) {
                const size_t packet = std::min<size_t>(kPacket, flights.size() - i);
                fly({&flights[i], packet}, bounce, land, next);
            }
            flights = std::move(next);
        }
    }

  private:
    struct Lit {
        vec3 wi;
        vec3 irradiance;  // by the shading normal, if nothing lies between
        Way way;
    };
    Lit light(const SurfaceSide& side, const vec3& n, uint32_t seed) const;
    void start(const Starts& starts, int first, int last, int count, uint32_t seed,
               std::vector<Flight>& flights) const;
    std::optional<Flight> leave(const Flight& arrived, const SurfacePoint& p,
                                const Scatterer& surface, const vec3& start, uint32_t use) const;
    template <class Land>
    void fly(std::span<const Flight> flights, int bounce, const Land& land,
             std::vector<Flight>& next) const;

    const Tracer& tracer_;
    const Scene& scene_;
    const LampSampler& lamps_;
    SkySampler sky_;
    const SeenSpace& seen_;
    int bounces_;
};

// Of all that may reach a point one light, by chance, as likely as it is bright there.
PhotonTracer::Lit PhotonTracer::light(const SurfaceSide& side, const vec3& n, uint32_t seed) const {
    Lit chosen{};
    double sum = 0.0;
    double u = randomPlace(seed, kSource).x;
    // One of many by a single number: what is left of it decides again.
    const auto offer = [&](const vec3& wi, const vec3& normal_irradiance, const auto& way) {
        const float NoL = glm::dot(n, wi);
        if (NoL <= 0.0f || glm::dot(side.n_g, wi) <= 0.0f) {
            return;
        }
        const vec3 irradiance = NoL * normal_irradiance;
        const double weight = luminance(irradiance);
        if (!(weight > 0.0)) {
            return;
        }
        sum += weight;
        const double share = weight / sum;
        if (u < share) {
            chosen = {
                .wi = wi, .irradiance = irradiance / static_cast<float>(weight), .way = way()};
            u /= share;
        } else {
            u = (u - share) / (1.0 - share);
        }
    };
    for (const PunctualLight& light : scene_.lights) {
        const LightSample s = shared::sampleLight(light, side.position);
        offer(s.wi, s.irradiance, [&] { return wayTo(light, s, side.start()); });
    }
    if (!lamps_.empty()) {
        const vec3 numbers(randomPlace(seed, kLampPoint), randomPlace(seed, kLamp).x);
        if (const auto s = lamps_.sample(side, n, vec3(numbers.z, numbers.x, numbers.y))) {
            offer(s->wi, s->radiance / s->density, [&] { return s->way; });
        }
    }
    if (!sky_.empty()) {
        const SkySampler::Sample s = sky_.sample(n, randomPlace(seed, kSky));
        if (s.density > 0.0f) {
            offer(s.wi, s.radiance / s.density, [&] {
                return Way{.start = side.start(), .direction = s.wi, .length = kInfinity};
            });
        }
    }
    chosen.irradiance *= static_cast<float>(sum);
    return chosen;
}

// Photons `first` to `last` of `count` at their first specular surface: lit, and on their way from
// there.
void PhotonTracer::start(const Starts& starts, int first, int last, int count, uint32_t seed,
                         std::vector<Flight>& flights) const {
    std::array<std::optional<Flight>, kPacket> begun;
    std::array<SurfacePoint, kPacket> points;
    std::array<Scatterer, kPacket> surfaces;
    std::array<vec3, kPacket> origins;
    Way ways[kPacket];
    for (int i = first; i < last; ++i) {
        const auto k = static_cast<size_t>(i - first);
        const uint32_t own = pcgHash(static_cast<uint32_t>(i) + pcgHash(seed));
        const auto [patch_index, probability] =
            starts.choose((i + double{randomPlace(own, kWhich).x}) / count);
        const Patch& patch = starts.patches[patch_index];
        const vec2 u = randomPlace(own, kWhere);
        const float root = std::sqrt(u.x);
        const vec2 uv = (1.0f - root) * patch.corners[0] + root * (1.0f - u.y) * patch.corners[1] +
                        root * u.y * patch.corners[2];
        const vec3 by_winding = geometricNormal(scene_, static_cast<int>(patch.triangle));
        const vec3 n_g = patch.back ? -by_winding : by_winding;
        SurfacePoint& p = points[k] = surfacePoint(scene_, patch.triangle, uv.x, uv.y, n_g, 0.0f);
        const SurfaceSide side{
            .position = p.position,
            .n_g = n_g,
            .toward_viewer = vec3(0.0f),
            .offset = surfaceOffset(scene_, patch.triangle, p.position, n_g, 0.0f)};
        surfaces[k] = scattererAt(scene_, p);
        const float coverage = coverageAt(scene_, patch.triangle, p.barycentric);
        if (!isSpecular(surfaces[k].brdf) || coverage == 0.0f || probability <= 0.0) {
            continue;
        }
        const Lit lit = light(side, surfaces[k].n, own);
        const double area =
            TriangleEdges(scene_, patch.triangle).area() *
            std::abs(glm::determinant(glm::mat2(patch.corners[1] - patch.corners[0],
                                                patch.corners[2] - patch.corners[0])));
        const auto stands_for = static_cast<float>(coverage * area / (probability * count));
        begun[k] = Flight{.origin = side.start(),
                          .direction = -lit.wi,
                          .power = stands_for * lit.irradiance,
                          .seed = own,
                          .start = starts.parts[patch_index]};
        ways[k] = lit.way;
        origins[k] = side.start();
    }
    const Tracer::Shares shares = tracer_.passing({ways, kPacket});
    for (size_t k = 0; k < kPacket; ++k) {
        if (!begun[k] || ways[k].length <= 0.0f || shares[k] <= 0.0f) {
            continue;
        }
        begun[k]->power *= shares[k];
        // The light was weighed by the shading normal already.
        if (auto flight = leave(*begun[k], points[k], surfaces[k], origins[k], kFirstLobe)) {
            flights.push_back(*flight);
        }
    }
}

// Along the lobe of a surface, of which as much goes on as it reflects. Photons carry what the
// integral over paths from the eye has: shading normals count on the side of the light, geometric
// ones on the other [Vea97, 5.3].
std::optional<Flight> PhotonTracer::leave(const Flight& arrived, const SurfacePoint& p,
                                          const Scatterer& surface, const vec3& start,
                                          uint32_t use) const {
    const mat3 frame = tangentFrame(surface.n);
    const vec3 wo_local = glm::transpose(frame) * -arrived.direction;
    if (wo_local.z <= 0.0f) {
        return std::nullopt;
    }
    const auto along = sampleLobe(wo_local, surface.brdf.alpha, surface.brdf.f0, surface.brdf.f90,
                                  randomPlace(arrived.seed, use));
    if (!along) {
        return std::nullopt;
    }
    const vec3 direction = glm::normalize(frame * along->wi);
    const float cosine = glm::dot(direction, p.n_g);
    if (cosine <= 0.0f) {
        return std::nullopt;
    }
    Flight flight = arrived;
    flight.origin = start;
    flight.direction = direction;
    flight.power *= along->weight * (cosine / std::max(along->wi.z, 1e-6f));
    return luminance(flight.power) > 0.0f && finite(flight.power) ? std::optional(flight)
                                                                  : std::nullopt;
}

template <class Land>
void PhotonTracer::fly(std::span<const Flight> flights, int bounce, const Land& land,
                       std::vector<Flight>& next) const {
    vec3 origins[kPacket];
    vec3 directions[kPacket];
    Hit hits[kPacket];
    for (size_t k = 0; k < flights.size(); ++k) {
        origins[k] = flights[k].origin;
        directions[k] = flights[k].direction;
    }
    tracer_.meet({.directions = {directions, flights.size()}, .origins = {origins, flights.size()}},
                 hits);
    for (size_t k = 0; k < flights.size(); ++k) {
        const Hit& hit = hits[k];
        if (!hit.found()) {
            continue;
        }
        Flight flight = flights[k];
        const SurfacePoint p =
            surfacePoint(scene_, hit.triangle, hit.u, hit.v, -flight.direction, hit.distance);
        const Scatterer surface = scattererAt(scene_, p);
        const bool specular = isSpecular(surface.brdf);
        if ((!specular || surface.brdf.diffuse != vec3(0.0f)) && seen_.contains(p.position)) {
            land(Photon{.position = p.position, .wi = p.wo, .n_g = p.n_g, .power = flight.power},
                 flight.start);
        }
        if (!specular || bounce >= bounces_) {
            continue;
        }
        const float before = luminance(flight.power);
        flight.power *=
            std::max(glm::dot(surface.n, p.wo), 0.0f) / std::max(glm::dot(p.n_g, p.wo), 1e-6f);
        const uint32_t use = kFirstLobe + 2 * static_cast<uint32_t>(bounce);
        auto gone_on = leave(flight, p, surface, p.eye(scene_), use);
        if (!gone_on) {
            continue;
        }
        const float chance = std::min(luminance(gone_on->power) / before, kLikeliest);
        if (randomPlace(flight.seed, use + 1).x < chance) {
            gone_on->power /= chance;
            next.push_back(*gone_on);
        }
    }
}

}  // namespace

SeenSpace::SeenSpace(const std::vector<vec3>& points) {
    Bounds box;
    for (const vec3& p : points) {
        box.add(p);
    }
    if (points.empty()) {
        return;
    }
    const vec3 extent = box.upper - box.lower;
    const float longest = std::max({extent.x, extent.y, extent.z});
    size_ = longest > 0.0f ? longest / kCells : 1.0f;
    lower_ = box.lower - vec3(size_);
    counts_ = ivec3(extent / size_) + 3;
    filled_.resize(static_cast<size_t>(counts_.x) * static_cast<size_t>(counts_.y) *
                   static_cast<size_t>(counts_.z));
    for (const vec3& p : points) {
        const ivec3 c = cellOf(p);
        for (int z = std::max(c.z - 1, 0); z <= std::min(c.z + 1, counts_.z - 1); ++z) {
            for (int y = std::max(c.y - 1, 0); y <= std::min(c.y + 1, counts_.y - 1); ++y) {
                for (int x = std::max(c.x - 1, 0); x <= std::min(c.x + 1, counts_.x - 1); ++x) {
                    filled_[static_cast<size_t>((z * counts_.y + y) * counts_.x + x)] = 1;
                }
            }
        }
    }
}

ivec3 SeenSpace::cellOf(const vec3& p) const { return ivec3(glm::floor((p - lower_) / size_)); }

bool SeenSpace::contains(const vec3& p) const {
    const vec3 scaled = (p - lower_) / size_;
    if (!glm::all(glm::greaterThanEqual(scaled, vec3(0.0f))) ||
        !glm::all(glm::lessThan(scaled, vec3(counts_)))) {
        return false;
    }
    const ivec3 c(scaled);
    return filled_[static_cast<size_t>((c.z * counts_.y + c.y) * counts_.x + c.x)] != 0;
}

std::vector<Photon> traceCaustics(const Tracer& tracer, const LampSampler& lamps,
                                  const SeenSpace& seen, int count, int bounces) {
    const Scene& scene = tracer.scene();
    const bool lit = !scene.lights.empty() || !lamps.empty() || !scene.environment.empty();
    Starts starts = lit && !seen.empty() ? findStarts(scene) : Starts{};
    if (starts.patches.empty() || bounces < 1) {
        return {};
    }
    const PhotonTracer photons(tracer, lamps, seen, bounces);
    constexpr int kBatch = 1024;
    const auto batches = [&](int all, const auto& trace) {
        const int batch_count = (all + kBatch - 1) / kBatch;
        parallelFor(batch_count, [&](int batch) {
            trace(static_cast<size_t>(batch), batch * kBatch, std::min((batch + 1) * kBatch, all));
        });
        return static_cast<size_t>(batch_count);
    };

    // What starts on each part brings, squared: were all photons of a part alike, the error would
    // be least where they are as many as that of one is large [Ney34].
    const int pilots = std::max(count / kPilots, kBatch);
    struct Found {
        size_t part;
        double light;
    };
    std::vector<std::vector<Found>> found(static_cast<size_t>((pilots + kBatch - 1) / kBatch));
    batches(pilots, [&](size_t batch, int first, int last) {
        photons.trace(starts, first, last, pilots, 1, [&](const Photon& photon, size_t part) {
            found[batch].push_back({part, luminance(photon.power)});
        });
    });
    std::vector<double> squares(kParts, 0.0);
    for (const std::vector<Found>& of_batch : found) {
        for (const Found& f : of_batch) {
            squares[f.part] += f.light * f.light;
        }
    }
    starts.heed(squares);

    std::vector<std::vector<Photon>> landed(static_cast<size_t>((count + kBatch - 1) / kBatch));
    batches(count, [&](size_t batch, int first, int last) {
        photons.trace(starts, first, last, count, 2,
                      [&](const Photon& photon, size_t) { landed[batch].push_back(photon); });
    });
    std::vector<Photon> result;
    for (const std::vector<Photon>& of_batch : landed) {
        result.insert(result.end(), of_batch.begin(), of_batch.end());
    }
    return result;
}

}  // namespace sheen
