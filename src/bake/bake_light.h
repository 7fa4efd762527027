// What a bake's gathers see: light of all kinds and bounces on the surfaces that they meet.
#pragma once

#include <optional>
#include <span>

#include "light/scattered_again.h"

namespace sheen {

struct BakeLight {
    SceneLights lights;
    ScatteredOnce once;
    std::optional<ScatteredAgain> again;  ///< none of one bounce

    /// `from`: points from which light will be looked for. The tracer must outlive it.
    BakeLight(const Tracer& tracer, std::span<const ElementSite> from, int bounces);

    const OutgoingLight& outgoing() const {
        return again ? static_cast<const OutgoingLight&>(*again) : once;
    }
};

}  // namespace sheen
