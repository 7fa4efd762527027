// Files that are written whole or not at all, where others have put links and leftovers.
#include <gtest/gtest.h>

#include "image/atomic_file.h"
#include "image_test_files.h"

namespace sheen {
namespace {

class AtomicFileTest : public FolderTest {};

TEST_F(AtomicFileTest, appearsOnlyWhenCommitted) {
    {
        AtomicFile out(file("a"));
        out.write("text");
        EXPECT_FALSE(fs::exists(file("a")));
        out.commit();
    }
    EXPECT_EQ(textOf(file("a")), "text");
    EXPECT_EQ(fileCount(), 1);
}

TEST_F(AtomicFileTest, abandonedLeavesWhatWasThere) {
    writeText(file("a"), "old");
    {
        AtomicFile out(file("a"));
        out.write("new");
    }
    EXPECT_EQ(textOf(file("a")), "old");
    EXPECT_EQ(fileCount(), 1);
}

TEST_F(AtomicFileTest, writesThroughSymbolicLinks) {
    fs::create_directory(file("there"));
    writeText(file("there/target"), "old");
    fs::create_symlink("there/target", file("link"));
    AtomicFile out(file("link"));
    out.write("new");
    out.commit();
    EXPECT_TRUE(fs::is_symlink(file("link")));
    EXPECT_EQ(textOf(file("there/target")), "new");
}

TEST_F(AtomicFileTest, keepsPermissions) {
    writeText(file("a"), "old");
    fs::permissions(file("a"), fs::perms::owner_read | fs::perms::owner_write);
    AtomicFile out(file("a"));
    out.commit();
    EXPECT_EQ(fs::status(file("a")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AtomicFileTest, longestName) {
    const std::string name = file(std::string(255, 'n'));
    AtomicFile out(name);
    out.commit();
    EXPECT_TRUE(fs::exists(name));
}

TEST_F(AtomicFileTest, seekOverwrites) {
    AtomicFile out(file("a"));
    out.write("0000text");
    out.seek(0);
    out.write("size");
    EXPECT_EQ(out.position(), 4u);
    out.commit();
    EXPECT_EQ(textOf(file("a")), "sizetext");
}

TEST_F(AtomicFileTest, refusesWhatIsNoFile) {
    expectError(ExitCode::kEnvironment, "is a directory",
                [&] { AtomicFile out(folder_.string()); });
    expectError(ExitCode::kEnvironment, "not a regular file", [] { AtomicFile out("/dev/null"); });
    expectError(ExitCode::kEnvironment, "No such file or directory",
                [&] { AtomicFile out(file("none/a")); });
    expectError(ExitCode::kEnvironment, "Not a directory", [&] {
        writeText(file("plain"), "");
        AtomicFile out(file("plain/a"));
    });
    expectError(ExitCode::kEnvironment, "without a name", [] { AtomicFile out(""); });
    expectError(ExitCode::kEnvironment, "too long",
                [&] { AtomicFile out(file(std::string(256, 'n'))); });
}

TEST_F(AtomicFileTest, checkWritableLeavesNothing) {
    checkWritable(file("a"));
    EXPECT_EQ(fileCount(), 0);
}

TEST_F(AtomicFileTest, signalCleansUp) {
    AtomicFile out(file("a"));
    EXPECT_EQ(fileCount(), 1);
    removePendingTemporaries();
    EXPECT_EQ(fileCount(), 0);
}

TEST_F(AtomicFileTest, writesThroughLinksToWhatDoesNotExistYet) {
    fs::create_directory(file("there"));
    fs::create_symlink("second", file("first"));
    fs::create_symlink(file("there/target"), file("second"));
    AtomicFile out(file("first"));
    EXPECT_EQ(fileCount("there"), 1)
        << "the temporary lies beside the target, which may be on another disk";
    out.write("new");
    out.commit();
    EXPECT_TRUE(fs::is_symlink(file("first")));
    EXPECT_TRUE(fs::is_symlink(file("second")));
    EXPECT_EQ(textOf(file("there/target")), "new");
}

TEST_F(AtomicFileTest, temporariesInUseAreNoLeftovers) {
    AtomicFile out(file("a"));
    writeText(file(".sheen-4000000-0.tmp"), "left");
    checkWritable(file("b"));
    EXPECT_EQ(fileCount(), 1) << "the leftover is gone, that in use is not";
    out.write("text");
    out.commit();
    EXPECT_EQ(textOf(file("a")), "text");
}

TEST_F(AtomicFileTest, sameFileByIdentity) {
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
