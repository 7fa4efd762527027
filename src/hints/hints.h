// Radiance hints: light from the surroundings, kept in spherical harmonics at the points of a
// lattice; quick to make and to look up, and approximate. The light of a viewer's first image, and
// a method by itself (render/hints.h).
// Based on: [Pap11].
#pragma once

#include <memory>
#include <vector>

#include "core/bounces.h"
#include "hints/hint_grid.h"
#include "hints/hint_light.h"
#include "hints/lit_samples.h"
#include "receivers/receivers.h"
#include "sh/brdf_sh.h"

namespace sheen {

/// Defaults were chosen by measurement (docs/decisions/hints.md).
struct HintsParams {
    int hints = 4096;           ///< of each volume, about
    int samples = 1024;         ///< of lit surfaces, shared among all lights
    int order = 3;              ///< of the spherical harmonics: 2 (4 coefficients) or 3 (9)
    int bounces = kAllBounces;  ///< so often light is scattered before it arrives, at the most
};

/// Of so many hints, with as many samples as suit them.
HintsParams hintsParams(int hints);

/// What arrives at receivers, as [receiver]; zero where there is no surface.
struct HintLight {
    std::vector<vec3> irradiance;  ///< lux
    std::vector<vec3> reflected;   ///< radiance that the specular lobe sends to the viewer
    int unseen = 0;  ///< receivers that see no hint nearby, and have the light of those around
};

/// Volumes of hints in a scene: made once for its geometry, filled for its lights, asked by any
/// views. The same bits for any number of threads; random places follow from the place in the scene
/// alone, so that what does not change does not flicker.
class RadianceHints {
  public:
    /// The scene's bounds are a volume; so is each of `near`, boxes within them (nearBoxes()),
    /// smallest first, in finer cells. The tracer must outlive it. No hints without triangles.
    RadianceHints(const Tracer& tracer, const HintsParams& params,
                  const std::vector<Bounds>& near = {});
    RadianceHints(const RadianceHints&) = delete;
    RadianceHints& operator=(const RadianceHints&) = delete;

    /// Fills them with the light of the tracer's scene as it is: again where its lights or its sky
    /// changed. `lights` must be those of the scene, and is not kept. (What surfaces reflect was
    /// found when the hints were made.) `share`, in (0, 1]: of this light, what is left is what
    /// they held before; less steadies, and delays, what a moving light does from frame to frame.
    void fill(const SceneLights& lights, float share = 1.0f);

    /// What the hints say, once filled; the sky's light is part of it. Only what receivers say of
    /// place, normal and reflectances is asked, as fieldsOf() has it.
    HintLight at(const Receivers& receivers) const;

    size_t count() const;                                   ///< of hints, in all volumes
    size_t sampleCount() const { return samples_.size(); }  ///< of lit surfaces, that were found

  private:
    using Values = std::vector<float>;  // [hint][hintNumbers()]
    struct Volume {
        HintGrid grid;
        // [hint][look]: the hint that what was met asks for light, and whose volume's it is.
        std::vector<int> anchors = {};
        std::vector<uint8_t> volumes = {};
        Values light = {};  // of all bounces
    };

    size_t stride() const { return static_cast<size_t>(hintNumbers(params_.order)); }
    Values dark(const Volume& volume) const;
    size_t volumeAt(const vec3& p, size_t from) const;
    void anchorLooks(size_t volume);
    void anchorLooksOf(int hint, size_t volume);
    Values ofSky(const Volume& volume, const SkySamples& sky) const;
    Values ofSamples(const Volume& volume) const;
    void addSamples(const HintGrid& grid, int hint, float* sums) const;
    std::vector<Values> scattered(const std::vector<Values>& light) const;
    vec3 irradianceAtLook(const Volume& volume, size_t look, const HintLook& at,
                          const std::vector<Values>& light) const;
    void followBounces(std::vector<Values> last, std::vector<Values>& sum) const;

    void lookUp(std::span<const HintGrid::Place> places, float* numbers, int& unseen) const;
    vec3 reflectedAt(const Receivers& receivers, size_t i, const float* numbers) const;
    int lightReceivers(const Receivers& receivers, size_t begin, size_t end,
                       HintLight& light) const;

    const Tracer& tracer_;
    const HintsParams params_;
    std::vector<LitSample> samples_;
    std::vector<Volume> volumes_;  // finest first
    const BrdfRotator rotator_;
};

}  // namespace sheen
