// What filled hints say at receivers.
#include <algorithm>
#include <atomic>

#include "core/error.h"
#include "core/parallel.h"
#include "hints/hints.h"

namespace sheen {

// What arrives at each of at most Tracer::kPacket places, [place][kMostHintNumbers]: by the finest
// volume, within a cell of whose border the next one fades in.
void RadianceHints::lookUp(std::span<const HintGrid::Place> places, float* numbers,
                           int& unseen) const {
    std::array<float, Tracer::kPacket> left;
    left.fill(1.0f);
    for (size_t v = 0; v < volumes_.size(); ++v) {
        const Volume& volume = volumes_[v];
        const bool widest = v + 1 == volumes_.size();
        std::array<HintGrid::Place, Tracer::kPacket> asked{};
        std::array<size_t, Tracer::kPacket> of{};
        std::array<float, Tracer::kPacket> shares{};
        size_t count = 0;
        for (size_t i = 0; i < places.size(); ++i) {
            const float within = volume.grid.lattice().within(places[i].position);
            const float share = left[i] * (widest ? 1.0f : glm::clamp(within, 0.0f, 1.0f));
            if (share > 0.0f) {
                asked[count] = places[i];
                of[count] = i;
                shares[count++] = share;
                left[i] -= share;
            }
        }
        if (count == 0) {
            continue;
        }
        const auto anchors = volume.grid.anchors({asked.data(), count});
        for (size_t k = 0; k < count; ++k) {
            unseen += anchors[k] == HintGrid::kUnseen ? 1 : 0;
            float found[kMostHintNumbers] = {};
            float weights = 0.0f;
            volume.grid.forEachHint(
                asked[k], anchors[k], volume.grid.kernel(asked[k]), [&](int hint, float weight) {
                    const float* kept = &volume.light[static_cast<size_t>(hint) * stride()];
                    for (size_t j = 0; j < stride(); ++j) {
                        found[j] += weight * kept[j];
                    }
                    weights += weight;
                });
            for (size_t j = 0; j < stride(); ++j) {
                numbers[of[k] * kMostHintNumbers + j] += shares[k] / weights * found[j];
            }
        }
    }
}

vec3 RadianceHints::reflectedAt(const Receivers& receivers, size_t i, const float* numbers) const {
    const vec3& f0 = receivers.f0[i];
    const float f90 = receivers.f90[i];
    if (f0 == vec3(0.0f) && f90 == 0.0f) {
        return vec3(0.0f);
    }
    const vec3& n = receivers.scatteringNormal(i);
    const vec3 wo = receivers.towardViewer(i);
    float lobe[9];
    rotator_.rotate(brdfSh(glm::dot(n, wo), receivers.roughness[i]), (f0.x + f0.y + f0.z) / 3.0f,
                    f90, n, wo, lobe);
    return receivers.specularAlbedo(i) * hintThroughLobe(numbers, lobe, params_.order);
}

// Returns how many see no hint.
int RadianceHints::lightReceivers(const Receivers& receivers, size_t begin, size_t end,
                                  HintLight& light) const {
    std::array<HintGrid::Place, Tracer::kPacket> places{};
    std::array<size_t, Tracer::kPacket> of{};
    size_t count = 0;
    for (size_t i = begin; i < end; ++i) {
        if (receivers.seen(i)) {
            places[count] = {receivers.positions[i], receivers.normals[i],
                             receivers.sideAt(tracer_.scene(), i).start()};
            of[count++] = i;
        }
    }
    float numbers[Tracer::kPacket * kMostHintNumbers] = {};
    int unseen = 0;
    lookUp({places.data(), count}, numbers, unseen);
    for (size_t k = 0; k < count; ++k) {
        const float* own = &numbers[k * kMostHintNumbers];
        light.irradiance[of[k]] =
            hintIrradiance(own, receivers.scatteringNormal(of[k]), params_.order);
        light.reflected[of[k]] = reflectedAt(receivers, of[k], own);
    }
    return unseen;
}

HintLight RadianceHints::at(const Receivers& receivers) const {
    constexpr size_t kTogether = Tracer::kPacket;
    const auto count = static_cast<size_t>(receivers.count());
    HintLight light;
    light.irradiance.assign(count, vec3(0.0f));
    light.reflected.assign(count, vec3(0.0f));
    if (volumes_.empty()) {
        return light;
    }
    SHEEN_CHECK(!volumes_.back().light.empty());
    std::atomic<int> unseen = 0;
    parallelFor(
        static_cast<int>((count + kTogether - 1) / kTogether),
        [&](int packet) {
            const size_t begin = static_cast<size_t>(packet) * kTogether;
            unseen += lightReceivers(receivers, begin, std::min(begin + kTogether, count), light);
        },
        kHintGrain);
    light.unseen = unseen;
    return light;
}

}  // namespace sheen
