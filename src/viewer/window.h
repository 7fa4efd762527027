// A window with an OpenGL context, in which Dear ImGui draws.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "image/tonemap.h"

struct GLFWwindow;

namespace sheen {

class Window {
  public:
    /// Environment error without a display, or without OpenGL 3.3.
    Window(int width, int height, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    bool open() const;
    void close();
    void setTitle(const std::string& title);
    /// Of what is drawn, in pixels, which on some screens are finer than the window's units.
    ivec2 pixels() const;

    /// Draws one frame: `image`, over all of it, and what `interface` asks Dear ImGui for. Waits
    /// for something to happen, up to so many seconds.
    void draw(const Image<Rgb8>* image, const std::function<void()>& interface, double wait);

    /// Files that were dropped since it was last asked.
    std::vector<std::string> dropped();
    /// A key that went down: GLFW's number, and whether Shift was held.
    struct Key {
        int key;
        bool shift;
    };
    /// Those since it was last asked, however short.
    std::vector<Key> pressed();

  private:
    void upload(const Image<Rgb8>& image);

    GLFWwindow* window_ = nullptr;
    unsigned texture_ = 0;
    const void* uploaded_ = nullptr;
    std::vector<std::string> dropped_;
    std::vector<Key> pressed_;
};

}  // namespace sheen
