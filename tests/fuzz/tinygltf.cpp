// The glTF library that Sheen links, compiled from Debian's own headers with the fuzzer's eyes in
// it.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>
