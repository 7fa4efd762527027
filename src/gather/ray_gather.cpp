#include "gather/ray_gather.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/timer.h"
#include "gather/face_directions.h"
#include "gather/motion.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Rays are cast in the order of blocks of texels, which are seen in similar directions.
constexpr int kBlockWidth = 4;
constexpr int kBlockHeight = Tracer::kPacket / kBlockWidth;

// A texel gets a ray more for each average texel's worth of light that it varies by: for a given
// number of rays a sum's variance is least where each texel has them in proportion to its standard
// deviation [Ney34].
constexpr float kLeastContrast = 2.0f;
constexpr float kMostRays = 64.0f;
// So many of a record's contrasts are passed on. A quarter finds a fifth less of the variance,
// twice as many find no more.
constexpr size_t kMostContrasts = 128;
// Steps of the R2 sequence, whose points fill a square evenly, however many there are [Rob18].
constexpr vec2 kSpread(0.7548777f, 0.5698403f);
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

// Rays of a record, and the texels they are for. Directions below the surface, to where the shading
// normal's hemisphere may reach, are not cast: nothing comes from there.
struct TexelRays {
    vec3 n_g;
    std::vector<vec3> directions = {};
    std::vector<float> solid_angles = {};  // that the rays stand for
    std::vector<size_t> of = {};
    std::vector<uint8_t> sets = {};

    void reserve(size_t count) {
        directions.reserve(count);
        solid_angles.reserve(count);
        of.reserve(count);
        sets.reserve(count);
    }
    void add(const vec3& direction, float solid_angle, size_t texel, size_t set) {
        if (glm::dot(direction, n_g) > 0.0f) {
            directions.push_back(direction);
            solid_angles.push_back(solid_angle);
            of.push_back(texel);
            sets.push_back(static_cast<uint8_t>(set));
        }
    }
    std::vector<vec4> cast(const OutgoingLight& light, const vec3& eye, bool without_caustics,
                           vec3* planes = nullptr) const {
        std::vector<vec4> seen(directions.size());
        light.cast({.origin = eye,
                    .directions = directions,
                    .solid_angles = solid_angles,
                    .sets = sets,
                    .without_caustics = without_caustics},
                   seen.data(), planes);
        return seen;
    }
};

// What a texel's light counts for: irradiance weighs it by its cosine, lobes anywhere.
std::span<const float> weightsFor(const Hemisphere& h, int order) {
    return order == shared::DIFFUSE_ORDER ? h.cosines : h.solid_angles;
}

// Light of texels, over their average.
std::vector<float> relativeLight(std::span<const vec4> texels, std::span<const float> weights) {
    std::vector<float> light(texels.size());
    float sum = 0.0f;
    for (size_t t = 0; t < texels.size(); ++t) {
        light[t] = (texels[t].x + texels[t].y + texels[t].z) * weights[t];
        sum += light[t];
    }
    const float scale = static_cast<float>(texels.size()) / sum;
    if (!std::isfinite(scale)) {
        return std::vector<float>(texels.size());  // dark, or nearly
    }
    for (float& l : light) {
        l *= scale;
    }
    return light;
}

// By how much light changes across each texel, judged by its neighbours and, but for its share of
// the average, never by its own ray: were it looked at closer because its ray met something bright,
// but not because it missed it, light would be lost.
std::vector<float> contrastsOfNeighbours(const Hemisphere& h, std::span<const float> light) {
    std::vector<float> least(light.size(), kInfinity);
    std::vector<float> most(light.size(), 0.0f);
    const auto heed = [&](uint32_t t, uint32_t neighbour) {
        least[t] = std::min(least[t], light[neighbour]);
        most[t] = std::max(most[t], light[neighbour]);
    };
    for (const HemisphereWall& wall : h.walls) {
        heed(wall.a, wall.b);
        heed(wall.b, wall.a);
    }
    for (size_t t = 0; t < light.size(); ++t) {
        most[t] = std::max(most[t] - least[t], 0.0f);
    }
    return most;
}

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

int raysMore(float contrast) {
    return contrast >= kLeastContrast ? static_cast<int>(std::min(contrast, kMostRays)) : 0;
}

// One ray through each texel, at a random place of its own. Neighbours, which decide how many more
// there are of a texel, are of other sets: did their chance depend on the texel's, light would be
// lost or won.
TexelRays raysThroughTexels(const Hemisphere& h, std::span<const FaceDirections> faces,
                            const vec3& n_g, uint32_t seed) {
    TexelRays rays{.n_g = n_g};
    rays.reserve(static_cast<size_t>(h.texelCount()));
    for (size_t f = 0; f < faces.size(); ++f) {
        const HemisphereFace& face = h.faces[f];
        for (int y0 = 0; y0 < face.height; y0 += kBlockHeight) {
            for (int x0 = 0; x0 < face.width; x0 += kBlockWidth) {
                for (int y = y0; y < std::min(y0 + kBlockHeight, face.height); ++y) {
                    for (int x = x0; x < std::min(x0 + kBlockWidth, face.width); ++x) {
                        const size_t t = texelOf(h, face, x, y);
                        const vec2 place = randomPlace(seed, static_cast<uint32_t>(t));
                        const size_t set = 2 * f + static_cast<size_t>((x + y) % 2);
                        rays.add(faces[f].direction(x, y, place), h.solid_angles[t], t, set);
                    }
                }
            }
        }
    }
    return rays;
}

// More where light changes, spread evenly over the texel from a random place on [Rob18].
TexelRays raysWhereLightChanges(const Hemisphere& h, std::span<const FaceDirections> faces,
                                const vec3& n_g, uint32_t seed, std::span<const float> contrasts) {
    TexelRays rays{.n_g = n_g};
    rays.reserve(2 * contrasts.size());
    for (size_t f = 0; f < faces.size(); ++f) {
        const HemisphereFace& face = h.faces[f];
        for (int y = 0; y < face.height; ++y) {
            for (int x = 0; x < face.width; ++x) {
                const size_t t = texelOf(h, face, x, y);
                const int count = raysMore(contrasts[t]);
                const float solid_angle = h.solid_angles[t] / static_cast<float>(1 + count);
                const vec2 start = randomPlace(seed, static_cast<uint32_t>(contrasts.size() + t));
                for (int k = 0; k < count; ++k) {
                    const vec2 place = glm::fract(start + static_cast<float>(k) * kSpread);
                    rays.add(faces[f].direction(x, y, place), solid_angle, t, 0);
                }
            }
        }
    }
    return rays;
}

// Makes texels, of one ray each, the means of radiance and of the distance's inverse over all rays.
void addRays(const TexelRays& more, std::span<const vec4> more_seen,
             std::span<const float> contrasts, std::span<vec4> texels) {
    const auto inverse = [](float distance) { return distance > 0.0f ? 1.0f / distance : 0.0f; };
    for (vec4& texel : texels) {
        texel.w = inverse(texel.w);
    }
    for (size_t i = 0; i < more.of.size(); ++i) {
        texels[more.of[i]] += vec4(vec3(more_seen[i]), inverse(more_seen[i].w));
    }
    for (size_t t = 0; t < texels.size(); ++t) {
        texels[t] /= static_cast<float>(1 + raysMore(contrasts[t]));
        texels[t].w = inverse(texels[t].w);
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

// The resolution of each site, with the matrices that it needs.
std::vector<const RayGatherer::Resolution*> RayGatherer::prepare(
    std::span<const RecordSite> sites) {
    std::vector<const Resolution*> resolutions;
    for (size_t i = 0; i < sites.size(); ++i) {
        HemisphereParams params = params_;
        params.size = sideForReach(params_.size, sites[i].reach);
        const auto [found, fresh] = resolutions_.try_emplace(params.size);
        Resolution& resolution = found->second;
        if (fresh) {
            resolution.hemisphere = makeHemisphere(params);
            resolution.projections = ProjectionMatrices(below_);
        }
        resolution.projections.prepare(resolution.hemisphere, sites.subspan(i, 1));
        resolutions.push_back(&resolution);
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
        lookAhead(*resolutions[i], seen[i].texels, sites[i], results[i]);
    });
    seconds_.project += project_timer.seconds();
    for (const Seen& s : seen) {
        rays_cast_ += s.rays;
    }
    return results;
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
    std::vector<FaceDirections> faces;
    for (const HemisphereFace& face : h.faces) {
        faces.emplace_back(face, frame);
    }
    Seen result;
    std::vector<vec4>& texels = result.texels.light;
    texels.resize(static_cast<size_t>(h.texelCount()));
    result.texels.planes.resize(texels.size());

    const TexelRays first = raysThroughTexels(h, faces, site.geometric_normal, seed);
    std::vector<vec3> planes(first.of.size());
    const std::vector<vec4> first_seen = first.cast(light_, eye, without_caustics_, planes.data());
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
    const TexelRays more = raysWhereLightChanges(h, faces, site.geometric_normal, seed, contrasts);
    const std::vector<vec4> more_seen = more.cast(light_, eye, without_caustics_);
    addRays(more, more_seen, contrasts, texels);
    result.rays = static_cast<int64_t>(first.of.size() + more.of.size());
    result.contrasts = findContrasts(h, texels, weights, more, more_seen, eye, frame);
    for (Contrast& c : result.contrasts) {
        c.strength /= sharpness;
    }
    return result;
}

}  // namespace sheen
