// Points whose light is wanted, as structure of arrays: the pixels of an image, or texels of a
// lightmap. All that gathers, places, splats or composes asks these what lies where, and never the
// G-buffer or the atlas that they were made of.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "light/elements.h"
#include "raster/gbuffer.h"
#include "receivers/lobes.h"
#include "receivers/point_index.h"
#include "record/record.h"

namespace sheen {

/// Material of a receiver without a surface.
constexpr int kNoMaterial = -1;
/// Order of a receiver without a surface.
constexpr int kNoOrder = -1;
/// Asked for in place of an order: records have none, and rays say all of lobes that matter.
constexpr int kLobesByRays = -1;

/// What light receivers ask for, counted.
struct ReceiverCounts {
    int seen = 0;     ///< with a surface
    int diffuse = 0;  ///< of these, diffuse
    // Likewise; a given order leaves both to the records.
    int corrected = 0;   ///< missed by the order, so that rays correct the records
    int too_glossy = 0;  ///< missed, but too glossy for the cache
};

/// Arrays are [receiver], row by row of the image; zero where there is no surface, or as said.
struct Receivers {
    // What is there.
    std::vector<vec3> positions;  ///< world space
    std::vector<vec3> normals;    ///< shading normals, unit
    /// By normal maps, unit: records stand and reach by the smooth surface, light is scattered by
    /// these. Empty where no material has one.
    std::vector<vec3> mapped_normals;
    std::vector<float> footprints;    ///< the width that a receiver stands for, scene units
    std::vector<uint32_t> triangles;  ///< kNoPrimitive: no surface
    std::vector<int> materials;       ///< of the scene; kNoMaterial: no surface

    // What it reflects toward the viewer, and what comes from there whatever the records say.
    std::vector<vec3> diffuse;     ///< diffuse reflectance
    std::vector<vec3> f0;          ///< specular F0
    std::vector<float> f90;        ///< specular F90
    std::vector<float> roughness;  ///< perceptual
    std::vector<vec3> direct;      ///< radiance of direct light
    std::vector<vec3> emission;    ///< radiance; empty where no material emits and no sky shows

    // What light it wants of records.
    std::vector<int8_t> orders;    ///< kNoOrder, shared::DIFFUSE_ORDER or bands
    std::vector<uint8_t> by_rays;  ///< 1: rays correct the specular light, or, where the order is
                                   ///< that of a diffuse receiver, say all of it
    Lobes lobes;                   ///< of the glossy ones
    bool irradiance_only = false;  ///< specular light is not wanted
    std::vector<int> material_orders;  ///< per material of the scene
    ReceiverCounts counts;
    bool are_coats = false;  ///< of the surfaces there, which have normals of their own (coats.h)

    /// What they are the pixels of: from there they are seen, and there they are looked for
    /// (served.h). Of a lightmap its size alone.
    PixelGrid image;
    /// From where each is seen, as GBuffer::eye has it; empty where glass bends no ray.
    std::vector<vec3> eyes;

    // Of texels of a lightmap, which no one sees; of pixels empty, or zero.
    std::vector<vec3> outward;  ///< unit, the geometric normal on the side that is lit
    float extent = 0.0f;        ///< of all of them, scene units: what stands for an image's height
    /// Where they are looked for; of an image's pixels, those whose rays glass has bent.
    std::shared_ptr<const PointIndex> places;

    int count() const { return static_cast<int>(positions.size()); }
    /// By which receiver i scatters light.
    const vec3& scatteringNormal(size_t i) const {
        return mapped_normals.empty() ? normals[i] : mapped_normals[i];
    }
    /// Whether there is a surface.
    bool seen(size_t i) const { return footprints[i] > 0.0f; }
    /// From where it is seen: of a texel, from straight above.
    vec3 viewer(size_t i) const {
        return !outward.empty() ? positions[i] + footprints[i] * outward[i]
               : eyes.empty()   ? image.view.origin
                                : eyes[i];
    }
    /// Whether glass has bent the ray that sees it: it does not lie where the image shows it.
    bool isBent(size_t i) const { return !eyes.empty() && eyes[i] != image.view.origin; }
    /// Unit.
    vec3 towardViewer(size_t i) const { return glm::normalize(viewer(i) - positions[i]); }
    /// The height of the image at the receiver's distance, scene units.
    float height(size_t i) const {
        return outward.empty() ? footprints[i] * static_cast<float>(image.whole_height) : extent;
    }
    float alpha(size_t i) const { return shared::alphaFromRoughness(roughness[i]); }
    /// Where rays leave it, on the viewer's side.
    SurfaceSide sideAt(const Scene& scene, size_t i) const {
        return sideToward(scene, triangles[i], positions[i], viewer(i));
    }
    /// What its specular lobe reflects of constant light.
    vec3 specularAlbedo(size_t i) const;

    /// Whether rays correct what records say of it.
    bool isCorrected(size_t i) const {
        return by_rays[i] != 0 && orders[i] > shared::DIFFUSE_ORDER;
    }
    /// Whether rays say all of its specular light.
    bool isTooGlossy(size_t i) const {
        return by_rays[i] != 0 && orders[i] == shared::DIFFUSE_ORDER;
    }
    bool anyByRays() const {
        return std::any_of(by_rays.begin(), by_rays.end(),
                           [](uint8_t by_ray) { return by_ray != 0; });
    }
};

/// Those of a G-buffer, whose arrays become theirs, each classified (classes.h), with its lobe;
/// `irradiance_only`: all as diffuse. None goes by rays where a given `sh_order` asks for its
/// truncation; 0: orders by prediction; kLobesByRays: all that are not diffuse do. Environment
/// error where there are too many lobes.
Receivers receiversOf(const Scene& scene, GBuffer gbuffer, int sh_order, bool irradiance_only);

/// What the G-buffer says of them alone: of no class, without orders and lobes.
Receivers fieldsOf(GBuffer gbuffer);

/// About a thousand of them, by chance: what light is looked for from (placeElements()).
std::vector<ElementSite> someOf(const Scene& scene, const Receivers& receivers);

}  // namespace sheen
