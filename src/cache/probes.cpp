#include "cache/probes.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Of the factor by which the squares that neighbours expect are off.
constexpr double kExpectedSpread = 0.5;
// Of what rays say of pixels, as a share of their light: before probes tell, a guess.
constexpr double kErrorByRays = 0.02;
constexpr double kGuessSpread = 2.0;
// Squared errors vary at least by this, relative to the square of what is expected: few of them
// are most of the sum, and probes that met none of these are not to be too sure.
constexpr double kTail = 10.0;
// Of the probes, the share that lies anywhere; the others lie where errors are expected.
constexpr double kAnywhere = 0.5;
// Nine times of ten within so many deviations.
constexpr double kNineOfTen = 1.645;
// The interval's ends differ by this factor at most.
constexpr double kWidest = 3.0;
// Rays of a probe's lobe over those of a pixel's.
constexpr float kLobeRays = 1.0f;

// The square of a pixel's error, in luminance, that is expected before probes tell.
double expectedSquare(const NeighbourErrors& neighbours, const Receivers& receivers,
                      const Image<vec3>& indirect, size_t pixel) {
    const double by_rays =
        receivers.by_rays[pixel] != 0 ? kErrorByRays * luminance(indirect.pixels[pixel]) : 0.0;
    return neighbours.squares.pixels[pixel] + by_rays * by_rays;
}

// Pixels by their bits in turn, so that any run of them is a compact piece of the image.
uint32_t mortonCode(uint32_t x, uint32_t y) {
    uint32_t code = 0;
    for (uint32_t bit = 0; bit < 16; ++bit) {
        code |= (x >> bit & 1u) << (2 * bit) | (y >> bit & 1u) << (2 * bit + 1);
    }
    return code;
}

// A judged pixel, in an order in which neighbours in the image are near each other.
struct Candidate {
    uint32_t code;
    int pixel;
    double weight;  // a probe should lie here with a chance in proportion to this
};

// One of each run of pixels of the same weight, at random.
void chooseFrom(std::vector<Candidate>& candidates, size_t count, std::vector<Probe>& probes) {
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.code < b.code; });
    double all = 0.0;
    for (const Candidate& c : candidates) {
        all += c.weight;
    }
    const double step = all / static_cast<double>(count);
    double passed = 0.0;
    size_t k = 0;
    for (const Candidate& c : candidates) {
        passed += c.weight;
        const auto next = [&] {
            const float u = randomPlace(static_cast<uint32_t>(k), static_cast<uint32_t>(count)).x;
            return (static_cast<double>(k) + u) * step;
        };
        for (; k < count && next() < passed; ++k) {
            probes.push_back({.pixel = c.pixel, .stands_for = static_cast<float>(step / c.weight)});
        }
    }
}

// What probes found over what neighbours expect, or of itself where these expect nothing.
struct Scale {
    bool of_expected = false;
    double factor = 0;
    double variance = 0;
};

// Of the pixels by rays, or of the others. Of each probe the product of two errors, which are
// independent but for the image's, is on average the square of that. A few pixels may hold most of
// an image's error, and no probe may lie there: so probes tell by what neighbours' expectations are
// to be multiplied. These are believed as far as they are known to be right, the less the more
// surely probes contradict them.
Scale scaleOf(const NeighbourErrors& neighbours, std::span<const Probe> probes,
              const Receivers& receivers, const Image<vec3>& indirect, bool rays) {
    const double spread = rays ? kGuessSpread : kExpectedSpread;
    double found = 0.0;
    double expected = 0.0;
    const auto visit = [&](const auto& body) {
        for (const Probe& p : probes) {
            const auto i = static_cast<size_t>(p.pixel);
            if ((receivers.by_rays[i] != 0) == rays) {
                const double c = luminance(indirect.pixels[i]);
                body(p.stands_for, (c - luminance(p.light[0])) * (c - luminance(p.light[1])),
                     expectedSquare(neighbours, receivers, indirect, i));
            }
        }
    };
    visit([&](double stands_for, double product, double square) {
        found += stands_for * product;
        expected += stands_for * square;
    });
    if (!std::isfinite(found) || (found == 0.0 && expected == 0.0)) {
        return {.of_expected = true, .factor = 1.0, .variance = spread * spread};
    }
    double variance = 0.0;
    if (expected <= 0.0) {
        visit([&](double stands_for, double product, double) {
            variance += stands_for * stands_for * product * product;
        });
        return {.factor = std::max(found, 0.0), .variance = variance};
    }
    const double factor = std::max(found / expected, 0.0);
    double least = 0.0;
    visit([&](double stands_for, double product, double square) {
        const double off = stands_for * (product - factor * square);
        variance += off * off;
        least += stands_for * square * stands_for * square;
    });
    const double tail = kTail * std::max(factor * factor, 1.0);
    variance = std::max(variance, tail * least) / (expected * expected);
    const double apart = factor - 1.0;
    const double doubt = spread * spread + std::max(apart * apart - variance, 0.0);
    const double trust = variance / (variance + doubt);
    return {
        .of_expected = true, .factor = trust + (1.0 - trust) * factor, .variance = trust * doubt};
}

}  // namespace

std::vector<Probe> chooseProbes(const NeighbourErrors& neighbours, const Receivers& receivers,
                                const Image<vec3>& indirect, int count) {
    std::vector<Candidate> candidates[2];  // by records, by rays
    double expected[2] = {};
    const int width = receivers.image.width;
    for (int i = 0; i < receivers.count(); ++i) {
        const auto pixel = static_cast<size_t>(i);
        if (receivers.orders[pixel] != kNoOrder && isJudged(pixel, width)) {
            const bool by_rays = receivers.by_rays[pixel] != 0;
            const double square = expectedSquare(neighbours, receivers, indirect, pixel);
            candidates[by_rays].push_back(
                {mortonCode(static_cast<uint32_t>(i % width), static_cast<uint32_t>(i / width)), i,
                 square});
            expected[by_rays] += square;
        }
    }
    std::vector<Probe> probes;
    const int rays = candidates[1].empty() ? 0 : candidates[0].empty() ? count : count / 2;
    for (const int kind : {0, 1}) {
        const auto pixels = static_cast<double>(candidates[kind].size());
        for (Candidate& c : candidates[kind]) {
            const double share = expected[kind] > 0.0 ? c.weight / expected[kind] : 0.0;
            c.weight = kAnywhere / pixels + (1.0 - kAnywhere) * share;
        }
        chooseFrom(candidates[kind], static_cast<size_t>(kind == 1 ? rays : count - rays), probes);
    }
    return probes;
}

void gatherProbes(const Scene& scene, const Receivers& receivers, const RecordField& field,
                  Gatherer& gatherer, const OutgoingLight& outgoing, const SpecularParams& params,
                  std::span<Probe> probes) {
    std::vector<RecordSite> sites(probes.size());
    parallelFor(static_cast<int>(probes.size()), [&](int k) {
        RecordSite& site = sites[static_cast<size_t>(k)];
        const auto pixel = static_cast<size_t>(probes[static_cast<size_t>(k)].pixel);
        site = siteAt(scene, receivers, pixel, true);
        site.order = shared::DIFFUSE_ORDER;  // its own light is wanted, not what pixels around see
        addContrasts(field, nearestOf(field, site.position), site);
    });
    for (int half = 0; half < 2; ++half) {
        for (RecordSite& site : sites) {
            site.seed = pcgHash(site.seed);  // other rays than any record's
        }
        const std::vector<GatheredRecord> gathered = gatherer.gather(sites);
        parallelFor(static_cast<int>(probes.size()), [&](int k) {
            Probe& probe = probes[static_cast<size_t>(k)];
            const GatheredRecord& g = gathered[static_cast<size_t>(k)];
            const auto pixel = static_cast<size_t>(probe.pixel);
            vec3 light = g.lobe_light;
            if (receivers.by_rays[pixel] != 0) {
                light = seeAgain(outgoing, receivers, pixel, kLobeRays, half, params);
            }
            probe.light[half] = receivers.diffuse[pixel] * g.record.irradiance / kPi;
            if (!receivers.irradiance_only) {
                probe.light[half] += receivers.specularAlbedo(pixel) * light;
            }
        });
    }
}

ErrorEstimate estimateError(const NeighbourErrors& neighbours, std::span<const Probe> probes,
                            const Receivers& receivers, const Image<vec3>& indirect) {
    double mean = 0.0;
    double seen = 0.0;
    double expected[2] = {};  // squares, of pixels by records and by rays
    for (size_t i = 0; i < indirect.pixels.size(); ++i) {
        if (receivers.seen(i) && isJudged(i, receivers.image.width)) {
            mean += luminance(indirect.pixels[i]);
            seen += 1.0;
            expected[receivers.by_rays[i] != 0 ? 1 : 0] +=
                expectedSquare(neighbours, receivers, indirect, i);
        }
    }
    if (!(mean > 0.0) || probes.empty()) {
        return {};
    }
    double square = 0.0;
    double variance = 0.0;
    for (const int rays : {0, 1}) {
        const Scale scale = scaleOf(neighbours, probes, receivers, indirect, rays != 0);
        if (scale.of_expected) {
            square += scale.factor * expected[rays];
            variance += scale.variance * expected[rays] * expected[rays];
        } else {
            square += scale.factor;
            variance += scale.variance;
        }
    }
    const double to_relative = seen / (mean * mean);
    square = std::max(square * to_relative, 0.0);
    const double deviation = std::sqrt(variance) * to_relative;
    const double high = std::sqrt(square + kNineOfTen * deviation);
    const double low = std::sqrt(std::max(square - kNineOfTen * deviation, 0.0));
    const double least = std::max(low, high / kWidest);
    return {std::max(std::sqrt(square), least), least, high};
}

}  // namespace sheen
