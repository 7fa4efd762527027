#include "light/elements.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/directions.h"
#include "core/hash.h"

namespace sheen {
namespace {

// Normals that differ more belong to another surface: the other side of a crease.
constexpr float kSameSurface = 0.8f;
// So far off the plane between both normals, over the element's reach, lies another surface.
constexpr float kSamePlane = 0.15f;
// No point that an element counts for lies farther off its own plane, over its reach: of that on a
// sphere whose normal differs so much.
constexpr float kOffSurface = 0.5f;

float offPlane(const vec3& d, const vec3& n, const vec3& other) {
    return 0.5f * std::abs(glm::dot(d, n + other));
}

}  // namespace

Elements::Elements(ByteReader& in)
    : elements_(in.get<std::vector<Element>>()),
      levels_(in.get<std::vector<Level>>()),
      voxels_(in.get<std::vector<Voxel>>()),
      filled_(in.get<size_t>()),
      links_(in.get<std::vector<Link>>()) {}

void Elements::write(ByteWriter& out) const {
    out.put(elements_);
    out.put(levels_);
    out.put(voxels_);
    out.put(filled_);
    out.put(links_);
}

size_t Elements::sector(const mat3& frame, const vec3& direction) {
    const float x = glm::dot(direction, frame[0]);
    const float y = glm::dot(direction, frame[1]);
    return (x < 0.0f ? 1u : 0u) + (y < 0.0f ? 2u : 0u) + (std::abs(x) < std::abs(y) ? 4u : 0u);
}

float Elements::Element::weight(const vec3& p, const vec3& n) const {
    const float reach = kReach * site.spacing;
    const vec3 d = p - site.side.position;
    const float distance2 = glm::dot(d, d);
    const float cosine = glm::dot(n, site.normal);
    if (distance2 >= reach * reach || cosine <= kSameSurface ||
        offPlane(d, n, site.normal) > kSamePlane * reach) {
        return 0.0f;
    }
    const float height = glm::dot(d, site.normal);
    const float way = free[sector(d)];
    if (distance2 - height * height > way * way) {
        return 0.0f;
    }
    const float nearness = 1.0f - std::sqrt(distance2) / reach;
    return nearness * nearness * (cosine - kSameSurface) / (1.0f - kSameSurface);
}

uint64_t Elements::keyOf(int level, const vec3& scaled) {
    // Of voxels that share a key by chance, each finds the elements of both, which weigh nothing.
    constexpr uint64_t kMask = (uint64_t{1} << 18u) - 1;
    const auto part = [](float x) {
        return static_cast<uint64_t>(static_cast<int64_t>(std::floor(x))) & kMask;
    };
    return (static_cast<uint64_t>(level + 512) << 54u) | (part(scaled.x) << 36u) |
           (part(scaled.y) << 18u) | part(scaled.z);
}

size_t Elements::slotOf(uint64_t key) const {
    const size_t mask = voxels_.size() - 1;
    size_t slot = splitMix(key) & mask;
    while (voxels_[slot].first != kNone && voxels_[slot].key != key) {
        slot = (slot + 1) & mask;
    }
    return slot;
}

void Elements::enter(uint64_t key, const Link& link) {
    if (2 * filled_ >= voxels_.size()) {
        std::vector<Voxel> old(2 * voxels_.size());
        old.swap(voxels_);
        for (const Voxel& voxel : old) {
            if (voxel.first != kNone) {
                voxels_[slotOf(voxel.key)] = voxel;
            }
        }
    }
    Voxel& voxel = voxels_[slotOf(key)];
    filled_ += voxel.first == kNone ? 1 : 0;
    links_.push_back(link);
    links_.back().next = voxel.first;
    voxel = {.key = key, .first = static_cast<uint32_t>(links_.size() - 1)};
}

bool Elements::lacks(const ElementSite& site) const {
    bool lacking = true;
    forEachAround(site.side.position, [&](size_t i) {
        if (!lacking) {
            return;
        }
        const Element& e = elements_[i];
        const vec3 d = site.side.position - e.site.side.position;
        lacking = glm::dot(d, d) >= e.site.spacing * e.site.spacing ||
                  e.weight(site.side.position, site.normal) <= 0.0f;
    });
    return lacking;
}

void Elements::add(const ElementSite& site) {
    Element element{.site = site, .frame = tangentFrame(site.normal), .free = {}};
    element.free.fill(kInfinity);
    elements_.push_back(element);
    index(elements_.size() - 1);
}

void Elements::index(size_t i) {
    const ElementSite& site = elements_[i].site;
    const float reach = kReach * site.spacing;
    // No voxel is smaller than what floats tell apart there, nor than 18 bits of a key hold.
    const float least =
        std::max(0x1p-16f * maxAbs(site.side.position), std::numeric_limits<float>::min());
    const int log = std::ilogb(std::max(reach, least));
    const int level = log + (log & 1);  // every other one: fewer to look into
    const float scale = std::ldexp(1.0f, -level);
    const vec3 lower = glm::floor((site.side.position - reach) * scale);
    const vec3 upper = glm::floor((site.side.position + reach) * scale);
    for (float z = lower.z; z <= upper.z; ++z) {
        for (float y = lower.y; y <= upper.y; ++y) {
            for (float x = lower.x; x <= upper.x; ++x) {
                // Nothing of its surface's plane lies in the others.
                const vec3 middle = (vec3(x, y, z) + 0.5f) / scale - site.side.position;
                if (std::abs(glm::dot(middle, site.normal)) <=
                    kOffSurface * reach + 0.87f / scale) {
                    enter(keyOf(level, vec3(x, y, z)), {.position = site.side.position,
                                                        .reach2 = reach * reach,
                                                        .element = static_cast<uint32_t>(i),
                                                        .next = kNone});
                }
            }
        }
    }
    const auto place = std::find_if(levels_.begin(), levels_.end(),
                                    [&](const Level& l) { return l.level >= level; });
    if (place == levels_.end() || place->level != level) {
        levels_.insert(place, {.level = level, .scale = scale});
    }
}

void Elements::reindex() {
    std::fill(voxels_.begin(), voxels_.end(), Voxel{});
    filled_ = 0;
    links_.clear();
    levels_.clear();
    for (size_t i = 0; i < elements_.size(); ++i) {
        index(i);
    }
    sortLinks();
}

// Each voxel's list lies in one piece.
void Elements::sortLinks() {
    std::vector<Link> sorted;
    sorted.reserve(links_.size());
    for (Voxel& voxel : voxels_) {
        uint32_t next = std::exchange(
            voxel.first, voxel.first == kNone ? kNone : static_cast<uint32_t>(sorted.size()));
        while (next != kNone) {
            sorted.push_back(links_[next]);
            next = links_[next].next;
            sorted.back().next = next == kNone ? kNone : static_cast<uint32_t>(sorted.size());
        }
    }
    links_.swap(sorted);
}

void Elements::know(size_t i, const Ways& free, float spacing) {
    elements_[i].free = free;
    elements_[i].site.spacing = std::min(elements_[i].site.spacing, spacing);
}

}  // namespace sheen
