#include "baselines/irradiance_cache.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "reference/sobol.h"

namespace sheen {
namespace {

// Records gathered together, a constant of the method: the same records for any thread count.
constexpr int kBatch = 64;
// The first pass begins with every 16th pixel of every 16th row.
constexpr int kCoarsest = 16;

// The second pass asks records this much farther than they were placed for: each pixel then
// averages more of them.
constexpr float kOverlap = 1.5f;
// At an accuracy of 0.4; docs/decisions/yardsticks.md. Reaches a R are in footprints of the
// record's pixel.
constexpr float kTunedAccuracy = 0.4f;
constexpr float kLeastReach = 1.5f;
constexpr float kGreatestReach = 10.0f;
constexpr float kRings = 34.0f;

// Limits of a record's radius, in footprints.
struct RadiusLimits {
    float least = 0.0f;
    float greatest = 0.0f;

    explicit RadiusLimits(float accuracy) {
        const float scale = std::sqrt(accuracy / kTunedAccuracy) / accuracy;
        least = kLeastReach * scale;
        greatest = kGreatestReach * scale;
    }
};

int ringsFor(float accuracy) {
    return std::max(
        4, static_cast<int>(std::lround(kRings * std::pow(kTunedAccuracy / accuracy, 0.75f))));
}

struct Pass {
    const RayScene& rays;
    const Lights& lights;
    const IrradianceCacheParams& params;
    Frame& frame;
    Image<Surface> surfaces;
    Image<uint8_t> has_record;  // not 0: a record was gathered at this pixel
    WardOctree octree;
    WardStrata strata;
    Counters counters;
    double gather_seconds = 0.0;
};

// Sums counters of parallel rows.
struct AtomicCounters {
    std::atomic<int64_t> rays{0};
    std::atomic<int64_t> nonfinite{0};

    void add(const Counters& counters) {
        rays += counters.rays;
        nonfinite += counters.nonfinite;
    }
    void addTo(Counters& counters) const {
        counters.rays += rays;
        counters.nonfinite += nonfinite;
    }
};

bool missed(const Pass& pass, int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const Frame& frame = pass.frame;
    return frame.primitive.pixels[i] != kNoPrimitive && pass.has_record.pixels[i] == 0 &&
           !pass.octree.serves(frame.position.pixels[i], frame.normal.pixels[i],
                               pass.params.accuracy);
}

// Brings a record's radius between two others. Where it grows the gradient shrinks: at the radius
// it changes no channel by more than all of it.
void limitRadius(float least, float greatest, WardRecord& record) {
    record.radius = glm::clamp(record.radius, least, greatest);
    for (int c = 0; c < 3; ++c) {
        const float change = glm::length(record.translation[c]) * record.radius;
        if (change > record.irradiance[c]) {
            record.translation[c] *= record.irradiance[c] / change;
        }
    }
}

float footprintAt(const Pass& pass, int pixel) {
    const float pixel_angle =
        2.0f * std::tan(0.5f * pass.params.camera.y_fov) /
        static_cast<float>(pass.params.camera.wholeSize({pass.params.width, pass.params.height}).y);
    return pass.frame.depth.pixels[static_cast<size_t>(pixel)] * pixel_angle;
}

void placeBatch(Pass& pass, std::span<const int> batch) {
    const Timer timer;
    std::vector<WardRecord> records(batch.size());
    AtomicCounters sum;
    parallelFor(static_cast<int>(batch.size()), [&](int i) {
        const int pixel = batch[static_cast<size_t>(i)];
        Counters counters;
        records[static_cast<size_t>(i)] =
            gatherRecord(pass.rays, pass.lights, pass.surfaces.pixels[static_cast<size_t>(pixel)],
                         pass.strata, hash32(static_cast<uint32_t>(pixel)), counters);
        sum.add(counters);
    });
    sum.addTo(pass.counters);
    pass.gather_seconds += timer.seconds();
    const RadiusLimits limits(pass.params.accuracy);
    for (size_t i = 0; i < batch.size(); ++i) {
        const float footprint = footprintAt(pass, batch[i]);
        limitRadius(limits.least * footprint, limits.greatest * footprint, records[i]);
        pass.octree.insert(records[i], limits.least * footprint);
        pass.has_record.pixels[static_cast<size_t>(batch[i])] = 1;
    }
}

// Pixels of every stride-th column and row that no record serves, in an order that keeps
// consecutive ones far apart: those gathered together then rarely serve each other.
std::vector<int> missedPixels(const Pass& pass, int stride) {
    const int width = pass.params.width, height = pass.params.height;
    const int rows = (height + stride - 1) / stride;
    std::vector<std::vector<int>> missed_of(static_cast<size_t>(rows));
    parallelFor(rows, [&](int row) {
        const int y = std::min(row * stride + stride / 2, height - 1);
        for (int x = std::min(stride / 2, width - 1); x < width; x += stride) {
            if (missed(pass, y * width + x)) {
                missed_of[static_cast<size_t>(row)].push_back(y * width + x);
            }
        }
    });
    std::vector<int> pixels;
    for (const std::vector<int>& row : missed_of) {
        pixels.insert(pixels.end(), row.begin(), row.end());
    }
    std::sort(pixels.begin(), pixels.end(), [](int a, int b) {
        return hash32(static_cast<uint32_t>(a)) < hash32(static_cast<uint32_t>(b));
    });
    return pixels;
}

// Adds records until those pixels are served. A record may shorten what served one of them before:
// hence the answer, whether any was added.
bool cover(Pass& pass, int stride) {
    const std::vector<int> pixels = missedPixels(pass, stride);
    std::vector<int> batch;
    for (const int pixel : pixels) {
        if (missed(pass, pixel)) {
            batch.push_back(pixel);
        }
        if (batch.size() == kBatch) {
            placeBatch(pass, batch);
            batch.clear();
        }
    }
    placeBatch(pass, batch);
    return !pixels.empty();
}

void fillCache(Pass& pass) {
    Progress progress("irradiance cache", 2 * kCoarsest - 1, pass.params.quiet);
    for (int stride = kCoarsest; stride >= 1; stride /= 2) {
        cover(pass, stride);
        progress.advance(kCoarsest / stride);
    }
    // No pixel gets a second record, so this ends.
    while (cover(pass, 1)) {
    }
}

// Of a pixel, by as many samples as leave little to see.
vec3 directFromLamps(const RayScene& rays, const Lights& lights, const Surface& p, int pixel,
                     Counters& counters) {
    constexpr uint32_t kSamples = 64;
    if (lights.lamps.empty()) {
        return vec3(0.0f);
    }
    const BrdfSampler sampler(p.brdf, p.specular_albedo, p.n, p.wo);
    vec3 sum(0.0f);
    for (uint32_t i = 0; i < kSamples; ++i) {
        const vec3 sample = sampleLamps(rays, lights, p, sampler, i,
                                        hash32(static_cast<uint32_t>(pixel)), counters);
        if (finite(sample)) {
            sum += sample;
        } else {
            ++counters.nonfinite;
        }
    }
    return sum / static_cast<float>(kSamples);
}

int interpolateAll(const Pass& pass) {
    std::atomic<int> uncovered{0};
    Frame& frame = pass.frame;
    const float accuracy = kOverlap * pass.params.accuracy;
    parallelFor(frame.height(), [&](int y) {
        for (int x = 0; x < frame.width(); ++x) {
            if (frame.primitive.at(x, y) == kNoPrimitive) {
                continue;
            }
            const Interpolated found =
                pass.octree.lookup(frame.position.at(x, y), frame.normal.at(x, y), accuracy);
            const vec3 radiance =
                glm::max(found.irradiance, vec3(0.0f)) * frame.albedo.at(x, y) / kPi;
            frame.indirect.at(x, y) = radiance;
            frame.indirect_diffuse.at(x, y) = radiance;
            frame.weight.at(x, y) = found.weight;
            frame.records.at(x, y) = static_cast<float>(found.records);
            uncovered += found.records == 0 ? 1 : 0;
        }
    });
    return uncovered;
}

}  // namespace

IrradianceCacheResult renderIrradianceCache(const Scene& scene,
                                            const IrradianceCacheParams& params) {
    SHEEN_CHECK(params.width > 0 && params.height > 0 && params.accuracy > 0.0f);
    IrradianceCacheResult result;
    const Timer see_timer;
    const RayScene rays(scene);
    const Lights lights(scene);
    Frame& frame = result.frame;
    frame = emptyFrame(params.width, params.height);
    frame.weight = Image<float>(params.width, params.height);
    frame.records = Image<float>(params.width, params.height);
    Image<Surface> surfaces(params.width, params.height);
    AtomicCounters seen;
    parallelFor(params.height, [&](int y) {
        Counters counters;
        for (int x = 0; x < params.width; ++x) {
            if (const auto p = seePixel(rays, params.camera, x, y, frame, counters)) {
                surfaces.at(x, y) = *p;
                frame.direct.at(x, y) +=
                    directFromLamps(rays, lights, *p, y * params.width + x, counters);
            }
        }
        seen.add(counters);
    });
    result.see = see_timer.seconds();

    const Timer place_timer;
    Pass pass{.rays = rays,
              .lights = lights,
              .params = params,
              .frame = frame,
              .surfaces = std::move(surfaces),
              .has_record = Image<uint8_t>(params.width, params.height),
              .octree = WardOctree(scene.bounds, kOverlap * params.accuracy),
              .strata = WardStrata(params.rings > 0 ? params.rings : ringsFor(params.accuracy)),
              .counters = {}};
    fillCache(pass);
    result.gather = pass.gather_seconds;
    result.place = place_timer.seconds() - result.gather;

    const Timer interpolate_timer;
    result.uncovered = interpolateAll(pass);
    result.interpolate = interpolate_timer.seconds();

    seen.addTo(pass.counters);
    result.records = static_cast<int>(pass.octree.records().size());
    result.rays = pass.counters.rays;
    result.nonfinite_samples = pass.counters.nonfinite;
    if (result.nonfinite_samples > 0) {
        warn(fmt::format("the octree's records dropped {} samples that were not finite",
                         result.nonfinite_samples));
    }
    return result;
}

}  // namespace sheen
