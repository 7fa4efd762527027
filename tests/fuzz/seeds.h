// What make_fuzz_seeds writes for the scene loader.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sheen::fuzz {

/// File names and bytes.
std::vector<std::pair<std::string, std::string>> sceneSeeds();

}  // namespace sheen::fuzz
