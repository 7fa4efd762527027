#include "cache/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "receivers/served.h"

namespace sheen {

Scan::Scan(const Receivers& receivers, const PlacementParams& params, bool anew, bool quiet)
    : receivers_(receivers),
      params_(params),
      anew_(anew),
      quiet_(quiet),
      stride_(params.coarsest_stride) {
    beginGrid();
}

void Scan::beginGrid() {
    at_ = passed_ = 0;
    progress_.reset();  // the last one's line ends before the next begins
    progress_ = std::make_unique<Progress>(
        stride_ == 1 ? "placing records, at every pixel"
                     : fmt::format("placing records, on a grid of {} pixels", stride_),
        receivers_.count(), quiet_);
}

// The receiver after i on the grid of every stride-th pixel of every stride-th row.
int Scan::nextOnGrid(int i) const {
    const int width = receivers_.image.width;
    const int x = i % width + stride_;
    return x < width ? i + stride_ : (i / width + stride_) * width;
}

// Placing a record may shorten the reach of others and uncover what lies behind the scan, so the
// last grid, all pixels, is scanned until nothing is missed. Every record keeps serving its own
// receiver, or that is given up, so this ends.
std::vector<SiteChoice> Scan::next(const PlacedRecords& placed) {
    while (true) {
        for (; at_ < receivers_.count(); at_ = nextOnGrid(at_)) {
            if (placed.coverage().missed(static_cast<size_t>(at_))) {
                progress_->advance(std::max(at_ - passed_, 0));
                passed_ = std::max(passed_, at_);
                placed_any_ = true;
                const int first = std::exchange(at_, nextOnGrid(at_));
                return choose(placed, first);
            }
        }
        at_ = 0;
        if (stride_ == 1 && !placed_any_) {
            return {};
        }
        placed_any_ = false;
        if (stride_ > 1) {
            stride_ /= 2;
            beginGrid();
        }
    }
}

// From `first` on: those that are missed and that no site chosen before them is predicted to serve.
std::vector<SiteChoice> Scan::choose(const PlacedRecords& placed, int first) const {
    struct Chosen {
        vec3 position, normal;
        float radius;
        int order;
    };
    std::vector<Chosen> chosen;
    std::vector<SiteChoice> choices;
    const WeightParams weight = params_.weight();
    for (int k = first; k < receivers_.count() && static_cast<int>(choices.size()) < params_.batch;
         k = nextOnGrid(k)) {
        const auto i = static_cast<size_t>(k);
        if (!placed.coverage().missed(i)) {
            continue;
        }
        const vec3& p = receivers_.positions[i];
        const vec3& n = receivers_.normals[i];
        const int order = receivers_.orders[i];
        const bool served = std::any_of(chosen.begin(), chosen.end(), [&](const Chosen& c) {
            return serves(c.order, order) &&
                   shared::recordWeight(weight, c.position, c.normal, c.radius, p, n,
                                        receivers_.footprints[i]) > shared::MIN_WEIGHT_SUM;
        });
        if (!served) {
            const NearestRecords nearest = placed.nearestTo(p);
            choices.push_back({.receiver = i,
                               .nearest = nearest,
                               .radius = placed.predictedRadius(i, nearest[0]),
                               .first = anew_ && stride_ == params_.coarsest_stride});
            chosen.push_back({p, n, choices.back().radius, order});
        }
    }
    return choices;
}

}  // namespace sheen
