// The shared functions in a shader and in C++ on the same inputs, and in both GL backends.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "gl/program.h"
#include "gl/worker_pool.h"
#include "hemisphere/hemisphere.h"
#include "image/image.h"
#include "raster/gpu_scene.h"
#include "raster/view.h"
#include "record/record.h"
#include "sh/sh.h"
#include "test_scenes.h"

namespace sheen::shared {
#include "test/twins.glsl"
}  // namespace sheen::shared

namespace sheen {
namespace {

constexpr int kColumns = 256;

std::vector<vec4> makeInputs() {
    Random random(11);
    std::vector<vec4> inputs;
    for (int column = 0; column < kColumns; ++column) {
        for (int i = 0; i < 3; ++i) {
            const vec3 d = random.direction();
            inputs.emplace_back(d, random.uniform(-1.0f, 1.0f));
        }
        const vec3 d = random.point(-1.0f, 1.0f);
        inputs.emplace_back(d, random.uniform(-1.0f, 1.0f));
    }
    return inputs;
}

Image<vec4> renderTwins(const std::vector<vec4>& inputs, gl::Backend backend,
                        std::string* renderer = nullptr) {
    gl::WorkerPool pool(1, backend);
    Image<vec4> image(kColumns, shared::TWIN_COUNT);
    pool.runOnFirst([&] {
        using namespace gl;
        const Program program("raster/fullscreen.vert", "test/twins.frag");
        const Buffer buffer = makeBuffer(std::span<const vec4>(inputs));
        const gl::Texture target = makeTexture2d(GL_RGBA32F, image.width, image.height);
        const GLuint name = target.name();
        const Framebuffer framebuffer = makeFramebuffer({&name, 1}, 0);
        const VertexArray empty = makeVertexArray();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glViewport(0, 0, image.width, image.height);
        program.use();
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.name());
        glBindVertexArray(empty.name());
        drawFullscreen();
        glReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_FLOAT, image.pixels.data());
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    });
    if (renderer != nullptr) {
        *renderer = pool.renderer();
    }
    return image;
}

// Relative to 1 + the value. Division, roots and trigonometry of the two languages differ in the
// last bits; recurrences and cancellation magnify that.
float tolerance(int row) {
    switch (row) {
        case shared::TWIN_BRDF:
            return 1e-3f;  // smooth lobes: 1 - NoH^2 in single precision
        case shared::TWIN_WEIGHT:
            return 1e-4f;
        case shared::TWIN_PLANE:
            return 2e-5f;  // arc tangents by the driver's polynomial
        default:
            return row < shared::TWIN_SH ? 1e-5f : 2e-5f;
    }
}

TEST(Twins, ShaderAndCpuAgreeOnEverySharedFunction) {
    const std::vector<vec4> inputs = makeInputs();
    const Image<vec4> image = renderTwins(inputs, gl::kDefaultBackend);
    for (int row = 0; row < shared::TWIN_COUNT; ++row) {
        bool varies = false;
        for (int column = 0; column < kColumns; ++column) {
            const vec4* in = &inputs[static_cast<size_t>(4 * column)];
            const vec4 expected = shared::twin(row, in[0], in[1], in[2], in[3]);
            const vec4 found = image.at(column, row);
            for (int c = 0; c < 4; ++c) {
                ASSERT_TRUE(std::isfinite(expected[c]));
                EXPECT_NEAR(found[c], expected[c], tolerance(row) * (1.0f + std::abs(expected[c])))
                    << "row " << row << " column " << column << " channel " << c;
            }
            varies |= expected != shared::twin(row, inputs[0], inputs[1], inputs[2], inputs[3]);
        }
        EXPECT_TRUE(varies) << "row " << row << " tests nothing";
    }
}

// Where the environment gives a surfaceless EGL display, it renders what OSMesa renders: bit for
// bit if it is the same software rasteriser, within tolerance on a GPU. Where it gives none, making
// the context is the documented environment error (exit code 4). Functions are loaded once a
// process, so EGL gets its own.
TEST(EglBackendDeathTest, RendersWhatOsmesaRendersOrSaysWhyNot) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    constexpr int kWorks = 20;
    const std::string path =
        (std::filesystem::path(testing::TempDir()) / "sheen_egl_twins.bin").string();
    const std::vector<vec4> inputs = makeInputs();
    int status = -1;
    const auto keep_status = [&](int value) {
        status = WIFEXITED(value) ? WEXITSTATUS(value) : -1;
        return true;
    };
    EXPECT_EXIT(
        {
            try {
                std::string renderer;
                const Image<vec4> image = renderTwins(inputs, gl::Backend::kEgl, &renderer);
                std::ofstream file(path, std::ios::binary);
                file.write(reinterpret_cast<const char*>(image.pixels.data()),
                           static_cast<std::streamsize>(image.pixels.size() * sizeof(vec4)));
                file << renderer;
                file.close();
                // Without running destructors of the driver's statics.
                std::_Exit(kWorks);
            } catch (const Error& error) {
                std::_Exit(static_cast<int>(error.code()));
            }
        },
        keep_status, "");
    if (status == static_cast<int>(ExitCode::kEnvironment)) {
        return;
    }
    ASSERT_EQ(status, kWorks);
    Image<vec4> egl(kColumns, shared::TWIN_COUNT);
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(egl.pixels.data()),
              static_cast<std::streamsize>(egl.pixels.size() * sizeof(vec4)));
    ASSERT_TRUE(file.good());
    const std::string renderer((std::istreambuf_iterator<char>(file)), {});
    std::filesystem::remove(path);
    std::string osmesa_renderer;
    const Image<vec4> osmesa = renderTwins(inputs, gl::Backend::kOsmesa, &osmesa_renderer);
    if (renderer == osmesa_renderer) {
        EXPECT_EQ(
            std::memcmp(egl.pixels.data(), osmesa.pixels.data(), egl.pixels.size() * sizeof(vec4)),
            0);
    }
    for (int row = 0; row < shared::TWIN_COUNT; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            for (int c = 0; c < 4; ++c) {
                const float expected = osmesa.at(column, row)[c];
                EXPECT_NEAR(egl.at(column, row)[c], expected,
                            2.0f * tolerance(row) * (1.0f + std::abs(expected)))
                    << renderer;
            }
        }
    }
}

}  // namespace
}  // namespace sheen
