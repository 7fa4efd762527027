// The program under mpirun, from outside.
#include <cstdlib>
#include <sstream>

#include "cli_test_animate.h"

namespace sheen {
namespace {

const char* const kFrames = "animate scene.gltf --fps 4 --size 16x12 --threads 1";
constexpr int kCount = 9;  // 0 to 8, of 2 s

// What mpirun says of a rank that failed is its own: lines of the program alone.
std::vector<std::string> linesOf(const Outcome& run) {
    std::vector<std::string> lines;
    std::istringstream in(run.err);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("sheen: ")) {
            lines.push_back(line);
        }
    }
    return lines;
}

class MpiAnimate : public CliAnimate {
  protected:
    void SetUp() override {
        CliAnimate::SetUp();
        setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);  // as in containers
        setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
        setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 1);
    }

    // `programs`: of mpirun, "-n 2 PROGRAM ARGUMENT... : -n 1 ...".
    // mpirun itself may wait for ever where a rank was killed at a bad moment.
    Outcome mpirun(const std::string& programs) const {
        return callShell(fmt::format("timeout -s KILL 120 {} {}", SHEEN_MPIRUN, programs));
    }
    Outcome onRanks(int count, const std::string& arguments) const {
        return mpirun(fmt::format("-n {} {} {}", count, SHEEN_PROGRAM, arguments));
    }
    // The rank's disk is full after 512 bytes, which no message passes through.
    static std::string onFullDisk(const std::string& arguments) {
        return fmt::format("--mca btl self,tcp sh -c 'ulimit -f 1 && exec {} {}'",
                           SHEEN_MPI_PROGRAM, arguments);
    }

    std::string framesTo(const std::string& folder) const {
        return fmt::format("{} --method irradiance --aa 1 --bounces 1 -o {}/%d.exr", kFrames,
                           folder);
    }
    // All frames, as one process makes them.
    void makeAlone() const { ASSERT_EQ(call(framesTo("alone")).code, 0); }
    void expectSameAsAlone(const std::string& folder) const {
        for (int frame = 0; frame < kCount; ++frame) {
            const std::string name = fmt::format("{}.exr", frame);
            EXPECT_TRUE(textOf(folder_ / folder / name) == textOf(folder_ / "alone" / name))
                << folder << "/" << name;
        }
        expectNothingElse(folder);
    }
    // No temporaries, nothing cut short.
    void expectNothingElse(const std::string& folder) const {
        for (const auto& entry : fs::directory_iterator(folder_ / folder)) {
            const std::string name = entry.path().filename().string();
            EXPECT_TRUE(name == "sequence.json" ||
                        textOf(entry.path()) == textOf(folder_ / "alone" / name))
                << entry.path();
        }
    }
};

TEST_F(MpiAnimate, SameBitsForAnyNumberOfRanks) {
    makeAlone();
    for (const int ranks : {1, 2, 3, 8}) {
        const std::string folder = fmt::format("ranks{}", ranks);
        const Outcome run = onRanks(ranks, framesTo(folder) + " --json -");
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(linesOf(run), std::vector<std::string>{});
        const Json json = Json::parse(run.out);
        ASSERT_EQ(json["frames"].size(), size_t{kCount});
        for (int frame = 0; frame < kCount; ++frame) {
            EXPECT_EQ(json["frames"][frame]["frame"], frame);
        }
        expectSameAsAlone(folder);
    }
}

TEST_F(MpiAnimate, PngsTakeTheExposureOfTheFirst) {
    const std::string options = fmt::format("{} --method reference --spp 4", kFrames);
    ASSERT_EQ(call(options + " -o alone/%d.png").code, 0);
    const Outcome run = onRanks(3, options + " -o ranks/%d.png");
    ASSERT_EQ(run.code, 0) << run.err;
    for (const char* name : {"0.png", "1.png", "8.png", "sequence.json"}) {
        EXPECT_TRUE(textOf(folder_ / "alone" / name) == textOf(folder_ / "ranks" / name)) << name;
    }
}

TEST_F(MpiAnimate, ContinuesWhatAnotherNumberOfRanksBegan) {
    makeAlone();
    ASSERT_EQ(onRanks(3, framesTo("parts") + " --frames 0..5").code, 0);
    fs::remove(file("parts/2.exr"));
    const Outcome rest = onRanks(2, framesTo("parts") + " --json -");
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(Json::parse(rest.out)["kept"], 5);
    expectSameAsAlone("parts");
}

TEST_F(MpiAnimate, WhatAKilledRankLeavesIsWhole) {
    makeAlone();
    // Whenever the second rank is killed, before it begins or after it has ended.
    for (const char* seconds : {"0.3", "0.6", "1"}) {
        const std::string folder = fmt::format("killed_after_{}", seconds);
        mpirun(fmt::format("-n 1 {} {} : -n 1 timeout -s KILL {} {} {}", SHEEN_MPI_PROGRAM,
                           framesTo(folder), seconds, SHEEN_MPI_PROGRAM, framesTo(folder)));
        const Outcome rest = onRanks(2, framesTo(folder));
        ASSERT_EQ(rest.code, 0) << rest.err;
        expectSameAsAlone(folder);
    }
}

TEST_F(MpiAnimate, OthersDoWhatARankWithAFullDiskCannot) {
    makeAlone();
    const Outcome run = mpirun(fmt::format("-n 1 {} : -n 2 {} {}", onFullDisk(framesTo("ranks")),
                                           SHEEN_MPI_PROGRAM, framesTo("ranks")));
    EXPECT_EQ(run.code, 0) << run.err;
    const std::vector<std::string> lines = linesOf(run);
    ASSERT_EQ(lines.size(), 1u) << run.err;
    EXPECT_TRUE(lines[0].starts_with("sheen: warning: rank 0 on ")) << lines[0];
    EXPECT_NE(lines[0].find("0.exr: cannot write"), std::string::npos) << lines[0];
    expectSameAsAlone("ranks");
}

TEST_F(MpiAnimate, FullDisksOfAllRanksEndIt) {
    const Outcome run = mpirun("-n 2 " + onFullDisk(framesTo("ranks")));
    EXPECT_EQ(run.code, 4) << run.err;
    const std::vector<std::string> lines = linesOf(run);
    ASSERT_EQ(lines.size(), 3u) << run.err;
    EXPECT_TRUE(lines[2].starts_with("sheen: error: rank ")) << lines[2];
    EXPECT_TRUE(lines[2].ends_with("; 0 of 9 are done")) << lines[2];
    expectNothingElse("ranks");
}

TEST_F(MpiAnimate, ARankOfAnotherBuildIsLeftOut) {
    makeAlone();
    fs::copy_file(SHEEN_MPI_PROGRAM, file("other-build"));
    std::ofstream(file("other-build"), std::ios::app) << " ";
    const Outcome run = mpirun(fmt::format("-n 2 {} {} : -n 1 ./other-build {}", SHEEN_MPI_PROGRAM,
                                           framesTo("ranks"), framesTo("ranks")));
    EXPECT_EQ(run.code, 0) << run.err;
    const std::vector<std::string> lines = linesOf(run);
    ASSERT_EQ(lines.size(), 1u) << run.err;
    EXPECT_TRUE(lines[0].starts_with("sheen: warning: rank 2 on ")) << lines[0];
    EXPECT_NE(lines[0].find(": is sheen "), std::string::npos) << lines[0];
    expectSameAsAlone("ranks");
}

TEST_F(MpiAnimate, ARankWithOtherOptionsIsGivenNothing) {
    const Outcome run =
        mpirun(fmt::format("-n 1 {} : -n 1 {} {} --accuracy 0.3", onFullDisk(framesTo("ranks")),
                           SHEEN_MPI_PROGRAM, framesTo("ranks")));
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_NE(run.err.find("rank 1 on "), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("other options"), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(file("ranks/0.exr")));
}

TEST_F(MpiAnimate, ErrorsOfAllRanksAreOneLine) {
    const auto expect_line = [&](const std::string& arguments, int code, const char* part) {
        const Outcome run = onRanks(3, arguments);
        EXPECT_EQ(run.code, code) << run.err;
        const std::vector<std::string> lines = linesOf(run);
        ASSERT_EQ(lines.size(), 1u) << run.err;
        EXPECT_TRUE(lines[0].starts_with("sheen: error: ")) << lines[0];
        EXPECT_NE(lines[0].find(part), std::string::npos) << lines[0];
    };
    expect_line("animate scene.gltf", 2, "--output is required");
    expect_line("animate none.gltf -o %d.exr", 3, "none.gltf");
    expect_line("animate scene.gltf -o %d.exr --lifespan 4", 2, "--lifespan");
    expect_line("animate scene.gltf -o %d.exr --anchors", 2, "--anchors");
    expect_line("animate scene.gltf -o scene.bin/%d.exr", 4, "scene.bin");
}

TEST_F(MpiAnimate, BakedLightHasTheSameBits) {
    const std::string bake = "bake scene.gltf --size 24 --accuracy 1 --threads 1";
    for (const char* method : {"records", "texels"}) {
        const std::string options = fmt::format("{} --method {}", bake, method);
        ASSERT_EQ(call(options + " -o alone.exr").code, 0);
        for (const int ranks : {1, 2, 3, 8}) {
            const Outcome run = onRanks(ranks, options + " -o ranks.exr");
            ASSERT_EQ(run.code, 0) << run.err;
            EXPECT_EQ(linesOf(run).size(), 1u) << "of the first rank: the file moves\n" << run.err;
            EXPECT_TRUE(textOf(file("ranks.exr")) == textOf(file("alone.exr")))
                << method << ", " << ranks << " ranks";
            fs::remove(file("ranks.exr"));
        }
    }
    const Outcome paths = onRanks(2, bake + " --method reference -o ranks.exr");
    EXPECT_EQ(paths.code, 2) << paths.err;
    EXPECT_FALSE(fs::exists(file("ranks.exr")));
}

TEST_F(MpiAnimate, AFrameWhoseRecordsAllGatherHasTheSameBits) {
    // Light kept at elements, by photons, and none; several passes, which look differently.
    for (const char* options : {"", "--kept-by photons", "--bounces 1", "--target-error 0.02"}) {
        const std::string render =
            fmt::format("render scene.gltf --size 24x16 --threads 1 {}", options);
        ASSERT_EQ(call(render + " -o alone.exr").code, 0) << options;
        const Outcome run = onRanks(3, render + " -o ranks.exr");
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_TRUE(textOf(file("ranks.exr")) == textOf(file("alone.exr"))) << options;
        fs::remove(file("ranks.exr"));
    }
    for (const char* options : {"--method reference --spp 4", "--gather hemicube --bounces 1"}) {
        const Outcome run = onRanks(
            2, fmt::format("render scene.gltf --size 24x16 --aa 1 {} -o ranks.exr", options));
        EXPECT_EQ(run.code, 2) << run.err;
        ASSERT_EQ(linesOf(run).size(), 2u) << "the file moves\n" << run.err;
        EXPECT_NE(linesOf(run)[1].find("run it without mpirun"), std::string::npos) << run.err;
        EXPECT_FALSE(fs::exists(file("ranks.exr")));
    }
}

TEST_F(MpiAnimate, PointsOfAChartAreMeasuredOnce) {
    const std::string chart =
        "chart scene.gltf --methods reference,irradiance --size 16x12 --reference-spp 64 "
        "--repeats 1 -o chart";
    const Outcome run = onRanks(3, chart);
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(textOf(file("chart/chart.json")));
    EXPECT_EQ(json["scenes"][0]["points"].size(), 10u);
    std::vector<std::string> there;
    for (const auto& entry : fs::directory_iterator(file("chart"))) {
        there.push_back(entry.path().filename().string());
    }
    std::sort(there.begin(), there.end());
    EXPECT_EQ(there, (std::vector<std::string>{"chart.csv", "chart.html", "chart.json", "points",
                                               "references"}));
    const Outcome again = onRanks(3, chart);  // by as many threads each
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(Json::parse(textOf(file("chart/chart.json")))["scenes"], json["scenes"]);
}

TEST_F(MpiAnimate, WithoutThePackageItSaysWhichIsMissing) {
    fs::create_directories(file("bin"));
    fs::copy_file(SHEEN_PROGRAM, file("bin/sheen"));
    const Outcome run = mpirun("-n 2 bin/sheen animate scene.gltf -o %d.exr");
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_NE(run.err.find("install the package sheen-mpi"), std::string::npos) << run.err;
    EXPECT_EQ(mpirun("-n 1 bin/sheen animate scene.gltf --frames 0..1 -o %d.exr --size 16x12").code,
              0);
}

}  // namespace
}  // namespace sheen
