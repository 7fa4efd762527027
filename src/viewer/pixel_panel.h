// A pixel that was picked, its records, and what the heaviest of them sees.
#pragma once

#include <memory>

#include "viewer/live_thread.h"

namespace sheen {

class PixelPanel {
  public:
    /// Draws nothing before a pixel was picked, and after the panel was closed until another is.
    void draw(const std::shared_ptr<const PixelParts>& parts, float exposure, ToneCurve tone);

  private:
    std::shared_ptr<const PixelParts> parts_;
    bool open_ = false;
    Image<Rgb8> hemisphere_, reconstruction_;
};

}  // namespace sheen
