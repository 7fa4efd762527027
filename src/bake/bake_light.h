// What a bake's gathers see: light of all kinds and bounces on the surfaces that they meet.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "bake/bake.h"
#include "gather/gatherer.h"
#include "light/scattered_again.h"

namespace sheen {

struct BakeLight {
    SceneLights lights;
    ScatteredOnce once;
    std::optional<ScatteredAgain> again;  ///< none of one bounce

    /// As another process wrote it.
    BakeLight(const Tracer& tracer, ByteReader in, int bounces);
    std::string written() const;
    /// `from`: points from which light will be looked for. The tracer must outlive it.
    BakeLight(const Tracer& tracer, std::span<const ElementSite> from, int bounces);

    /// By records of this accuracy. This must outlive it.
    std::unique_ptr<Gatherer> gatherer(float accuracy) const;
    /// The same by all ranks, and by what is in the log, if there is one. So must they.
    std::unique_ptr<Gatherer> gatherer(const BakeParams& params, const RankedJob& job) const;

    const OutgoingLight& outgoing() const {
        return again ? static_cast<const OutgoingLight&>(*again) : once;
    }
};

}  // namespace sheen
