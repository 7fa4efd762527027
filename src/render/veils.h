// Blended surfaces that the camera sees through, and what lies behind them: each rendered for
// itself, then put together.
#pragma once

#include "render/render.h"

namespace sheen {

/// A frame that begins as what lies behind all blended surfaces; those are added to it.
class VeiledFrame {
  public:
    /// `whole` is dimmed to its `share` of each pixel's light (empty: all of it), and is what the
    /// others are added to; it must outlive this.
    VeiledFrame(RenderResult& whole, const Image<vec3>& share);
    /// Adds a blended surface in each pixel. Where nothing lies behind, it says what is seen there.
    void add(RenderResult veil, const Image<vec3>& share);

  private:
    // What is known of an error that is relative to a mean: both as sums over pixels.
    struct Error {
        double squares = 0.0;
        bool known = false;

        void add(double rel_rmse, double light, double pixels);
        double relativeTo(double light, double pixels) const;
    };
    void count(const RenderResult& part);

    RenderResult& whole_;
    double light_ = 0.0;
    double pixels_ = 0.0;
    Error error_, low_, high_;
};

}  // namespace sheen
