// The glTF library that Sheen links, compiled from Debian's own headers with the fuzzer's eyes in
// it.
#define TINYGLTF_IMPLEMENTATION
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <tiny_gltf.h>
