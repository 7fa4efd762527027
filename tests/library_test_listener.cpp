// Who hears of a call, and that nobody else does.
#include <map>

#include "library_test.h"

namespace sheen {
namespace {

// Nothing lights it: a warning each of loading.
Arrays darkFloor() {
    Arrays scene = floorBelow({});
    scene.lights.clear();
    return scene;
}

TEST(LibraryListener, HearsWarningsAndNothingIsPrinted) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    std::vector<std::string> warnings;
    const Listener listener{.warning = [&](const std::string& what) { warnings.push_back(what); }};
    Session(Scene::fromArrays(darkFloor(), {}, listener)).render(small(), listener);
    Session(Scene::fromArrays(darkFloor())).render(small());  // to no one
    Session(Scene::load(scenePath("cornell_glossy")))
        .render({{"method", "reference"}, {"size", "64x64"}, {"spp", 64}});
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].rfind("the scene has no light and nothing that emits", 0), 0u);
}

TEST(LibraryListener, HearsHowFarWorkIs) {
    const Session session(Scene::load(scenePath("cornell_glossy")));
    std::map<std::string, double> last;
    const Listener listener{.progress = [&](const std::string& what, double done) {
        EXPECT_GE(done, last[what]) << what;
        EXPECT_LE(done, 1.0);
        last[what] = done;
        return true;
    }};
    session.render(small(), listener);
    EXPECT_FALSE(last.empty());
    last.clear();
    session.render({{"method", "reference"}, {"size", "16x16"}, {"spp", 4}}, listener);
    ASSERT_EQ(last.size(), 1u);
    EXPECT_EQ(last["path tracing"], 1.0);
}

TEST(LibraryListener, CancelsAndTheSessionGoesOn) {
    const Scene scene = Scene::load(scenePath("cornell_glossy"));
    const Session session(scene);
    for (const char* method : {"radiance", "reference", "octree"}) {
        int calls = 0;
        const Listener listener{
            .progress = [&](const std::string&, double) { return ++calls < 2; }};
        expectError(ErrorKind::cancelled, "cancelled", [&] {
            session.render({{"method", method}, {"size", "40x40"}, {"aa", 1}, {"bounces", 1}},
                           listener);
        });
        EXPECT_EQ(calls, 2) << method;
    }
    expectSame(session.render(small()), Session(scene).render(small()));
}

TEST(LibraryListener, MayThrow) {
    const Session session(Scene::load(scenePath("cornell_glossy")));
    const Listener listener{
        .progress = [](const std::string&, double) -> bool { throw std::out_of_range("mine"); }};
    EXPECT_THROW(session.render(small(), listener), std::out_of_range);
    const Listener of_warnings{
        .warning = [](const std::string&) { throw std::out_of_range("mine"); }};
    EXPECT_THROW(Scene::fromArrays(darkFloor(), {}, of_warnings), std::out_of_range);
}

}  // namespace
}  // namespace sheen
