// Sessions and frames as a program of one's own has them.
#include "library_test.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "test_folder.h"

namespace sheen {
namespace {

std::string bytesOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST(Library, WritesTheFileThatTheProgramWrites) {
    const TestFolder folder;
    const std::string by_program = (folder.path() / "program.exr").string();
    const std::string by_library = (folder.path() / "library.exr").string();
    const std::string command =
        std::string(SHEEN_PROGRAM) + " render '" + scenePath("cornell_glossy") +
        "' --environment 0.2,0.2,0.3 --size 24x20 --layers all --accuracy 1 --bounces 1 -o '" +
        by_program + "' > /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const Session session(
        Scene::load(scenePath("cornell_glossy"), {{"environment", {0.2, 0.2, 0.3}}}));
    session
        .render({{"width", 24}, {"height", 20}, {"layers", "all"}, {"accuracy", 1}, {"bounces", 1}})
        .write(by_library);
    EXPECT_FALSE(bytesOf(by_library).empty());
    EXPECT_TRUE(bytesOf(by_library) == bytesOf(by_program));
}

TEST(Library, BeautyIsTheSumOfTheLayersOfLight) {
    const Frame frame = Session(Scene::load(scenePath("cornell_glossy"))).render(small());
    const Layer beauty = frame.layer("beauty");
    EXPECT_EQ(beauty.width, 24);
    EXPECT_EQ(beauty.height, 20);
    double sum = 0.0;
    for (int y = 0; y < beauty.height; ++y) {
        for (int x = 0; x < beauty.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                float parts =
                    frame.layer("direct").at(x, y, c) + frame.layer("indirect").at(x, y, c);
                for (const std::string& name : frame.layers()) {
                    parts += name == "caustic" ? frame.layer(name).at(x, y, c) : 0.0f;
                }
                EXPECT_NEAR(beauty.at(x, y, c), parts, 1e-5f * (1.0f + parts));
                sum += parts;
            }
        }
    }
    EXPECT_GT(sum, 0.0);
}

TEST(Library, LayersAreThoseAskedFor) {
    const Session session(Scene::load(scenePath("cornell_diffuse")));
    const std::vector<std::string> basic = session.render(small()).layers();
    EXPECT_EQ(std::count(basic.begin(), basic.end(), "depth"), 0);
    const Frame frame = session.render(small({{"layers", "all"}}));
    EXPECT_GT(frame.layer("depth").at(12, 10), 0.0f);
    EXPECT_EQ(frame.layer("normal").channels, 3);
    EXPECT_LT(frame.primitive()[24 * 10 + 12],
              Scene::load(scenePath("cornell_diffuse")).triangleCount());
    expectError(ErrorKind::usage, "layer colour: the frame has none of that name; it has beauty,",
                [&] { frame.layer("colour"); });
}

TEST(Library, FiguresAreThoseOfTheProgram) {
    const Frame frame = Session(Scene::load(scenePath("cornell_diffuse"))).render(small());
    EXPECT_GT(frame.figure("records"), 0.0);
    EXPECT_GT(frame.figure("seconds/total"), 0.0);
    EXPECT_LE(frame.figure("estimate_low"), frame.figure("estimate_high"));
    EXPECT_NE(frame.json().find("\"records\":"), std::string::npos);
    expectError(ErrorKind::usage, "figure record:", [&] { frame.figure("record"); });
    expectError(ErrorKind::usage, "figure method:", [&] { frame.figure("method"); });  // is text
}

TEST(Library, EachFrameIsTheSameWhateverWasBeforeAndWhateverTheThreads) {
    const Scene scene = Scene::load(scenePath("cornell_glossy"));
    const Session session(scene);
    const Frame first = session.render(small());
    session.render(small({{"camera-at", {0.2, 0.3, -0.6}}}));
    expectSame(session.render(small({{"threads", 1}})), first);
    Options two = small({{"threads", 2}});
    expectSame(Session(scene).render(two), first);
}

TEST(Library, RecordsAreKeptWhereAskedFor) {
    const Scene scene = Scene::load(scenePath("cornell_glossy"));
    const Session session(scene);
    session.render(small());
    EXPECT_EQ(session.render(small()).figure("records_reused"), 0.0);
    session.keepRecords();
    const Frame first = session.render(small());
    const Frame finer =
        session.render({{"size", "24x20"}, {"aa", 1}, {"accuracy", 1.0}, {"bounces", 1}});
    EXPECT_GT(finer.figure("records_reused"), 0.5 * first.figure("records"));
    EXPECT_GT(finer.figure("records"), finer.figure("records_reused"));
}

TEST(Library, RecordsOfAFileServeTheNextRun) {
    const TestFolder folder;
    const Options cached = small({{"cache", (folder.path() / "records").string()}});
    const Scene scene = Scene::load(scenePath("cornell_glossy"));
    EXPECT_EQ(Session(scene).render(cached).figure("records_reused"), 0.0);
    const Session session(scene);
    EXPECT_GT(session.render(cached).figure("records_reused"), 0.0);
    expectSame(session.render(small()), Session(scene).render(small()));
    expectError(ErrorKind::usage, "option cache: records are kept only of scenes",
                [&] { Session(Scene::fromArrays(floorBelow({}))).render(cached); });
}

TEST(Library, SessionsRenderSideBySide) {
    const Scene scene = Scene::load(scenePath("cornell_diffuse"));
    const Frame alone = Session(scene).render(small());
    std::vector<Frame> frames(2, alone);
    std::vector<std::thread> threads;
    for (Frame& frame : frames) {
        threads.emplace_back([&] { frame = Session(scene).render(small()); });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    expectSame(frames[0], alone);
    expectSame(frames[1], alone);
}

TEST(Library, AViewOfOnesOwnIsThatOfTheFileLoadedSo) {
    const Options view = {
        {"camera-at", {0.1, 0.25, -0.4}}, {"look-at", {0.3, 0.2, 0.3}}, {"fov", 60}};
    const Frame later = Session(Scene::load(scenePath("cornell_diffuse"))).render(small(view));
    Scene loaded = Scene::load(scenePath("cornell_diffuse"), view);
    EXPECT_EQ(loaded.cameras().front(), "view");
    expectSame(later, Session(loaded).render(small()));
}

TEST(Library, APartOfAnImageHasItsSize) {
    const Session session(Scene::load(scenePath("cornell_diffuse")));
    const Frame part = session.render(small({{"crop", "4,5,8,6"}}));
    EXPECT_EQ(part.width(), 8);
    EXPECT_EQ(part.height(), 6);
}

TEST(Library, BytesAreTheFile) {
    const std::string bytes = bytesOf(scenePath("cornell_glossy"));
    const Scene scene = Scene::fromBytes(bytes.data(), bytes.size());
    expectSame(Session(scene).render(small()),
               Session(Scene::load(scenePath("cornell_glossy"))).render(small()));
    expectError(ErrorKind::input, "bytes: is empty", [] { Scene::fromBytes("", 0); });
    expectError(ErrorKind::input, "bytes: header: the file is truncated",
                [&] { Scene::fromBytes(bytes.data(), bytes.size() / 2); });
}

TEST(Library, WritesImagesToLookAt) {
    const TestFolder folder;
    const Frame frame = Session(Scene::load(scenePath("cornell_diffuse"))).render(small());
    const std::string path = (folder.path() / "a.png").string();
    frame.write(path, {{"exposure", 1.0}, {"tone", "none"}});
    const std::string one_stop = bytesOf(path);
    EXPECT_EQ(one_stop.substr(1, 3), "PNG");
    frame.write(path, {{"exposure", 3.0}});
    EXPECT_FALSE(bytesOf(path) == one_stop);
    expectError(ErrorKind::usage, "must end in .exr or .png", [&] { frame.write("a.jpg"); });
    expectError(ErrorKind::environment, "/nowhere/a.png", [&] { frame.write("/nowhere/a.png"); });
    expectError(ErrorKind::usage, "option accuracy: there is none of that name here", [&] {
        frame.write(path, {{"accuracy", 1}});
    });
}

TEST(LibraryErrors, AreOneLineOfTheirKind) {
    expectError(ErrorKind::input, "/nowhere.glb: no such file",
                [] { Scene::load("/nowhere.glb"); });
    const Scene scene = Scene::load(scenePath("cornell_diffuse"));
    const Session session(scene);
    expectError(ErrorKind::usage, "option acuracy: there is none of that name here; there are",
                [&] {
                    session.render({{"acuracy", 1}});
                });
    expectError(ErrorKind::usage, "--accuracy: 7 is not a number in 0.01..2", [&] {
        session.render({{"accuracy", 7}});
    });
    expectError(ErrorKind::usage, "option accuracy: is given twice", [&] {
        session.render(small({{"accuracy", 1}}));
    });
    expectError(ErrorKind::usage, "--size 0x512: must be WIDTHxHEIGHT", [&] {
        session.render({{"width", 0}});
    });
    expectError(ErrorKind::usage, "--camera none: no such camera", [&] {
        session.render({{"camera", "none"}});
    });
    expectError(ErrorKind::usage, "--spp: not an option of --method radiance", [&] {
        session.render({{"spp", 4}});
    });
    // Options of files are not the frame's, nor the other way round.
    expectError(ErrorKind::usage, "option output:", [&] { session.render({{"output", "a.exr"}}); });
    expectError(ErrorKind::usage, "option variant:", [&] { session.render({{"variant", "a"}}); });
    expectError(ErrorKind::usage, "option accuracy:", [] {
        Scene::load(scenePath("cornell_diffuse"), {{"accuracy", 1}});
    });
    expectSame(session.render(small()), Session(scene).render(small()));
}

TEST(LibraryErrors, OfCAreFilledInAndNothingIsMade) {
    sheen_error error;
    sheen_scene* scene = nullptr;
    EXPECT_EQ(sheen_scene_load(nullptr, nullptr, 0, nullptr, &scene, &error), SHEEN_USAGE);
    EXPECT_STREQ(error.message, "path is NULL");
    EXPECT_EQ(sheen_scene_load("/nowhere.glb", nullptr, 0, nullptr, &scene, nullptr), SHEEN_INPUT);
    EXPECT_EQ(scene, nullptr);
    sheen_session* session = nullptr;
    EXPECT_EQ(sheen_session_new(nullptr, &session, &error), SHEEN_USAGE);
    sheen_frame* frame = nullptr;
    EXPECT_EQ(sheen_render(nullptr, nullptr, 0, nullptr, &frame, &error), SHEEN_USAGE);
    const sheen_option unnamed = {nullptr, "1"};
    EXPECT_EQ(sheen_scene_load("a.glb", &unnamed, 1, nullptr, &scene, &error), SHEEN_USAGE);
    EXPECT_EQ(sheen_scene_load("a.glb", nullptr, 1, nullptr, &scene, &error), SHEEN_USAGE);
    sheen_scene_free(nullptr);
    sheen_session_free(nullptr);
    sheen_frame_free(nullptr);
    // A message that is too long ends within the buffer, at a whole character.
    const std::string long_name(2000, 'x');
    std::string umlauts = "/";
    for (int i = 0; i < 1000; ++i) {
        umlauts += "\xc3\xa4";
    }
    for (const std::string& name : {long_name, umlauts}) {
        EXPECT_EQ(sheen_scene_load(name.c_str(), nullptr, 0, nullptr, &scene, &error), SHEEN_INPUT);
        const size_t length = std::strlen(error.message);
        EXPECT_LT(length, sizeof(error.message));
        EXPECT_GE(length, sizeof(error.message) - 2);
    }
    EXPECT_EQ(static_cast<unsigned char>(error.message[std::strlen(error.message) - 1]), 0xa4u);
}

}  // namespace
}  // namespace sheen
