// The program `sheen`.
#include "cli/program.h"
#include "cli/sibling.h"

int main(int argc, char** argv) {
    using namespace sheen::cli;
    sheen::OneRank ranks;
    return runProgram(argc, argv, [&](CLI::App& program) {
        becomeRank(argc, argv);
        return std::vector<Command>{
            addRender(program, ranks), addView(program, argv), addAnimate(program, ranks),
            addCompare(program),       addInfo(program),       addChart(program, ranks),
            addBake(program, ranks),   addManual(program),     addCompletion(program)};
    });
}
