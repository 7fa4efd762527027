#include "cache/classes.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "cache/record.h"
#include "core/parallel.h"
#include "scene/brdf_albedo.h"
#include "sh/brdf_sh.h"

namespace sheen {
namespace {

// Predictions over view cosine and roughness, looked up per pixel.
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
    std::vector<vec4> texels =
        linearTexels(scene, scene.textures[static_cast<size_t>(use.texture)]);
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
        const Brdf brdf = shared::makeBrdf(material, albedo);
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

PixelClasses classifyPixels(const Scene& scene, const GBuffer& gbuffer, int sh_order,
                            bool irradiance_only) {
    PixelClasses classes;
    classes.orders = Image<int>(gbuffer.width, gbuffer.height, kNoOrder);
    classes.by_rays = Image<uint8_t>(gbuffer.width, gbuffer.height);
    classes.materials = Image<int>(gbuffer.width, gbuffer.height, kNoMaterial);
    classes.irradiance_only = irradiance_only;
    for (const Material& material : scene.materials) {
        classes.material_orders.push_back(
            irradiance_only ? shared::DIFFUSE_ORDER : materialOrder(scene, material, sh_order));
    }
    std::atomic<int> corrected_count = 0;
    std::atomic<int> too_glossy_count = 0;
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            const int i = y * gbuffer.width + x;
            if (!gbuffer.seen(i)) {
                continue;
            }
            int& order = classes.orders.at(x, y);
            const uint32_t material = scene.materials_of[gbuffer.primitive.at(x, y)];
            classes.materials.at(x, y) = static_cast<int>(material);
            order = classes.material_orders[material];
            if (order == shared::DIFFUSE_ORDER) {
                continue;
            }
            const vec4 normal = gbuffer.normal.at(x, y);
            const vec3 wo = glm::normalize(gbuffer.view.origin - vec3(gbuffer.position.at(x, y)));
            const float NoV = glm::dot(vec3(normal), wo);
            const vec4 diffuse = gbuffer.diffuse.at(x, y);
            const float share = specularShare(vec3(diffuse), gbuffer.f0.at(x, y), diffuse.w,
                                              brdfAlbedo(NoV, normal.w));
            const LobePrediction& p = predictions().at(NoV, normal.w);
            if (share * p.as_diffuse < kDiffuseBudget) {
                order = shared::DIFFUSE_ORDER;
            } else if (share * p.truncated[order] > kTruncationBudget) {
                const bool too_glossy = shared::alphaFromRoughness(normal.w) < kTooGlossy;
                ++(too_glossy ? too_glossy_count : corrected_count);
                if (sh_order == 0) {
                    classes.by_rays.at(x, y) = 1;
                    order = too_glossy ? shared::DIFFUSE_ORDER : order;
                }
            }
        }
    });
    classes.corrected = corrected_count;
    classes.too_glossy = too_glossy_count;
    for (size_t i = 0; i < classes.orders.pixels.size(); ++i) {
        const int order = classes.orders.pixels[i];
        classes.geometry += order != kNoOrder ? 1 : 0;
        classes.diffuse += order == shared::DIFFUSE_ORDER && classes.by_rays.pixels[i] == 0 ? 1 : 0;
    }
    return classes;
}

}  // namespace sheen
