#include "receivers/classes.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/parallel.h"
#include "scene/brdf_albedo.h"
#include "sh/brdf_sh.h"

namespace sheen {
namespace {

// Predictions over view cosine and roughness, looked up per receiver.
class PredictionTable {
  public:
    PredictionTable() {
        for (int y = 0; y < kRoughness; ++y) {
            for (int x = 0; x < kMu; ++x) {
                const float root = static_cast<float>(x) / (kMu - 1);
                entries_[y][x] =
                    predictLobeError(root * root, static_cast<float>(y) / (kRoughness - 1));
            }
        }
    }
    const LobePrediction& at(float NoV, float roughness) const {
        const int x = static_cast<int>(std::sqrt(std::clamp(NoV, 0.0f, 1.0f)) * (kMu - 1) + 0.5f);
        const int y = static_cast<int>(std::clamp(roughness, 0.0f, 1.0f) * (kRoughness - 1) + 0.5f);
        return entries_[y][x];
    }

  private:
    static constexpr int kMu = 24;
    static constexpr int kRoughness = 48;
    LobePrediction entries_[kRoughness][kMu];
};

const PredictionTable& predictions() {
    static const PredictionTable table;
    return table;
}

float mean(const vec3& v) { return (v.x + v.y + v.z) / 3.0f; }

// Share of the specular lobe in what a surface reflects of constant light.
float specularShare(const vec3& diffuse, const vec3& f0, float f90, const vec2& albedo_ab) {
    const float specular = mean(f0) * albedo_ab.x + f90 * albedo_ab.y;
    return specular / std::max(specular + mean(diffuse), 1e-12f);
}

// Of a texture's texels the one by whose `value` one in kLower is lower.
template <class Value>
vec4 lowTexel(const Scene& scene, const TextureUse& use, const Value& value) {
    constexpr size_t kLower = 20;
    const Texture& texture = scene.textures[static_cast<size_t>(use.texture)];
    std::vector<vec4> texels =
        linearTexels(scene.images[static_cast<size_t>(texture.image)], texture.srgb);
    const auto low = texels.begin() + static_cast<std::ptrdiff_t>(texels.size() / kLower);
    std::nth_element(texels.begin(), low, texels.end(),
                     [&](const vec4& a, const vec4& b) { return value(a) < value(b); });
    return *low;
}

}  // namespace

int materialOrder(const MaterialParams& material, int sh_order) {
    // Views spread over the hemisphere; grazing ones count, as floors are seen that way.
    constexpr float kViews[] = {0.95f, 0.75f, 0.5f, 0.3f};
    float worst[shared::SH_MAX_ORDER + 1] = {};
    float as_diffuse = 0.0f;
    for (float NoV : kViews) {
        const vec2 albedo = brdfAlbedo(NoV, material.roughness);
        const Brdf brdf = shared::makeBrdf(material, NoV, albedo);
        const float share = specularShare(brdf.diffuse, brdf.f0, brdf.f90, albedo);
        const LobePrediction& p = predictions().at(NoV, material.roughness);
        for (int n = 1; n <= shared::SH_MAX_ORDER; ++n) {
            worst[n] = std::max(worst[n], share * p.truncated[n]);
        }
        as_diffuse = std::max(as_diffuse, share * p.as_diffuse);
    }
    if (as_diffuse < kDiffuseBudget) {
        return shared::DIFFUSE_ORDER;
    }
    if (sh_order > 0) {
        return sh_order;
    }
    int order = 3;
    while (order < shared::SH_MAX_ORDER && worst[order] > kTruncationBudget) {
        ++order;
    }
    return order;
}

int materialOrder(const Scene& scene, const Material& material, int sh_order) {
    MaterialParams params = material.params;
    const TextureUse& color = material.textures[shared::TEXTURE_BASE_COLOR];
    if (color.used()) {
        params.base_color *=
            vec3(lowTexel(scene, color, [](const vec4& texel) { return luminance(vec3(texel)); }));
    }
    const TextureUse& rough = material.textures[shared::TEXTURE_METALLIC_ROUGHNESS];
    if (rough.used()) {
        params.roughness *= lowTexel(scene, rough, [](const vec4& texel) { return texel.y; }).y;
        const float metallic = params.metallic;
        params.metallic =
            metallic * lowTexel(scene, rough, [](const vec4& texel) { return -texel.z; }).z;
        const int most_metallic = materialOrder(params, sh_order);
        params.metallic =
            metallic * lowTexel(scene, rough, [](const vec4& texel) { return texel.z; }).z;
        return std::max(most_metallic, materialOrder(params, sh_order));
    }
    return materialOrder(params, sh_order);
}

void classify(const Scene& scene, int sh_order, bool irradiance_only, Receivers& receivers) {
    const size_t all = receivers.positions.size();
    receivers.orders.assign(all, kNoOrder);
    receivers.by_rays.assign(all, 0);
    receivers.materials.assign(all, kNoMaterial);
    receivers.irradiance_only = irradiance_only;
    receivers.material_orders.clear();
    for (const Material& material : scene.materials) {
        receivers.material_orders.push_back(
            irradiance_only ? shared::DIFFUSE_ORDER : materialOrder(scene, material, sh_order));
    }
    std::atomic<int> corrected = 0;
    std::atomic<int> too_glossy = 0;
    constexpr int kGrain = 256;
    parallelFor(
        receivers.count(),
        [&](int k) {
            const auto i = static_cast<size_t>(k);
            if (!receivers.seen(i)) {
                return;
            }
            const uint32_t material = scene.materials_of[receivers.triangles[i]];
            receivers.materials[i] = static_cast<int>(material);
            const int order = receivers.material_orders[material];
            receivers.orders[i] = static_cast<int8_t>(order);
            if (order == shared::DIFFUSE_ORDER) {
                return;
            }
            const float NoV = glm::dot(receivers.normals[i], receivers.towardViewer(i));
            const float roughness = receivers.roughness[i];
            const float share = specularShare(receivers.diffuse[i], receivers.f0[i],
                                              receivers.f90[i], brdfAlbedo(NoV, roughness));
            const LobePrediction& p = predictions().at(NoV, roughness);
            if (share * p.as_diffuse < kDiffuseBudget) {
                receivers.orders[i] = shared::DIFFUSE_ORDER;
            } else if (sh_order == kLobesByRays) {
                ++too_glossy;
                receivers.by_rays[i] = 1;
                receivers.orders[i] = static_cast<int8_t>(shared::DIFFUSE_ORDER);
            } else if (share * p.truncated[order] > kTruncationBudget) {
                const bool glossy = receivers.alpha(i) < kTooGlossy;
                ++(glossy ? too_glossy : corrected);
                if (sh_order == 0) {
                    receivers.by_rays[i] = 1;
                    receivers.orders[i] =
                        glossy ? static_cast<int8_t>(shared::DIFFUSE_ORDER) : receivers.orders[i];
                }
            }
        },
        kGrain);
    receivers.counts = {.corrected = corrected, .too_glossy = too_glossy};
    for (size_t i = 0; i < all; ++i) {
        const int order = receivers.orders[i];
        receivers.counts.seen += order != kNoOrder ? 1 : 0;
        receivers.counts.diffuse +=
            order == shared::DIFFUSE_ORDER && receivers.by_rays[i] == 0 ? 1 : 0;
    }
}

}  // namespace sheen
