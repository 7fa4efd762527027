#include "gather/strata.h"

#include <algorithm>
#include <optional>

#include "core/parallel.h"

namespace sheen {
namespace {

constexpr vec3 kNoTint(1.0f);

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
std::vector<uint32_t> changedStrata(const Hemisphere& h, std::span<const FaceDirections> faces,
                                    const Anchors& anchors, const Strata& strata) {
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
std::vector<uint32_t> texelsOfOthers(const Strata& strata) {
    std::vector<uint32_t> of;
    of.reserve(strata.anchors.size() - strata.more.size());
    for (size_t t = 0; t < strata.more.size(); ++t) {
        of.insert(of.end(), strata.more[t], static_cast<uint32_t>(t));
    }
    return of;
}

// As Tracer::meet() has planes, of the one through a point so far away; zero if it is seen from
// behind.
vec3 planeOf(const vec3& n, const vec3& way) {
    const float distance = glm::dot(n, way);
    return distance < 0.0f ? n / distance : vec3(0.0f);
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

MetByRays traceAnew(const Hemisphere& h, const OutgoingLight& light, bool without_caustics,
                    const Anchors& anchors, Strata& strata) {
    const mat3 frame = tangentFrame(strata.site.normal, 0.0f);
    const std::vector<FaceDirections> faces = directionsOfFaces(h, frame);
    MetByRays met;
    met.strata = changedStrata(h, faces, anchors, strata);
    if (met.strata.empty()) {
        return met;
    }
    const std::vector<size_t> others = firstOthers(strata);
    const std::vector<uint32_t> of_others = texelsOfOthers(strata);
    TexelRays rays{.n_g = strata.site.geometric_normal};
    for (const uint32_t i : met.strata) {
        const size_t texels = strata.more.size();
        const size_t t = i < texels ? i : of_others[i - texels];
        const int number = i < texels ? 0 : static_cast<int>(i - others[t]) + 1;
        rays.add(texelRay(h, faces, t, number, strata.site.seed),
                 h.solid_angles[t] / static_cast<float>(number == 0 ? 1 : 1 + strata.more[t]), t,
                 number, 0);
    }
    std::vector<Hit> hits(rays.of.size());
    met.planes.resize(hits.size());
    met.seen = rays.cast(light, strata.eye, without_caustics, met.planes.data(), hits.data());
    std::vector<float> distances;
    for (size_t k = 0; k < hits.size(); ++k) {
        strata.anchors[met.strata[k]] = Strata::kTraced;
        met.met.push_back({strata.eye, rays.directions[k], rays.solid_angles[k], hits[k]});
        distances.push_back(hits[k].distance);
    }
    // Also what is behind glass that moves.
    met.by_movers.assign(hits.size(), 0);
    if (anchors.movers().any()) {
        met.by_movers = anchors.movers().hide(strata.eye, rays.directions, distances);
    }
    for (size_t k = 0; k < hits.size(); ++k) {
        if (hits[k].found() && anchors.movers().moves(hits[k].triangle)) {
            met.by_movers[k] = 1;
        }
    }
    return met;
}

void tie(const Scene& scene, Anchors& anchors, std::span<Strata* const> strata,
         std::span<const MetByRays> met) {
    std::vector<std::vector<std::optional<Anchors::Link>>> found(strata.size());
    parallelFor(static_cast<int>(strata.size()), [&](int r) {
        const auto k = static_cast<size_t>(r);
        found[k].resize(met[k].met.size());
        for (size_t i = 0; i < met[k].met.size(); ++i) {
            if (met[k].met[i].hit.found() && met[k].by_movers[i] == 0) {
                found[k][i] = anchors.find(scene, met[k].met[i]);
            }
        }
    });
    for (size_t k = 0; k < strata.size(); ++k) {
        for (size_t i = 0; i < met[k].met.size(); ++i) {
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
    }
}

SeenTexels texelsOf(const Anchors& anchors, const Strata& strata, const MetByRays& met) {
    const size_t texels = strata.more.size();
    const mat3 frame = tangentFrame(strata.site.normal, 0.0f);
    std::vector<vec4> seen(strata.anchors.size());
    SeenTexels result;
    result.planes.resize(texels);
    for (size_t i = 0; i < seen.size(); ++i) {
        const uint32_t anchor = strata.anchors[i];
        if (anchor < Strata::kFirstOther) {
            seen[i] = vec4(anchors.light(anchor) * strata.tint(i), strata.distances[i]);
            if (i < texels) {
                const vec3 way = anchors.position(anchor) - strata.eye;
                result.planes[i] = planeOf(anchors.normal(anchor), way) * frame;
            }
        } else if (anchor == Strata::kNothing) {
            seen[i] = vec4(strata.tint(i), 0.0f);
        }
    }
    for (size_t k = 0; k < met.strata.size(); ++k) {
        const size_t i = met.strata[k];
        if (strata.anchors[i] == Strata::kTraced) {
            seen[i] = met.seen[k];
            if (i < texels) {
                result.planes[i] = met.planes[k] * frame;
            }
        }
    }
    result.light.assign(seen.begin(), seen.begin() + static_cast<ptrdiff_t>(texels));
    const std::vector<uint32_t> of_others = texelsOfOthers(strata);
    const std::vector<size_t> of(of_others.begin(), of_others.end());
    addRays(of, std::span(seen).subspan(texels), strata.more, result.light);
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
