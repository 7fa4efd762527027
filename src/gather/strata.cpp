#include "gather/strata.h"

#include <algorithm>
#include <optional>

#include "core/parallel.h"

namespace sheen {
namespace {

constexpr vec3 kNoTint(1.0f);
// Rays of a record, over its texels: it gets no more where light comes to change, since none are
// ever given back.
constexpr size_t kMostGrown = 4;

// [texel]: the first of the rays besides the first.
std::vector<size_t> firstOthers(const Strata& strata) {
    std::vector<size_t> first(strata.more.size());
    size_t next = strata.more.size();
    for (size_t t = 0; t < first.size(); ++t) {
        first[t] = next;
        next += strata.more[t];
    }
    return first;
}

// The strata whose rays may have become others'.
std::vector<uint32_t> changedStrata(const Hemisphere& h, const Anchors& anchors,
                                    const Strata& strata) {
    std::vector<uint32_t> changed;
    for (size_t i = 0; i < strata.anchors.size(); ++i) {
        const uint32_t anchor = strata.anchors[i];
        if (anchor == Strata::kTraced ||
            (anchor < Strata::kFirstOther && !anchors.stands(anchor))) {
            changed.push_back(static_cast<uint32_t>(i));
        }
    }
    const Movers& movers = anchors.movers();
    if (!movers.any()) {
        return changed;
    }
    const auto faces = directionsOfFaces(h, tangentFrame(strata.site.normal, 0.0f));
    std::vector<uint32_t> asked;
    std::vector<vec3> directions;
    std::vector<float> distances;
    const std::vector<size_t> others = firstOthers(strata);
    for (const uint32_t t : movers.texelsToward(h, strata.eye, strata.site.normal)) {
        for (int k = 0; k <= strata.more[t]; ++k) {
            const size_t i = k == 0 ? t : others[t] + static_cast<size_t>(k) - 1;
            if (strata.anchors[i] != Strata::kBelow && strata.anchors[i] != Strata::kTraced) {
                asked.push_back(static_cast<uint32_t>(i));
                directions.push_back(texelRay(h, faces, t, k, strata.site.seed));
                distances.push_back(strata.distances[i]);
            }
        }
    }
    const std::vector<uint8_t> hidden = movers.hide(strata.eye, directions, distances);
    for (size_t i = 0; i < asked.size(); ++i) {
        if (hidden[i] != 0) {
            changed.push_back(asked[i]);
        }
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    return changed;
}

// [ray - texels]: the texel of each ray besides the first.
std::vector<size_t> texelsOfOthers(const Strata& strata) {
    std::vector<size_t> of;
    of.reserve(strata.anchors.size() - strata.more.size());
    for (size_t t = 0; t < strata.more.size(); ++t) {
        of.insert(of.end(), strata.more[t], t);
    }
    return of;
}

// As Tracer::meet() has planes, of the one through a point so far away; zero if it is seen from
// behind.
vec3 planeOf(const vec3& n, const vec3& way) {
    const float distance = glm::dot(n, way);
    return distance < 0.0f ? n / distance : vec3(0.0f);
}

// Casts rays of strata, whose numbers lie in `wanted`, and adds what they met to `met`.
void castStrata(const Hemisphere& h, const LightForRays& by, const Anchors& anchors, Strata& strata,
                std::span<const uint32_t> wanted, MetByRays& met) {
    const auto faces = directionsOfFaces(h, tangentFrame(strata.site.normal, 0.0f));
    const std::vector<size_t> others = firstOthers(strata);
    const std::vector<size_t> of_others = texelsOfOthers(strata);
    const size_t texels = strata.more.size();
    TexelRays rays{.n_g = strata.site.geometric_normal};
    std::vector<uint32_t> cast;
    for (const uint32_t i : wanted) {
        const size_t t = i < texels ? i : of_others[i - texels];
        const int number = i < texels ? 0 : static_cast<int>(i - others[t]) + 1;
        const float share = static_cast<float>(number == 0 ? 1 : 1 + strata.more[t]);
        rays.add(texelRay(h, faces, t, number, strata.site.seed), h.solid_angles[t] / share, t,
                 number, 0);
        if (rays.of.size() > cast.size()) {
            cast.push_back(i);
        }
    }
    std::vector<Hit> hits(cast.size());
    std::vector<vec3> planes(cast.size());
    const std::vector<vec4> seen =
        rays.cast(by.light, strata.eye, by.without_caustics, planes.data(), hits.data());
    const Movers& movers = anchors.movers();
    std::vector<uint8_t> hidden(cast.size());  // also by glass that moves
    if (movers.any()) {
        std::vector<float> distances;
        for (const Hit& hit : hits) {
            distances.push_back(hit.distance);
        }
        hidden = movers.hide(strata.eye, rays.directions, distances);
    }
    for (size_t k = 0; k < cast.size(); ++k) {
        const Hit& hit = hits[k];
        strata.anchors[cast[k]] = Strata::kTraced;
        met.strata.push_back(cast[k]);
        met.met.push_back({strata.eye, rays.directions[k], rays.solid_angles[k], hit});
        met.seen.push_back(seen[k]);
        met.planes.push_back(planes[k]);
        met.by_movers.push_back(hidden[k] != 0 || (hit.found() && movers.moves(hit.triangle)));
    }
}

// By what it is tied to, what a ray sees.
vec4 lightOf(const Anchors& anchors, const Strata& strata, size_t ray) {
    const uint32_t anchor = strata.anchors[ray];
    return anchor < Strata::kFirstOther
               ? vec4(anchors.light(anchor) * strata.tint(ray), strata.distances[ray])
           : anchor == Strata::kNothing ? vec4(strata.tint(ray), 0.0f)
                                        : vec4(0.0f);
}

// Of `count` rays, the first; of those that are traced what they met.
std::vector<vec4> lightOfFirst(size_t count, const Anchors& anchors, const Strata& strata,
                               const MetByRays& met) {
    std::vector<vec4> seen(count);
    for (size_t i = 0; i < count; ++i) {
        seen[i] = lightOf(anchors, strata, i);
    }
    for (size_t k = 0; k < met.strata.size(); ++k) {
        const size_t i = met.strata[k];
        if (i < count && strata.anchors[i] == Strata::kTraced) {
            seen[i] = met.seen[k];
        }
    }
    return seen;
}

// Gives texels so many rays besides the first, no fewer than they have. Returns the new ones.
std::vector<uint32_t> growTo(std::vector<uint8_t> more, Strata& strata, MetByRays& met) {
    const size_t texels = more.size();
    const std::vector<size_t> before = firstOthers(strata);
    Strata grown{.site = {}, .eye = {}, .more = std::move(more)};
    const std::vector<size_t> after = firstOthers(grown);
    const size_t count = after.back() + grown.more.back();
    grown.anchors.assign(count, Strata::kBelow);
    grown.distances.assign(count, kInfinity);
    grown.tints.assign(strata.tints.empty() ? 0 : count, kNoTint);
    std::vector<uint32_t> becomes(strata.anchors.size());
    const auto move = [&](size_t from, size_t to) {
        becomes[from] = static_cast<uint32_t>(to);
        grown.anchors[to] = strata.anchors[from];
        grown.distances[to] = strata.distances[from];
        if (!grown.tints.empty()) {
            grown.tints[to] = strata.tints[from];
        }
    };
    std::vector<uint32_t> added;
    for (size_t t = 0; t < texels; ++t) {
        move(t, t);
        for (size_t k = 0; k < grown.more[t]; ++k) {
            if (k < strata.more[t]) {
                move(before[t] + k, after[t] + k);
            } else {
                added.push_back(static_cast<uint32_t>(after[t] + k));
            }
        }
    }
    for (uint32_t& i : met.strata) {
        i = becomes[i];
    }
    strata.more = std::move(grown.more);
    strata.anchors = std::move(grown.anchors);
    strata.distances = std::move(grown.distances);
    strata.tints = std::move(grown.tints);
    return added;
}

}  // namespace

const vec3& Strata::tint(size_t ray) const { return tints.empty() ? kNoTint : tints[ray]; }

void Strata::setTint(size_t ray, const vec3& tint) {
    if (tints.empty() && tint != kNoTint) {
        tints.assign(anchors.size(), kNoTint);
    }
    if (!tints.empty()) {
        tints[ray] = tint;
    }
}

Strata makeStrata(const Hemisphere& h, const RecordSite& site, std::vector<uint8_t> more,
                  std::span<const CastRays> rays, const Movers& movers, MetByRays& met) {
    Strata strata{.site = site, .eye = site.eye(), .side = h.params.size, .more = std::move(more)};
    strata.site.contrasts = {};
    const std::vector<size_t> others = firstOthers(strata);
    const size_t count =
        others.empty() ? 0 : others.back() + static_cast<size_t>(strata.more.back());
    strata.anchors.assign(count, Strata::kBelow);
    strata.distances.assign(count, kInfinity);
    for (const CastRays& part : rays) {
        const TexelRays& cast = part.rays;
        for (size_t i = 0; i < cast.of.size(); ++i) {
            const size_t t = cast.of[i];
            const size_t number = cast.numbers[i];
            const size_t stratum = number == 0 ? t : others[t] + number - 1;
            const Hit& hit = part.hits[i];
            strata.anchors[stratum] = Strata::kTraced;
            met.strata.push_back(static_cast<uint32_t>(stratum));
            met.met.push_back({strata.eye, cast.directions[i], cast.solid_angles[i], hit});
            met.seen.push_back(part.seen[i]);
            met.planes.push_back(part.planes.empty() ? vec3(0.0f) : part.planes[i]);
            met.by_movers.push_back(hit.found() && movers.moves(hit.triangle) ? 1 : 0);
        }
    }
    return strata;
}

MetByRays traceChanged(const Hemisphere& h, const LightForRays& by, const Anchors& anchors,
                       Strata& strata) {
    MetByRays met;
    const std::vector<uint32_t> changed = changedStrata(h, anchors, strata);
    if (!changed.empty()) {
        castStrata(h, by, anchors, strata, changed, met);
    }
    return met;
}

void lookCloser(const Hemisphere& h, const LightForRays& by, const Anchors& anchors, Strata& strata,
                MetByRays& met) {
    met.first = lightOfFirst(strata.more.size(), anchors, strata, met);
    const std::vector<float> light = relativeLight(met.first, weightsFor(h, strata.site.order));
    std::vector<uint8_t> more = raysMore(contrastsOfNeighbours(h, light));
    std::transform(more.begin(), more.end(), strata.more.begin(), more.begin(),
                   [](uint8_t a, uint8_t b) { return std::max(a, b); });
    if (more != strata.more && strata.anchors.size() < kMostGrown * more.size()) {
        castStrata(h, by, anchors, strata, growTo(std::move(more), strata, met), met);
    }
}

void tie(const Scene& scene, Anchors& anchors, std::span<Strata* const> strata,
         std::span<MetByRays> met) {
    std::vector<std::vector<std::optional<Anchors::Link>>> found(strata.size());
    parallelFor(static_cast<int>(strata.size()), [&](int r) {
        const auto k = static_cast<size_t>(r);
        found[k].resize(met[k].met.size());
        for (size_t i = met[k].tied; i < met[k].met.size(); ++i) {
            if (met[k].met[i].hit.found() && met[k].by_movers[i] == 0) {
                found[k][i] = anchors.find(scene, met[k].met[i]);
            }
        }
    });
    for (size_t k = 0; k < strata.size(); ++k) {
        for (size_t i = met[k].tied; i < met[k].met.size(); ++i) {
            const size_t stratum = met[k].strata[i];
            const Anchors::Met& m = met[k].met[i];
            if (met[k].by_movers[i] != 0) {
                continue;
            }
            Strata& of = *strata[k];
            if (!m.hit.found()) {
                of.anchors[stratum] = Strata::kNothing;
                of.distances[stratum] = kInfinity;
                of.setTint(stratum, vec3(met[k].seen[i]));
                continue;
            }
            auto link = found[k][i];
            if (!link) {
                link = anchors.findOrAdd(scene, m);
            }
            if (link) {
                of.anchors[stratum] = link->anchor;
                of.distances[stratum] = m.hit.distance;
                of.setTint(stratum, link->tint);
            }
        }
        met[k].tied = met[k].met.size();
    }
}

SeenTexels texelsOf(const Anchors& anchors, const Strata& strata, MetByRays& met) {
    const size_t texels = strata.more.size();
    const mat3 frame = tangentFrame(strata.site.normal, 0.0f);
    SeenTexels result;
    result.planes.resize(texels);
    for (size_t t = 0; t < texels; ++t) {
        if (strata.anchors[t] < Strata::kFirstOther) {
            const Anchors::Point& p = anchors.point(strata.anchors[t]);
            result.planes[t] = planeOf(p.normal, p.position - strata.eye) * frame;
        }
    }
    for (size_t k = 0; k < met.strata.size(); ++k) {
        if (met.strata[k] < texels && strata.anchors[met.strata[k]] == Strata::kTraced) {
            result.planes[met.strata[k]] = met.planes[k] * frame;
        }
    }
    result.light = std::move(met.first);
    if (result.light.empty()) {
        result.light = lightOfFirst(texels, anchors, strata, met);
    }
    const size_t count = strata.anchors.size() - texels;
    std::vector<vec4> others(count);
    for (size_t i = 0; i < count; ++i) {
        others[i] = lightOf(anchors, strata, texels + i);
    }
    for (size_t k = 0; k < met.strata.size(); ++k) {
        const size_t i = met.strata[k];
        vec4& seen = i < texels ? result.light[i] : others[i - texels];
        seen = strata.anchors[i] == Strata::kTraced ? met.seen[k] : lightOf(anchors, strata, i);
    }
    addRays(texelsOfOthers(strata), others, strata.more, result.light);
    return result;
}

void dropUnused(Anchors& anchors, std::span<Strata* const> strata) {
    std::vector<uint8_t> used(anchors.size());
    for (const Strata* of : strata) {
        for (const uint32_t anchor : of->anchors) {
            if (anchor < Strata::kFirstOther) {
                used[anchor] = 1;
            }
        }
    }
    const std::vector<uint32_t> becomes = anchors.keepOnly(used);
    for (Strata* of : strata) {
        for (uint32_t& anchor : of->anchors) {
            if (anchor < Strata::kFirstOther) {
                anchor = becomes[anchor] == Anchors::kNone ? Strata::kTraced : becomes[anchor];
            }
        }
    }
}

}  // namespace sheen
