// Changing a glTF document, and writing it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sheen::gltf {

using Json = nlohmann::json;

/// The object's array of that name, made where it is not.
Json& arrayIn(Json& object, const char* key);

/// Whether a texture in it, known or not, is looked up by another set of coordinates than the
/// first. Lightmaps do not count.
bool usesLaterSets(const Json& value);

/// Names an extension among those that the document uses.
void useExtension(Json& document, const char* extension);
/// Its inverse.
void forgetExtension(Json& document, const char* extension);
/// Takes an extension out of the document, and out of all members of its array of that name.
void dropExtension(Json& document, const char* array, const char* extension);

/// What an image's bytes are: PNG, WebP or, by default, JPEG.
const char* mediaTypeOf(const std::vector<unsigned char>& image);

/// Stores a number as glTF's component type has it; other types than whole numbers as a float.
void storeNumber(double value, int component_type, unsigned char* to);

/// Bytes of a .glb file beside its two chunks.
constexpr uint64_t kGlbHeaders = 12 + 8 + 8;

/// A .glb file up to the bytes of its binary chunk, which are so many. Both chunks' sizes must be
/// multiples of four, and the whole below 4 GiB. [glTF 2.0, 4.4]
std::string glbBeginning(const std::string& text, uint64_t bytes);

/// Writes a .glb file of both chunks, whose sizes are multiples of four; it appears whole or not at
/// all. Environment error where it cannot be written.
void writeGlb(const std::string& path, const std::string& text,
              const std::vector<unsigned char>& bytes);

}  // namespace sheen::gltf
