// Photons where they met surfaces, and the light that they stand for at a point: as many of them
// lie near it as light arrives. Based on: [Jen96]; how many are asked is chosen point by point, so
// that edges stay sharp and what lies between them has little noise [Sch03].
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

struct Photon {
    vec3 position;
    vec3 wi;     ///< unit, toward where it came from
    vec3 n_g;    ///< unit geometric normal of the surface, on the side it arrived on
    vec3 power;  ///< lumens
    uint32_t triangle;
    int scattered;  ///< so often, on the way here
};

/// Surfaces whose normals differ by more than this cosine are two: photons on one tell nothing of
/// the other.
constexpr float kOneSurfaceCosine = 0.7f;

/// Ways along a surface from a point, and how far each leads before a wall stands in it. What faces
/// as the point does is the surface going on, curved as it may be, and no wall.
struct WaysAlong {
    static constexpr int kCount = Tracer::kPacket;
    std::array<vec3, kCount> directions;  ///< unit, at right angles to n_g, evenly spread
    std::array<float, kCount> lengths;    ///< infinite: no wall

    WaysAlong(const Tracer& tracer, const SurfaceSide& point);
};

/// Safe to use from many threads.
class PhotonMap {
  public:
    /// Photons farther off than `reach` tell nothing of a point.
    PhotonMap(std::vector<Photon> photons, float reach);

    size_t size() const { return photons_.size(); }
    /// Those of a range of a kd-tree lie together: of [begin, end), and so on, the one in the
    /// middle parts the ranges before and behind it.
    std::span<const Photon> photons() const { return photons_; }

    /// What a surface gets by them, and how it scatters that.
    struct Light {
        vec3 irradiance{0.0f};  ///< by the shading normal
        vec3 reflected{0.0f};   ///< radiance, by the lobe, toward where the point is seen from
    };
    /// At a point whose unit shading normal is n. `lobe`: what is asked of it; a diffuse part does
    /// not count. `tracer`: finds the walls that stand near, on which no photon of this surface can
    /// lie.
    Light at(const Tracer& tracer, const SurfaceSide& point, const vec3& n, const Brdf* lobe) const;

  private:
    struct Near {
        float distance2;
        uint32_t photon;
        bool operator<(const Near& other) const {
            return distance2 != other.distance2 ? distance2 < other.distance2
                                                : photon < other.photon;
        }
    };
    struct Disc {
        size_t count = 0;
        float radius2 = 0;
    };
    void divide(size_t begin, size_t end);
    void find(const SurfaceSide& point, size_t begin, size_t end, std::vector<Near>& heap) const;
    Disc choose(std::span<const Near> near) const;
    float open(const Tracer& tracer, const SurfaceSide& point, float radius) const;

    // A balanced kd-tree: the photon in the middle of a range parts it along axes_[middle].
    std::vector<Photon> photons_;
    std::vector<uint8_t> axes_;
    float reach_;
    size_t fewest_, most_;
};

}  // namespace sheen
