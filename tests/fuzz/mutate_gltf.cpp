// Mutates glTF files as what they are: bytes changed anywhere in a .glb almost always end at its
// header or at a JSON bracket. Most steps change a value, a member or an element of the JSON tree;
// others change the JSON's text, the binary chunk, or bytes anywhere. The file is put together
// again with the right lengths, so that every input is a file that `sheen info` can be given.
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "fuzz/gltf_words.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace sheen::fuzz {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kHeader = 20;  // of a .glb and of its first chunk
constexpr size_t kChunkHeader = 8;

struct Parts {
    bool is_binary = false;
    std::string json;
    std::string binary;
};

std::string word(size_t value) {
    const auto number = static_cast<uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&number), sizeof(number));
}

uint32_t wordAt(const std::string& bytes, size_t offset) {
    uint32_t number = 0;
    std::memcpy(&number, bytes.data() + offset, sizeof(number));
    return number;
}

std::optional<Parts> split(const std::string& bytes) {
    if (bytes.compare(0, 1, "{") == 0) {
        return Parts{.is_binary = false, .json = bytes, .binary = {}};
    }
    if (bytes.size() < kHeader || bytes.compare(0, 4, "glTF") != 0 ||
        wordAt(bytes, 12) > bytes.size() - kHeader) {
        return std::nullopt;
    }
    const size_t json_end = kHeader + wordAt(bytes, 12);
    const size_t binary_begin = std::min(bytes.size(), json_end + kChunkHeader);
    return Parts{.is_binary = true,
                 .json = bytes.substr(kHeader, json_end - kHeader),
                 .binary = bytes.substr(binary_begin)};
}

std::string join(Parts parts) {
    if (!parts.is_binary) {
        return parts.json;
    }
    parts.json.resize((parts.json.size() + 3) / 4 * 4, ' ');
    parts.binary.resize((parts.binary.size() + 3) / 4 * 4, '\0');
    std::string chunks = word(parts.json.size()) + "JSON" + parts.json;
    if (!parts.binary.empty()) {
        chunks += word(parts.binary.size()) + std::string("BIN\0", 4) + parts.binary;
    }
    return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

std::string mutatedBytes(std::string bytes, size_t max_size) {
    const size_t size = bytes.size();
    bytes.resize(std::max(size, max_size));
    bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), size, bytes.size()));
    return bytes;
}

class TreeMutator {
  public:
    explicit TreeMutator(unsigned seed) : random_(seed) {}

    size_t below(size_t count) { return random_() % count; }

    void mutate(Json& root) {
        for (size_t steps = 1 + below(4); steps > 0; --steps) {
            nodes_.clear();
            collect(root);
            step(*nodes_[below(nodes_.size())]);
        }
    }

  private:
    void collect(Json& node) {
        nodes_.push_back(&node);
        if (node.is_structured()) {
            for (Json& child : node) {
                collect(child);
            }
        }
    }

    Json anyNode() { return *nodes_[below(nodes_.size())]; }

    template <class T, size_t N>
    const T& anyOf(const T (&list)[N]) {
        return list[below(N)];
    }

    Json number() {
        const double value = anyOf(kNumbers);
        const bool whole = value == std::floor(value) && std::abs(value) < 1e19;
        return whole ? Json(static_cast<int64_t>(value)) : Json(value);
    }

    Json newValue() {
        switch (below(8)) {
            case 0:
                return Json::array();
            case 1:
                return Json::object();
            case 2:
                return Json();
            case 3:
                return below(2) == 0;
            case 4:
                return anyOf(kStrings);
            case 5:
                return anyNode();
            default:
                return number();
        }
    }

    // A value that fits where `node` is, as often as not.
    Json similarValue(const Json& node) {
        if (node.is_number_integer() && below(2) == 0) {
            // Around the ends too, where signed numbers may not overflow.
            return static_cast<int64_t>(node.get<uint64_t>() + below(9) - 4);
        }
        if (node.is_number() && below(4) > 0) {
            return number();
        }
        if (node.is_string() && below(2) == 0) {
            return anyOf(kStrings);
        }
        return newValue();
    }

    void step(Json& node) {
        if (node.is_object() && below(2) == 0) {
            if (below(2) == 0 || node.empty()) {
                node[anyOf(kKeys)] = newValue();
            } else {
                node.erase(std::next(node.begin(), static_cast<long>(below(node.size()))));
            }
        } else if (node.is_array() && !node.empty() && below(2) == 0) {
            const size_t index = below(node.size());
            if (below(2) == 0) {
                node.erase(index);
            } else {
                const Json copy = node[index];
                node.push_back(copy);
            }
        } else {
            node = similarValue(node);
        }
    }

    std::minstd_rand random_;
    std::vector<Json*> nodes_;
};

std::string mutated(const std::string& bytes, size_t max_size, unsigned seed) {
    TreeMutator tree(seed);
    std::optional<Parts> parts = split(bytes);
    const size_t kind = tree.below(10);
    if (!parts || kind == 0) {
        return mutatedBytes(bytes, max_size);
    }
    if (kind <= 2 && parts->is_binary) {
        parts->binary = mutatedBytes(parts->binary, max_size);
        return join(*parts);
    }
    Json json = Json::parse(parts->json, nullptr, false);
    if (json.is_discarded() || kind <= 4) {
        parts->json = mutatedBytes(parts->json, max_size);
    } else {
        tree.mutate(json);
        parts->json = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    }
    return join(*parts);
}

}  // namespace
}  // namespace sheen::fuzz

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    const std::string result = sheen::fuzz::mutated(bytes, max_size, seed);
    const size_t length = std::min(result.size(), max_size);
    std::memcpy(data, result.data(), length);
    return length;
}
