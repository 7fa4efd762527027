// Points where records are gathered in tests.
#pragma once

#include <vector>

#include "rays/jitter.h"
#include "record/record.h"
#include "test_scenes.h"

namespace sheen {

constexpr float kOffset = 1e-5f;  // off surfaces of rooms about as large as 1

inline RecordSite siteAt(const vec3& position, const vec3& n, int order = shared::DIFFUSE_ORDER) {
    return {.position = position,
            .normal = n,
            .geometric_normal = n,
            .toward_viewer = n,
            .offset = kOffset,
            .order = order};
}

/// The same site many times, each time with random numbers of its own.
inline std::vector<RecordSite> repeated(int count, const RecordSite& site) {
    std::vector<RecordSite> sites(static_cast<size_t>(count), site);
    for (size_t i = 0; i < sites.size(); ++i) {
        sites[i].seed = pcgHash(static_cast<uint32_t>(i));
    }
    return sites;
}

/// Diffuse sites on the walls of glossyRoom() and on the box's top in it.
inline std::vector<RecordSite> sitesInGlossyRoom(int count) {
    Random random(1);
    std::vector<RecordSite> sites;
    for (int i = 0; i < count; ++i) {
        const vec3 p = random.point(-0.8f, 0.8f);
        const vec3 walls[][2] = {{{-1, p.y, p.z}, {1, 0, 0}},
                                 {{p.x, -1, 0.5f}, {0, 1, 0}},
                                 {{-0.3f, -0.4f, 0.1f * p.z}, {0, 1, 0}}};
        sites.push_back(siteAt(walls[i % 3][0], walls[i % 3][1]));
        sites.back().seed = pcgHash(static_cast<uint32_t>(i));
    }
    return sites;
}

}  // namespace sheen
