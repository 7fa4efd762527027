#include "cache/raster_gather.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/timer.h"

namespace sheen {
namespace {

constexpr int kBatch = 16;  // records that one worker draws before it shades and reads back
// Error of coarser geometry that is accepted, in texels at the middle of a face.
constexpr float kLodTexels = 0.1f;

// How near the eye, in lifts of it, things are seen: records in corners lie as near to a wall as
// their pixel happens to. Reversed depth in floating point has digits to spare.
constexpr float kNearOverLift = 0.08f;

}  // namespace

// What one worker owns: framebuffers, programs and its time.
struct RasterGatherer::Worker {
    gl::Texture visibility, depth, radiance;
    gl::Framebuffer first, second;
    gl::VertexArray empty;
    gl::Program lambert;
    gl::Program shade;
    gl::Buffer views;
    ClusterDrawer drawer;
    std::vector<vec4> pixels;  // as read back: [y][record][x]
    SeenTexels seen;           // by one record
    GatherSeconds seconds;
};

RasterGatherer::RasterGatherer(gl::WorkerPool& pool, const Scene& scene, const GpuScene& gpu,
                               const HemisphereParams& params)
    : pool_(pool), gpu_(gpu), hemisphere_(makeHemisphere(params)) {
    near_ = kNearOverLift * surfaceOffset(scene);
    lift_ = surfaceOffset(scene);
    const float texel_angle = 2.0f * glm::length(hemisphere_.faces[0].right) /
                              static_cast<float>(hemisphere_.faces[0].width);
    lod_tolerance_ = kLodTexels * texel_angle;
    any_shaded_ = std::any_of(gpu.lit_triangles.begin(), gpu.lit_triangles.end(),
                              [](const LitTriangle& t) { return t.lambertian == 0; });
    workers_.resize(static_cast<size_t>(pool.size()));
    pool.run([&](int index) {
        using namespace gl;
        auto worker = std::make_unique<Worker>();
        const int width = kBatch * hemisphere_.width;
        const int height = hemisphere_.height;
        worker->visibility = makeTexture2d(GL_R32UI, width, height);
        worker->depth = makeTexture2d(GL_DEPTH_COMPONENT32F, width, height);
        worker->radiance = makeTexture2d(GL_RGBA32F, width, height);
        const GLuint visibility = worker->visibility.name();
        const GLuint radiance = worker->radiance.name();
        worker->first = makeFramebuffer({&visibility, 1}, worker->depth.name());
        worker->second = makeFramebuffer({&radiance, 1}, 0);
        worker->empty = makeVertexArray();
        worker->shade = Program("raster/fullscreen.vert", "gather/shade.frag", shadingDefines(1));
        worker->lambert = Program("raster/fullscreen.vert", "gather/lambert.frag");
        for (const Program* program : {&worker->shade, &worker->lambert}) {
            program->set("tile_width", hemisphere_.width);
            program->set("face_count", static_cast<int>(hemisphere_.faces.size()));
            for (size_t i = 0; i < hemisphere_.faces.size(); ++i) {
                const HemisphereFace& f = hemisphere_.faces[i];
                program->set(fmt::format("faces[{}]", i).c_str(),
                             vec4(f.x, f.y, f.width, f.height));
            }
        }
        worker->views = makeBuffer(std::span<const View>());
        worker->drawer = ClusterDrawer(gpu, "raster/visibility.frag");
        worker->pixels.resize(static_cast<size_t>(width) * height);
        worker->seen.light.resize(static_cast<size_t>(hemisphere_.texelCount()));
        workers_[static_cast<size_t>(index)] = std::move(worker);
    });
}

RasterGatherer::~RasterGatherer() {
    pool_.release([&](int index) { workers_[static_cast<size_t>(index)].reset(); });
}

GatherSeconds RasterGatherer::seconds() const {
    GatherSeconds mean;
    for (const auto& worker : workers_) {
        mean.see += worker->seconds.see / static_cast<double>(workers_.size());
        mean.project += worker->seconds.project / static_cast<double>(workers_.size());
    }
    return mean;
}

std::vector<GatheredRecord> RasterGatherer::gather(std::span<const RecordSite> sites) {
    projections_.prepare(hemisphere_, sites);
    std::vector<GatheredRecord> results(sites.size());
    const auto total = static_cast<int>(sites.size());
    const int round = kBatch * pool_.size();
    gl::DrawingPhases phases(pool_.size());
    // Which worker draws a batch has no effect; a record's place within its batch may, in the last
    // bit of where the rasteriser puts an edge, so that place depends on the site's index alone.
    pool_.run([&](int index) {
        Worker& w = *workers_[static_cast<size_t>(index)];
        gl::DrawingPhases::Member member(phases);
        for (int first = 0; first < total; first += round) {
            const int begin = std::min(first + kBatch * index, total);
            const std::span<const RecordSite> batch = sites.subspan(
                static_cast<size_t>(begin), static_cast<size_t>(std::min(kBatch, total - begin)));
            const Timer raster_timer;
            member.transfer([&] { upload(w, batch); });
            member.draw([&] { draw(w, static_cast<int>(batch.size())); });
            member.transfer([&] { readBack(w, static_cast<int>(batch.size())); });
            w.seconds.see += raster_timer.seconds();
            const Timer project_timer;
            integrate(w, batch, &results[static_cast<size_t>(begin)]);
            w.seconds.project += project_timer.seconds();
        }
    });
    return results;
}

void RasterGatherer::upload(Worker& w, std::span<const RecordSite> batch) const {
    std::vector<View> views;
    for (const RecordSite& site : batch) {
        const mat3 frame = tangentFrame(site.normal);
        const vec3 eye =
            offSurface(site.position, site.geometric_normal, site.toward_viewer, lift_);
        for (const HemisphereFace& f : hemisphere_.faces) {
            views.push_back(
                perspectiveView(eye, frame * f.right, frame * f.up, frame * f.forward, near_));
        }
    }
    w.drawer.setViews(gpu_, views, lod_tolerance_);
    gl::refillBuffer(w.views, std::span<const View>(views));
}

void RasterGatherer::draw(Worker& w, int records) const {
    using namespace gl;
    if (records == 0) {
        return;
    }
    const int faces = static_cast<int>(hemisphere_.faces.size());
    glBindFramebuffer(GL_FRAMEBUFFER, w.first.name());
    const GLuint none[4] = {0, 0, 0, 0};
    const float far_depth = 0.0f;
    glClearNamedFramebufferuiv(w.first.name(), GL_COLOR, 0, none);
    glClearNamedFramebufferfv(w.first.name(), GL_DEPTH, 0, &far_depth);
    glEnable(GL_DEPTH_TEST);
    for (int i = 0; i < records; ++i) {
        for (int f = 0; f < faces; ++f) {
            const HemisphereFace& face = hemisphere_.faces[static_cast<size_t>(f)];
            glViewport(i * hemisphere_.width + face.x, face.y, face.width, face.height);
            w.drawer.draw(i * faces + f);
        }
    }
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, w.second.name());
    const float black[4] = {};
    glClearNamedFramebufferfv(w.second.name(), GL_COLOR, 0, black);
    glViewport(0, 0, records * hemisphere_.width, hemisphere_.height);
    bindShading(gpu_, w.shade);
    glBindTextureUnit(1, w.visibility.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, w.views.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, gpu_.lit_triangle_buffer.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 8, gpu_.surface_light.name());
    glBindVertexArray(w.empty.name());
    if (any_shaded_) {
        drawFullscreen();
    }
    w.lambert.use();
    drawFullscreen();
}

void RasterGatherer::readBack(Worker& w, int records) const {
    if (records > 0) {
        gl::glReadPixels(0, 0, records * hemisphere_.width, hemisphere_.height, GL_RGBA, GL_FLOAT,
                         w.pixels.data());
    }
}

void RasterGatherer::integrate(Worker& w, std::span<const RecordSite> batch,
                               GatheredRecord* results) const {
    const size_t width = batch.size() * static_cast<size_t>(hemisphere_.width);
    for (size_t i = 0; i < batch.size(); ++i) {
        for (int y = 0; y < hemisphere_.height; ++y) {
            std::copy_n(&w.pixels[static_cast<size_t>(y) * width +
                                  i * static_cast<size_t>(hemisphere_.width)],
                        hemisphere_.width,
                        &w.seen.light[static_cast<size_t>(y * hemisphere_.width)]);
        }
        results[i] =
            integrateHemisphere(hemisphere_, w.seen, projections_.of(batch[i].order), batch[i]);
    }
}

}  // namespace sheen
