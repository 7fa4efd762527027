// Files that are written whole or not at all, where others have put links and leftovers.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "image/atomic_file.h"
#include "test_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

class AtomicFileFolderTest : public testing::Test {
  protected:
    std::string file(const std::string& name) const { return (folder_.path() / name).string(); }

    TestFolder folder_;
};

int fileCount(const fs::path& folder) {
    return static_cast<int>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string textOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void writeText(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

TEST_F(AtomicFileFolderTest, writesThroughLinksToWhatDoesNotExistYet) {
    fs::create_directory(file("there"));
    fs::create_symlink("second", file("first"));
    fs::create_symlink(file("there/target"), file("second"));
    AtomicFile out(file("first"));
    EXPECT_EQ(fileCount(file("there")), 1)
        << "the temporary lies beside the target, which may be on another disk";
    out.write("new");
    out.commit();
    EXPECT_TRUE(fs::is_symlink(file("first")));
    EXPECT_TRUE(fs::is_symlink(file("second")));
    EXPECT_EQ(textOf(file("there/target")), "new");
}

TEST_F(AtomicFileFolderTest, temporariesInUseAreNoLeftovers) {
    AtomicFile out(file("a"));
    writeText(file(".sheen-4000000-0.tmp"), "left");
    checkWritable(file("b"));
    EXPECT_EQ(fileCount(folder_.path()), 1) << "the leftover is gone, that in use is not";
    out.write("text");
    out.commit();
    EXPECT_EQ(textOf(file("a")), "text");
}

TEST_F(AtomicFileFolderTest, sameFileByIdentity) {
    writeText(file("a"), "");
    writeText(file("b"), "");
    fs::create_hard_link(file("a"), file("hard"));
    fs::create_symlink("a", file("soft"));
    fs::create_symlink("none", file("dangling"));
    fs::create_symlink("circle", file("circle"));
    EXPECT_TRUE(isSameFile(file("a"), file("./a")));
    EXPECT_TRUE(isSameFile(file("a"), file("hard")));
    EXPECT_TRUE(isSameFile(file("soft"), file("a")));
    EXPECT_TRUE(isSameFile(file("none"), file("./none")));
    EXPECT_TRUE(isSameFile(file("dangling"), file("none")));
    EXPECT_FALSE(isSameFile(file("a"), file("b")));
    EXPECT_FALSE(isSameFile(file("a"), file("none")));
    EXPECT_FALSE(isSameFile(file("none"), file("other")));
    EXPECT_FALSE(isSameFile(file("circle"), file("a")));
    EXPECT_FALSE(isSameFile(file("circle"), file("none")));
}

}  // namespace
}  // namespace sheen
