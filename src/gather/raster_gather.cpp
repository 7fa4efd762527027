#include "gather/raster_gather.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/parallel.h"
#include "core/timer.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

constexpr int kBatch = 16;   // records that one worker draws before it shades and reads back
constexpr int kBatches = 4;  // drawn before they are integrated: what is kept in between
// Error of coarser geometry that is accepted, in texels at the middle of a face.
constexpr float kLodTexels = 0.1f;

// How near the eye, in lifts of it, things are seen: records in corners lie as near to a wall as
// their pixel happens to. Reversed depth in floating point has digits to spare.
constexpr float kNearOverLift = 0.08f;

// By how much a record's hemisphere is turned about its normal. In one frame for all, edges of the
// hemisphere's rows would cross what a room has in the same way for all records of a wall, which
// then err alike: stripes. A quarter of a turn is all there is: layouts have four like sides.
float turnOf(const RecordSite& site) { return 0.5f * kPi * randomPlace(site.seed, 0).x; }

// The plane of a triangle as seen from `eye` (SeenTexels); zero where it is seen from its edge.
vec3 planeFrom(const vec3& eye, const TrianglePlane& t) {
    const float height = glm::dot(t.normal, t.point - eye);
    return height != 0.0f ? t.normal / height : vec3(0.0f);
}

}  // namespace

// What one worker owns: framebuffers and programs.
struct RasterGatherer::Worker {
    gl::Texture visibility, depth, radiance;
    gl::Framebuffer first, second;
    gl::VertexArray empty;
    gl::Program shade;
    gl::Buffer views;
    ClusterDrawer drawer;
};

// What the records of a batch see, as it is read back: [y][record][x].
struct RasterGatherer::Drawn {
    std::vector<vec4> light;          // w: distance
    std::vector<uint32_t> triangles;  // + 1; 0: none
};

RasterGatherer::RasterGatherer(gl::WorkerPool& pool, const GpuScene& gpu,
                               const HemisphereParams& params)
    : pool_(pool), gpu_(gpu), hemisphere_(makeHemisphere(params)) {
    const float texel_angle = 2.0f * glm::length(hemisphere_.faces[0].right) /
                              static_cast<float>(hemisphere_.faces[0].width);
    lod_tolerance_ = kLodTexels * texel_angle;
    // Made once: fresh memory costs more than what is written there.
    const auto texels = static_cast<size_t>(hemisphere_.texelCount());
    drawn_.resize(kBatches);
    for (Drawn& drawn : drawn_) {
        drawn.light.resize(kBatch * texels);
        drawn.triangles.resize(kBatch * texels);
    }
    seen_.assign(size_t{kBatch} * kBatches,
                 {.light = std::vector<vec4>(texels), .planes = std::vector<vec3>(texels)});
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
        worker->shade = Program("gather/texel.vert", "gather/shade.frag", shadingDefines(gpu, 1));
        worker->shade.set("tile_width", static_cast<float>(hemisphere_.width));
        worker->shade.set("face_count", static_cast<int>(hemisphere_.faces.size()));
        for (size_t i = 0; i < hemisphere_.faces.size(); ++i) {
            const HemisphereFace& f = hemisphere_.faces[i];
            worker->shade.set(fmt::format("faces[{}]", i).c_str(),
                              vec4(f.x, f.y, f.width, f.height));
        }
        worker->views = makeBuffer(std::span<const View>());
        worker->drawer = ClusterDrawer(gpu, "raster/visibility.frag");
        workers_[static_cast<size_t>(index)] = std::move(worker);
    });
}

RasterGatherer::~RasterGatherer() {
    pool_.release([&](int index) { workers_[static_cast<size_t>(index)].reset(); });
}

std::vector<GatheredRecord> RasterGatherer::gather(std::span<const RecordSite> sites) {
    projections_.prepare(hemisphere_, sites);
    std::vector<GatheredRecord> results(sites.size());
    constexpr size_t kTogether = size_t{kBatch} * kBatches;
    for (size_t first = 0; first < sites.size(); first += kTogether) {
        const std::span<const RecordSite> some =
            sites.subspan(first, std::min(kTogether, sites.size() - first));
        const Timer see_timer;
        see(some);
        seconds_.see += see_timer.seconds();
        const Timer project_timer;
        parallelFor(static_cast<int>(some.size()), [&](int i) {
            const auto k = static_cast<size_t>(i);
            seenBy(some, k, seen_[k]);
            results[first + k] =
                integrateHemisphere(hemisphere_, seen_[k], projections_.of(some[k].order), some[k]);
        });
        seconds_.project += project_timer.seconds();
    }
    return results;
}

// Draws sites in batches, and reads back what they see.
void RasterGatherer::see(std::span<const RecordSite> sites) {
    const size_t batches = (sites.size() + kBatch - 1) / kBatch;
    gl::DrawingPhases phases(pool_.size());
    // Which worker draws a batch has no effect; a record's place within its batch may, in the last
    // bit of where the rasteriser puts an edge, so that place depends on the site's index alone.
    pool_.run([&](int index) {
        Worker& w = *workers_[static_cast<size_t>(index)];
        gl::DrawingPhases::Member member(phases);
        // All workers take part in every round, those that have nothing to draw as well.
        for (size_t round = 0; round < batches; round += static_cast<size_t>(pool_.size())) {
            const size_t batch = round + static_cast<size_t>(index);
            const size_t begin = std::min(batch * kBatch, sites.size());
            const std::span<const RecordSite> of_batch =
                sites.subspan(begin, std::min<size_t>(kBatch, sites.size() - begin));
            member.transfer([&] { upload(w, of_batch); });
            member.draw([&] { draw(w, static_cast<int>(of_batch.size())); });
            member.transfer([&] {
                if (!of_batch.empty()) {
                    readBack(w, static_cast<int>(of_batch.size()), drawn_[batch]);
                }
            });
        }
    });
}

void RasterGatherer::upload(Worker& w, std::span<const RecordSite> batch) const {
    std::vector<View> views;
    for (const RecordSite& site : batch) {
        const mat3 frame = tangentFrame(site.normal, turnOf(site));
        const vec3 eye = site.eye();
        const float near = kNearOverLift * site.offset;
        for (const HemisphereFace& f : hemisphere_.faces) {
            views.push_back(
                perspectiveView(eye, frame * f.right, frame * f.up, frame * f.forward, near));
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
    const int width = records * hemisphere_.width;
    glViewport(0, 0, width, hemisphere_.height);
    bindShading(gpu_, w.shade);
    w.shade.set("image_size", vec2(width, hemisphere_.height));
    glBindTextureUnit(1, w.visibility.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, w.views.name());
    glBindVertexArray(w.empty.name());
    glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, records * faces, 0);
}

void RasterGatherer::readBack(const Worker& w, int records, Drawn& drawn) const {
    const int width = records * hemisphere_.width;
    gl::glReadPixels(0, 0, width, hemisphere_.height, GL_RGBA, GL_FLOAT, drawn.light.data());
    gl::glBindFramebuffer(GL_FRAMEBUFFER, w.first.name());
    gl::glReadPixels(0, 0, width, hemisphere_.height, GL_RED_INTEGER, GL_UNSIGNED_INT,
                     drawn.triangles.data());
}

// What the record at sites[index] sees, of what its batch was drawn as. Directions below the
// surface, to where the shading normal's hemisphere may reach, bring nothing.
void RasterGatherer::seenBy(std::span<const RecordSite> sites, size_t index,
                            SeenTexels& seen) const {
    const Drawn& drawn = drawn_[index / kBatch];
    const RecordSite& site = sites[index];
    seen.turn = turnOf(site);
    const mat3 frame = tangentFrame(site.normal, seen.turn);
    const vec3 eye = site.eye();
    const vec3 n_g = site.geometric_normal * frame;  // into the record's frame
    const auto width = static_cast<size_t>(hemisphere_.width);
    const size_t in_batch = index % kBatch;
    const size_t records = std::min(sites.size() - (index - in_batch), size_t{kBatch});
    uint32_t last = 0;  // triangle + 1; neighbouring texels often see the same
    vec3 plane(0.0f);
    for (size_t t = 0; t < seen.light.size(); ++t) {
        const size_t pixel = (t / width * records + in_batch) * width + t % width;
        const uint32_t triangle = drawn.triangles[pixel];
        if (triangle == 0 || glm::dot(hemisphere_.directions[t], n_g) <= 0.0f) {
            seen.light[t] = vec4(0.0f);
            seen.planes[t] = vec3(0.0f);
            continue;
        }
        if (triangle != last) {
            last = triangle;
            plane = planeFrom(eye, gpu_.planes[triangle - 1]) * frame;
        }
        seen.light[t] = drawn.light[pixel];
        seen.planes[t] = plane;
    }
}

}  // namespace sheen
