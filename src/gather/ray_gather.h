// Gathering by rays: one through each texel of a record's hemisphere, at a random place within it,
// and more where light changes, as its neighbours and records nearby saw. Records that serve more
// pixels have more texels.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/error.h"
#include "gather/integrate.h"
#include "gather/strata.h"
#include "light/outgoing.h"

namespace sheen {

/// Texels along the side of the hemisphere of a record that reaches so many pixels (RecordSite),
/// where `usual` are asked for: `usual`, also where the reach is not known (0), or an even number.
int sideForReach(int usual, float reach);

/// Gathers on all threads; the results depend on the sites alone. The light must outlive
/// it.
class RayGatherer : public Gatherer {
  public:
    /// A hemicube alone: rays go through a face's texels, and a border's stand for what lies
    /// beyond.
    /// `without_caustics`: records know nothing of those (Rays).
    RayGatherer(const OutgoingLight& light, const HemisphereParams& params,
                bool without_caustics = false, BelowHorizon below = BelowHorizon::kContinued)
        : light_(light), params_(params), without_caustics_(without_caustics), below_(below) {
        SHEEN_CHECK(params.kind == HemisphereKind::kHemicube);
    }

    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override;

    void lookAheadBy(const Motion& motion) override { motion_ = &motion; }
    std::vector<float> changesSince(std::span<const GatheredRecord* const> records) override;
    void keepStrata(Anchors& anchors) override;
    void follow(std::span<GatheredRecord* const> records, bool turned) override;

    /// Rays cast so far from records, those from what they met to the lights not counted.
    int64_t rays() const { return rays_cast_; }

  private:
    struct Resolution {
        Hemisphere hemisphere;
        ProjectionMatrices projections;
    };
    struct Seen {
        SeenTexels texels;
        std::vector<Contrast> contrasts;
        std::vector<GatheredRecord::Witness> witnesses;
        int64_t rays = 0;
        std::shared_ptr<Strata> strata = {};
        MetByRays met = {};  // of those
    };
    Resolution& resolutionOf(int side, std::span<const RecordSite> sites);
    GatheredRecord followed(const Resolution& resolution, MetByRays& met, GatheredRecord& before,
                            bool turned) const;
    bool keepsStrata(const RecordSite& site) const;
    void tieTogether(std::span<Strata* const> strata, std::span<MetByRays> met);
    void tieGathered(std::span<const Resolution* const> resolutions, std::span<Seen> seen);
    std::vector<const Resolution*> prepare(std::span<const RecordSite> sites);
    Seen see(const Hemisphere& h, const RecordSite& site, uint32_t seed,
             std::span<const Contrast> found) const;
    std::vector<vec4> witness(std::span<const GatheredRecord::Witness> witnesses,
                              const vec3& eye) const;
    std::vector<GatheredRecord::Witness> witnessesOf(std::span<const vec3> directions,
                                                     std::span<const float> solid_angles,
                                                     const vec3& eye) const;
    float changeSince(const GatheredRecord& record) const;
    void lookAhead(const Resolution& resolution, SeenTexels& seen, const RecordSite& site,
                   GatheredRecord& result) const;

    const OutgoingLight& light_;
    HemisphereParams params_;
    bool without_caustics_;
    BelowHorizon below_;
    const Motion* motion_ = nullptr;         // none: nothing is known of the next frame
    Anchors* anchors_ = nullptr;             // none: strata are not kept
    std::map<int, Resolution> resolutions_;  // by texels along the side
    int64_t rays_cast_ = 0;
};

}  // namespace sheen
