// Records in files: what is written is read, and nothing else is.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "render/record_file.h"
#include "test_folder.h"
#include "test_render.h"

namespace sheen {
namespace {

const RecordOrigin kOrigin = {std::string(32, 'a'), "some options"};

std::string bytesOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
}

// What loading says against; empty: nothing.
std::string refusalOf(const std::string& path, const RecordOrigin& origin) {
    try {
        loadRecords(path, origin);
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ExitCode::kInput);
        return e.what();
    }
    return {};
}

class RecordFile : public testing::Test {
  protected:
    TestFolder folder_;
    const std::string path_ = (folder_.path() / "a.records").string();
};

TEST_F(RecordFile, GivesBackWhatWasKeptSoThatTheImageHasTheSameBits) {
    const Scene scene = glossyRoom();
    const RenderParams params = smallRender(24, 24);
    Session first(scene);
    first.keepRecords();
    const RenderResult drawn = first.render(params);
    const RecordOrigin origin = {sceneFingerprint(scene), recordRecipe(params)};
    saveRecords(path_, first.records(), origin);

    Session second(scene);
    second.keepRecords(loadRecords(path_, origin), origin.recipe);
    const RenderResult redrawn = second.render(params);
    EXPECT_EQ(redrawn.stats.records_reused, drawn.stats.records);
    EXPECT_EQ(redrawn.stats.records, drawn.stats.records);
    ASSERT_EQ(redrawn.frame.indirect.pixels.size(), drawn.frame.indirect.pixels.size());
    EXPECT_EQ(std::memcmp(redrawn.frame.indirect.pixels.data(), drawn.frame.indirect.pixels.data(),
                          drawn.frame.indirect.pixels.size() * sizeof(vec3)),
              0);
}

TEST_F(RecordFile, MayHoldNone) {
    saveRecords(path_, {}, kOrigin);
    EXPECT_EQ(loadRecords(path_, kOrigin).size(), 0u);
}

TEST_F(RecordFile, OfAnotherOriginIsRefused) {
    saveRecords(path_, {}, kOrigin);
    EXPECT_NE(refusalOf(path_, {std::string(32, 'b'), kOrigin.recipe}).find("another scene"),
              std::string::npos);
    EXPECT_NE(refusalOf(path_, {kOrigin.scene, "others"}).find("other options (some options"),
              std::string::npos);
}

TEST_F(RecordFile, CutShortOrChangedAnywhereIsRefused) {
    const Scene scene = glossyRoom();
    Session session(scene);
    session.keepRecords();
    session.render(smallRender(8, 8));
    saveRecords(path_, session.records(), kOrigin);
    EXPECT_EQ(refusalOf(path_, kOrigin), "");
    const std::string whole = bytesOf(path_);
    for (const size_t size :
         {size_t{0}, size_t{5}, size_t{20}, whole.size() / 2, whole.size() - 1}) {
        write(path_, whole.substr(0, size));
        EXPECT_NE(refusalOf(path_, kOrigin), "") << size;
    }
    for (size_t at = 0; at < whole.size(); at += whole.size() / 50) {
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ 0x10);
        write(path_, changed);
        EXPECT_NE(refusalOf(path_, kOrigin), "") << at;
    }
    EXPECT_NE(refusalOf((folder_.path() / "none").string(), kOrigin), "");
}

TEST(SceneFingerprint, FollowsWhatRecordsDependOn) {
    const Scene scene = glossyRoom();
    const std::string print = sceneFingerprint(scene);
    EXPECT_EQ(print.size(), 32u);
    EXPECT_EQ(sceneFingerprint(glossyRoom()), print);
    Scene moved = scene;
    moved.positions[0].x += 1e-3f;
    EXPECT_NE(sceneFingerprint(moved), print);
    Scene lit = scene;
    lit.lights.at(0).intensity *= 2.0f;
    EXPECT_NE(sceneFingerprint(lit), print);
    Scene under_sky = scene;
    under_sky.environment.texels = Image<vec3>(1, 1, vec3(1.0f));
    EXPECT_NE(sceneFingerprint(under_sky), print);
    Scene seen_otherwise = scene;
    seen_otherwise.cameras.clear();
    EXPECT_EQ(sceneFingerprint(seen_otherwise), print);
}

}  // namespace
}  // namespace sheen
