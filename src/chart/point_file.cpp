#include "chart/point_file.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/error.h"

namespace sheen {
namespace {

// Fowler, Noll, Vo: FNV-1a, 64 bits. Tells files apart; nobody attacks it.
class Hash {
  public:
    void add(const void* data, size_t size) {
        const auto* bytes = static_cast<const unsigned char*>(data);
        for (size_t i = 0; i < size; ++i) {
            value_ = (value_ ^ bytes[i]) * 0x100000001b3ull;
        }
    }
    template <class T>
    void add(const std::vector<T>& values) {
        const size_t count = values.size();
        add(&count, sizeof(count));
        add(values.data(), count * sizeof(T));
    }
    std::string text() const { return fmt::format("{:016x}", value_); }

  private:
    uint64_t value_ = 0xcbf29ce484222325ull;
};

// A whole number that an int holds: Json's own conversion takes any number and cuts it down.
int intFrom(const Json& json) {
    const double value = json.get<double>();
    if (!json.is_number_integer() || value < std::numeric_limits<int>::min() ||
        value > std::numeric_limits<int>::max()) {
        throw std::out_of_range("not an int");
    }
    return static_cast<int>(value);
}

Json jsonFromHost(const ChartHost& host) {
    return {{"version", host.version},
            {"build", host.build},
            {"cpu", host.cpu},
            {"threads", host.threads}};
}

ChartHost hostFromJson(const Json& json) {
    return {.version = json.at("version"),
            .build = json.at("build"),
            .cpu = json.at("cpu"),
            .threads = intFrom(json.at("threads"))};
}

Json jsonFromKey(const ImageKey& key) {
    return {{"scene", key.scene},
            {"camera", key.camera},
            {"size", {key.width, key.height}},
            {"arguments", key.arguments},
            {"gl", key.gl}};
}

ImageKey keyFromJson(const Json& json) {
    return {.scene = json.at("scene"),
            .camera = intFrom(json.at("camera")),
            .width = intFrom(json.at("size").at(0)),
            .height = intFrom(json.at("size").at(1)),
            .arguments = json.at("arguments"),
            .gl = json.at("gl")};
}

TimedRun runFromJson(const Json& json) {
    TimedRun run = {.seconds = json.at("seconds"), .stages = {}};
    for (const auto& [stage, seconds] : json.at("stages").items()) {
        run.stages.emplace_back(stage, seconds.get<double>());
    }
    return run;
}

Measurement measurementFromJson(const Json& json) {
    Measurement measured;
    measured.host = hostFromJson(json.at("host"));
    for (const Json& run : json.at("runs")) {
        measured.runs.push_back(runFromJson(run));
    }
    measured.cold_seconds = json.at("cold_seconds");
    measured.records = intFrom(json.at("records"));
    measured.gl_renderer = json.at("gl_renderer");
    return measured;
}

}  // namespace

std::string contentHash(const Scene& scene) {
    // These are hashed as bytes, so they must have no padding.
    static_assert(sizeof(MaterialParams) == 16 * sizeof(float));
    static_assert(sizeof(TextureUse) == 2 * sizeof(int) + 6 * sizeof(float));
    static_assert(sizeof(Layers) == 6 * sizeof(float));
    static_assert(sizeof(PunctualLight) == 16 * sizeof(float));
    Hash hash;
    hash.add(scene.positions);
    hash.add(scene.normals);
    hash.add(scene.uvs);
    hash.add(scene.second_uvs);
    hash.add(scene.colors);
    hash.add(scene.tangents);
    hash.add(scene.triangles);
    hash.add(scene.materials_of);
    for (const Material& material : scene.materials) {
        hash.add(&material.params, sizeof(material.params));
        const float flags[] = {material.unlit ? 1.0f : 0.0f, material.single_sided ? 1.0f : 0.0f,
                               material.blended ? 1.0f : 0.0f, material.alpha,
                               material.alpha_cutoff};
        hash.add(flags, sizeof(flags));
        for (const TextureUse* use :
             {&material.alpha_texture, &material.normal_texture, &material.coat_normal_texture,
              &material.coat_texture, &material.coat_roughness_texture,
              &material.fibre_color_texture, &material.fibre_roughness_texture}) {
            hash.add(use, sizeof(*use));
        }
        hash.add(&material.normal_scale, sizeof(material.normal_scale));
        hash.add(&material.coat_normal_scale, sizeof(material.coat_normal_scale));
        hash.add(&material.layers, sizeof(material.layers));
        hash.add(&material.absorption, sizeof(material.absorption));
        for (const TextureUse& use : material.textures) {
            hash.add(&use, sizeof(use));
        }
    }
    for (const Texture& texture : scene.textures) {
        const int use[] = {texture.image, texture.wrap.x, texture.wrap.y, texture.nearest,
                           texture.srgb};
        hash.add(use, sizeof(use));
    }
    for (const TextureImage& image : scene.images) {
        const int size[] = {image.width, image.height};
        hash.add(size, sizeof(size));
        hash.add(image.bytes);
        hash.add(image.words);
    }
    hash.add(scene.lights);
    for (const Camera& camera : scene.cameras) {
        hash.add(&camera.world_from_camera, sizeof(camera.world_from_camera));
        hash.add(&camera.y_fov, sizeof(camera.y_fov));
        hash.add(&camera.near, sizeof(camera.near));
    }
    if (!scene.environment.empty()) {
        const Environment& sky = scene.environment;
        const int shape[] = {sky.texels.width, sky.texels.height, sky.visible ? 1 : 0};
        hash.add(shape, sizeof(shape));
        hash.add(&sky.rotation, sizeof(sky.rotation));
        hash.add(sky.texels.pixels);
    }
    return hash.text();
}

std::string fileHash(const std::string& path) {
    const std::optional<std::string> bytes = readText(path);
    if (!bytes) {
        throwEnvironment("{}: cannot be read", path);
    }
    Hash hash;
    hash.add(bytes->data(), bytes->size());
    return hash.text();
}

std::string fileNamePart(const std::string& name) {
    constexpr size_t kLongest = 40;
    std::string part = name.substr(0, kLongest);
    for (char& c : part) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') || c == '-' || c == '_';
        c = plain ? c : '_';
    }
    return part;
}

std::string shortHash(const ImageKey& key) {
    const std::string text = jsonFromKey(key).dump(-1, ' ', false, Json::error_handler_t::replace);
    Hash hash;
    hash.add(text.data(), text.size());
    return hash.text().substr(0, 12);
}

Json jsonFromStages(const StageTimes& stages) {
    Json json = Json::object();
    for (const auto& [stage, seconds] : stages) {
        json[stage] = seconds;
    }
    return json;
}

std::string jsonText(const StoredPoint& point) {
    const Measurement& m = point.measured;
    Json runs = Json::array();
    for (const TimedRun& run : m.runs) {
        runs.push_back({{"seconds", run.seconds}, {"stages", jsonFromStages(run.stages)}});
    }
    return asciiText({{"image", jsonFromKey(point.key)},
                      {"host", jsonFromHost(m.host)},
                      {"runs", runs},
                      {"cold_seconds", m.cold_seconds},
                      {"records", m.records},
                      {"gl_renderer", m.gl_renderer}},
                     2);
}

void addRun(Measurement& measured, double wall_seconds, const std::string& render_json) {
    const Json stats = Json::parse(render_json);
    TimedRun run = {.seconds = wall_seconds, .stages = {}};
    double other = wall_seconds;
    for (const auto& [stage, seconds] : stats.at("seconds").items()) {
        if (stage != "total" && seconds.get<double>() > 0) {
            run.stages.emplace_back(stage, seconds.get<double>());
            other -= seconds.get<double>();
        }
    }
    run.stages.emplace_back("other", std::max(other, 0.0));
    measured.runs.push_back(run);
    measured.records = stats.at("records");
    measured.gl_renderer = stats.at("gl_renderer");
}

std::optional<StoredPoint> parsePoint(const std::string& text) {
    try {
        const Json json = Json::parse(text);
        StoredPoint point = {.key = keyFromJson(json.at("image")),
                             .measured = measurementFromJson(json)};
        const std::vector<TimedRun>& runs = point.measured.runs;
        const bool sane =
            !runs.empty() &&
            std::all_of(runs.begin(), runs.end(), [](const TimedRun& r) { return r.seconds > 0; });
        return sane ? std::optional(std::move(point)) : std::nullopt;
    } catch (const Json::exception&) {
        return std::nullopt;
    } catch (const std::out_of_range&) {
        return std::nullopt;
    }
}

bool sameImage(const ImageKey& a, const ImageKey& b) { return jsonFromKey(a) == jsonFromKey(b); }

std::optional<std::string> readText(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        return std::nullopt;
    }
    return std::string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
}

std::string asciiText(const Json& json, int indent) {
    return json.dump(indent, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace sheen
