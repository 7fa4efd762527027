// stages SCENES [--threads N] [--workers N] [--benchmark_...]: how long each stage of a render
// takes, alone (Google Benchmark). `bench/run` runs it in every way that docs/performance.md shows.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <charconv>

#include "core/error.h"
#include "core/parallel.h"
#include "stages_setup.h"

namespace {

using namespace sheen;

int number(std::string_view text) {
    int value = 0;
    const char* end = text.data() + text.size();
    if (std::from_chars(text.data(), end, value).ptr != end || value < 1) {
        throwUsage("{}: not a number above 0", text);
    }
    return value;
}

void measure(const std::vector<std::string>& arguments) {
    std::string scenes;
    int threads = 0, workers = 1;
    for (size_t i = 0; i < arguments.size(); ++i) {
        const bool takes_value = arguments[i] == "--threads" || arguments[i] == "--workers";
        if (takes_value && i + 1 < arguments.size()) {
            (arguments[i] == "--threads" ? threads : workers) = number(arguments[i + 1]);
            ++i;
        } else if (scenes.empty() && !arguments[i].starts_with("-")) {
            scenes = arguments[i];
        } else {
            throwUsage("{}: no such option, or without its value", arguments[i]);
        }
    }
    if (scenes.empty()) {
        throwUsage("usage: stages SCENES [--threads N] [--workers N] [--benchmark_...]");
    }
    setThreadCount(threads);
    benchmark::AddCustomContext("threads", std::to_string(threadCount()));
    benchmark::AddCustomContext("gl_workers", std::to_string(workers));
    bench::Setup setup(scenes, workers);
    bench::registerStartup(setup);
    bench::registerGather(setup);
    bench::registerImage(setup);
    if (benchmark::RunSpecifiedBenchmarks() == 0) {
        throwUsage("no benchmark has such a name");
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        benchmark::Initialize(&argc, argv);  // takes its own options out
        measure({argv + 1, argv + argc});
        return 0;
    } catch (const Error& error) {
        fmt::print(stderr, "stages: {}\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        fmt::print(stderr, "stages: bug: {}\n", error.what());
        return 1;
    }
}
