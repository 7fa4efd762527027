// The program `judge`: its command line. bench/judge builds and calls it.
#include "judge.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "core/error.h"

namespace {

using namespace sheen;

// A..B, or one number.
void parseSeeds(const std::string& text, bench::StressOptions& options) {
    const size_t dots = text.find("..");
    const std::string last = dots == text.npos ? text : text.substr(dots + 2);
    if (!CLI::detail::lexical_cast(text.substr(0, dots), options.first) ||
        !CLI::detail::lexical_cast(last, options.last)) {
        throwUsage("--seeds {}: not A..B", text);
    }
}

int run(int argc, char** argv) {
    CLI::App app("Judges the program by its reference.", "judge");
    app.require_subcommand(1);

    CLI::App* const points =
        app.add_subcommand("points", "Each approximation alone, by rays at the same points");
    std::string scenes, output;
    std::vector<std::string> studies;
    int records = 0;
    points->add_option("scenes", scenes, "Folder of the scenes")->required();
    points->add_option("output", output, "Folder for tables and plots' data")->required();
    points->add_option("studies", studies)->check(CLI::IsMember(bench::pointStudies()));
    points->add_option("--records", records, "Points a scene at most")->check(CLI::PositiveNumber);

    CLI::App* const sweep =
        app.add_subcommand("sweep", "One render with parameters that are no options");
    std::string scene, reference;
    std::vector<std::string> settings;
    sweep->add_option("scene", scene)->required();
    sweep->add_option("reference", reference, "EXR file of the same view")->required();
    sweep->add_option("settings", settings, "KEY=VALUE, or KEY=@RECORDS to search the value");

    CLI::App* const stress = app.add_subcommand("stress", "Random scenes, what is off flagged");
    bench::StressOptions options;
    std::string seeds = "0..199";
    stress->add_option("--seeds", seeds, "A..B")->capture_default_str();
    stress->add_option("--size", options.size, "Of the square images")->capture_default_str();
    stress->add_option("--spp", options.spp, "Paths a pixel of references")->capture_default_str();
    stress->add_option("--most", options.most, "Paths where fewer tell too little")
        ->capture_default_str();
    stress->add_option("--keep", options.keep, "Folder for images of what is flagged");
    stress->add_flag("--keep-all", options.keep_all, "Also of what is not");

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
    }
    if (points->parsed()) {
        bench::judgePoints(scenes, output, records, studies);
    } else if (sweep->parsed()) {
        bench::sweep(scene, reference, settings);
    } else {
        parseSeeds(seeds, options);
        return bench::stress(options) ? 0 : 1;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const Error& error) {
        fmt::print(stderr, "judge: {}\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        fmt::print(stderr, "judge: bug: {}\n", error.what());
        return 1;
    }
}
