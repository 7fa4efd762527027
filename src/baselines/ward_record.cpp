#include "baselines/ward_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "reference/sampling.h"
#include "reference/sobol.h"

namespace sheen {
namespace {

// Polar angle of the upper edge of a ring: sin^2 theta = row / rows.
struct Ring {
    float sine = 0.0f;
    float cosine = 1.0f;
    float theta = 0.0f;

    Ring(int row, int rows) {
        const float sine2 = static_cast<float>(row) / static_cast<float>(rows);
        sine = std::sqrt(sine2);
        cosine = std::sqrt(1.0f - sine2);
        theta = std::asin(sine);
    }
};

vec3 horizontal(float phi) { return {std::cos(phi), std::sin(phi), 0.0f}; }

// vec3 per channel along a direction of the hemisphere's frame.
void addAlong(mat3& gradient, const vec3& direction, const vec3& change) {
    for (int c = 0; c < 3; ++c) {
        gradient[c] += change[c] * direction;
    }
}

// How much light a wall between two cells lets in where the observer moves by one unit across it:
// the nearer of the two surfaces moves it. A cell below the surface hides nothing and turns with
// it.
vec3 exchange(const WardCell& from, const WardCell& to) {
    const float nearest = std::min(from.distance, to.distance);
    if (nearest <= 0.0f || nearest == kInfinity) {
        return vec3(0.0f);
    }
    return (to.radiance - from.radiance) / nearest;
}

}  // namespace

WardStrata::WardStrata(int rows_)
    : rows(rows_), columns(static_cast<int>(std::lround(kPi * static_cast<float>(rows_)))) {}

vec3 WardStrata::direction(int column, int row, const vec2& u) const {
    const float sine2 = (static_cast<float>(row) + u.x) / static_cast<float>(rows);
    const float phi = 2.0f * kPi * (static_cast<float>(column) + u.y) / static_cast<float>(columns);
    const float sine = std::sqrt(sine2);
    return {sine * std::cos(phi), sine * std::sin(phi), std::sqrt(std::max(0.0f, 1.0f - sine2))};
}

WardRecord integrateCells(const WardStrata& strata, std::span<const WardCell> cells,
                          const mat3& world_from_local) {
    SHEEN_CHECK_EQ(cells.size(), static_cast<size_t>(strata.count()));
    const int rows = strata.rows, columns = strata.columns;
    const auto at = [&](int column, int row) -> const WardCell& {
        return cells[static_cast<size_t>(column * rows + row)];
    };
    std::vector<Ring> rings;
    for (int row = 0; row <= rows; ++row) {
        rings.emplace_back(row, rows);
    }
    const float width = 2.0f * kPi / static_cast<float>(columns);
    // A sector's mean horizontal direction is this much shorter than one.
    const float chord = 2.0f * std::sin(0.5f * width);

    vec3 sum(0.0f);
    float inverse_distance = 0.0f;
    mat3 rotation(0.0f), translation(0.0f);
    for (int column = 0; column < columns; ++column) {
        const vec3 middle = horizontal((static_cast<float>(column) + 0.5f) * width);
        const vec3 across = horizontal(static_cast<float>(column) * width + 0.5f * kPi);
        const int before = column > 0 ? column - 1 : columns - 1;
        for (int row = 0; row < rows; ++row) {
            const WardCell& cell = at(column, row);
            const Ring &upper = rings[static_cast<size_t>(row)],
                       &lower = rings[static_cast<size_t>(row) + 1];
            sum += cell.radiance;
            inverse_distance += cell.distance > 0.0f ? 1.0f / cell.distance : 0.0f;

            // The horizontal direction's integral over the cell, without the cosine.
            const float moment = 0.5f * ((lower.theta - lower.sine * lower.cosine) -
                                         (upper.theta - upper.sine * upper.cosine));
            addAlong(rotation, middle, chord * moment * cell.radiance);

            if (row > 0) {
                addAlong(translation, middle,
                         chord * upper.cosine * upper.cosine * upper.sine *
                             exchange(at(column, row - 1), cell));
            }
            addAlong(translation, across,
                     (lower.sine - upper.sine) * exchange(at(before, row), cell));
        }
    }

    WardRecord record;
    record.normal = world_from_local[2];
    record.irradiance = kPi / static_cast<float>(strata.count()) * sum;
    record.rotation = world_from_local * rotation;
    record.translation = world_from_local * translation;
    record.radius =
        inverse_distance > 0.0f ? static_cast<float>(strata.count()) / inverse_distance : kInfinity;
    const float slope = glm::length(record.translation * kLuminanceWeights);
    if (slope > 0.0f) {
        record.radius = std::min(record.radius, luminance(record.irradiance) / slope);
    }
    return record;
}

namespace {

// One estimate of what lamps and sky send from a surface.
vec3 lampsAndSky(const RayScene& rays, const Lights& lights, const Surface& s, uint32_t seed,
                 Counters& counters) {
    if (lights.empty()) {
        return vec3(0.0f);
    }
    const BrdfSampler sampler(s.brdf, s.specular_albedo, s.n, s.wo);
    vec3 radiance(0.0f);
    if (!lights.lamps.empty()) {
        radiance += sampleLamps(rays, lights, s, sampler, 0, seed, counters);
    }
    if (!lights.sky.empty()) {
        radiance += sampleSky(rays, lights, s, sampler, 1, seed, counters);
    }
    return radiance;
}

// What neighbouring rays of one hemisphere meet, and how it is lit; [k] of both.
void seeCells(const RayScene& rays, const Lights& lights, const Surface& p,
              std::span<const vec3> directions, std::span<WardCell*> cells, uint32_t seed,
              Counters& counters) {
    constexpr auto kPacket = static_cast<size_t>(RayScene::kPacket);
    std::array<RayHit, kPacket> hits;
    rays.intersect(p.rayOrigin(), directions, hits.data());
    counters.rays += static_cast<int64_t>(directions.size());
    std::array<Surface, kPacket> met;
    std::array<WardCell*, kPacket> met_by;
    std::array<vec3, kPacket> weights;
    size_t count = 0;
    for (size_t k = 0; k < directions.size(); ++k) {
        if (hits[k].found()) {
            met[count] = rays.surfaceAt(hits[k], -directions[k]);
            met_by[count] = cells[k];
            weights[count] = hits[k].weight;
            ++count;
        } else {
            cells[k]->radiance = hits[k].weight * rays.scene().environment.radiance(directions[k]);
        }
    }
    std::array<vec3, kPacket> lit;
    directRadiance(rays, {met.data(), count}, lit.data(), counters);
    for (size_t k = 0; k < count; ++k) {
        const vec3 radiance =
            weights[k] *
            (lit[k] + lampsAndSky(rays, lights, met[k], hashCombine(seed, static_cast<uint32_t>(k)),
                                  counters));
        met_by[k]->distance = glm::length(met[k].position - p.position);
        if (finite(radiance)) {
            met_by[k]->radiance = radiance;
        } else {
            ++counters.nonfinite;
        }
    }
}

}  // namespace

WardRecord gatherRecord(const RayScene& rays, const Lights& lights, const Surface& p,
                        const WardStrata& strata, uint32_t seed, Counters& counters) {
    constexpr auto kPacket = static_cast<size_t>(RayScene::kPacket);
    const mat3 world_from_local = tangentFrame(p.n);
    std::vector<WardCell> cells(static_cast<size_t>(strata.count()));
    std::array<vec3, kPacket> directions;
    std::array<WardCell*, kPacket> aimed_at;
    size_t count = 0;
    uint32_t packets = 0;
    const auto see = [&] {
        seeCells(rays, lights, p, {directions.data(), count}, {aimed_at.data(), count},
                 hashCombine(~seed, packets++), counters);
        count = 0;
    };
    for (int row = 0; row < strata.rows; ++row) {
        for (int column = 0; column < strata.columns; ++column) {
            const int index = column * strata.rows + row;
            const uint32_t random = hashCombine(seed, static_cast<uint32_t>(index));
            constexpr float kUnit = 0x1p-16f;
            const vec2 u(static_cast<float>(random >> 16) * kUnit,
                         static_cast<float>(random & 0xffffu) * kUnit);
            const vec3 wi = world_from_local * strata.direction(column, row, u);
            WardCell& cell = cells[static_cast<size_t>(index)];
            if (glm::dot(p.n_g, wi) <= 0.0f) {
                cell.distance = 0.0f;
                continue;
            }
            directions[count] = wi;
            aimed_at[count] = &cell;
            if (++count == kPacket) {
                see();
            }
        }
    }
    see();
    WardRecord record = integrateCells(strata, cells, world_from_local);
    record.position = p.position;
    return record;
}

}  // namespace sheen
