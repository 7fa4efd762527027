#include "viewer/window.h"

#define GLFW_INCLUDE_NONE
#include <GL/glcorearb.h>
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "core/error.h"

namespace sheen {
namespace {

// OpenGL of the window's context: what a picture and a background take. (gl/functions.h holds that
// of the renderer's context, of another driver.)
struct WindowGl {
    PFNGLGENTEXTURESPROC genTextures;
    PFNGLDELETETEXTURESPROC deleteTextures;
    PFNGLBINDTEXTUREPROC bindTexture;
    PFNGLPIXELSTOREIPROC pixelStorei;
    PFNGLTEXIMAGE2DPROC texImage2D;
    PFNGLTEXPARAMETERIPROC texParameteri;
    PFNGLVIEWPORTPROC viewport;
    PFNGLCLEARCOLORPROC clearColor;
    PFNGLCLEARPROC clear;

    void load() {
        const auto get = [](auto& function, const char* name) {
            function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(
                glfwGetProcAddress(name));
            if (function == nullptr) {
                throwEnvironment("OpenGL: the window's driver has no {}", name);
            }
        };
        get(genTextures, "glGenTextures");
        get(deleteTextures, "glDeleteTextures");
        get(bindTexture, "glBindTexture");
        get(pixelStorei, "glPixelStorei");
        get(texImage2D, "glTexImage2D");
        get(texParameteri, "glTexParameteri");
        get(viewport, "glViewport");
        get(clearColor, "glClearColor");
        get(clear, "glClear");
    }
};
WindowGl g_gl;

std::string g_glfw_error;

void onError(int, const char* message) { g_glfw_error = message; }

[[noreturn]] void failWindow(const char* what) {
    const std::string why = oneLine(g_glfw_error);
    throwEnvironment(
        "view: {}{}{}; a window needs a display (DISPLAY or WAYLAND_DISPLAY): render "
        "to a file instead, or start one, as xvfb-run does",
        what, why.empty() ? "" : ": ", why);
}

// The interface's size follows the screen's.
void scaleInterface(GLFWwindow* window) {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window, &x, &y);
    ImGui::GetStyle().ScaleAllSizes(x);
    ImGui::GetIO().FontGlobalScale = x;
}

}  // namespace

Window::Window(int width, int height, const std::string& title) {
    glfwSetErrorCallback(onError);
    if (glfwInit() == GLFW_FALSE) {
        failWindow("no window system");
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
        glfwTerminate();
        failWindow("no window with OpenGL 3.3");
    }
    glfwMakeContextCurrent(window_);
    g_gl.load();
    glfwSwapInterval(1);
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
    ImGui::StyleColorsDark();
    scaleInterface(window_);
    glfwSetWindowUserPointer(window_, this);
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
        auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
        self->dropped_.insert(self->dropped_.end(), paths, paths + count);
    });
    // Dear ImGui forgets keys that come up before its next frame begins.
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
        if (action == GLFW_PRESS) {
            static_cast<Window*>(glfwGetWindowUserPointer(window))
                ->pressed_.push_back({key, (modifiers & GLFW_MOD_SHIFT) != 0});
        }
    });
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    g_gl.genTextures(1, &texture_);
}

Window::~Window() {
    g_gl.deleteTextures(1, &texture_);
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
    // GLFW is not ended: it would unload the driver of OpenGL, and what that keeps until the
    // process ends would be lost.
}

bool Window::open() const { return glfwWindowShouldClose(window_) == GLFW_FALSE; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }
void Window::setTitle(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

ivec2 Window::pixels() const {
    ivec2 size(0);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
}

std::vector<std::string> Window::dropped() { return std::exchange(dropped_, {}); }

std::vector<Window::Key> Window::pressed() { return std::exchange(pressed_, {}); }

void Window::upload(const Image<Rgb8>& image) {
    g_gl.bindTexture(GL_TEXTURE_2D, texture_);
    g_gl.pixelStorei(GL_UNPACK_ALIGNMENT, 1);
    g_gl.texImage2D(GL_TEXTURE_2D, 0, GL_RGBA, image.width, image.height, 0, GL_RGB,
                    GL_UNSIGNED_BYTE, image.pixels.data());
    g_gl.texParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    g_gl.texParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    uploaded_ = &image;
}

void Window::draw(const Image<Rgb8>* image, const std::function<void()>& interface, double wait) {
    if (wait > 0.0) {
        glfwWaitEventsTimeout(wait);
    } else {
        glfwPollEvents();
    }
    if (image == nullptr) {
        uploaded_ = nullptr;
    }
    if (image != nullptr && !image->empty() && image != uploaded_) {
        upload(*image);
    }
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (image != nullptr && !image->empty()) {
        const ImVec2 all = ImGui::GetIO().DisplaySize;
        ImGui::GetBackgroundDrawList()->AddImage(
            reinterpret_cast<ImTextureID>(static_cast<intptr_t>(texture_)), {0.0f, 0.0f}, all);
    }
    interface();
    ImGui::Render();
    const ivec2 size = pixels();
    g_gl.viewport(0, 0, size.x, size.y);
    g_gl.clearColor(0.0f, 0.0f, 0.0f, 1.0f);
    g_gl.clear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(window_);
}

}  // namespace sheen
