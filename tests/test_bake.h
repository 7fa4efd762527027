// Small lightmaps for the tests of baking.
#pragma once

#include <memory>

#include "bake/bake.h"
#include "test_scenes.h"

namespace sheen {

/// A scene with its lightmap; the scene must outlive it.
struct Bench {
    Tracer tracer;
    Lightmap map;

    Bench(const Scene& scene, int size) : Bench(scene, AtlasParams{.size = size}) {}
    Bench(const Scene& scene, const AtlasParams& params) : tracer(scene) {
        std::string why;
        Atlas atlas = atlasOfFile(scene, params, why);
        map = lightmapOf(tracer, why.empty() ? std::move(atlas) : makeAtlas(scene, params));
    }
    Baked bake(BakeParams params = {}) const {
        params.quiet = true;
        return sheen::bake(tracer, map, params);
    }
    /// Calls body(texel) for those with light of their own.
    template <class F>
    void forSeen(const F& body) const {
        for (size_t i = 0; i < map.receivers.positions.size(); ++i) {
            if (map.receivers.seen(i)) {
                body(i);
            }
        }
    }
};

/// One that every direction shines from alike.
inline void addSky(Scene& scene, const vec3& radiance) {
    scene.environment.texels = Image<vec3>(1, 1, radiance);
}

}  // namespace sheen
