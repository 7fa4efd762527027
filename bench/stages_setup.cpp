#include "stages_setup.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace sheen::bench {
namespace {

constexpr int kSites = 512;  // of a scene to gather in
constexpr int kSide = 512;

// Cuts every triangle into n * n alike. Those cut from one triangle share vertices with each other
// only.
Scene tessellated(const Scene& scene, int n) {
    Scene cut = scene;
    cut.positions.clear();
    cut.normals.clear();
    cut.uvs.clear();
    cut.triangles.clear();
    cut.materials_of.clear();
    for (size_t t = 0; t < scene.triangles.size(); ++t) {
        const uvec3& corners = scene.triangles[t];
        const auto first = static_cast<uint32_t>(cut.positions.size());
        const auto interpolate = [&corners](const auto& values, const vec3& b) {
            return b.x * values[corners.x] + b.y * values[corners.y] + b.z * values[corners.z];
        };
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; j <= n - i; ++j) {
                const vec3 b = vec3(n - i - j, i, j) / static_cast<float>(n);
                cut.positions.push_back(interpolate(scene.positions, b));
                cut.normals.push_back(glm::normalize(interpolate(scene.normals, b)));
                cut.uvs.push_back(interpolate(scene.uvs, b));
            }
        }
        // Row i holds n - i + 1 vertices.
        const auto index = [&](int i, int j) {
            return first + static_cast<uint32_t>(i * (n + 1) - i * (i - 1) / 2 + j);
        };
        const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
            cut.triangles.emplace_back(a, b, c);
            cut.materials_of.push_back(scene.materials_of[t]);
        };
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n - i; ++j) {
                add(index(i, j), index(i + 1, j), index(i, j + 1));
                if (j + 1 < n - i) {
                    add(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
                }
            }
        }
    }
    return cut;
}

// The same of every site: uniform light, which no neighbour disagrees with.
class MadeUpGatherer : public Gatherer {
  public:
    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override {
        std::vector<GatheredRecord> results(sites.size());
        for (size_t i = 0; i < sites.size(); ++i) {
            GatheredRecord& g = results[i];
            g.record.position = sites[i].position;
            g.record.normal = sites[i].normal;
            g.record.tangent = tangentFrame(sites[i].normal)[0];
            g.record.order = sites[i].order;
            g.record.irradiance = vec3(1.0f);
            g.record.radius = 1.0f;
            if (sites[i].order > 0) {
                const ShLayout layout = shLayout(sites[i].order);
                g.sh.assign(static_cast<size_t>(layout.size()), 0.0f);
                std::fill_n(g.sh.begin(), 3 * layout.coefficients(), 0.5f);
            }
        }
        return results;
    }
};

Receivers receiversOfOrder(const View512& view, int order) {
    Receivers receivers = receiversOf(view.scene, view.gbuffer, 0, true);
    for (int8_t& own : receivers.orders) {
        own = static_cast<int8_t>(own == kNoOrder ? kNoOrder : order);
    }
    receivers.irradiance_only = false;
    receivers.lobes = buildLobes(receivers);
    return receivers;
}

}  // namespace

GatherScene::GatherScene(const SceneChoice& choice, Scene made)
    : scene(choice.name, std::move(made), kSites),
      light(scene.tracer, nullptr, {}),
      yardstick(scene.scene) {}

Setup::Setup(std::string folder, int gl_workers)
    : folder_(std::move(folder)), gl_workers_(gl_workers) {}

Setup::~Setup() {
    if (pool_) {
        pool_->runOnFirst([this] { gpu_ = {}; });
    }
}

gl::WorkerPool& Setup::pool() {
    if (!pool_) {
        pool_ = std::make_unique<gl::WorkerPool>(gl_workers_, threadCount(), gl::kDefaultBackend);
    }
    return *pool_;
}

Scene Setup::load(const SceneChoice& choice) const {
    Scene scene = loadScene(folder_ + "/" + choice.file + ".glb");
    return choice.cuts > 1 ? tessellated(scene, choice.cuts) : scene;
}

const GatherScene& Setup::gatherScene(const SceneChoice& choice) {
    if (gather_name_ != choice.name) {
        gather_.reset();
        gather_ = std::make_unique<GatherScene>(choice, load(choice));
        gather_name_ = choice.name;
    }
    return *gather_;
}

const GpuScene& Setup::gpuScene(const SceneChoice& choice) {
    if (gpu_name_ != choice.name) {
        const Scene scene = load(choice);
        pool().runOnFirst([&] {
            gpu_ = {};
            gpu_ = uploadScene(scene);
        });
        renderShadowMaps(pool(), scene, gpu_);
        gpu_name_ = choice.name;
    }
    return gpu_;
}

const View512& Setup::glossyView() {
    if (!view_) {
        view_ = std::make_unique<View512>();
        view_->scene = load(kGlossyCornell);
        view_->gbuffer =
            renderGBuffer(Tracer(view_->scene), view_->scene.cameras.front(), kSide, kSide);
    }
    return *view_;
}

const MadeUpRecords& Setup::madeUpRecords(int order, int count) {
    const std::pair<int, int> wanted(order, count);
    if (!made_up_ || made_up_for_ != wanted) {
        made_up_ = std::make_unique<MadeUpRecords>(glossyView(), order, count);
        made_up_for_ = wanted;
    }
    return *made_up_;
}

MadeUpRecords::MadeUpRecords(const View512& view_, int order, int count)
    : view(view_), receivers(receiversOfOrder(view, order)) {
    // All records reach as many pixels; the count falls with the square of it.
    constexpr int kTries = 4;
    constexpr double kNear = 0.03;
    double reach = std::sqrt(receivers.counts.seen / static_cast<double>(count));
    for (int i = 0; i < kTries; ++i) {
        params.min_pixels = params.max_pixels = static_cast<float>(reach);
        field = {};
        placement = place(field);
        const double found = static_cast<double>(placement.cache.records.size()) / count;
        if (std::abs(found - 1.0) < kNear) {
            break;
        }
        reach *= std::sqrt(found);
    }
}

Placement MadeUpRecords::place(RecordField& field) const {
    MadeUpGatherer gatherer;
    return placeRecords(view.scene, receivers, params, gatherer, field, true);
}

}  // namespace sheen::bench
