// The options of sheen bake, as text and as what they say.
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <vector>

#include "bake/bake.h"
#include "image/exr.h"
#include "scene/scene.h"

namespace sheen::cli {

struct BakeOptions {
    std::string scene;
    std::vector<std::string> outputs;
    std::string method = "records";
    std::string bounces = "all";
    std::string probes;  ///< empty: a lightmap is baked
    std::string json;
    int threads = 0;
    bool unlit = false;
    LoadParams load;
    AtlasParams atlas;
    BakeParams params;
    const CLI::App* app = nullptr;
    CLI::Option* accuracy_option = nullptr;
    CLI::Option* spp_option = nullptr;
    CLI::Option* seed_option = nullptr;
    std::vector<CLI::Option*> of_lightmaps;  ///< that light probes have no use for
};

/// Spherical harmonics, [coefficient], as a file has them: sh0, sh1, ...
std::vector<ExrColors> layersOfSh(std::span<const Image<vec3>> coefficients);

enum class BakedKind { kExr, kPng, kGlb, kJson };

/// By the name's ending. Usage error for any other.
BakedKind bakedKind(const std::string& path);

}  // namespace sheen::cli
