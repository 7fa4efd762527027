#include "image/cryptomatte.h"

#include <fmt/format.h>
#include <murmurhash.h>

#include <algorithm>
#include <bit>
#include <map>
#include <nlohmann/json.hpp>

namespace sheen {
namespace {

constexpr size_t kMostRanks = 6;

struct Share {
    uint32_t name = 0;
    float coverage = 0;
};

void add(uint32_t name, float coverage, std::vector<Share>& shares) {
    const auto known = std::find_if(shares.begin(), shares.end(),
                                    [name](const Share& s) { return s.name == name; });
    if (known == shares.end()) {
        shares.push_back({name, coverage});
    } else {
        known->coverage += coverage;
    }
}

// Of a pixel, those that cover more first.
class Coverage {
  public:
    Coverage(const Frame& frame, const MatteNames& names) : frame_(frame), names_(names) {
        for (size_t i = 0; i < frame.fragments.size(); ++i) {
            first_.try_emplace(frame.fragments[i].pixel, i);
        }
    }

    std::vector<Share> of(size_t pixel) const {
        std::vector<Share> shares;
        const auto first = first_.find(static_cast<uint32_t>(pixel));
        if (first == first_.end()) {
            if (frame_.primitive.pixels[pixel] != kNoPrimitive) {
                shares.push_back({names_.of[frame_.primitive.pixels[pixel]], 1.0f});
            }
            return shares;
        }
        const std::vector<Fragment>& all = frame_.fragments;
        for (size_t i = first->second; i < all.size() && all[i].pixel == pixel; ++i) {
            add(names_.of[all[i].primitive], all[i].coverage, shares);
        }
        std::stable_sort(shares.begin(), shares.end(),
                         [](const Share& a, const Share& b) { return a.coverage > b.coverage; });
        return shares;
    }

  private:
    const Frame& frame_;
    const MatteNames& names_;
    std::map<uint32_t, size_t> first_;  // fragment of a pixel
};

std::string hexadecimal(float identifier) {
    return fmt::format("{:08x}", std::bit_cast<uint32_t>(identifier));
}

}  // namespace

float matteIdentifier(const std::string& name) {
    uint32_t hash = 0;
    lmmh_x86_32(name.data(), static_cast<unsigned int>(name.size()), 0, &hash);
    // Neither zero, infinite nor no number.
    const uint32_t exponent = hash >> 23 & 0xff;
    return std::bit_cast<float>(exponent == 0 || exponent == 0xff ? hash ^ 1u << 23 : hash);
}

Matte makeMatte(const Frame& frame, const MatteNames& names) {
    const Coverage coverage(frame, names);
    Matte matte{.layer = names.layer, .manifest = {}, .ranks = {}};
    nlohmann::json manifest = nlohmann::json::object();
    std::vector<float> identifiers;
    for (const std::string& name : names.names) {
        identifiers.push_back(matteIdentifier(name));
        manifest[name] = hexadecimal(identifiers.back());
    }
    matte.manifest = manifest.dump();
    matte.ranks.emplace_back(frame.width(), frame.height());
    for (size_t pixel = 0; pixel < frame.primitive.pixels.size(); ++pixel) {
        const std::vector<Share> shares = coverage.of(pixel);
        for (size_t k = 0; k < std::min(shares.size(), kMostRanks); ++k) {
            if (k / 2 == matte.ranks.size()) {
                matte.ranks.emplace_back(frame.width(), frame.height());
            }
            vec4& two = matte.ranks[k / 2].pixels[pixel];
            const int at = k % 2 == 0 ? 0 : 2;
            two[at] = identifiers[shares[k].name];
            two[at + 1] = shares[k].coverage;
        }
    }
    return matte;
}

}  // namespace sheen
