// Punctual lights: few are asked one by one; where there are many, those that have a place are
// asked by chance, so that the hundredth costs little.
// Based on: [EK18] for the tree; [WFA05] for a cut through it, which opens what counts most.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "light/light_tree.h"
#include "rays/jitter.h"
#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

/// Safe to use from many threads.
class ManyLights {
  public:
    /// So many lights that have a place are asked one by one.
    static constexpr size_t kFew = 15;
    /// And so many, or parts of them all, at a pixel.
    static constexpr size_t kParts = 256;

    explicit ManyLights(const Scene& scene);

    /// What is asked one by one: all lights, or those that are infinitely far.
    std::span<const PunctualLight> each() const { return each_; }
    /// Whether nothing is left to ask by chance.
    bool empty() const { return tree_.empty(); }

    struct Sample {
        LightSample light;  ///< its irradiance over the probability of being chosen
        Way way;            ///< must be free
    };
    /// One of the others by a random number in [0, 1), for a surface from where it is not known to
    /// be dark: on the sides of its geometric normal and of the unit normal n. None where the
    /// number leads to lights that do not shine there.
    std::optional<Sample> sample(const SurfaceSide& surface, const vec3& n, float u) const {
        return sample(surface, n, tree_.choose(surface.start(), n, u));
    }
    /// Calls body(sample) for one of each of so many parts at the most, kParts or less, all lights
    /// among them: those that count most are parts by themselves, and leave nothing to chance. By
    /// random numbers of `seed`.
    template <class F>
    void forEachPart(const SurfaceSide& surface, const vec3& n, size_t most, uint32_t seed,
                     const F& body) const {
        std::array<uint32_t, kParts> nodes;
        const vec3 start = surface.start();
        const size_t count = tree_.cut(start, n, {nodes.data(), most});
        for (uint32_t i = 0; i < count; ++i) {
            const float u = randomPlace(seed, i).x;
            if (const auto s = sample(surface, n, tree_.choose(start, n, u, nodes[i]))) {
                body(*s);
            }
        }
    }

  private:
    std::optional<Sample> sample(const SurfaceSide& surface, const vec3& n,
                                 const std::optional<LightTree::Choice>& choice) const;

    std::vector<PunctualLight> each_, others_;
    LightTree tree_;  // of others_
};

}  // namespace sheen
