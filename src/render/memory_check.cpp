#include "render/memory_check.h"

#include <algorithm>

#include "core/error.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "receivers/classes.h"
#include "splat/splat.h"

namespace sheen {
namespace {

// Or lightmaps in their place.
bool usesRecords(Method method) {
    return method == Method::kRadiance || method == Method::kIrradiance ||
           method == Method::kLightmap;
}

bool emits(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& material) { return material.emits(); });
}

// Bytes that so many pixels take, at the most (docs/stability.md).
uint64_t bytesOfPixels(const Scene& scene, const RenderParams& params, uint64_t pixels) {
    constexpr uint64_t kByPaths = 270;
    constexpr uint64_t kByRecords = 230;
    constexpr uint64_t kDrawn = 100;    // what OpenGL holds of pixels that are splatted together
    constexpr uint64_t kByRays = 320;   // what rays saw and how it is filtered
    constexpr uint64_t kOfEdges = 300;  // where half of the pixels have some, and strays
    constexpr uint64_t kOfLamps = 50;   // what their samples add up to
    constexpr uint64_t kOfCoats = 160;  // receivers of their own
    constexpr uint64_t kOfGlass = 60;   // from where pixels are seen, and where they lie
    constexpr uint64_t kOfMasks = 100;  // by material and object, all layers
    constexpr uint64_t kPerCoefficient = 4;  // of a lobe, here and as OpenGL has it
    const uint64_t masks = params.all_layers ? kOfMasks : 0;
    if (!usesRecords(params.method)) {
        return (kByPaths + masks) * pixels;
    }
    std::vector<bool> used(scene.materials.size(), false);
    for (const uint32_t material : scene.materials_of) {
        used[material] = true;
    }
    int order = 0;
    for (size_t i = 0; i < used.size() && params.method != Method::kIrradiance; ++i) {
        if (used[i]) {
            order = std::max(order, materialOrder(scene, scene.materials[i], params.sh_order));
        }
    }
    bool coated = false;
    for (size_t i = 0; i < used.size(); ++i) {
        coated = coated || (used[i] && scene.materials[i].layers.coat > 0.0f);
    }
    // Blended surfaces are rendered beside what lies behind them.
    bool blended = false;
    bool glass = false;
    for (size_t i = 0; i < used.size(); ++i) {
        blended = blended || (used[i] && scene.materials[i].blended);
        glass = glass || (used[i] && scene.materials[i].transmits());
    }
    const uint64_t each =
        kByRecords + masks + (params.aa > 1 ? kOfEdges : 0) + (emits(scene) ? kOfLamps : 0) +
        (order > shared::DIFFUSE_ORDER ? kByRays : 0) + (coated ? kByRays + kOfCoats : 0) +
        (glass ? kOfGlass : 0) +
        (params.method == Method::kRadiance ? kPerCoefficient * static_cast<uint64_t>(order * order)
                                            : 0);
    return (blended ? 2 : 1) * each * pixels + kDrawn * std::min<uint64_t>(pixels, kBandPixels);
}

}  // namespace

void checkRenderMemory(const Scene& scene, const RenderParams& params) {
    constexpr uint64_t kProgram = uint64_t{128} << 20;
    constexpr uint64_t kPerTriangle = 650;
    constexpr uint64_t kKept = uint64_t{112} << 20;  // light of more than one bounce
    constexpr uint64_t kKeptPerTriangle = 40;
    // With what each looks at, and its volume's share of what is found in between.
    constexpr uint64_t kPerHint = 3000;
    constexpr uint64_t kVolumes = 6;      // as many as nearBoxes() makes of large surroundings
    constexpr uint64_t kPerPhoton = 400;  // as it is found, and in the map
    const uint64_t pixels =
        static_cast<uint64_t>(params.width) * static_cast<uint64_t>(params.height);
    constexpr uint64_t kCells = uint64_t{16} << 20;  // of lamps', many lights' and the sky's light
    constexpr uint64_t kCellsPerTriangle = 28;
    const bool records = usesRecords(params.method);
    const bool keeps = records && params.bounces > 1;
    const uint64_t kept = keeps ? kKept + kKeptPerTriangle * scene.triangles.size() : 0;
    // Where photons start, and as they lie in the map, be they scattered many times.
    constexpr uint64_t kStartsPerTriangle = 160, kPerPhotonKept = 2500;
    const uint64_t by_photons = keeps && params.kept_by == KeptBy::kPhotons
                                    ? kStartsPerTriangle * scene.triangles.size() +
                                          kPerPhotonKept * static_cast<uint64_t>(params.photons)
                                    : 0;
    const uint64_t cells = records ? kCells + kCellsPerTriangle * scene.triangles.size() : 0;
    const bool caustics =
        records && findsCaustics(params.method, params.gather_road) && anySpecular(scene);
    const uint64_t photons = caustics ? kPerPhoton * static_cast<uint64_t>(params.caustics) : 0;
    const uint64_t hints = params.method == Method::kHints
                               ? kVolumes * kPerHint * static_cast<uint64_t>(params.hints)
                               : 0;
    checkMemory({.bytes = kProgram + bytesOfPixels(scene, params, pixels) + kept + by_photons +
                          cells + photons + hints + kPerTriangle * scene.triangles.size(),
                 .threads = threadCount()},
                fmt::format("an image of {}x{} pixels of {} triangles", params.width, params.height,
                            scene.triangles.size()),
                "choose a smaller --size or fewer --caustics or --hints, or fewer --threads below "
                "an address "
                "limit");
}

}  // namespace sheen
