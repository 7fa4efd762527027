// The program from outside: exit codes, one line for every error.
#include "cli_test.h"

namespace sheen {
namespace {

TEST_F(CliTest, versionAndHelp) {
    EXPECT_EQ(call("--version").code, 0);
    EXPECT_EQ(call("--version").out.rfind("sheen ", 0), 0u);
    for (const char* arguments :
         {"--help", "render --help", "compare -h", "info --help", "chart --help", "bake --help"}) {
        const Outcome run = call(arguments);
        EXPECT_EQ(run.code, 0) << arguments;
        EXPECT_NE(run.out.find("Usage: "), std::string::npos) << arguments;
        EXPECT_EQ(run.err, "") << arguments;
    }
}

TEST_F(CliTest, helpStatesDefaults) {
    const std::string help = call("render --help").out;
    for (const char* text : {"512x512", "=radiance", "=0.4", "ray}=ray", "=256", "=basic"}) {
        EXPECT_NE(help.find(text), std::string::npos) << text;
    }
}

TEST_F(CliTest, wrongCommands) {
    expectError("", ExitCode::kUsage, "subcommand is required");
    expectError("paint scene.gltf", ExitCode::kUsage, "paint: no such subcommand");
    expectError("render", ExitCode::kUsage, "SCENE is required (see sheen render --help)");
    expectError("render scene.gltf --fast", ExitCode::kUsage, "not expected: --fast");
    expectError("render scene.gltf other.gltf", ExitCode::kUsage, "not expected: other.gltf");
    expectError("render scene.gltf --size 8x8 --size 9x9", ExitCode::kUsage, "--size");
    expectError("compare a.exr", ExitCode::kUsage, "REFERENCE is required");
}

TEST_F(CliTest, environmentsThatCannotBe) {
    const auto expect = [this](const char* option, ExitCode code, const char* part) {
        expectError(
            fmt::format("render scene.gltf --method reference -o a.exr --environment {}", option),
            code, part);
    };
    expect("no.hdr", ExitCode::kInput, "no.hdr: no such file");
    expect("no.exr", ExitCode::kInput, "no.exr: no such file");
    expect("scene.bin", ExitCode::kInput, "scene.bin: not an environment");
    expect("1,2", ExitCode::kInput, "1,2: not an environment");
    expect("1,2,1e13", ExitCode::kUsage, "must be 0..1e+12 nits");
    expect("''", ExitCode::kUsage, "name is empty");
    expect("1,1,1 --environment-strength -1", ExitCode::kUsage, "-1");
    expect("1,1,1 --environment-rotation 361", ExitCode::kUsage, "361");
    for (const char* gather : {"hemicube", "border"}) {
        expectError(fmt::format("render scene.gltf --environment 1,1,1 --gather {}", gather),
                    ExitCode::kUsage, "--gather ray");
    }
    for (const char* option : {"--environment-rotation 10", "--environment-strength 2"}) {
        expectError(fmt::format("render scene.gltf {}", option), ExitCode::kUsage, "--environment");
    }
}

TEST_F(CliTest, optionsOutOfRange) {
    for (const char* option : {"--size 0x8",
                               "--size 8",
                               "--size 8x",
                               "--size x8",
                               "--size 8x8x8",
                               "--size 16385x8",
                               "--size -8x8",
                               "--size 8x99999999999999999999",
                               "--accuracy 0",
                               "--accuracy 2.1",
                               "--accuracy nan",
                               "--accuracy inf",
                               "--accuracy 0.1x",
                               "--target-error 0",
                               "--target-error 0.6",
                               "--target-error nan",
                               "--target-error 1%",
                               "--time-limit 0",
                               "--time-limit nan",
                               "--time-limit 2s",
                               "--sh-order 1",
                               "--sh-order 11",
                               "--sh-order best",
                               "--gather sphere",
                               "--placement some",
                               "--gather-size 7",
                               "--gather-size 513",
                               "--gather-size 64.5",
                               "--gather-extent 0.5",
                               "--gather-extent 11",
                               "--method magic",
                               "--method octree --accuracy 0",
                               "--method octree --gather-size 7",
                               "--method hints --hints 63",
                               "--method hints --hints 65537",
                               "--method hints --hints many",
                               "--method hints --sh-order 4",
                               "--method hints --caustics 1000",
                               "--method hints --aa 4",
                               "--method denoised --spp 0",
                               "--method reference --spp 0",
                               "--method reference --spp 65537",
                               "--method reference --seed -1",
                               "--method reference --bounces 0",
                               "--bounces 65",
                               "--bounces some",
                               "--gather plane --bounces 2",
                               "--gather hemicube --bounces all",
                               "--caustics 0",
                               "--caustics 999",
                               "--caustics some",
                               "--caustics 1e9",
                               "--gather plane --caustics 1000",
                               "--method denoised --caustics 1000",
                               "--threads -1",
                               "--threads 257",
                               "--layers some",
                               "--exposure bright -o a.png",
                               "--exposure nan -o a.png",
                               "--exposure 51 -o a.png",
                               "--accuracy"}) {
        const std::string text = option;
        const std::string name = text.substr(0, text.find(' '));
        expectError("render scene.gltf " + text, ExitCode::kUsage,
                    name == "--method" && text.find(" --") != std::string::npos ? "--" : name);
    }
}

TEST_F(CliTest, optionsTheMethodDoesNotSupport) {
    for (const char* option :
         {"--accuracy 0.1", "--target-error 0.02", "--time-limit 2", "--gather plane",
          "--gather-size 32", "--spp 16", "--seed 1", "--placement scan"}) {
        expectError(fmt::format("render scene.gltf --method hints {}", option), ExitCode::kUsage,
                    "not an option of --method hints");
    }
    expectError("render scene.gltf --hints 100", ExitCode::kUsage,
                "--hints: not an option of --method radiance");
    for (const char* option : {"--spp 16", "--seed 1"}) {
        expectError(fmt::format("render scene.gltf {}", option), ExitCode::kUsage, "radiance");
        expectError(fmt::format("render scene.gltf --method irradiance {}", option),
                    ExitCode::kUsage, "irradiance");
    }
    expectError("render scene.gltf --method irradiance --sh-order 4", ExitCode::kUsage,
                "--sh-order: not an option of --method irradiance");
    for (const char* method : {"reference", "denoised"}) {
        for (const char* option :
             {"--accuracy 0.1", "--target-error 0.02", "--time-limit 2", "--sh-order 4",
              "--gather plane", "--gather-size 32", "--gather-extent 2", "--placement kmeans"}) {
            expectError(fmt::format("render scene.gltf --method {} {}", method, option),
                        ExitCode::kUsage, fmt::format("not an option of --method {}", method));
        }
    }
    for (const char* option :
         {"--spp 16", "--seed 1", "--target-error 0.02", "--bounces 2", "--caustics 1000",
          "--sh-order 4", "--gather plane", "--gather-extent 2", "--placement kmeans"}) {
        expectError(fmt::format("render scene.gltf --method octree {}", option), ExitCode::kUsage,
                    "--method octree");
    }
    expectError("render scene.gltf --target-error 0.02 --accuracy 0.1", ExitCode::kUsage,
                "--accuracy");
    for (const char* other : {"--accuracy 0.1", "--target-error 0.02"}) {
        expectError(fmt::format("render scene.gltf --time-limit 2 {}", other), ExitCode::kUsage,
                    "--time-limit");
    }
    for (const char* gather : {"hemicube", "ray"}) {
        expectError(fmt::format("render scene.gltf --gather {} --gather-extent 2", gather),
                    ExitCode::kUsage, fmt::format("not an option of --gather {}", gather));
    }
}

TEST_F(CliTest, optionsTheFileDoesNotSupport) {
    expectError("render scene.gltf -o a.exr --exposure 1", ExitCode::kUsage, "for PNG only");
    expectError("render scene.gltf -o a.exr --tone none", ExitCode::kUsage, "for PNG only");
    expectError("render scene.gltf -o a.png --tone filmic", ExitCode::kUsage, "filmic");
    expectError("render scene.gltf -o a.png --layers all", ExitCode::kUsage, "for EXR only");
    expectError("render scene.gltf -o a.jpg", ExitCode::kUsage, "must end in .exr or .png");
    expectError("render scene.gltf -o a", ExitCode::kUsage, "must end in .exr or .png");
    expectError("compare a.exr b.exr --layer normal", ExitCode::kUsage, "--layer");
    expectError("compare a.exr b.exr --heatmap h.exr", ExitCode::kUsage, "must be a .png");
}

TEST_F(CliTest, badScenes) {
    std::ofstream(file("text.glb")) << "this is no scene\n";
    std::ofstream(file("empty.glb")) << "";
    fs::create_directory(file("folder.glb"));
    for (const char* command : {"render", "info"}) {
        for (const char* scene : {"none.glb", "text.glb", "empty.glb", "folder.glb"}) {
            expectError(fmt::format("{} {}", command, scene), ExitCode::kInput, scene);
        }
    }
}

TEST_F(CliTest, unknownCamera) {
    expectError(std::string(kReference) + " --camera side", ExitCode::kUsage, "--camera side");
    expectError(std::string(kReference) + " --camera 7", ExitCode::kUsage, "front");
    expectError(std::string(kReference) + " --camera-at 1,2", ExitCode::kUsage, "must be X,Y,Z");
    expectError(std::string(kReference) + " --look-at 1,2,3,4", ExitCode::kUsage, "must be X,Y,Z");
    expectError(std::string(kReference) + " --crop 1,2,3", ExitCode::kUsage, "must be X,Y,W,H");
    expectError(std::string(kReference) + " --crop 0,0,17,1", ExitCode::kUsage, "must lie in");
    expectError(std::string(kReference) + " --fov 180", ExitCode::kUsage, "--fov");
    expectError(std::string(kReference) + " --variant red", ExitCode::kUsage, "has none");
}

TEST_F(CliTest, unwritableOutputIsFoundBeforeRendering) {
    // So many paths that a render could not end within the test's time limit.
    const std::string endless =
        "render scene.gltf --method reference --size 4096x4096 --spp 65536 ";
    fs::create_directory(file("folder.exr"));
    expectError(endless + "-o none/a.exr", ExitCode::kEnvironment, "none/a.exr: cannot write");
    expectError(endless + "-o folder.exr", ExitCode::kEnvironment, "is a directory");
    expectError(endless + "-o a.exr --json none/a.json", ExitCode::kEnvironment, "none/a.json");
    expectError("info scene.gltf --json none/a.json", ExitCode::kEnvironment, "none/a.json");
}

TEST_F(CliTest, fullStandardOutput) {
    const Outcome run = call("info scene.gltf --json - >/dev/full");
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_NE(run.err.find("standard output"), std::string::npos);
    EXPECT_EQ(call("info scene.gltf >/dev/full").code, 4);
    EXPECT_EQ(call("--help >/dev/full").code, 4);
}

TEST_F(CliTest, nobodyReadsTheErrors) {
    EXPECT_EQ(call("info none.gltf 2>/dev/full").code, 3);
    EXPECT_EQ(call("info none.gltf 2>&-").code, 3);
    EXPECT_EQ(call("render 2>/dev/full").code, 2);
}

TEST_F(CliTest, numbersAreDecimal) {
    for (const char* option : {"--spp 010", "--seed 07", "--seed -1", "--threads 01"}) {
        expectError(std::string(kReference) + " " + option, ExitCode::kUsage, "is not a number");
    }
    EXPECT_EQ(call("render scene.gltf --size 8x8 --accuracy 0.5").code, 0);
}

}  // namespace
}  // namespace sheen
