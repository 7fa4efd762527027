#include "scene/gltf_edit.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "image/atomic_file.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

void eraseExtension(Json& object, const char* name) {
    if (object.contains("extensions")) {
        object["extensions"].erase(name);
        if (object["extensions"].empty()) {
            object.erase("extensions");
        }
    }
}

}  // namespace

Json& arrayIn(Json& object, const char* key) {
    Json& array = object[key];
    if (!array.is_array()) {
        array = Json::array();
    }
    return array;
}

bool usesLaterSets(const Json& value) {
    if (!value.is_structured()) {
        return false;
    }
    for (const auto& [key, member] : value.items()) {
        const bool later = key == "texCoord" && member.is_number() && member.get<double>() >= 1.0;
        if (later || (key != "MOZ_lightmap" && usesLaterSets(member))) {
            return true;
        }
    }
    return false;
}

void useExtension(Json& document, const char* extension) {
    Json& used = arrayIn(document, "extensionsUsed");
    if (std::find(used.begin(), used.end(), extension) == used.end()) {
        used.push_back(extension);
    }
}

void forgetExtension(Json& document, const char* extension) {
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
        if (!document.contains(list)) {
            continue;
        }
        Json& names = document[list];
        names.erase(std::remove(names.begin(), names.end(), extension), names.end());
        if (names.empty()) {
            document.erase(list);
        }
    }
}

void dropExtension(Json& document, const char* array, const char* extension) {
    if (document.contains(array)) {
        for (Json& user : document[array]) {
            eraseExtension(user, extension);
        }
    }
    eraseExtension(document, extension);
    forgetExtension(document, extension);
}

const char* mediaTypeOf(const std::vector<unsigned char>& image) {
    const auto begins = [&](std::string_view magic) {
        return image.size() > magic.size() &&
               std::memcmp(image.data(), magic.data(), magic.size()) == 0;
    };
    return begins("\x89PNG") ? "image/png" : begins("RIFF") ? "image/webp" : "image/jpeg";
}

void storeNumber(double value, int component_type, unsigned char* to) {
    const auto as = [&](auto number) {
        number = static_cast<decltype(number)>(value);
        std::memcpy(to, &number, sizeof(number));
    };
    switch (component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return as(int8_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return as(uint8_t{});
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return as(int16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return as(uint16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return as(uint32_t{});
        default:
            return as(float{});
    }
}

std::string glbBeginning(const std::string& text, uint64_t bytes) {
    constexpr uint32_t kMagic = 0x46546c67, kVersion = 2, kJson = 0x4e4f534a, kBin = 0x004e4942;
    std::string result;
    const auto word = [&](uint64_t value) {
        for (int i = 0; i < 4; ++i) {
            result.push_back(static_cast<char>(value >> (8 * i) & 0xff));
        }
    };
    for (const uint64_t value :
         {uint64_t{kMagic}, uint64_t{kVersion}, kGlbHeaders + text.size() + bytes,
          uint64_t{text.size()}, uint64_t{kJson}}) {
        word(value);
    }
    result += text;
    word(bytes);
    word(kBin);
    return result;
}

void writeGlb(const std::string& path, const std::string& text,
              const std::vector<unsigned char>& bytes) {
    AtomicFile out(path);
    out.write(glbBeginning(text, bytes.size()));
    out.write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    out.commit();
}

}  // namespace sheen::gltf
