// Programs that lie beside this one and know libraries that it does without.
#pragma once

#include <string>

namespace sheen::cli {

/// Runs the program of that name in place of this one, with its arguments, null at the end. Returns
/// only where it cannot be run: its path.
std::string becomeSibling(const char* name, char** arguments);

/// Under mpirun, with several ranks and a command that shares its work out: becomes `sheen-mpi`.
/// Environment error where that cannot be run.
void becomeRank(int argc, char** argv);

}  // namespace sheen::cli
