#include "render/veils.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math.h"

namespace sheen {
namespace {

constexpr Image<vec3> Frame::*kLights[] = {
    &Frame::direct, &Frame::indirect, &Frame::indirect_diffuse, &Frame::caustic, &Frame::emission};

void dim(Frame& frame, const Image<vec3>& share) {
    for (Image<vec3> Frame::*light : kLights) {
        for (size_t i = 0; i < (frame.*light).pixels.size(); ++i) {
            (frame.*light).pixels[i] *= share.pixels[i];
        }
    }
}

// What `from` sees in a pixel, `to` sees there.
template <class T>
void copyPixel(const Image<T>& from, size_t i, Image<T>& to) {
    if (!to.empty()) {
        to.pixels[i] = from.pixels[i];
    }
}

void showInstead(const Frame& from, size_t i, Frame& to) {
    for (Image<vec3> Frame::*layer : {&Frame::albedo, &Frame::normal, &Frame::position}) {
        copyPixel(from.*layer, i, to.*layer);
    }
    for (Image<float> Frame::*layer :
         {&Frame::roughness, &Frame::depth, &Frame::weight, &Frame::records}) {
        copyPixel(from.*layer, i, to.*layer);
    }
    copyPixel(from.primitive, i, to.primitive);
}

}  // namespace

void VeiledFrame::Error::add(double rel_rmse, double light, double pixels) {
    if (!std::isnan(rel_rmse) && pixels > 0.0) {
        const double of_pixel = rel_rmse * light / pixels;
        squares += of_pixel * of_pixel * pixels;
        known = true;
    }
}

double VeiledFrame::Error::relativeTo(double light, double pixels) const {
    return known && light > 0.0 ? std::sqrt(squares / pixels) / (light / pixels)
                                : std::numeric_limits<double>::quiet_NaN();
}

// Its light has been dimmed.
void VeiledFrame::count(const RenderResult& part) {
    double light = 0.0;
    double pixels = 0.0;
    for (size_t i = 0; i < part.frame.indirect.pixels.size(); ++i) {
        if (part.frame.primitive.pixels[i] != kNoPrimitive) {
            light += luminance(part.frame.indirect.pixels[i]);
            pixels += 1.0;
        }
    }
    light_ += light;
    pixels_ = std::max(pixels_, pixels);
    error_.add(part.stats.estimated_rel_rmse, light, pixels);
    low_.add(part.stats.estimate_low, light, pixels);
    high_.add(part.stats.estimate_high, light, pixels);
}

VeiledFrame::VeiledFrame(RenderResult& whole, const Image<vec3>& share) : whole_(whole) {
    if (!share.empty()) {
        dim(whole.frame, share);
        count(whole);
        // Before nothing, panes cover what they stop.
        Frame& frame = whole.frame;
        frame.coverage = alpha(frame);
        for (size_t i = 0; i < share.pixels.size(); ++i) {
            if (frame.primitive.pixels[i] == kNoPrimitive) {
                frame.coverage.pixels[i] =
                    std::max(frame.coverage.pixels[i], 1.0f - passingShare(share.pixels[i]));
            }
        }
    }
}

void VeiledFrame::add(RenderResult veil, const Image<vec3>& share) {
    dim(veil.frame, share);
    count(veil);
    Frame& frame = whole_.frame;
    for (Image<vec3> Frame::*light : kLights) {
        for (size_t i = 0; i < (frame.*light).pixels.size(); ++i) {
            (frame.*light).pixels[i] += (veil.frame.*light).pixels[i];
        }
    }
    for (size_t i = 0; i < frame.primitive.pixels.size(); ++i) {
        if (frame.primitive.pixels[i] == kNoPrimitive) {
            showInstead(veil.frame, i, frame);
        }
    }
    RenderStats& stats = whole_.stats;
    const RenderStats& of_veil = veil.stats;
    stats.seconds = of_veil.seconds;
    stats.records += of_veil.records;
    stats.records_of_clusters += of_veil.records_of_clusters;
    stats.edge_records += of_veil.edge_records;
    stats.pixels_edges += of_veil.pixels_edges;
    stats.pixels_uncovered += of_veil.pixels_uncovered;
    stats.negative_pixels += of_veil.negative_pixels;
    stats.passes += of_veil.passes;
    stats.gather_size = std::max(stats.gather_size, of_veil.gather_size);
    stats.accuracy = std::min(stats.accuracy, of_veil.accuracy);
    stats.estimated_rel_rmse = error_.relativeTo(light_, pixels_);
    stats.estimate_low = low_.relativeTo(light_, pixels_);
    stats.estimate_high = high_.relativeTo(light_, pixels_);
}

}  // namespace sheen
