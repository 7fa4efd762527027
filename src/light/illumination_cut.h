// Light kept by photons: their tree is cut where its nodes say well enough what arrives, and what
// arrives there is kept. Based on: [WWZ09, 3.3]. Beyond it nodes whose photons lie on surfaces
// that face elsewhere are opened too, and what lies off a node's plane is not asked of it: thin
// walls and creases keep their sides apart.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "light/kept_light.h"
#include "light/photon_map.h"
#include "light/scene_lights.h"

namespace sheen {

/// A cut through one tree of photons. Safe to use from many threads.
class IlluminationCut {
  public:
    IlluminationCut(const Tracer& tracer, const PhotonMap& map);

    explicit IlluminationCut(ByteReader& in);
    void write(ByteWriter& out) const;

    size_t size() const { return elements_.size(); }
    /// By the nodes around; none where no node is.
    std::optional<vec3> irradiance(const ElementSite& at) const;

  private:
    struct Node;
    struct Range;
    static Node nodeOf(const Tracer& tracer, const PhotonMap& map, const Range& range);

    Elements elements_;  // the nodes: where they are, and what hides points from them
    std::vector<vec3> irradiances_;
};

/// Light of all bounces, or of few, by photons.
class PhotonLight : public KeptLight {
  public:
    /// By `count` photons that start. `bounces`: as WaysOn has them.
    PhotonLight(const Tracer& tracer, const SceneLights& lights, int count, int bounces);

    explicit PhotonLight(ByteReader& in);

    std::optional<vec3> irradiance(const ElementSite& at, int followed) const override;
    size_t size() const override;
    void write(ByteWriter& out) const override;

  private:
    int bounces_;
    std::vector<IlluminationCut> cuts_;  // [rays followed]; of all bounces one
};

}  // namespace sheen
