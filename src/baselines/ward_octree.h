// Records in an octree, and what they say together at a point. Based on: [WRC88], with the
// gradients of [WH92] and neighbour clamping of [KBPZ06].
#pragma once

#include <array>
#include <vector>

#include "baselines/ward_record.h"

namespace sheen {

/// What the records that serve a point say of it.
struct Interpolated {
    vec3 irradiance{0.0f};  ///< weighted mean; 0 where no record serves the point
    float weight = 0.0f;    ///< sum
    int records = 0;
};

/// Ward's estimate of a record's error at a point, relative to the irradiance there [WRC88, eq.
/// 10]:
///   e = |p - p_k| / R + sqrt(4 (1 - n.n_k));
/// infinite where the point lies off the record's tangent plane, before or behind it.
float wardError(const WardRecord& record, const vec3& p, const vec3& n);

/// Each record lies in the node whose cube holds its position and is the smallest that is as wide
/// as the sphere it serves: it then serves nothing farther than half a cube outside.
class WardOctree {
  public:
    /// `accuracy` is the largest error a record may serve at; `bounds` hold all records.
    WardOctree(const Bounds& bounds, float accuracy);

    /// Adds a record, and shortens its radius and its neighbours' where they differ by more than
    /// the distance between them, but none below the least it was given. [KBPZ06, sec. 4.3]
    void insert(const WardRecord& record, float least_radius);

    /// At a point of a surface, from all records with an error e below `accuracy`, which is at most
    /// the octree's own; weights 1 - e / accuracy. [TL04]
    Interpolated lookup(const vec3& p, const vec3& n, float accuracy) const;
    /// Whether any record serves the point; what lookup() finds, sooner.
    bool serves(const vec3& p, const vec3& n, float accuracy) const;

    const std::vector<WardRecord>& records() const { return records_; }

  private:
    struct Node {
        vec3 center{0.0f};
        float half = 0.0f;  // half a cube's side
        std::array<int, 8> children{-1, -1, -1, -1, -1, -1, -1, -1};
        std::vector<int> records;
    };
    // Calls visit(record index) for all records of nodes that reach(center, half) admits, until one
    // call answers true.
    template <class Reach, class Visit>
    bool anyOf(const Reach& reach, const Visit& visit) const;
    int nodeFor(const vec3& p, float reach);
    void clampNeighbours(int added);

    float accuracy_;
    std::vector<Node> nodes_;
    std::vector<WardRecord> records_;
    std::vector<float> least_radius_;
};

}  // namespace sheen
