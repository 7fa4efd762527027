// What is known of a frame of a scene that moves, for records that live longer than it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gather/anchors.h"
#include "gather/motion.h"

namespace sheen {

/// What a record says of light while it lives [GBP07].
enum class TemporalGradients {
    kNone,          ///< as it was gathered
    kExtrapolated,  ///< it goes on changing as it did from its first frame on
    kInterpolated,  ///< on the line to what is gathered at its end (recordAt())
};

struct TemporalParams {
    /// a_t: by how much of itself a record's light may change while it lives.
    float accuracy = 0.03f;
    int longest = 8;  ///< life, frames
    TemporalGradients gradients = TemporalGradients::kExtrapolated;
};

struct Ageing {
    TemporalParams params = {};
    std::vector<uint8_t> moved = {};  ///< [triangle]: since the frame before; empty: none has
    std::shared_ptr<const Motion> coming = {};  ///< up to the next frame; null: not known
    /// Records have no lives but are followed, by strata that are tied to these, for which the
    /// frame has begun; null: they have. `stands`: nothing but cameras differs from the frame
    /// before.
    std::shared_ptr<Anchors> anchors = {};
    bool stands = false;
};

}  // namespace sheen
