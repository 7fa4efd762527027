#include "render/crop.h"

#include <algorithm>

#include "core/error.h"

namespace sheen {
namespace {

// Pixels around a part that are rendered with it: as far as filters look.
constexpr int kMargin = 16;

template <class T>
void cut(Image<T>& image, const Crop& crop) {
    if (image.empty()) {
        return;
    }
    Image<T> part(crop.size.x, crop.size.y);
    for (int y = 0; y < crop.size.y; ++y) {
        const auto from = image.pixels.begin() +
                          (static_cast<ptrdiff_t>(crop.first.y + y) * image.width + crop.first.x);
        std::copy(from, from + crop.size.x,
                  part.pixels.begin() + static_cast<ptrdiff_t>(y) * crop.size.x);
    }
    image = std::move(part);
}

void cut(Frame& frame, const Crop& crop) {
    for (Image<vec3>* layer :
         {&frame.direct, &frame.indirect, &frame.indirect_diffuse, &frame.emission, &frame.albedo,
          &frame.normal, &frame.position, &frame.indirect_variance,
          &frame.indirect_diffuse_variance, &frame.direct_variance, &frame.caustic,
          &frame.caustic_variance, &frame.global_variance}) {
        cut(*layer, crop);
    }
    for (Image<float>* layer : {&frame.coverage, &frame.roughness, &frame.depth, &frame.weight,
                                &frame.records, &frame.error}) {
        cut(*layer, crop);
    }
    std::vector<Fragment> fragments;
    for (Fragment fragment : frame.fragments) {
        const auto width = static_cast<uint32_t>(frame.primitive.width);
        const ivec2 at = ivec2(fragment.pixel % width, fragment.pixel / width) - crop.first;
        if (glm::all(glm::greaterThanEqual(at, ivec2(0))) &&
            glm::all(glm::lessThan(at, crop.size))) {
            fragment.pixel = static_cast<uint32_t>(at.y * crop.size.x + at.x);
            fragments.push_back(fragment);
        }
    }
    frame.fragments = std::move(fragments);
    cut(frame.primitive, crop);
}

}  // namespace

RenderParams paramsOfPart(const RenderParams& params, const Crop& crop) {
    const ivec2 whole(params.width, params.height);
    // In this order no sum overflows.
    if (glm::any(glm::lessThan(crop.first, ivec2(0))) ||
        glm::any(glm::lessThan(crop.size, ivec2(1))) ||
        glm::any(glm::greaterThan(crop.size, whole)) ||
        glm::any(glm::greaterThan(crop.first, whole - crop.size))) {
        throwUsage("--crop {},{},{},{}: must lie in the image, which has {}x{} pixels",
                   crop.first.x, crop.first.y, crop.size.x, crop.size.y, whole.x, whole.y);
    }
    const int margin = params.method == Method::kReference ? 0 : kMargin;
    const ivec2 from = glm::max(crop.first - margin, 0);
    const ivec2 to = glm::min(crop.first + crop.size + margin, whole);
    RenderParams part = params;
    part.width = to.x - from.x;
    part.height = to.y - from.y;
    part.window = {.first = from, .whole = whole};
    return part;
}

RenderResult renderPart(Session& session, const RenderParams& params, const Crop& crop) {
    const RenderParams part = paramsOfPart(params, crop);
    RenderResult result = session.render(part);
    cut(result.frame, {.first = crop.first - part.window.first, .size = crop.size});
    return result;
}

}  // namespace sheen
