// The program `sheen`.
#include "cli/program.h"

int main(int argc, char** argv) {
    using namespace sheen::cli;
    return runProgram(argc, argv, [argv](CLI::App& program) {
        return std::vector<Command>{
            addRender(program),  addView(program, argv), addAnimate(program),
            addCompare(program), addInfo(program),       addChart(program),
            addBake(program),    addManual(program),     addCompletion(program)};
    });
}
