// .glb files whose JSON tests change.
#pragma once

#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace sheen {

using Json = nlohmann::json;
using Edit = std::function<void(Json&)>;

/// The JSON of a .glb file.
inline Json jsonOf(const std::string& bytes) {
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    return Json::parse(bytes.substr(20, length));
}

/// A .glb file with its JSON changed.
inline std::string edited(const std::string& bytes, const Edit& edit) {
    uint32_t old_length = 0;
    std::memcpy(&old_length, bytes.data() + 12, 4);
    Json json = jsonOf(bytes);
    edit(json);
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto length = static_cast<uint32_t>(text.size());
    std::string result = bytes.substr(0, 20) + text + bytes.substr(20 + old_length);
    const auto size = static_cast<uint32_t>(result.size());
    std::memcpy(result.data() + 8, &size, 4);
    std::memcpy(result.data() + 12, &length, 4);
    return result;
}

}  // namespace sheen
