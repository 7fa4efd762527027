// The light that leaves surfaces toward rays, and the sky: what records and the pixels' own rays
// gather. A new source of it is a class behind this interface.
#pragma once

#include <span>

#include "rays/tracer.h"

namespace sheen {

/// Safe to use from many threads. The tracer must outlive it.
class OutgoingLight {
  public:
    explicit OutgoingLight(const Tracer& tracer) : tracer_(tracer) {}
    virtual ~OutgoingLight() = default;
    OutgoingLight(const OutgoingLight&) = delete;
    OutgoingLight& operator=(const OutgoingLight&) = delete;

    const Tracer& tracer() const { return tracer_; }
    const Scene& scene() const { return tracer_.scene(); }

    /// For each ray: the radiance that arrives, and in w the distance it comes from, 0 where
    /// nothing is met. As many `seen` as rays. `planes`, `met`: as Tracer::meet() has planes and
    /// hits.
    void cast(const Rays& rays, vec4* seen, vec3* planes = nullptr, Hit* met = nullptr) const;

    /// So many rays are lit together, at the most: few hits of a packet lack light, those of many
    /// packets fill packets of shadow rays.
    static constexpr size_t kTogether = size_t{32} * Tracer::kPacket;

    /// The radiance that arrives along each of at most kTogether rays, which met `hits` (misses
    /// among them), whose weights count. As many `radiance` as rays.
    virtual void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const = 0;

  private:
    const Tracer& tracer_;
};

}  // namespace sheen
