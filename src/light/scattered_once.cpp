#include "light/scattered_once.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "light/punctual.h"
#include "rays/jitter.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// Of a specular surface what its lobe makes of lights is left out where rays ask for the rest.
Scatterer withoutCaustics(const Rays& rays, Scatterer surface) {
    if (rays.without_caustics && isSpecular(surface.brdf)) {
        surface.brdf.f0 = vec3(0.0f);
        surface.brdf.f90 = 0.0f;
    }
    return surface;
}

// Chance, by what light is chosen: from lamps, many lights and the sky.
constexpr size_t kSources = 3;
using SourceChances = std::array<SpreadPlaces, kSources>;

SourceChances chancesOf(uint32_t seed) {
    return {SpreadPlaces(seed, 0), SpreadPlaces(seed, 1), SpreadPlaces(seed, 2)};
}

std::array<vec3, kSources> nextOf(SourceChances& chances) {
    return {chances[0].next(), chances[1].next(), chances[2].next()};
}

}  // namespace

// A hit, and what is known of its light.
struct ScatteredOnce::Lit {
    size_t ray;
    const Hit* hit;
    const LightCells::Cell* cell;  // null: nothing

    uint32_t shade() const { return cell != nullptr ? cell->shade : ~0u; }
    uint32_t trace() const { return cell != nullptr ? cell->trace : ~0u; }
};

ScatteredOnce::ScatteredOnce(const Tracer& tracer, const SceneLights* lights,
                             const std::vector<Bounds>& near, float cell_length)
    : ScatteredOnce(tracer, lights) {
    cells_.emplace(tracer, each(), near, cell_length);
    if (choosing()) {
        sampled_.emplace(tracer, near);
    }
}

void ScatteredOnce::radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const {
    Lit lit[kTogether];
    size_t count = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
        const Hit& hit = hits[i];
        if (!hit.found()) {
            radiance[i] = sky_.radiance(rays.directions[i]);
            continue;
        }
        const float area = rays.solidAngle(i) * hit.distance * hit.distance;
        lit[count++] = {
            .ray = i,
            .hit = &hit,
            .cell = cells_ ? cells_->find(hit.triangle, hit.u, hit.v, hit.back, area) : nullptr};
        // By the time that it is read, a cell, which lies anywhere in memory, has arrived.
        __builtin_prefetch(lit[count - 1].cell);
    }
    const std::span<Lit> all(lit, count);
    for (const Lit& l : all) {
        radiance[l.ray] = l.cell != nullptr ? l.cell->radiance : vec3(0.0f);
        const uint32_t triangle = l.hit->triangle;
        if (scene().materials[scene().materials_of[triangle]].emits() &&
            (lights_ == nullptr || !lights_->lamps.isLamp(triangle))) {
            radiance[l.ray] +=
                emissionAt(scene(), triangle, vec3(1.0f - l.hit->u - l.hit->v, l.hit->u, l.hit->v),
                           rays.solidAngle(l.ray) * l.hit->distance * l.hit->distance);
        }
    }
    const auto dark =
        std::partition(all.begin(), all.end(), [](const Lit& l) { return l.shade() != 0; });
    const auto known =
        std::partition(all.begin(), dark, [](const Lit& l) { return l.trace() != 0; });
    for (const std::span<Lit> lacking : {std::span(all.begin(), known), std::span(known, dark)}) {
        for (size_t i = 0; i < lacking.size(); i += Tracer::kPacket) {
            addPunctual(rays,
                        lacking.subspan(i, std::min<size_t>(Tracer::kPacket, lacking.size() - i)),
                        radiance);
        }
    }
    if (choosing()) {
        addSampled(rays, all, radiance);
    }
    for (size_t i = 0; i < hits.size(); ++i) {
        radiance[i] *= hits[i].weight;
    }
}

// Adds the punctual lights that a packet of hits lacks.
void ScatteredOnce::addPunctual(const Rays& rays, std::span<const Lit> lacking,
                                vec3* radiance) const {
    SurfacePoint points[Tracer::kPacket];
    for (size_t k = 0; k < lacking.size(); ++k) {
        const Hit& hit = *lacking[k].hit;
        points[k] =
            surfacePoint(scene(), hit.triangle, hit.u, hit.v, -rays.directions[lacking[k].ray],
                         hit.distance, rays.solidAngle(lacking[k].ray));
    }
    // Much of what is met lies in the dark: never asked.
    std::optional<Scatterer> surfaces[Tracer::kPacket];
    for (size_t i = 0; i < each().size(); ++i) {
        const uint32_t bit = LightCells::bit(i);
        const PunctualLight& light = each()[i];
        LightSample samples[Tracer::kPacket];
        bool arrives[Tracer::kPacket] = {};
        Way ways[Tracer::kPacket];
        for (size_t k = 0; k < lacking.size(); ++k) {
            const SurfacePoint& p = points[k];
            if ((lacking[k].shade() & bit) == 0) {
                continue;
            }
            samples[k] = shared::sampleLight(light, p.position);
            arrives[k] =
                glm::dot(p.n_g, samples[k].wi) > 0.0f && samples[k].irradiance != vec3(0.0f);
            if (arrives[k] && (lacking[k].trace() & bit) != 0) {
                ways[k] = wayTo(light, samples[k], p.eye(scene()));
            }
        }
        const Tracer::Shares passing = tracer().passing({ways, lacking.size()});
        for (size_t k = 0; k < lacking.size(); ++k) {
            const vec3 share = ways[k].length > 0.0f ? passing[k] : vec3(1.0f);
            if (!arrives[k] || share == vec3(0.0f)) {
                continue;
            }
            if (!surfaces[k]) {
                surfaces[k] = scattererAt(scene(), points[k]);
            }
            const size_t ray = lacking[k].ray;
            Scatterer surface = withoutCaustics(rays, *surfaces[k]);
            surface.brdf.alpha =
                shared::filteredAlpha(surface.brdf.alpha, rays.solidAngle(ray),
                                      lacking[k].hit->distance, samples[k].distance);
            radiance[ray] += share * scattered(surface, points[k].wo, samples[k]);
        }
    }
}

// A point that light chosen by chance arrives at.
struct ScatteredOnce::Asked {
    SurfaceSide side;
    Scatterer surface;
    std::array<vec3, kSources> places;          // in [0, 1)^3, for each
    float solid_angle = 0.0f, distance = 0.0f;  // of the ray that sees it
};

// For each of a packet of points, the light by one sample of all lamps, one of many
// lights and one of the sky.
void ScatteredOnce::sample(std::span<const Asked> points, vec3* radiance) const {
    vec3 light[kSources][Tracer::kPacket];
    Way ways[kSources][Tracer::kPacket];
    for (size_t k = 0; k < points.size(); ++k) {
        const Asked& p = points[k];
        const auto arriving = [&](const vec3& wi, float distance, const vec3& irradiance) {
            Scatterer seen = p.surface;
            seen.brdf.alpha =
                shared::filteredAlpha(seen.brdf.alpha, p.solid_angle, p.distance, distance);
            return scattered(seen, p.side.toward_viewer,
                             {.wi = wi, .distance = distance, .irradiance = irradiance});
        };
        if (lights_ != nullptr) {
            if (const auto s = lights_->lamps.sample(p.side, p.surface.n, p.places[0])) {
                light[0][k] = arriving(s->wi, s->distance, s->radiance / s->density);
                ways[0][k] = s->way;
            }
            if (const auto s = lights_->punctual.sample(p.side, p.surface.n, p.places[1].x)) {
                light[1][k] = arriving(s->light.wi, s->light.distance, s->light.irradiance);
                ways[1][k] = s->way;
            }
        }
        if (skyLights()) {
            const SkySampler::Sample s = sky_.sample(p.surface.n, vec2(p.places[2]));
            if (s.density > 0.0f && glm::dot(s.wi, p.side.n_g) > 0.0f) {
                light[2][k] = arriving(s.wi, -1.0f, s.radiance / s.density);
                ways[2][k] = {.start = p.side.start(), .direction = s.wi, .length = kInfinity};
            }
        }
        radiance[k] = vec3(0.0f);
    }
    for (size_t source = 0; source < kSources; ++source) {
        const Tracer::Shares passing = tracer().passing({ways[source], points.size()});
        for (size_t k = 0; k < points.size(); ++k) {
            radiance[k] += passing[k] != vec3(0.0f) ? passing[k] * light[source][k] : vec3(0.0f);
        }
    }
}

ScatteredOnce::Asked ScatteredOnce::pointAt(const Hit& hit, const vec2& uv, const vec3& wo) const {
    const SurfacePoint p = surfacePoint(scene(), hit.triangle, uv.x, uv.y, wo, hit.distance);
    return {.side = {.position = p.position,
                     .n_g = p.n_g,
                     .toward_viewer = p.wo,
                     .offset = surfaceOffset(scene(), hit.triangle, p.position, p.n_g, p.distance)},
            .surface = scattererAt(scene(), p),
            .places = {}};
}

// What the side of a cell that was hit scatters alike in all directions, or would if it were white
// where that depends on where it is seen from: the mean over places spread over it.
vec3 ScatteredOnce::scatteredByCell(const Hit& hit, const IrradianceCells::Cell& cell) const {
    const vec3 front = geometricNormal(scene(), static_cast<int>(hit.triangle));
    Hit seen = hit;  // from as far as the cell is long: whichever hit asks first finds the same
    seen.distance = TriangleEdges(scene(), hit.triangle).longestEdge() * std::abs(cell.scale);
    const uint32_t seed = pcgHash(cell.cell + pcgHash(hit.triangle));
    SourceChances chances = chancesOf(seed);
    vec3 sum(0.0f);
    for (uint32_t first = 0; first < kCellSamples; first += Tracer::kPacket) {
        std::array<Asked, Tracer::kPacket> points;
        for (uint32_t k = 0; k < Tracer::kPacket; ++k) {
            const vec2 uv = cell.spread(randomPlace(~seed, first + k));
            points[k] = pointAt(seen, uv, hit.back ? -front : front);
            if (!lambertian(hit)) {
                points[k].surface.brdf = {
                    .diffuse = vec3(1.0f), .alpha = 1.0f, .f0 = vec3(0.0f), .f90 = 0.0f};
            }
            points[k].places = nextOf(chances);
        }
        vec3 light[Tracer::kPacket];
        sample(points, light);
        for (const vec3& l : light) {
            sum += l;
        }
    }
    return sum / float{kCellSamples};
}

// Adds what lamps, many lights and the sky send by way of hits. Cells know what is scattered alike
// in all directions; lobes, and hits without a cell, are sampled once each: many rays share a
// record, and average what chance adds to each.
void ScatteredOnce::addSampled(const Rays& rays, std::span<const Lit> lit, vec3* radiance) const {
    if (lit.empty()) {
        return;
    }
    const auto seedOf = [](const Lit& l) {
        return hashOfPoint(l.hit->triangle, l.hit->u, l.hit->v);
    };
    // Rays from one point, such as those of a mirror's pixel, may all meet one place: together
    // their samples are strata. Ways that go on are strata of what led to them already.
    std::vector<SourceChances> sets;
    for (uint32_t k = 0; k < (rays.sets.empty() ? 1 : Rays::kSets); ++k) {
        sets.push_back(chancesOf(pcgHash(k + seedOf(lit.front()))));
    }
    std::array<Asked, Tracer::kPacket> points;
    size_t of[Tracer::kPacket];
    size_t count = 0;
    const auto flush = [&] {
        vec3 light[Tracer::kPacket];
        sample({points.data(), count}, light);
        for (size_t k = 0; k < count; ++k) {
            radiance[of[k]] += light[k];
        }
        count = 0;
    };
    for (const Lit& l : lit) {
        const Hit& hit = *l.hit;
        const float area = rays.solidAngle(l.ray) * hit.distance * hit.distance;
        // What is met of a surface with holes tells nothing of the holes.
        const bool whole = !scene().materials[scene().materials_of[hit.triangle]].lightPasses();
        const auto cell = sampled_ && whole ? sampled_->cellOf(hit, area) : std::nullopt;
        vec3 alike(0.0f);
        if (cell) {
            alike =
                *sampled_->at(*cell, [&] { return std::optional(scatteredByCell(hit, *cell)); });
            if (lambertian(hit)) {
                radiance[l.ray] += alike;
                continue;
            }
        }
        Asked& p = points[count];
        p = pointAt(hit, vec2(hit.u, hit.v), -rays.directions[l.ray]);
        p.surface = withoutCaustics(rays, p.surface);
        SourceChances own = chancesOf(seedOf(l));
        p.places = nextOf(rays.origins.empty() ? sets[rays.setOf(l.ray)] : own);
        p.solid_angle = rays.solidAngle(l.ray);
        p.distance = hit.distance;
        if (cell) {
            radiance[l.ray] += p.surface.brdf.diffuse * alike;
            p.surface.brdf.diffuse = vec3(0.0f);
        }
        of[count++] = l.ray;
        if (count == Tracer::kPacket) {
            flush();
        }
    }
    flush();
}

}  // namespace sheen
