// What surfaces receive from each other, kept so that rays need not look for it again.
#pragma once

#include <optional>

#include "light/elements.h"

namespace sheen {

/// Safe to use from many threads.
class KeptLight {
  public:
    KeptLight() = default;
    virtual ~KeptLight() = default;
    KeptLight(const KeptLight&) = delete;
    KeptLight& operator=(const KeptLight&) = delete;

    /// The irradiance of light that surfaces have scattered once at least, and less often than the
    /// bounces asked for by `followed` and one. None where nothing is kept near.
    virtual std::optional<vec3> irradiance(const ElementSite& at, int followed) const = 0;
    /// So many values are kept.
    virtual size_t size() const = 0;
    /// For another process of the same scene: each kind reads what it wrote.
    virtual void write(ByteWriter& out) const = 0;
};

}  // namespace sheen
