// Programs, objects and workers of the OpenGL layer.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <stdexcept>

#include "core/error.h"
#include "gl/program.h"
#include "gl/worker_pool.h"

namespace sheen::gl {
namespace {

std::string messageOf(const std::function<void()>& job) {
    try {
        job();
    } catch (const std::logic_error& error) {
        return error.what();
    }
    return "";
}

// ---- Sources ------------------------------------------------------------------------------------

TEST(ExpandIncludes, NamesAMissingShader) {
    EXPECT_NE(messageOf([] { expandIncludes("test/no_such.frag"); }).find("test/no_such.frag"),
              std::string::npos);
    EXPECT_NE(messageOf([] {
                  expandIncludes("test/broken_include.frag");
              }).find("test/no_such_file.glsl"),
              std::string::npos);
}

TEST(ExpandIncludes, EachFileOnceWithLineMarks) {
    const ShaderSource source = expandIncludes("test/broken.frag");
    EXPECT_EQ(source.files, (std::vector<std::string>{"test/broken.frag", "shared/language.glsl",
                                                      "test/broken.glsl"}));
    EXPECT_EQ(source.text.find("#include"), std::string::npos);
    EXPECT_EQ(source.text.rfind("#line 1 0\n", 0), 0u);
    // Back in the first file after its include on line 2.
    EXPECT_NE(source.text.find("#line 3 0\n"), std::string::npos);
    const size_t first = source.text.find("const float PI");
    EXPECT_NE(first, std::string::npos);
    EXPECT_EQ(source.text.find("const float PI", first + 1), std::string::npos);
}

// Debug output keeps the first error of the process, so what provokes one runs in its own.
void printErrorAndExit(const std::function<void()>& job) {
    WorkerPool pool(2);
    std::string message;
    try {
        pool.runOnFirst(job);
    } catch (const std::logic_error& error) {
        message = error.what();
    }
    std::fprintf(stderr, "%s\n", message.c_str());
    std::exit(message.empty() ? 0 : 7);
}

TEST(ProgramDeathTest, AnErrorNamesFileAndLine) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto job = [] { Program("raster/fullscreen.vert", "test/broken.frag"); };
    // Line 3 of string 2, and what string 2 is.
    EXPECT_EXIT(printErrorAndExit(job), testing::ExitedWithCode(7), "nothing_of_this_name");
    EXPECT_EXIT(printErrorAndExit(job), testing::ExitedWithCode(7), "2:3\\(");
    EXPECT_EXIT(printErrorAndExit(job), testing::ExitedWithCode(7), "2: test/broken.glsl");
}

TEST(ProgramDeathTest, DefinesReachTheShader) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(printErrorAndExit(
                    [] { Program("raster/fullscreen.vert", "raster/depth.frag", {"UNUSED 1"}); }),
                testing::ExitedWithCode(0), "");
    EXPECT_EXIT(printErrorAndExit([] {
                    Program("raster/fullscreen.vert", "raster/depth.frag", {"main no_main"});
                }),
                testing::ExitedWithCode(7), "raster/");
}

TEST(CheckErrorsDeathTest, AWrongCallFailsTheRun) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(printErrorAndExit([] { glBindBuffer(0xdead, 0); }), testing::ExitedWithCode(7),
                "OpenGL: ");
}

TEST(Program, UniformsTheCompilerRemovedAreIgnored) {
    WorkerPool pool(1);
    pool.runOnFirst([] {
        const Program program("raster/fullscreen.vert", "test/twins.frag");
        program.set("unused_uniform", 3);
        program.set("never_declared", vec3(1.0f));
        program.set("never_declared", mat4(1.0f));
        program.set("never_declared", ivec2(1));
    });
    EXPECT_NO_THROW(checkErrors());
}

// ---- Objects ------------------------------------------------------------------------------------

TEST(Objects, MoveOnlyAndEmptyByDefault) {
    WorkerPool pool(1);
    pool.runOnFirst([] {
        Buffer none;
        EXPECT_EQ(none.name(), 0u);
        const float values[] = {1.0f, 2.0f};
        Buffer a = makeBuffer(std::span<const float>(values));
        const GLuint name = a.name();
        EXPECT_NE(name, 0u);
        Buffer b = std::move(a);
        EXPECT_EQ(b.name(), name);
        none = std::move(b);
        EXPECT_EQ(none.name(), name);
        const Buffer empty = makeBuffer(std::span<const float>());
        EXPECT_NE(empty.name(), 0u);
    });
    static_assert(!std::is_copy_constructible_v<Buffer>);
    EXPECT_NO_THROW(checkErrors());
}

TEST(Objects, IncompleteFramebufferIsRefused) {
    WorkerPool pool(1);
    pool.runOnFirst([] {
        EXPECT_THROW(makeFramebuffer({}, 0), std::logic_error);
        const Texture color = makeTexture2d(GL_RGBA32F, 1, 1);
        const GLuint name = color.name();
        EXPECT_NO_THROW(makeFramebuffer({&name, 1}, 0));
    });
}

// ---- Workers ------------------------------------------------------------------------------------

TEST(WorkerPool, RunsOnEveryWorkerAtTheSameTime) {
    for (int workers : {1, 2, 5}) {
        WorkerPool pool(workers);
        ASSERT_EQ(pool.size(), workers);
        EXPECT_FALSE(pool.renderer().empty());
        std::mutex mutex;
        std::condition_variable arrived;
        std::set<int> indices;
        std::set<std::thread::id> threads;
        bool together = true;
        for (int round = 0; round < 3; ++round) {
            indices.clear();
            pool.run([&](int worker) {
                std::unique_lock<std::mutex> lock(mutex);
                indices.insert(worker);
                threads.insert(std::this_thread::get_id());
                arrived.notify_all();
                together &= arrived.wait_for(lock, std::chrono::seconds(20), [&] {
                    return static_cast<int>(indices.size()) == workers;
                });
            });
            EXPECT_TRUE(together);
            EXPECT_EQ(static_cast<int>(indices.size()), workers);
        }
        EXPECT_EQ(static_cast<int>(threads.size()), workers);
        EXPECT_FALSE(threads.contains(std::this_thread::get_id()));
    }
}

TEST(WorkerPool, RunOnFirstIsWorkerZeroAlone) {
    WorkerPool pool(3);
    std::thread::id first;
    pool.run([&](int worker) {
        if (worker == 0) {
            first = std::this_thread::get_id();
        }
    });
    std::atomic<int> calls = 0;
    pool.runOnFirst([&] {
        ++calls;
        EXPECT_EQ(std::this_thread::get_id(), first);
    });
    EXPECT_EQ(calls, 1);
}

TEST(WorkerPool, ExceptionsAreRethrownAndThePoolLivesOn) {
    WorkerPool pool(3);
    std::atomic<int> finished = 0;
    const auto fail = [&](int worker) {
        if (worker >= 1) {
            throw Error(ExitCode::kInput, "worker " + std::to_string(worker));
        }
        ++finished;
    };
    for (int round = 0; round < 2; ++round) {
        try {
            pool.run(fail);
            FAIL() << "nothing was thrown";
        } catch (const Error& error) {
            EXPECT_STREQ(error.what(), "worker 1");  // the first by worker
            EXPECT_EQ(error.code(), ExitCode::kInput);
        }
    }
    EXPECT_EQ(finished, 2);
    EXPECT_NO_THROW(pool.run([](int) {}));
}

TEST(WorkerPool, WorkersShareBuffersAndTextures) {
    WorkerPool pool(2);
    Buffer buffer;
    Texture texture;
    pool.runOnFirst([&] {
        const float values[] = {1.0f, 2.0f, 3.0f, 4.0f};
        buffer = makeBuffer(std::span<const float>(values));
        texture = makeTexture2d(GL_RGBA32F, 1, 1);
        glTextureSubImage2D(texture.name(), 0, 0, 0, 1, 1, GL_RGBA, GL_FLOAT, values);
    });
    pool.run([&](int) {
        const GLuint name = texture.name();
        const Framebuffer framebuffer = makeFramebuffer({&name, 1}, 0);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        float pixel[4] = {};
        glReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, pixel);
        EXPECT_EQ(pixel[3], 4.0f);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    });
    pool.runOnFirst([&] {
        buffer = {};
        texture = {};
    });
}

TEST(WorkerPool, RefusesNoWorkers) {
    EXPECT_THROW(WorkerPool(0), std::logic_error);
    EXPECT_THROW(WorkerPool(-1), std::logic_error);
}

}  // namespace
}  // namespace sheen::gl
