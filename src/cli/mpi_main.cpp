// The program `sheen-mpi`: what `sheen` becomes under mpirun, with the same arguments.
#include "chart/point_file.h"
#include "cli/program.h"
#include "mpi/mpi_ranks.h"

int main(int argc, char** argv) {
    using namespace sheen;
    // Ranks of another build may make other images.
    MpiRanks ranks("sheen " SHEEN_VERSION ", build " + fileHash("/proc/self/exe"));
    return cli::runProgram(
        argc, argv,
        [&](CLI::App& program) {
            return std::vector<cli::Command>{
                cli::addRender(program, ranks), cli::addAnimate(program, ranks),
                cli::addBake(program, ranks), cli::addChart(program, ranks)};
        },
        [&](const Failure& failure) {
            if (ranks.first()) {
                return cli::printFailure(failure);
            }
            // mpirun would end all ranks where one ends with another code.
            ranks.giveUp(failure);
            return static_cast<int>(ExitCode::kDone);
        });
}
