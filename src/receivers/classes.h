// Which receivers pay for what: irradiance only, or spherical harmonics of how many bands.
#pragma once

#include "receivers/receivers.h"
#include "scene/scene.h"

namespace sheen {

/// A receiver is diffuse where replacing its specular lobe by a cosine of the same albedo is
/// predicted to change it by less than this share.
constexpr float kDiffuseBudget = 0.005f;
/// A material gets the smallest order whose truncated bands are predicted to change what it shows
/// by less than this share. Where they change a receiver by more, seen from where it is, rays
/// correct what its records say (reflectSpecular()).
constexpr float kTruncationBudget = 0.025f;
/// Of these receivers, those with a lobe of a smaller alpha are too glossy for the cache: their
/// rays say all, since what records miss would change from pixel to pixel as much as the light.
constexpr float kTooGlossy = 0.15f;

/// The order that `sh_order` (0: by prediction) gives a material; shared::DIFFUSE_ORDER for one
/// whose specular lobe never matters.
int materialOrder(const MaterialParams& material, int sh_order);
/// The same of a material with its textures, by so dark and smooth a texel that one in twenty is
/// darker or smoother: the darker the diffuse light, the more the lobe matters. (Receivers that
/// need less are diffuse again.)
int materialOrder(const Scene& scene, const Material& material, int sh_order);

/// Fills in materials, orders, by_rays and what is counted of them; lobes are not built.
void classify(const Scene& scene, int sh_order, bool irradiance_only, Receivers& receivers);

}  // namespace sheen
