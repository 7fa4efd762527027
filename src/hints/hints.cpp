#include "hints/hints.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace sheen {
namespace {

template <class T>
void add(const std::vector<T>& what, float factor, std::vector<T>& to) {
    for (size_t i = 0; i < to.size(); ++i) {
        to[i] += factor * what[i];
    }
}

// Of the mean over all directions, in all hints and channels.
double total(const std::vector<std::vector<float>>& values, size_t stride) {
    double sum = 0.0;
    for (const std::vector<float>& volume : values) {
        for (size_t i = 0; i < volume.size(); i += stride) {
            sum += double{volume[i]} + double{volume[i + 1]} + double{volume[i + 2]};
        }
    }
    return sum;
}

}  // namespace

HintsParams hintsParams(int hints) {
    const HintsParams usual;
    const double finer = std::cbrt(static_cast<double>(hints) / usual.hints);
    return {.hints = hints, .samples = static_cast<int>(std::lround(usual.samples * finer))};
}

RadianceHints::RadianceHints(const Tracer& tracer, const HintsParams& params,
                             const std::vector<Bounds>& near)
    : tracer_(tracer), params_(params), rotator_(params.order) {
    SHEEN_CHECK(params.hints > 0 && params.samples > 0 && params.bounces > 0);
    SHEEN_CHECK(params.order == 2 || params.order == 3);
    const Scene& scene = tracer.scene();
    if (scene.triangles.empty()) {
        return;
    }
    const HintLattice whole = latticeOf(scene.bounds, params.hints);
    for (const Bounds& box : near) {
        volumes_.push_back({.grid = HintGrid(tracer, latticeWithin(whole, box, params.hints))});
    }
    volumes_.push_back({.grid = HintGrid(tracer, whole)});
    for (size_t i = 0; i < volumes_.size(); ++i) {
        anchorLooks(i);
    }
}

size_t RadianceHints::count() const {
    size_t sum = 0;
    for (const Volume& volume : volumes_) {
        sum += static_cast<size_t>(volume.grid.lattice().count());
    }
    return sum;
}

RadianceHints::Values RadianceHints::dark(const Volume& volume) const {
    return Values(static_cast<size_t>(volume.grid.lattice().count()) * stride(), 0.0f);
}

// The finest volume, of those from `from` on, that a point lies in.
size_t RadianceHints::volumeAt(const vec3& p, size_t from) const {
    size_t i = from;
    while (i + 1 < volumes_.size() && volumes_[i].grid.lattice().within(p) < 0.0f) {
        ++i;
    }
    return i;
}

void RadianceHints::anchorLooks(size_t index) {
    Volume& volume = volumes_[index];
    const int count = volume.grid.lattice().count();
    volume.anchors.assign(static_cast<size_t>(count) * HintGrid::kLooks, HintGrid::kUnseen);
    volume.volumes.assign(volume.anchors.size(), 0);
    parallelFor(
        count, [&](int hint) { anchorLooksOf(hint, index); }, kHintGrain);
}

// What a hint of a volume met is lit by that volume or, outside of it, a wider one.
void RadianceHints::anchorLooksOf(int hint, size_t index) {
    Volume& volume = volumes_[index];
    const HintLook* looks = volume.grid.looksOf(hint);
    const size_t first = static_cast<size_t>(hint) * HintGrid::kLooks;
    for (size_t v = index; v < volumes_.size(); ++v) {
        std::array<HintGrid::Place, Tracer::kPacket> places{};
        std::array<size_t, Tracer::kPacket> of{};
        size_t count = 0;
        const auto ask = [&] {
            const auto anchors = volumes_[v].grid.anchors({places.data(), count});
            for (size_t k = 0; k < count; ++k) {
                volume.anchors[of[k]] = anchors[k];
                volume.volumes[of[k]] = static_cast<uint8_t>(v);
            }
            count = 0;
        };
        for (size_t k = 0; k < HintGrid::kLooks; ++k) {
            if (looks[k].found() && volumeAt(looks[k].position, index) == v) {
                places[count] = looks[k].place();
                of[count++] = first + k;
                if (count == Tracer::kPacket) {
                    ask();
                }
            }
        }
        ask();
    }
}

// Each direction is asked from a point of the hint's cell.
RadianceHints::Values RadianceHints::ofSky(const Volume& volume, const SkySamples& sky) const {
    static_assert(SkySamples::kCount % Tracer::kPacket == 0);
    Values light = dark(volume);
    const auto light_hint = [&](int hint) {
        const vec3* points = volume.grid.pointsOf(hint);
        const mat3 rotation = volume.grid.rotationOf(hint);
        const vec2 shift = vec2(0.5f) + 0.5f * vec2(rotation[0]);
        float* sums = &light[static_cast<size_t>(hint) * stride()];
        for (int first = 0; first < SkySamples::kCount; first += Tracer::kPacket) {
            std::array<Way, Tracer::kPacket> ways;
            std::array<vec3, Tracer::kPacket> lights;
            for (int k = 0; k < Tracer::kPacket; ++k) {
                const SkySamples::Sample sample = sky.at(first + k, rotation, shift);
                ways[static_cast<size_t>(k)] = {.start = points[(first + k) % HintGrid::kLooks],
                                                .direction = sample.wi,
                                                .length = kInfinity};
                lights[static_cast<size_t>(k)] = sample.light;
            }
            const Tracer::Shares shares = tracer_.passing(ways);
            for (size_t k = 0; k < ways.size(); ++k) {
                if (shares[k] != vec3(0.0f)) {
                    addHintLight(ways[k].direction, shares[k] * lights[k], params_.order, sums);
                }
            }
        }
        keepMissed(params_.order, sums);
    };
    parallelFor(sky.empty() ? 0 : volume.grid.lattice().count(), light_hint, kHintGrain);
    return light;
}

RadianceHints::Values RadianceHints::ofSamples(const Volume& volume) const {
    Values light = dark(volume);
    parallelFor(
        volume.grid.lattice().count(),
        [&](int hint) {
            float* sums = &light[static_cast<size_t>(hint) * stride()];
            addSamples(volume.grid, hint, sums);
            keepMissed(params_.order, sums);
        },
        kHintGrain);
    return light;
}

// Each group of samples is asked from a point of the hint's cell; one ray says of each whether it
// is seen.
void RadianceHints::addSamples(const HintGrid& grid, int hint, float* sums) const {
    const vec3* points = grid.pointsOf(hint);
    const vec3& cell = grid.lattice().cell;
    const float width = std::cbrt(cell.x * cell.y * cell.z);
    std::array<Way, Tracer::kPacket> ways;
    std::array<vec3, Tracer::kPacket> lights;
    size_t count = 0;
    const auto ask = [&] {
        const Tracer::Shares shares = tracer_.passing({ways.data(), count});
        for (size_t k = 0; k < count; ++k) {
            if (shares[k] != vec3(0.0f)) {
                addHintLight(ways[k].direction, shares[k] * lights[k], params_.order, sums);
            }
        }
        count = 0;
    };
    for (size_t s = 0; s < samples_.size(); ++s) {
        const LitSample& sample = samples_[s];
        const vec3& p = points[sample.group % HintGrid::kLooks];
        const vec3 way = sample.position - p;
        const float height = -glm::dot(sample.n_g, way);
        if (!(height > 0.0f)) {
            continue;
        }
        const float d2 = glm::dot(way, way);
        const float distance = std::sqrt(d2);
        const vec3 direction = way / distance;
        ways[count] = {.start = p, .direction = direction, .length = distance};
        lights[count] =
            sample.toward(-direction, d2, width) * (height / (distance * (d2 + sample.softening2)));
        if (++count == Tracer::kPacket) {
            ask();
        }
    }
    ask();
}

// On what a hint met, by the light that hints have.
vec3 RadianceHints::irradianceAtLook(const Volume& volume, size_t look, const HintLook& at,
                                     const std::vector<Values>& light) const {
    const size_t v = volume.volumes[look];
    const HintGrid& grid = volumes_[v].grid;
    const HintGrid::Place place = at.place();
    const vec3 above = grid.above(place);
    float sums[kMostHintNumbers] = {};
    float weights = 0.0f;
    grid.forEachHint(place, volume.anchors[look], {&above, 1}, [&](int hint, float weight) {
        const float* numbers = &light[v][static_cast<size_t>(hint) * stride()];
        for (size_t j = 0; j < stride(); ++j) {
            sums[j] += weight * numbers[j];
        }
        weights += weight;
    });
    return hintIrradiance(sums, at.n_g, params_.order) / weights;
}

// What surfaces that hints see make of light once more.
std::vector<RadianceHints::Values> RadianceHints::scattered(
    const std::vector<Values>& light) const {
    constexpr float kEach = 4.0f * kPi / HintGrid::kLooks;
    std::vector<Values> again;
    for (const Volume& volume : volumes_) {
        Values& values = again.emplace_back(dark(volume));
        parallelFor(
            volume.grid.lattice().count(),
            [&](int hint) {
                const HintLook* looks = volume.grid.looksOf(hint);
                const mat3 rotation = volume.grid.rotationOf(hint);
                float* sums = &values[static_cast<size_t>(hint) * stride()];
                for (size_t k = 0; k < HintGrid::kLooks; ++k) {
                    if (looks[k].found()) {
                        const size_t look = static_cast<size_t>(hint) * HintGrid::kLooks + k;
                        const vec3 irradiance = irradianceAtLook(volume, look, looks[k], light);
                        addHintLight(rotation * HintGrid::directions()[k],
                                     looks[k].albedo * irradiance * (kEach / kPi), params_.order,
                                     sums);
                    }
                }
                keepMissed(params_.order, sums);
            },
            kHintGrain);
    }
    return again;
}

// Adds to all light so far what becomes of the last bounce's. The remainder of all bounces is taken
// to fall on as the last one did, a geometric series.
void RadianceHints::followBounces(std::vector<Values> last, std::vector<Values>& sum) const {
    constexpr int kMostFollowed = 4;
    constexpr double kLeast = 0.003;  // of all light; what is less is not followed on
    constexpr double kNone = 1e-5;    // likewise, of a given number of bounces
    constexpr double kSlowest = 0.95;
    double before = total(last, stride());
    bool ends = false;
    for (int bounce = 2; bounce <= params_.bounces && before > 0.0 && !ends; ++bounce) {
        last = scattered(last);
        const double now = total(last, stride());
        const bool all = params_.bounces == kAllBounces;
        ends =
            (all && bounce > kMostFollowed) || now < (all ? kLeast : kNone) * total(sum, stride());
        const double ratio = std::min(now / before, kSlowest);
        const auto factor = static_cast<float>(all && ends ? 1.0 / (1.0 - ratio) : 1.0);
        for (size_t v = 0; v < sum.size(); ++v) {
            add(last[v], factor, sum[v]);
        }
        before = now;
    }
}

void RadianceHints::fill(const SceneLights& lights, float share) {
    SHEEN_CHECK(share > 0.0f && share <= 1.0f);
    samples_ = litSamples(tracer_, lights, params_.samples);
    const SkySamples sky(tracer_.scene().environment);
    // The sky's own light, and what is scattered once.
    std::vector<Values> sum;
    for (const Volume& volume : volumes_) {
        sum.push_back(ofSky(volume, sky));
    }
    std::vector<Values> once = sky.empty() ? sum : scattered(sum);
    for (size_t v = 0; v < volumes_.size(); ++v) {
        add(ofSamples(volumes_[v]), 1.0f, once[v]);
        add(once[v], 1.0f, sum[v]);
    }
    followBounces(std::move(once), sum);
    for (size_t v = 0; v < volumes_.size(); ++v) {
        Values& light = volumes_[v].light;
        if (share == 1.0f || light.empty()) {
            light = std::move(sum[v]);
            continue;
        }
        for (size_t i = 0; i < light.size(); ++i) {
            light[i] += share * (sum[v][i] - light[i]);
        }
    }
}

}  // namespace sheen
