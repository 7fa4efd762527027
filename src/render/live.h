// An image that becomes better step by step, and begins anew as little as it can where its view,
// its light or its surfaces change. Based on: [GKB09, 8.7.2]: records serve all views, and so many
// new ones are gathered at a time.
#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "render/pixel_parts.h"
#include "render/render.h"

namespace sheen {

/// A record of the frame.
struct LiveMark {
    vec3 position, normal;
    float reach = 0;  ///< scene units, within which it serves
    int order = 0;
};

/// What the image is at the moment.
struct LiveProgress {
    int width = 0, height = 0;  ///< of the frame: less than asked for as long as it is coarse
    bool complete = false;      ///< as Session::render() would make it
    int records = 0;            ///< that serve the frame
    int records_new = 0;        ///< of these, gathered since it began
    int uncovered = 0;          ///< pixels that no record serves yet: hints light them
    double estimated_rel_rmse =
        std::numeric_limits<double>::quiet_NaN();  ///< of the indirect light, once it is complete;
                                                   ///< else NaN
    StageSeconds seconds;                          ///< of the last step
};

/// Not safe to use from many threads at once.
class LiveImage {
  public:
    /// `params`: of the image once it is complete: radiance or irradiance by rays; the camera, the
    /// size and all that changes is set later. Usage error for other methods, and as
    /// Session::render().
    LiveImage(Scene scene, const RenderParams& params);
    ~LiveImage();

    const Scene& scene() const;
    const RenderParams& params() const;
    const Camera& camera() const;

    /// Of these, what is the same keeps its records.
    void look(const Camera& camera);
    void setParams(const RenderParams& params);
    /// Changes lights, or what materials reflect or emit: all records go.
    void edit(const std::function<void(Scene&)>& change);

    /// Whether a step would change nothing.
    bool done() const;
    /// Works for about so many seconds, at the least on one frame: coarse where something has just
    /// changed, as fine as that time allows; finer with each step that follows.
    /// `outdated`, unless null: set by another thread when something is about to change; a step
    /// that refines what is seen then ends soon, without a frame, and the next begins anew. Whether
    /// there is another frame.
    bool step(double seconds, const std::atomic<bool>* outdated = nullptr);

    const Frame& frame() const;
    const LiveProgress& progress() const;
    /// Those that served the last frame before it was complete, or it, if it is not.
    std::vector<LiveMark> marks() const;
    /// Of a place of the image, (0, 0) its upper left, (1, 1) its lower right corner: of the whole
    /// image's pixel there, by the records of marks(). None before the first frame, and
    /// for a place outside.
    std::optional<PixelParts> partsAt(const vec2& place) const;
    /// Of the spherical harmonics that each pixel of the frame asks for.
    const Image<float>& orders() const;

  private:
    struct State;
    std::unique_ptr<State> s_;
};

}  // namespace sheen
