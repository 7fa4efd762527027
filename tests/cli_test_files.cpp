// The program from outside: what it writes and what it must not, on disks and under users as
// hostile as they come.
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli_test.h"

namespace sheen {
namespace {

// So many paths that a render could not end within the test's time limit.
constexpr const char* kEndless =
    "render scene.gltf --method reference --size 4096x4096 --spp 65536 ";
constexpr unsigned kNobody = 65534;

class CliFilesTest : public CliTest {
  protected:
    // An error as expectError() checks it, after which every file has the bytes it had.
    void expectNothingOverwritten(const std::string& arguments, ExitCode code,
                                  const std::string& part) const {
        std::vector<std::string> before;
        for (const std::string& name : files()) {
            before.push_back(textOf(file(name)));
        }
        expectError(arguments, code, part);
        std::vector<std::string> after;
        for (const std::string& name : files()) {
            after.push_back(textOf(file(name)));
        }
        EXPECT_EQ(after, before) << arguments;
    }

    // Runs the program as a user who owns none of the test's files, but may reach them.
    void expectErrorAsNobody(const std::string& arguments, const std::string& part) const {
        fs::copy_file(SHEEN_PROGRAM, base_.path() / "sheen", fs::copy_options::skip_existing);
        fs::permissions(base_.path(), fs::perms(0755));
        const std::vector<std::string> before = files();
        const std::string command = fmt::format(
            "cd '{}' && setpriv --reuid {} --regid {} --clear-groups '{}/sheen' {} 2>'{}/err' "
            "</dev/null",
            folder_.string(), kNobody, kNobody, base_.path().string(), arguments,
            base_.path().string());
        const int status = std::system(command.c_str());
        const std::string err = textOf(base_.path() / "err");
        EXPECT_EQ(WEXITSTATUS(status), 4) << arguments << "\n" << err;
        EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
        EXPECT_NE(err.find(part), std::string::npos) << arguments << "\n" << err;
        EXPECT_EQ(files(), before) << arguments;
    }
};

// A file system of its own at a folder, while it lives.
class Mount {
  public:
    Mount(std::string folder, const char* options) : folder_(std::move(folder)) {
        fs::create_directory(folder_);
        mounted_ = mount("tmpfs", folder_.c_str(), "tmpfs", 0, options) == 0;
    }
    ~Mount() {
        if (mounted_) {
            umount2(folder_.c_str(), MNT_DETACH);
        }
    }
    Mount(const Mount&) = delete;
    Mount& operator=(const Mount&) = delete;
    bool mounted() const { return mounted_; }
    bool makeReadOnly() const {
        return mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr) == 0;
    }

  private:
    std::string folder_;
    bool mounted_ = false;
};

TEST_F(CliFilesTest, outputsThatWouldOverwriteAnInput) {
    fs::create_symlink("scene.gltf", file("soft.gltf"));
    fs::create_symlink("scene.gltf", file("soft.exr"));
    fs::create_hard_link(file("scene.gltf"), file("hard.png"));
    const char* const what = "would overwrite";
    for (const char* outputs :
         {"--json scene.gltf", "--json ./scene.gltf", "--json soft.gltf", "--json hard.png",
          "-o soft.exr", "-o hard.png", "--json scene.bin", "--json ../work/scene.bin"}) {
        expectNothingOverwritten(fmt::format("{}{}", kEndless, outputs), ExitCode::kUsage, what);
    }
    expectNothingOverwritten("info scene.gltf --json scene.bin", ExitCode::kUsage, what);
    expectNothingOverwritten("info soft.gltf --json scene.gltf", ExitCode::kUsage, what);
    // A scene is one by its content, so that the default image may have its name.
    fs::rename(file("scene.gltf"), file("scene.exr"));
    expectNothingOverwritten("render scene.exr", ExitCode::kUsage, what);

    fs::create_directory(file("charts"));
    fs::rename(file("scene.exr"), file("charts/chart.json"));
    fs::rename(file("scene.bin"), file("charts/scene.bin"));
    const std::string scene = textOf(file("charts/chart.json"));
    expectError("chart charts/chart.json -o charts", ExitCode::kUsage, what);
    EXPECT_EQ(textOf(file("charts/chart.json")), scene);
}

TEST_F(CliFilesTest, comparisonsThatWouldOverwriteAnInput) {
    ASSERT_EQ(call(std::string(kReference) + " -o a.exr").code, 0);
    fs::copy_file(file("a.exr"), file("b.exr"));
    fs::create_symlink("b.exr", file("b.png"));
    for (const char* outputs : {"--json a.exr", "--json b.exr", "--heatmap b.png"}) {
        expectNothingOverwritten(fmt::format("compare a.exr b.exr {}", outputs), ExitCode::kUsage,
                                 "would overwrite");
    }
}

TEST_F(CliFilesTest, outputsThatAreOneFile) {
    expectError("render scene.gltf -o a.exr --json a.exr", ExitCode::kUsage, "is the file of -o");
    expectError("render scene.gltf -o a.exr --json ./a.exr", ExitCode::kUsage, "is the file of -o");
    fs::create_symlink("a.exr", file("link"));
    expectError("render scene.gltf -o a.exr --json link", ExitCode::kUsage, "is the file of -o");
    expectError("compare a.exr b.exr --heatmap h.png --json h.png", ExitCode::kUsage,
                "is the file of --heatmap");
}

TEST_F(CliFilesTest, emptyNames) {
    for (const char* arguments :
         {"render ''", "render scene.gltf -o ''", "render scene.gltf --output=''",
          "render scene.gltf --json ''", "info scene.gltf --json ''", "compare a.exr ''",
          "compare a.exr b.exr --json ''", "compare a.exr b.exr --heatmap ''",
          "chart scene.gltf -o ''", "chart '' -o charts"}) {
        expectError(arguments, ExitCode::kUsage, "");
    }
}

TEST_F(CliFilesTest, namesThatAreTooLong) {
    const std::string name(300, 'n');
    expectError(fmt::format("{}-o {}.exr", kEndless, name), ExitCode::kEnvironment,
                "File name too long");
    expectError(fmt::format("{}--json {}", kEndless, name), ExitCode::kEnvironment,
                "File name too long");
    // As long as may be, so that no temporary name fits beside it that holds it.
    EXPECT_EQ(call(fmt::format("{} -o {}.exr", kReference, name.substr(0, 251))).code, 0);
}

TEST_F(CliFilesTest, linksAreFollowed) {
    fs::create_directory(file("there"));
    fs::create_symlink("there/a.exr", file("a.exr"));
    ASSERT_EQ(call(std::string(kReference) + " -o a.exr").code, 0);
    EXPECT_TRUE(fs::is_symlink(file("a.exr")));
    EXPECT_TRUE(fs::is_regular_file(file("there/a.exr"))) << "that did not exist";
    ASSERT_EQ(call(std::string(kReference) + " -o a.exr --seed 1").code, 0);
    EXPECT_TRUE(fs::is_symlink(file("a.exr"))) << "to a file that exists";

    fs::create_symlink("nowhere/b.exr", file("b.exr"));
    expectError(std::string(kEndless) + "-o b.exr", ExitCode::kEnvironment,
                "b.exr: cannot write to nowhere/b.exr");
    fs::create_symlink("c.exr", file("c.exr"));
    expectError(std::string(kEndless) + "-o c.exr", ExitCode::kEnvironment, "symbolic links");
}

TEST_F(CliFilesTest, foldersOfAnotherUser) {
    if (geteuid() != 0) {
        GTEST_SKIP() << "only root can become another user";
    }
    expectErrorAsNobody(std::string(kEndless) + "-o a.exr", "a.exr: cannot write: Permission");
    expectErrorAsNobody("info scene.gltf --json a.json", "a.json: cannot write: Permission");
    expectErrorAsNobody("chart scene.gltf -o charts", "charts: cannot make this folder");

    std::ofstream(file("theirs.exr")) << "a file of another user\n";
    fs::permissions(file("theirs.exr"), fs::perms(0644));
    fs::permissions(folder_, fs::perms(0777));
    expectErrorAsNobody(std::string(kEndless) + "-o theirs.exr", "Permission denied");
    // As in /tmp: who may write the file may still not replace it.
    fs::permissions(file("theirs.exr"), fs::perms(0666));
    fs::permissions(folder_, fs::perms(01777));
    expectErrorAsNobody(std::string(kEndless) + "-o theirs.exr", "belongs to another user");
}

TEST_F(CliFilesTest, fullAndReadOnlyDisks) {
    const Mount disk(file("disk"), "size=16k");
    if (!disk.mounted()) {
        GTEST_SKIP() << "no file system can be mounted here";
    }
    std::ofstream(file("disk/old.exr")) << "an older image\n";
    const auto on_disk = [this] {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(file("disk"))) {
            names.push_back(entry.path().filename().string());
        }
        return names;
    };
    for (const char* image : {"disk/old.exr", "disk/new.exr", "disk/new.png"}) {
        const Outcome run = call(fmt::format(
            "render scene.gltf --method reference --size 512x512 --spp 4 -o {}", image));
        EXPECT_EQ(run.code, 4) << run.err;
        EXPECT_NE(run.err.find(fmt::format("sheen: error: {}: cannot write: No space left", image)),
                  std::string::npos)
            << run.err;
        EXPECT_EQ(on_disk(), std::vector<std::string>{"old.exr"});
        EXPECT_EQ(textOf(file("disk/old.exr")), "an older image\n");
    }
    ASSERT_TRUE(disk.makeReadOnly());
    for (const char* outputs : {"-o disk/old.exr", "-o disk/new.exr", "--json disk/new.json"}) {
        expectError(fmt::format("{}{}", kEndless, outputs), ExitCode::kEnvironment,
                    "Read-only file system");
    }
}

TEST_F(CliFilesTest, leftoversOfKilledRunsAreRemoved) {
    const auto leftovers = [this] {
        int count = 0;
        for (const std::string& name : files()) {
            count += name.rfind(".sheen-", 0) == 0 ? 1 : 0;
        }
        return count;
    };
    std::ofstream(file(".sheen-4000000-0.tmp")) << "of a run that was killed\n";
    std::ofstream(file(".sheen-4000000-12.tmp")) << "another\n";
    for (const char* name : {".sheen-1-1.tmp.bak", ".sheen-1.tmp", "sheen-1-1.tmp",
                             ".sheen-x-1.tmp", ".sheen- 1-1.tmp"}) {
        std::ofstream(file(name)) << "of the user\n";
    }
    fs::create_directory(file(".sheen-2-2.tmp"));
    const size_t before = files().size();
    ASSERT_EQ(call("info scene.gltf").code, 0);
    EXPECT_EQ(files().size(), before) << "writes nothing";
    ASSERT_EQ(call("info scene.gltf --json a.json").code, 0);
    EXPECT_EQ(files().size(), before - 1) << "two less, a.json more";
    EXPECT_FALSE(fs::exists(file(".sheen-4000000-0.tmp")));
    EXPECT_FALSE(fs::exists(file(".sheen-4000000-12.tmp")));
    EXPECT_EQ(leftovers(), 5) << "those of the user";
}

TEST_F(CliFilesTest, anIgnoredHangUpStaysIgnored) {
    const std::string command = fmt::format(
        "cd '{}' && trap '' HUP && ('{}' chart scene.gltf -o charts --methods reference --size 8x8 "
        "--reference-spp 32 --repeats 1 & chart=$!; until [ -d charts/points ]; do sleep 0.01; "
        "done; kill -HUP $chart; wait $chart) >/dev/null 2>&1 </dev/null",
        folder_.string(), SHEEN_PROGRAM);
    EXPECT_EQ(std::system(command.c_str()), 0);
    EXPECT_TRUE(fs::exists(file("charts/chart.html")));
}

}  // namespace
}  // namespace sheen
