// Clear coats of what pixels see: surfaces of their own before the pixels', whose light is added to
// theirs. (The pixels' are dimmed by what the coats reflect: scene/layers.h.)
#pragma once

#include "light/direct.h"
#include "receivers/receivers.h"

namespace sheen {

/// Direct light of a G-buffer, that of its coats included; as traceDirect().
Image<vec3> directWithCoats(const Tracer& tracer, const SceneLights& lights, const GBuffer& gbuffer,
                            std::span<const uint32_t> rows_of = {});

/// The coats as receivers that rays alone serve; the others are seen by none. Only what rays of
/// receivers ask for is filled in.
Receivers coatsOf(const Scene& scene, const GBuffer& gbuffer);

}  // namespace sheen
