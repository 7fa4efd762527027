// How surfaces move from one frame to the next, and what that makes of what a record sees: its
// light in the coming frame, without a ray cast for it.
// Based on: [GBP07], whose reprojection follows [WDP99]; here texels look for what comes to them,
// where there each sample goes to its new texel, which leaves gaps in what comes nearer.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gather/site.h"
#include "hemisphere/hemisphere.h"
#include "rays/tracer.h"

namespace sheen {

/// [triangle]: 1 where a vertex lies elsewhere in the other positions, [vertex].
std::vector<uint8_t> movedTriangles(const Scene& scene, std::span<const vec3> positions);

/// Safe to use from many threads.
class Motion {
  public:
    /// Where the vertices of a scene will lie, [vertex]; its triangles stay as they are.
    Motion(const Scene& scene, std::span<const vec3> next);

    /// Whether a triangle of the scene moves.
    bool moves(uint32_t triangle) const { return moves_[triangle] != 0; }
    bool any() const { return now_.tracer != nullptr; }

    /// What the texels of a record's hemisphere, `light` (radiance; w: distance, 0: nothing seen),
    /// will see in the next frame. Where something that moves will be nearer than what stands still
    /// there, it is seen, with the radiance that the same point has now or, if that is hidden now,
    /// with the mean of what is seen of all that moves; where something went away the nearest
    /// texel of what stands still fills the gap. None where nothing that is seen moves.
    /// Light that changes on surfaces that stand still is not foreseen, nor is a site that moves
    /// itself.
    std::optional<std::vector<vec4>> reproject(const Hemisphere& hemisphere, const RecordSite& site,
                                               std::span<const vec4> light) const;

  private:
    // The triangles that move, in one of the frames.
    struct Moving {
        Scene scene;
        std::unique_ptr<Tracer> tracer;  // none where there are no triangles

        vec3 at(const Hit& hit) const;
    };
    std::vector<uint8_t> moves_;  // [triangle]
    Moving now_, then_;
};

}  // namespace sheen
