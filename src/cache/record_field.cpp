#include "cache/record_field.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "cache/reach.h"
#include "cache/temporal.h"

namespace sheen {
namespace {

constexpr int kNowhere = -1;

// A record lies at a receiver where it is on the same smooth surface within its footprint.
constexpr float kSameSurfaceCosine = 0.95f;
constexpr float kSamePlane = 0.5f;  // footprints

// What the lobe of a record's own pixel sees counts for one that looks from elsewhere as long as
// the directions differ by less than this, radians: the narrowest lobe that coefficients follow
// (kTooGlossy) is some ten times as wide.
constexpr float kSameDirection = 0.01f;

bool liesAt(const Receivers& receivers, size_t i, const GatheredRecord& found) {
    const Record& k = found.record;
    if (!receivers.seen(i) || receivers.orders[i] != k.order ||
        glm::dot(receivers.normals[i], k.normal) < kSameSurfaceCosine) {
        return false;
    }
    const vec3 d = k.position - receivers.positions[i];
    const float slant = std::abs(glm::dot(k.normal, receivers.towardViewer(i)));
    return std::abs(glm::dot(d, k.normal)) <= kSamePlane * receivers.footprints[i] &&
           glm::length(d) * slant <= receivers.footprints[i];
}

// Where light changes within a pixel, a record speaks for its own place alone: taken for that of
// the pixel's middle, it would be wrong there and on the pixels beside it.
bool reachesTooLittle(const Receivers& receivers, int pixel, const GatheredRecord& found,
                      const PlacementParams& params) {
    constexpr float kSamePlace = 0.1f;  // footprints
    const auto i = static_cast<size_t>(pixel);
    const float footprint = receivers.footprints[i];
    const float allowed = allowedRadius(found, params, receivers.height(i));
    return allowed * params.accuracy <= params.min_pixels * footprint &&
           glm::length(found.record.position - receivers.positions[i]) > kSamePlace * footprint;
}

// The receiver that a record lies at; kNowhere where it is not seen.
int receiverOf(const Receivers& receivers, const GatheredRecord& found) {
    const PixelGrid& image = receivers.image;
    const vec3 c = viewCoordinates(image.view, found.record.position);
    if (!(c.z > 0.0f)) {
        return kNowhere;
    }
    const float x = (0.5f * c.x / c.z + 0.5f) * static_cast<float>(image.width);
    const float y = (0.5f * c.y / c.z + 0.5f) * static_cast<float>(image.height);
    if (!(x >= 0.0f && x < static_cast<float>(image.width) && y >= 0.0f &&
          y < static_cast<float>(image.height))) {
        return kNowhere;
    }
    const size_t i = image.index(static_cast<int>(x), static_cast<int>(y));
    return liesAt(receivers, i, found) ? static_cast<int>(i) : kNowhere;
}

}  // namespace

NearestRecords nearestOf(const RecordField& field, const vec3& p, size_t except) {
    std::array<std::pair<float, size_t>, kNearestRecords> found;
    found.fill({kInfinity, kNoRecord});
    for (size_t k = 0; k < field.records.size(); ++k) {
        const vec3 d = field.records[k].record.position - p;
        const std::pair candidate(glm::dot(d, d), k);
        if (k != except && candidate < found.back()) {
            found.back() = candidate;
            std::sort(found.begin(), found.end());
        }
    }
    NearestRecords nearest;
    std::transform(found.begin(), found.end(), nearest.begin(),
                   [](const auto& each) { return each.second; });
    return nearest;
}

void addContrasts(const RecordField& field, const NearestRecords& nearest, RecordSite& site) {
    for (const size_t k : nearest) {
        if (k != kNoRecord) {
            const std::vector<Contrast>& found = field.records[k].contrasts;
            site.contrasts.insert(site.contrasts.end(), found.begin(), found.end());
        }
    }
}

RecordField KeptRecords::take(const Receivers& receivers, const PlacementParams& params) {
    RecordField field;
    field.gather_size = gather_size_;
    std::vector<uint8_t> taken(receivers.positions.size(), 0);
    std::vector<GatheredRecord> left;
    for (GatheredRecord& found : records_) {
        const int pixel = receiverOf(receivers, found);
        if (pixel == kNowhere || reachesTooLittle(receivers, pixel, found, params) ||
            std::exchange(taken[static_cast<size_t>(pixel)], 1) != 0) {
            left.push_back(std::move(found));
            continue;
        }
        const vec3 toward = receivers.towardViewer(static_cast<size_t>(pixel));
        if (glm::length(toward - found.toward_viewer) > kSameDirection) {
            found.lobe_texels = 0.0f;
        }
        field.records.push_back(std::move(found));
        field.pixels.push_back(pixel);
    }
    field.reused = field.records.size();
    records_ = std::move(left);
    latest_ = 0;
    return field;
}

void KeptRecords::put(RecordField field) {
    latest_ = 0;
    if (field.records.empty()) {
        return;
    }
    gather_size_ = records_.empty() ? field.gather_size : std::min(gather_size_, field.gather_size);
    std::move(field.records.begin(), field.records.end(), std::back_inserter(records_));
    latest_ = field.records.size();
}

void KeptRecords::dropToLatest(size_t most) {
    if (records_.size() > most) {  // what views have seen goes to the end
        records_.erase(records_.begin(), records_.end() - static_cast<ptrdiff_t>(most));
        latest_ = 0;
    }
}

void KeptRecords::beginFrame(Ageing ageing, bool older) {
    for (GatheredRecord& found : records_) {
        if (older) {
            growOlder(found, ageing.params);
        }
    }
    ageing_ = std::move(ageing);
}

void KeptRecords::forgetEnded() {
    latest_ = 0;
    std::erase_if(records_, [](const GatheredRecord& found) {
        return found.lifespan > 0 && found.age >= found.lifespan;
    });
}

}  // namespace sheen
