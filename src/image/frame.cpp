#include "image/frame.h"

namespace sheen {

Image<float> alpha(const Frame& frame) {
    Image<float> image(frame.width(), frame.height(), 1.0f);
    for (size_t i = 0; i < image.pixels.size() && !frame.shows_sky; ++i) {
        const bool seen = frame.primitive.pixels[i] != kNoPrimitive;
        image.pixels[i] = !frame.coverage.empty() ? frame.coverage.pixels[i] : seen ? 1.0f : 0.0f;
    }
    return image;
}

Image<vec3> beauty(const Frame& frame) {
    Image<vec3> sum(frame.width(), frame.height());
    for (const Image<vec3>* layer :
         {&frame.direct, &frame.indirect, &frame.caustic, &frame.emission}) {
        if (layer->empty()) {
            continue;
        }
        SHEEN_CHECK_EQ(layer->pixels.size(), sum.pixels.size());
        for (size_t i = 0; i < sum.pixels.size(); ++i) {
            sum.pixels[i] += layer->pixels[i];
        }
    }
    return sum;
}

std::vector<FrameLayer> layersOf(const Frame& frame) {
    using Kind = FrameLayer::Kind;
    // A reference knows the variance of that layer, which is of no use without it.
    const bool judged = !frame.indirect_diffuse_variance.empty();
    const FrameLayer all[] = {
        {"direct", "direct", Kind::kColor, false, true, &frame.direct},
        {"indirect", "indirect", Kind::kColor, false, true, &frame.indirect},
        {"indirect_diffuse", "indirect_diffuse", Kind::kColor, false, judged,
         &frame.indirect_diffuse},
        {"caustic", "caustic", Kind::kColor, false, true, &frame.caustic},
        {"variance", "variance", Kind::kColor, true, true, &frame.indirect_variance},
        {"variance_diffuse", "variance_diffuse", Kind::kColor, true, true,
         &frame.indirect_diffuse_variance},
        {"variance_direct", "variance_direct", Kind::kColor, true, true, &frame.direct_variance},
        {"variance_caustic", "variance_caustic", Kind::kColor, true, true, &frame.caustic_variance},
        {"variance_global", "variance_global", Kind::kColor, true, true, &frame.global_variance},
        {"emission", "emission", Kind::kColor, false, false, &frame.emission},
        {"albedo", "albedo", Kind::kColor, false, false, &frame.albedo},
        {"normal", "N", Kind::kVector, false, false, &frame.normal},
        {"position", "P", Kind::kVector, true, false, &frame.position},
        {"roughness", "roughness", Kind::kNumber, false, false, nullptr, &frame.roughness},
        {"depth", "Z", Kind::kDepth, true, false, nullptr, &frame.depth},
        {"weight", "weight", Kind::kNumber, true, false, nullptr, &frame.weight},
        {"records", "records", Kind::kNumber, true, false, nullptr, &frame.records},
        {"error", "error", Kind::kNumber, true, false, nullptr, &frame.error}};
    std::vector<FrameLayer> layers;
    for (const FrameLayer& layer : all) {
        if (layer.triples != nullptr ? !layer.triples->empty() : !layer.numbers->empty()) {
            layers.push_back(layer);
        }
    }
    return layers;
}

}  // namespace sheen
