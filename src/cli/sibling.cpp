#include "cli/sibling.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <string_view>

#include "core/error.h"

namespace sheen::cli {

std::string becomeSibling(const char* name, char** arguments) {
    const std::filesystem::path program =
        std::filesystem::read_symlink("/proc/self/exe").replace_filename(name);
    execv(program.c_str(), arguments);
    return program.string();
}

void becomeRank(int argc, char** argv) {
    constexpr std::string_view kShared[] = {"render", "animate", "bake", "chart"};
    const char* const ranks = std::getenv("OMPI_COMM_WORLD_SIZE");  // set by Open MPI's mpirun
    if (ranks == nullptr || std::string_view(ranks) == "1" || argc < 2 ||
        std::find(std::begin(kShared), std::end(kShared), argv[1]) == std::end(kShared)) {
        return;
    }
    throwEnvironment(
        "{}: {} ranks need {}, which cannot be run; install the package sheen-mpi, or build with "
        "SHEEN_MPI",
        argv[1], ranks, becomeSibling("sheen-mpi", argv));
}

}  // namespace sheen::cli
