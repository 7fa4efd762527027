#include "gather/ray_gather.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/timer.h"
#include "gather/face_directions.h"
#include "gather/motion.h"
#include "gather/texel_rays.h"

namespace sheen {
namespace {

// So many of a record's contrasts are passed on. A quarter finds a fifth less of the variance,
// twice as many find no more.
constexpr size_t kMostContrasts = 128;
// From so many rays on, a texel's standard deviation is theirs; below, that from its neighbours.
constexpr int kEnoughRays = 4;

// A record's noise shows in all pixels it serves: their number pays for its rays, up to a point,
// since noise is not all that is wrong. From record to record the side of the hemisphere goes with
// the fourth root of the reach, in steps, since each size needs matrices of its own.
constexpr float kUsualReach = 5.0f;
constexpr float kSideStep = 1.25f;
constexpr float kMostSteps = 2.0f;
constexpr int kEnoughTexels = 128;  // no record takes more for its reach

// Of rays that are cast again to see whether a record is still right.
constexpr size_t kWitnesses = 32;

// What is smaller than a texel and bright, one ray in many meets, and no neighbour: half of the
// variance lies in one texel of a hundred, and records nearby know which. Raises the contrasts of
// the four texels that lie nearest to each of theirs. `scale`: what their strengths are times.
void heedContrasts(const Hemisphere& h, std::span<const FaceDirections> faces, const vec3& eye,
                   std::span<const Contrast> found, float scale, std::vector<float>& contrasts) {
    for (const Contrast& c : found) {
        for (size_t f = 0; f < faces.size(); ++f) {
            const std::optional<vec2> place = faces[f].meet(c.position - eye);
            if (!place) {
                continue;
            }
            const HemisphereFace& face = h.faces[f];
            const ivec2 last(face.width - 1, face.height - 1);
            const ivec2 corner(glm::floor(*place - 0.5f));
            for (const ivec2 offset : {ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(1, 1)}) {
                const ivec2 texel = glm::clamp(corner + offset, ivec2(0), last);
                float& contrast = contrasts[texelOf(h, face, texel.x, texel.y)];
                contrast = std::max(contrast, scale * c.strength);
            }
            break;  // no other face meets it
        }
    }
}

// Contrasts found by all rays of a record: `more` went through some texels and saw `more_seen`.
std::vector<Contrast> findContrasts(const Hemisphere& h, std::span<const vec4> texels,
                                    std::span<const float> weights, const TexelRays& more,
                                    std::span<const vec4> more_seen, const vec3& eye,
                                    const mat3& frame) {
    const std::vector<float> light = relativeLight(texels, weights);
    std::vector<float> strengths(texels.size());
    for (const HemisphereWall& wall : h.walls) {
        const float change = std::abs(light[wall.a] - light[wall.b]);
        strengths[wall.a] = std::max(strengths[wall.a], change);
        strengths[wall.b] = std::max(strengths[wall.b], change);
    }
    // The rays of a texel follow each other.
    for (size_t first = 0, end = 0; first < more.of.size(); first = end) {
        const size_t t = more.of[first];
        float sum = 0.0f;
        float sum_of_squares = 0.0f;
        for (end = first; end < more.of.size() && more.of[end] == t; ++end) {
            const float l = more_seen[end].x + more_seen[end].y + more_seen[end].z;
            sum += l;
            sum_of_squares += l * l;
        }
        const auto count = static_cast<float>(end - first);
        if (count >= kEnoughRays && sum > 0.0f) {  // what rays missed, the first may have met
            const float deviation = std::sqrt(std::max(sum_of_squares * count - sum * sum, 0.0f));
            strengths[t] = 2.0f * light[t] * deviation / sum;
        }
    }
    std::vector<Contrast> contrasts;
    for (size_t t = 0; t < texels.size(); ++t) {
        if (strengths[t] >= kLeastContrast && texels[t].w > 0.0f) {
            contrasts.push_back({eye + frame * h.directions[t] * texels[t].w, strengths[t]});
        }
    }
    if (contrasts.size() > kMostContrasts) {
        const auto last = contrasts.begin() + kMostContrasts;
        std::nth_element(
            contrasts.begin(), last, contrasts.end(),
            [](const Contrast& a, const Contrast& b) { return a.strength > b.strength; });
        contrasts.erase(last, contrasts.end());
    }
    contrasts.shrink_to_fit();  // records keep them for the whole placement
    return contrasts;
}

}  // namespace

int sideForReach(int usual, float reach) {
    if (reach <= 0.0f) {
        return usual;
    }
    const float steps = 0.25f * std::log(reach / kUsualReach) / std::log(kSideStep);
    const float step = std::round(std::clamp(steps, -kMostSteps, kMostSteps));
    if (step == 0.0f) {
        return usual;
    }
    // A hemicube's sides have half the rows.
    const float half = 0.5f * static_cast<float>(usual) * std::pow(kSideStep, step);
    const int side = 2 * static_cast<int>(std::lround(half));
    return std::min(side, std::max(usual, kEnoughTexels));
}

// With the matrices that the sites need.
RayGatherer::Resolution& RayGatherer::resolutionOf(int side, std::span<const RecordSite> sites) {
    const auto [found, fresh] = resolutions_.try_emplace(side);
    Resolution& resolution = found->second;
    if (fresh) {
        HemisphereParams params = params_;
        params.size = side;
        resolution.hemisphere = makeHemisphere(params);
        resolution.projections = ProjectionMatrices(below_);
    }
    resolution.projections.prepare(resolution.hemisphere, sites);
    return resolution;
}

// The resolution of each site, with the matrices that it needs.
std::vector<const RayGatherer::Resolution*> RayGatherer::prepare(
    std::span<const RecordSite> sites) {
    std::vector<const Resolution*> resolutions;
    for (size_t i = 0; i < sites.size(); ++i) {
        const int side = sideForReach(params_.size, sites[i].reach);
        resolutions.push_back(&resolutionOf(side, sites.subspan(i, 1)));
    }
    return resolutions;
}

std::vector<GatheredRecord> RayGatherer::gather(std::span<const RecordSite> sites) {
    const Timer prepare_timer;
    const std::vector<const Resolution*> resolutions = prepare(sites);
    seconds_.project += prepare_timer.seconds();
    const auto count = static_cast<int>(sites.size());
    std::vector<Seen> seen(sites.size());
    const Timer see_timer;
    parallelFor(count, [&](int k) {
        const auto i = static_cast<size_t>(k);
        const RecordSite& site = sites[i];
        const Hemisphere& h = resolutions[i]->hemisphere;
        std::span<const Contrast> found = site.contrasts;
        Seen looked;
        // The first look twice, and only what they see the second time counts.
        if (site.first) {
            looked = see(h, site, ~site.seed, found);
            found = looked.contrasts;
        }
        seen[i] = see(h, site, site.seed, found);
        seen[i].rays += looked.rays;
    });
    tieGathered(resolutions, seen);
    seconds_.see += see_timer.seconds();
    const Timer project_timer;
    std::vector<GatheredRecord> results(sites.size());
    parallelFor(count, [&](int k) {
        const auto i = static_cast<size_t>(k);
        results[i] = integrateHemisphere(resolutions[i]->hemisphere, seen[i].texels,
                                         resolutions[i]->projections.of(sites[i].order), sites[i]);
        results[i].contrasts = std::move(seen[i].contrasts);
        results[i].witnesses = std::move(seen[i].witnesses);
        results[i].eye = sites[i].eye();
        results[i].strata = std::move(seen[i].strata);
        lookAhead(*resolutions[i], seen[i].texels, sites[i], results[i]);
    });
    seconds_.project += project_timer.seconds();
    for (const Seen& s : seen) {
        rays_cast_ += s.rays;
    }
    return results;
}

// ---- Strata -------------------------------------------------------------------------------------

void RayGatherer::keepStrata(Anchors& anchors) {
    const Timer timer;
    anchors_ = &anchors;
    anchors.lightBy(light_, without_caustics_);
    seconds_.see += timer.seconds();
}

bool RayGatherer::keepsStrata(const RecordSite& site) const {
    return anchors_ != nullptr && !anchors_->movers().moves(site.triangle);
}

void RayGatherer::tieTogether(std::span<Strata* const> strata, std::span<MetByRays> met) {
    tie(light_.scene(), *anchors_, strata, met);
    anchors_->lightBy(light_, without_caustics_);
}

// From the first on records say what their anchors do.
void RayGatherer::tieGathered(std::span<const Resolution* const> resolutions,
                              std::span<Seen> seen) {
    std::vector<Strata*> strata;
    std::vector<MetByRays> met;
    std::vector<size_t> of;
    for (size_t i = 0; i < seen.size(); ++i) {
        if (seen[i].strata && !anchors_->claim(seen[i].strata->anchors.size())) {
            seen[i].strata.reset();
        }
        if (seen[i].strata) {
            strata.push_back(seen[i].strata.get());
            met.push_back(std::move(seen[i].met));
            of.push_back(i);
        }
    }
    if (strata.empty()) {
        return;
    }
    const auto count = static_cast<int>(of.size());
    tieTogether(strata, met);
    parallelFor(count, [&](int n) {
        const auto k = static_cast<size_t>(n);
        lookCloser(resolutions[of[k]]->hemisphere, {light_, without_caustics_}, *anchors_,
                   *strata[k], met[k]);
    });
    tieTogether(strata, met);
    parallelFor(count, [&](int n) {
        const auto k = static_cast<size_t>(n);
        seen[of[k]].texels = texelsOf(*anchors_, *strata[k], met[k]);
    });
}

// What the record has become. It takes what stays of `before`.
GatheredRecord RayGatherer::followed(const Resolution& resolution, MetByRays& met,
                                     GatheredRecord& before, bool turned) const {
    const Hemisphere& h = resolution.hemisphere;
    const RecordSite& site = before.strata->site;
    const SeenTexels texels = texelsOf(*anchors_, *before.strata, met);
    if (turned) {
        GatheredRecord now = std::move(before);
        seeThroughLobe(h, texels.light, now.strata->site, tangentFrame(now.record.normal, 0.0f),
                       now);
        return now;
    }
    GatheredRecord now =
        integrateHemisphere(h, texels, resolution.projections.of(site.order), site);
    now.contrasts = std::move(before.contrasts);
    now.eye = before.eye;
    now.age = before.age;
    now.strata = std::move(before.strata);
    return now;
}

void RayGatherer::follow(std::span<GatheredRecord* const> records, bool turned) {
    constexpr size_t kTogether = 256;
    for (size_t first = 0; first < records.size(); first += kTogether) {
        const auto some = records.subspan(first, std::min(kTogether, records.size() - first));
        const auto count = static_cast<int>(some.size());
        const Timer see_timer;
        std::vector<const Resolution*> resolutions;
        std::vector<Strata*> strata;
        for (const GatheredRecord* record : some) {
            strata.push_back(record->strata.get());
            resolutions.push_back(&resolutionOf(strata.back()->side, {&strata.back()->site, 1}));
        }
        std::vector<MetByRays> met(some.size());
        parallelFor(count, [&](int k) {
            const auto i = static_cast<size_t>(k);
            const Hemisphere& h = resolutions[i]->hemisphere;
            const LightForRays by{light_, without_caustics_};
            met[i] = traceChanged(h, by, *anchors_, *strata[i]);
            if (anchors_->change() && !turned) {
                lookCloser(h, by, *anchors_, *strata[i], met[i]);
            }
        });
        tieTogether(strata, met);
        seconds_.see += see_timer.seconds();
        const Timer project_timer;
        parallelFor(count, [&](int k) {
            const auto i = static_cast<size_t>(k);
            *some[i] = followed(*resolutions[i], met[i], *some[i], turned);
        });
        seconds_.project += project_timer.seconds();
        for (const MetByRays& m : met) {
            rays_cast_ += static_cast<int64_t>(m.strata.size());
        }
    }
}

std::vector<float> RayGatherer::changesSince(std::span<const GatheredRecord* const> records) {
    const Timer timer;
    std::vector<float> changes(records.size());
    parallelFor(static_cast<int>(records.size()), [&](int k) {
        const auto i = static_cast<size_t>(k);
        changes[i] = changeSince(*records[i]);
    });
    seconds_.see += timer.seconds();
    return changes;
}

std::vector<vec4> RayGatherer::witness(std::span<const GatheredRecord::Witness> witnesses,
                                       const vec3& eye) const {
    std::vector<vec3> directions;
    std::vector<float> solid_angles;
    for (const GatheredRecord::Witness& w : witnesses) {
        directions.push_back(w.direction);
        solid_angles.push_back(w.solid_angle);
    }
    std::vector<vec4> seen(directions.size());
    light_.cast({.origin = eye,
                 .directions = directions,
                 .solid_angles = solid_angles,
                 .without_caustics = without_caustics_},
                seen.data());
    return seen;
}

// Of the record's rays, cast by themselves, as they will be in later frames.
std::vector<GatheredRecord::Witness> RayGatherer::witnessesOf(std::span<const vec3> directions,
                                                              std::span<const float> solid_angles,
                                                              const vec3& eye) const {
    std::vector<GatheredRecord::Witness> witnesses;
    const size_t count = directions.size();
    for (size_t k = 0; k < kWitnesses && count > 0; ++k) {
        const size_t i = (2 * k + 1) * count / (2 * kWitnesses);
        witnesses.push_back({directions[i], solid_angles[i], vec3(0.0f)});
    }
    const std::vector<vec4> seen = witness(witnesses, eye);
    for (size_t k = 0; k < seen.size(); ++k) {
        witnesses[k].light = vec3(seen[k]);
    }
    return witnesses;
}

// The rays are those of then, and draw their chance as they did, so that where nothing has changed
// there is no noise.
float RayGatherer::changeSince(const GatheredRecord& record) const {
    const bool diffuse = record.record.order == shared::DIFFUSE_ORDER;
    const std::vector<vec4> seen = witness(record.witnesses, record.eye);
    float change = 0.0f, before = 0.0f, after = 0.0f;
    for (size_t k = 0; k < seen.size(); ++k) {
        const float cosine = glm::dot(record.record.normal, record.witnesses[k].direction);
        const float weight =
            record.witnesses[k].solid_angle * (diffuse ? std::max(cosine, 0.0f) : 1.0f);
        const float was = weight * luminance(record.witnesses[k].light);
        const float is = weight * luminance(vec3(seen[k]));
        before += was;
        after += is;
        change += diffuse ? is - was : std::abs(is - was);
    }
    const float most = std::max(before, after);
    return most > 0.0f ? std::abs(change) / most : 0.0f;
}

void RayGatherer::lookAhead(const Resolution& resolution, SeenTexels& seen, const RecordSite& site,
                            GatheredRecord& result) const {
    if (motion_ == nullptr) {
        return;
    }
    auto later = motion_->reproject(resolution.hemisphere, site, seen.light);
    if (!later) {
        return;
    }
    seen.light = std::move(*later);
    GatheredRecord then = integrateHemisphere(resolution.hemisphere, seen,
                                              resolution.projections.of(site.order), site);
    result.later = GatheredRecord::Later{then.record.irradiance, std::move(then.sh)};
}

// Rays through the middles of texels would all miss, or all meet, a thin thing that lies along a
// row of them, and a record's neighbours would err the same way. Random places make that noise,
// which differs from record to record, so that interpolation averages it.
RayGatherer::Seen RayGatherer::see(const Hemisphere& h, const RecordSite& site, uint32_t seed,
                                   std::span<const Contrast> found) const {
    const mat3 frame = tangentFrame(site.normal);
    const vec3 eye = site.eye();
    const std::span<const float> weights = weightsFor(h, site.order);
    const std::vector<FaceDirections> faces = directionsOfFaces(h, frame);
    Seen result;
    std::vector<vec4>& texels = result.texels.light;
    texels.resize(static_cast<size_t>(h.texelCount()));
    result.texels.planes.resize(texels.size());

    const TexelRays first = raysThroughTexels(h, faces, site.geometric_normal, seed);
    std::vector<vec3> planes(first.of.size());
    const bool keeps = keepsStrata(site) && seed == site.seed;
    std::vector<Hit> first_hits(keeps ? first.of.size() : 0);
    const auto hits_of = [&](std::vector<Hit>& hits) { return keeps ? hits.data() : nullptr; };
    const std::vector<vec4> first_seen =
        first.cast(light_, eye, without_caustics_, planes.data(), hits_of(first_hits));
    for (size_t i = 0; i < first.of.size(); ++i) {
        texels[first.of[i]] = first_seen[i];
        result.texels.planes[first.of[i]] = planes[i] * frame;  // into the record's frame
    }

    if (motion_ != nullptr) {
        result.witnesses = witnessesOf(first.directions, first.solid_angles, eye);
    }
    std::vector<float> contrasts = contrastsOfNeighbours(h, relativeLight(texels, weights));
    // What is smaller than a texel deviates, over what a texel brings, as the side.
    const float sharpness = static_cast<float>(h.params.size) / static_cast<float>(params_.size);
    heedContrasts(h, faces, eye, found, sharpness, contrasts);
    std::vector<uint8_t> counts = raysMore(contrasts);
    const TexelRays more = raysWhereLightChanges(h, faces, site.geometric_normal, seed, counts);
    std::vector<Hit> more_hits(keeps ? more.of.size() : 0);
    const std::vector<vec4> more_seen =
        more.cast(light_, eye, without_caustics_, nullptr, hits_of(more_hits));
    addRays(more.of, more_seen, counts, texels);
    result.rays = static_cast<int64_t>(first.of.size() + more.of.size());
    result.contrasts = findContrasts(h, texels, weights, more, more_seen, eye, frame);
    for (Contrast& c : result.contrasts) {
        c.strength /= sharpness;
    }
    if (keeps) {
        const CastRays cast[] = {{first, first_hits, first_seen, planes},
                                 {more, more_hits, more_seen}};
        result.strata = std::make_shared<Strata>(
            makeStrata(h, site, std::move(counts), cast, anchors_->movers(), result.met));
    }
    return result;
}

}  // namespace sheen
