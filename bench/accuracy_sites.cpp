#include "accuracy_sites.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/error.h"
#include "rays/jitter.h"
#include "reference/ray_scene.h"
#include "reference/sobol.h"

namespace sheen::bench {
namespace {

constexpr uint32_t kSiteSeed = 20090;

// Points seen by one camera, in the order of the Sobol points that find them.
void appendSites(const RayScene& rays, const Camera& camera, uint32_t seed, int count,
                 std::vector<RecordSite>& sites) {
    const int tries = 64 * count + 1024;  // far more than any camera of the scenes needs
    int found = 0;
    for (int i = 0; i < tries && found < count; ++i) {
        const vec2 place = owenSobol(static_cast<uint32_t>(i), seed);
        const CameraRay ray = cameraRay(camera, 1, 1, place.x - 0.5f, place.y - 0.5f);
        const RayHit hit = rays.intersect(ray.origin, ray.direction);
        if (!hit.found()) {
            continue;
        }
        const Surface s = rays.surfaceAt(hit, -ray.direction);
        sites.push_back({.position = s.position,
                         .normal = s.n,
                         .geometric_normal = s.n_g,
                         .toward_viewer = -ray.direction,
                         .offset = surfaceOffset(rays.scene(), hit.triangle, s.position, s.n_g,
                                                 glm::distance(s.position, ray.origin)),
                         .seed = pcgHash(static_cast<uint32_t>(sites.size()))});
        ++found;
    }
    if (found < count) {
        throwInput("camera {}: sees too little to judge", camera.name);
    }
}

}  // namespace

BenchScene::BenchScene(const std::string& scene_name, Scene made, int site_count)
    : name(scene_name), scene(std::move(made)), tracer(scene), light(tracer) {
    const RayScene ray_scene(scene);
    const auto cameras = static_cast<int>(scene.cameras.size());
    for (int c = 0; c < cameras; ++c) {
        const int count = (c + 1) * site_count / cameras - c * site_count / cameras;
        appendSites(ray_scene, scene.cameras[static_cast<size_t>(c)],
                    hashCombine(kSiteSeed, static_cast<uint32_t>(c)), count, sites);
    }
}

BenchScenes loadBenchScenes(const std::string& folder, const std::vector<std::string>& names,
                            int sites_per_scene) {
    BenchScenes scenes;
    for (const std::string& name : names) {
        scenes.push_back(std::make_unique<BenchScene>(name, loadScene(folder + "/" + name + ".glb"),
                                                      sites_per_scene));
    }
    return scenes;
}

void Output::write(const std::string& file, const std::string& text) const {
    const std::string path = folder + "/" + file;
    std::ofstream out(path, std::ios::binary);
    out << text;
    if (!out.flush()) {
        throwEnvironment("{}: cannot be written", path);
    }
}

Table::Table(const std::vector<std::string>& head) {
    add(head);
    add(std::vector<std::string>(head.size(), "---"));
}

void Table::add(const std::vector<std::string>& row) {
    text_ += "|";
    for (const std::string& cell : row) {
        text_ += " " + cell + " |";
    }
    text_ += "\n";
}

std::string percent(double share) {
    const double p = 100.0 * share;
    return std::abs(p) < 1.0    ? fmt::format("{:.2f}%", p)
           : std::abs(p) < 99.5 ? fmt::format("{:.3g}%", p)
                                : fmt::format("{:.0f}%", p);
}

SeenTexels traceTexels(const OutgoingLight& light, const Hemisphere& hemisphere, const mat3& frame,
                       const vec3& eye, const TexelRays& how) {
    SeenTexels result;
    std::vector<vec4>& texels = result.light;
    texels.resize(static_cast<size_t>(hemisphere.texelCount()));
    result.planes.resize(texels.size());
    std::vector<float> inverse(texels.size());
    std::vector<vec3> directions;
    std::vector<size_t> of;
    std::vector<vec4> seen;
    std::vector<vec3> planes;
    const int parts = how.side * how.side;
    const mat3 turn = how.mirrored ? mat3(frame[0], frame[1], -frame[2]) : frame;
    for (const HemisphereFace& face : hemisphere.faces) {
        for (int y = 0; y < face.height; ++y) {
            directions.clear();
            of.clear();
            for (int x = 0; x < face.width; ++x) {
                const auto t = static_cast<size_t>((face.y + y) * hemisphere.width + face.x + x);
                for (int k = 0; k < parts; ++k) {
                    const uint32_t ray = static_cast<uint32_t>(t) * static_cast<uint32_t>(parts) +
                                         static_cast<uint32_t>(k);
                    const vec2 place = how.random ? randomPlace(how.seed, ray) : vec2(0.5f);
                    const vec2 part =
                        (vec2(k % how.side, k / how.side) + place) / static_cast<float>(how.side);
                    const vec2 uv = (vec2(x, y) + part) * 2.0f / vec2(face.width, face.height);
                    const vec3 local = glm::normalize(face.forward + (uv.x - 1.0f) * face.right +
                                                      (uv.y - 1.0f) * face.up);
                    const vec3 direction = turn * local;
                    const float height = how.mirrored ? -local.z : local.z;
                    const bool black =
                        how.above != vec3(0.0f) && glm::dot(direction, how.above) <= 0.0f;
                    if (!black && height >= how.lowest) {
                        directions.push_back(direction);
                        of.push_back(t);
                    }
                }
            }
            seen.resize(directions.size());
            planes.resize(directions.size());
            light.cast({.origin = eye, .directions = directions}, seen.data(), planes.data());
            for (size_t i = of.size(); i-- > 0;) {  // of a texel's planes the first stays
                result.planes[of[i]] = planes[i] * turn;
                texels[of[i]] += vec4(vec3(seen[i]), 0.0f) / static_cast<float>(parts);
                inverse[of[i]] += seen[i].w > 0.0f ? 1.0f / seen[i].w : 0.0f;
            }
        }
    }
    for (size_t t = 0; t < texels.size(); ++t) {
        texels[t].w = inverse[t] > 0.0f ? static_cast<float>(parts) / inverse[t] : 0.0f;
    }
    return result;
}

float metalLobe(float alpha, const vec3& n, const vec3& wo, const vec3& wi) {
    const float NoL = glm::dot(n, wi);
    if (NoL <= 0.0f) {
        return 0.0f;
    }
    const vec2 lobe = shared::specularLobe(alpha, n, wo, wi);
    return glm::mix(kMetalF0, 1.0f, lobe.y) * lobe.x * NoL;
}

Errors errorsOf(std::span<const float> estimate, std::span<const float> truth,
                std::span<const float> variance) {
    SHEEN_CHECK_EQ(estimate.size(), truth.size());
    SHEEN_CHECK_EQ(variance.size(), truth.size());
    const auto count = static_cast<double>(truth.size());
    double mean = 0.0;
    for (float t : truth) {
        mean += t / count;
    }
    Errors errors;
    double squares = 0.0;
    double point_squares = 0.0;
    double noise = 0.0;
    for (size_t i = 0; i < truth.size(); ++i) {
        const double e = static_cast<double>(estimate[i]) - truth[i];
        const double scale = truth[i] + 0.01 * mean;
        errors.bias += e / count;
        squares += e * e / count;
        point_squares += (e * e - variance[i]) / (scale * scale * count);
        noise += variance[i] / count;
    }
    errors.rel_rmse = std::sqrt(std::max(0.0, squares - noise)) / mean;
    errors.bias /= mean;
    errors.point_rms = std::sqrt(std::max(0.0, point_squares));
    errors.noise = std::sqrt(noise) / mean;
    return errors;
}

double rms(std::span<const double> values) {
    double sum = 0.0;
    for (double v : values) {
        sum += v * v;
    }
    return std::sqrt(sum / static_cast<double>(std::max<size_t>(values.size(), 1)));
}

}  // namespace sheen::bench
