#include "light/photon_starts.h"

#include <algorithm>
#include <numeric>

#include "light/triangle_grid.h"
#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

// Surfaces are divided into cells of this share of the scene, at most so many; each has
// two sides.
constexpr float kCellShare = 1.0f / 64.0f;
constexpr size_t kMostStartCells = 1u << 18u;
constexpr size_t kMostParts = 1024;
// A share of the photons starts anywhere.
constexpr double kAnywhere = 0.2;

void addPatches(const Scene& scene, uint32_t triangle, const TriangleGrid& grid, bool back,
                bool specular, std::vector<Patch>& patches) {
    constexpr float kTypicalCosine = 0.7f;
    const double area =
        TriangleEdges(scene, triangle).area() / static_cast<double>(grid.n * grid.n);
    const std::vector<vec2> corners = grid.corners();
    grid.forEachCell([&](uint32_t, const uvec3& c, const vec2& middle) {
        const MaterialParams material =
            materialAt(scene, triangle, vec3(1.0f - middle.x - middle.y, middle));
        const Brdf brdf = shared::makeBrdf(material, kTypicalCosine,
                                           brdfAlbedo(kTypicalCosine, material.roughness));
        const vec3 albedo = specularAlbedo(kTypicalCosine, material.roughness, brdf.f0, brdf.f90) +
                            (specular ? vec3(0.0f) : brdf.diffuse);
        // A texture's middle does not tell of all of the cell.
        constexpr double kLeast = 1e-3;
        patches.push_back({.triangle = triangle,
                           .back = back,
                           .corners = {corners[c.x], corners[c.y], corners[c.z]},
                           .likely = area * std::max<double>(luminance(albedo), kLeast)});
    });
}

}  // namespace

PhotonStarts::PhotonStarts(const Scene& scene, bool specular) {
    std::vector<uint8_t> wanted(scene.materials.size());
    for (size_t i = 0; i < wanted.size(); ++i) {
        wanted[i] = !specular || maybeSpecular(scene, scene.materials[i]) ? 1 : 0;
    }
    const std::vector<uint32_t> divisions = gridDivisions(scene, {}, kCellShare, kMostStartCells);
    for (const bool back : {false, true}) {
        for (uint32_t t = 0; t < divisions.size(); ++t) {
            if (wanted[scene.materials_of[t]] != 0) {
                addPatches(scene, t, {divisions[t]}, back, specular, patches_);
            }
        }
    }
    double all = 0.0;
    for (const Patch& patch : patches_) {
        all += patch.likely;
    }
    if (!(all > 0.0)) {  // none, or none that has an area
        patches_.clear();
        return;
    }
    // Small things near a lamp may matter as much as large ones.
    const size_t count = patches_.size();
    part_count_ = std::min(count, kMostParts);
    for (size_t i = 0; i < count; ++i) {
        patches_[i].likely = patches_[i].likely / all + 1.0 / static_cast<double>(count);
        parts_.push_back(static_cast<uint32_t>(i * part_count_ / count));
    }
    setLikelihoods(std::vector<double>(part_count_, 1.0));
}

PhotonStarts::Choice PhotonStarts::choose(double u) const {
    const auto above = std::upper_bound(sums_.begin() + 1, sums_.end() - 1, u);
    const auto patch = static_cast<size_t>(above - sums_.begin()) - 1;
    return {patch, sums_[patch + 1] - sums_[patch]};
}

void PhotonStarts::setLikelihoods(const std::vector<double>& factors) {
    sums_.assign(patches_.size() + 1, 0.0);
    for (size_t i = 0; i < patches_.size(); ++i) {
        sums_[i + 1] = sums_[i] + patches_[i].likely * factors[parts_[i]];
    }
    for (double& sum : sums_) {
        sum /= sums_.back() > 0.0 ? sums_.back() : 1.0;
    }
    sums_.back() = 1.0;
}

void PhotonStarts::heed(const std::vector<double>& light) {
    std::vector<double> likely(part_count_, 0.0);
    double all = 0.0;
    for (size_t i = 0; i < patches_.size(); ++i) {
        likely[parts_[i]] += patches_[i].likely;
        all += patches_[i].likely;
    }
    const double sum = std::accumulate(light.begin(), light.end(), 0.0);
    std::vector<double> factors(part_count_, 1.0);
    for (size_t part = 0; part < part_count_ && sum > 0.0; ++part) {
        factors[part] = light[part] / (sum * likely[part]) + kAnywhere / all;
    }
    setLikelihoods(factors);
}

}  // namespace sheen
