#include "render/record_file.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "image/atomic_file.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
using Bytes = std::vector<uint8_t>;

// The file: this, the checksum of what follows as 32 hexadecimal digits, then an object as CBOR
// (RFC 8949), whose arrays of numbers are byte strings of little-endian floats and integers.
constexpr char kMagic[] = "sheen records\n";
constexpr int kVersion = 1;
constexpr size_t kDigits = 32;

std::string hex(const XXH128_hash_t& hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string checksum(std::span<const uint8_t> bytes) {
    return hex(XXH3_128bits(bytes.data(), bytes.size()));
}

class Fingerprint {
  public:
    Fingerprint() : state_(XXH3_createState(), XXH3_freeState) {
        if (!state_) {
            throwEnvironment("not enough memory");
        }
        XXH3_128bits_reset(state_.get());
    }
    template <class T>
    void add(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        const uint64_t count = values.size();
        XXH3_128bits_update(state_.get(), &count, sizeof(count));
        XXH3_128bits_update(state_.get(), values.data(), values.size() * sizeof(T));
    }
    void addFile(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        std::vector<char> block(1 << 16);
        if (!file) {
            throwEnvironment("{}: cannot be read", path);
        }
        while (file.read(block.data(), static_cast<std::streamsize>(block.size())) ||
               file.gcount() > 0) {
            XXH3_128bits_update(state_.get(), block.data(), static_cast<size_t>(file.gcount()));
        }
    }
    std::string text() const { return hex(XXH3_128bits_digest(state_.get())); }

  private:
    std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

// What a GatheredRecord has a fixed number of, of floats alone: no padding.
struct Fixed {
    Record record;
    vec3 toward_viewer;
    float curvature;
    vec3 lobe_light;
    float lobe_texels;
    uint32_t contrasts;
};
static_assert(sizeof(Fixed) == sizeof(Record) + 9 * sizeof(float));
static_assert(sizeof(Contrast) == 4 * sizeof(float));

template <class T>
Json::binary_t pack(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Bytes bytes(values.size() * sizeof(T));
    if (!bytes.empty()) {
        std::memcpy(bytes.data(), values.data(), bytes.size());
    }
    return Json::binary_t(std::move(bytes));
}

template <class T>
std::vector<T> unpack(const Json& json) {
    const Bytes& bytes = json.get_binary();
    if (bytes.size() % sizeof(T) != 0) {
        throw std::out_of_range("a part of a number");
    }
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!bytes.empty()) {
        std::memcpy(values.data(), bytes.data(), bytes.size());
    }
    return values;
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throwInput("{}: {}; remove it, or name another file", path, why);
}

Bytes readWhole(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throwInput("{}: cannot be read; check the path", path);
    }
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// So many coefficients as its order says; numbers that no gather finds are refused.
bool isSound(const Fixed& f) {
    const Record& r = f.record;
    const auto order = r.order;
    return order >= 0 && order <= shared::SH_MAX_ORDER && r.radius > 0.0f && finite(r.position) &&
           finite(r.irradiance) && std::abs(glm::length(r.normal) - 1.0f) < 1e-3f &&
           std::abs(glm::length(r.tangent) - 1.0f) < 1e-3f && finite(r.rotation_r) &&
           finite(r.rotation_g) && finite(r.rotation_b) && finite(r.translation_r) &&
           finite(r.translation_g) && finite(r.translation_b) && finite(f.lobe_light) &&
           finite(f.toward_viewer) && std::isfinite(f.curvature) && std::isfinite(f.lobe_texels);
}

RecordField unpackRecords(const Json& json) {
    const auto fixed = unpack<Fixed>(json.at("records"));
    const auto sh = unpack<float>(json.at("coefficients"));
    const auto contrasts = unpack<Contrast>(json.at("contrasts"));
    RecordField field;
    field.gather_size = json.at("gather_size").get<int>();
    auto next_sh = sh.begin();
    auto next_contrast = contrasts.begin();
    for (const Fixed& f : fixed) {
        if (!isSound(f)) {
            throw std::out_of_range("a record of no meaning");
        }
        const int count =
            f.record.order > shared::DIFFUSE_ORDER ? shLayout(f.record.order).size() : 0;
        if (sh.end() - next_sh < count || contrasts.end() - next_contrast < f.contrasts) {
            throw std::out_of_range("a record without its numbers");
        }
        GatheredRecord found{.record = f.record,
                             .toward_viewer = f.toward_viewer,
                             .sh = {next_sh, next_sh + count},
                             .curvature = f.curvature,
                             .lobe_light = f.lobe_light,
                             .lobe_texels = f.lobe_texels,
                             .contrasts = {next_contrast, next_contrast + f.contrasts}};
        for (const float c : found.sh) {
            if (!std::isfinite(c)) {
                throw std::out_of_range("a coefficient of no number");
            }
        }
        next_sh += count;
        next_contrast += f.contrasts;
        field.records.push_back(std::move(found));
    }
    return field;
}

}  // namespace

std::string sceneFingerprint(const Scene& scene) {
    Fingerprint print;
    print.add(scene.positions);
    print.add(scene.normals);
    print.add(scene.triangles);
    print.add(scene.materials_of);
    print.add(std::vector<dvec3>{scene.origin});
    // Every light's numbers, one after the other: between them there may be padding.
    for (const PunctualLight& light : scene.lights) {
        print.add(std::vector<vec3>{light.position, light.direction, light.intensity});
        print.add(std::vector<float>{static_cast<float>(light.kind), light.inverse_range,
                                     light.spot_scale, light.spot_offset, light.cos_outer});
    }
    print.add(scene.environment.texels.pixels);
    print.add(std::vector<float>{scene.environment.rotation,
                                 static_cast<float>(scene.environment.texels.width)});
    for (const std::string& file : scene.files) {
        print.addFile(file);
    }
    return print.text();
}

void saveRecords(const std::string& path, const KeptRecords& records, const RecordOrigin& origin) {
    std::vector<Fixed> fixed;
    std::vector<float> sh;
    std::vector<Contrast> contrasts;
    for (const GatheredRecord& g : records.records()) {
        fixed.push_back({g.record, g.toward_viewer, g.curvature, g.lobe_light, g.lobe_texels,
                         static_cast<uint32_t>(g.contrasts.size())});
        sh.insert(sh.end(), g.sh.begin(), g.sh.end());
        contrasts.insert(contrasts.end(), g.contrasts.begin(), g.contrasts.end());
    }
    const Json json = {{"version", kVersion},         {"scene", origin.scene},
                       {"recipe", origin.recipe},     {"gather_size", records.gatherSize()},
                       {"records", pack(fixed)},      {"coefficients", pack(sh)},
                       {"contrasts", pack(contrasts)}};
    const Bytes body = Json::to_cbor(json);
    AtomicFile file(path);
    file.write(kMagic);
    file.write(checksum(body));
    file.write(reinterpret_cast<const char*>(body.data()), body.size());
    file.commit();
}

KeptRecords loadRecords(const std::string& path, const RecordOrigin& origin) {
    const Bytes bytes = readWhole(path);
    constexpr size_t kMagicSize = sizeof(kMagic) - 1;
    if (bytes.size() < kMagicSize || std::memcmp(bytes.data(), kMagic, kMagicSize) != 0) {
        refuse(path, "not a file of records");
    }
    if (bytes.size() < kMagicSize + kDigits) {
        refuse(path, "damaged: it ends too early");
    }
    const std::span<const uint8_t> body = std::span(bytes).subspan(kMagicSize + kDigits);
    if (std::memcmp(checksum(body).data(), bytes.data() + kMagicSize, kDigits) != 0) {
        refuse(path, "damaged: its checksum does not fit what it holds");
    }
    KeptRecords kept;
    try {
        const Json json = Json::from_cbor(body.begin(), body.end());
        const int version = json.at("version").get<int>();
        if (version != kVersion) {
            refuse(path, fmt::format("records of version {}, where {} is read", version, kVersion));
        }
        if (json.at("scene").get<std::string>() != origin.scene) {
            refuse(path, "records of another scene, or of this one before it changed");
        }
        const auto recipe = json.at("recipe").get<std::string>();
        if (recipe != origin.recipe) {
            refuse(path, fmt::format("records of other options ({}; wanted: {})", oneLine(recipe),
                                     origin.recipe));
        }
        kept.put(unpackRecords(json));
    } catch (const Json::exception& e) {
        refuse(path, fmt::format("damaged: {}", oneLine(e.what())));
    } catch (const std::out_of_range& e) {
        refuse(path, fmt::format("damaged: {}", e.what()));
    }
    return kept;
}

}  // namespace sheen
