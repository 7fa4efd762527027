#include "cli/bake_probes.h"

#include <filesystem>

#include "bake/light_probes.h"
#include "cli/options.h"
#include "cli/output.h"
#include "core/timer.h"
#include "image/exr.h"

namespace sheen::cli {
namespace {

HintLattice probeLattice(const std::string& text, const Bounds& box) {
    const ProbeSpacing spacing = parseProbes(text);
    return spacing.counts ? lightProbeLattice(box, *spacing.counts)
                          : lightProbeLattice(box, spacing.space);
}

// As THREE.LightProbe.toJSON() has them: nine times red, green and blue.
Json probesJson(const BakeOptions& o, const Scene& scene, const HintLattice& lattice,
                const LightProbes& probes) {
    Json list = Json::array();
    for (int i = 0; i < lattice.count(); ++i) {
        const auto probe = static_cast<size_t>(i);
        Json sh = Json::array();
        for (const vec3& c : probes.light[probe]) {
            for (int channel = 0; channel < 3; ++channel) {
                sh.push_back(c[channel]);
            }
        }
        list.push_back({{"position", jsonFrom(scene.inFile(lattice.middle(lattice.at(i))))},
                        {"solid", probes.solid[probe] != 0},
                        {"sh", std::move(sh)}});
    }
    return {
        {"generator", "sheen " SHEEN_VERSION},
        {"scene", std::filesystem::path(o.scene).filename().string()},
        {"basis",
         "radiance, as THREE.SphericalHarmonics3: real, orthonormal, without the Condon-Shortley "
         "phase, l (l + 1) + m"},
        {"order", kLightProbeOrder},
        {"counts", {lattice.counts.x, lattice.counts.y, lattice.counts.z}},
        {"first", jsonFrom(scene.inFile(lattice.middle(ivec3(0))))},
        {"spacing", jsonFrom(dvec3(lattice.cell))},
        {"probes", std::move(list)}};
}

// A column for each along x; rows go along y, then z.
void writeProbesExr(const std::string& path, const BakeOptions& o, const Scene& scene,
                    const HintLattice& lattice, const LightProbes& probes) {
    constexpr size_t kCoefficients = kLightProbeOrder * kLightProbeOrder;
    const ivec2 size(lattice.counts.x, lattice.counts.y * lattice.counts.z);
    std::vector<Image<vec3>> images(kCoefficients, Image<vec3>(size.x, size.y));
    Image<float> solid(size.x, size.y);
    for (size_t i = 0; i < probes.light.size(); ++i) {
        for (size_t k = 0; k < kCoefficients; ++k) {
            images[k].pixels[i] = probes.light[i][k];
        }
        solid.pixels[i] = probes.solid[i] != 0 ? 1.0f : 0.0f;
    }
    const dvec3 first = scene.inFile(lattice.middle(ivec3(0)));
    ExrNotes notes{.texts = {{"software", "sheen " SHEEN_VERSION},
                             {"sheen.scene", std::filesystem::path(o.scene).filename().string()}},
                   .numbers = {{"sheen.probes_along_y", static_cast<float>(lattice.counts.y)}}};
    for (int axis = 0; axis < 3; ++axis) {
        notes.numbers[fmt::format("sheen.first_{}", "xyz"[axis])] = static_cast<float>(first[axis]);
        notes.numbers[fmt::format("sheen.spacing_{}", "xyz"[axis])] = lattice.cell[axis];
    }
    writeExrLayers(path, layersOfSh(images), {{"solid.Y", solid}}, notes);
}

void tellOfProbes(const BakeOptions& o, const HintLattice& lattice, const LightProbes& probes,
                  double load, double total) {
    const BakeStats& s = probes.stats;
    const int solid = lattice.count() - probes.free;
    writeJson(o.json, {{"scene", o.scene},
                       {"outputs", o.outputs},
                       {"counts", {lattice.counts.x, lattice.counts.y, lattice.counts.z}},
                       {"probes", lattice.count()},
                       {"probes_solid", solid},
                       {"accuracy", o.params.accuracy},
                       {"probes_continued", o.params.log->reused()},
                       {"seconds",
                        {{"total", total},
                         {"load", load},
                         {"lights", s.seconds_lights},
                         {"direct", s.seconds_direct},
                         {"gather", s.seconds_gather}}}});
    if (wantsText(o.json)) {
        fmt::print("probes      {} x {} x {}, {} of them within solids\n", lattice.counts.x,
                   lattice.counts.y, lattice.counts.z, solid);
        fmt::print("seconds     {:.2f}: lights {:.2f}, gather {:.2f}, direct {:.2f}\n", total,
                   s.seconds_lights, s.seconds_gather, s.seconds_direct);
    }
}

}  // namespace

void checkProbeOptions(const BakeOptions& o) {
    for (const CLI::Option* option : o.of_lightmaps) {
        if (option->count() > 0) {
            throwUsage("{}: of lightmaps; --probes bakes none", option->get_name());
        }
    }
    for (const std::string& output : o.outputs) {
        const BakedKind kind = bakedKind(output);
        if (kind != BakedKind::kJson && kind != BakedKind::kExr) {
            throwUsage("-o {}: the name of light probes must end in .json or .exr", output);
        }
    }
    probeLattice(o.probes, {});
}

void runProbes(const BakeOptions& o, const Tracer& tracer, const RankedJob& job, double load) {
    const Timer timer;
    const Scene& scene = tracer.scene();
    const HintLattice lattice = probeLattice(o.probes, scene.bounds);
    const LightProbes probes = bakeLightProbes(tracer, lattice, o.params, job);
    if (probes.free == 0) {
        warn("all probes lie within solids: they are black");
    }
    for (const std::string& output : o.outputs) {
        if (bakedKind(output) == BakedKind::kJson) {
            writeJson(output, probesJson(o, scene, lattice, probes), true);
        } else {
            writeProbesExr(output, o, scene, lattice, probes);
        }
    }
    tellOfProbes(o, lattice, probes, load, load + timer.seconds());
}

}  // namespace sheen::cli
