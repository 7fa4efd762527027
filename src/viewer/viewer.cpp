#include "viewer/viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/timer.h"
#include "image/exr.h"
#include "image/png.h"
#include "raster/gbuffer.h"
#include "viewer/benchmark.h"
#include "viewer/panels.h"
#include "viewer/pixel_panel.h"
#include "viewer/window.h"

namespace sheen {
namespace {

constexpr double kStepSeconds = 1.0 / 30.0;
// How long the window waits for a hand, or a new image; the longer where none is being made.
constexpr double kWait = 1.0 / 60.0, kIdleWait = 0.2;

bool hasExtension(const std::string& path, const std::string& extension) {
    std::string own = std::filesystem::path(path).extension().string();
    std::transform(own.begin(), own.end(), own.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return own == extension;
}

// The first name "STEM-1.EXTENSION", "STEM-2..." in the current folder that no file has.
std::string freeName(const std::string& scene, const char* extension) {
    const std::string stem = std::filesystem::path(scene).stem().string();
    for (int i = 1;; ++i) {
        std::string name = fmt::format("{}-{}.{}", stem, i, extension);
        if (!std::filesystem::exists(name)) {
            return name;
        }
    }
}

// A scene that is looked at.
struct Opened {
    std::string file;
    Bounds bounds;  // of the scene
    CameraControl control;
    ViewerState state;
    std::unique_ptr<LiveThread> live;

    Opened(const ViewerParams& params, const std::string& path, const ivec2& size)
        : Opened(params, path, size, loadWarned(path, params.load)) {}

  private:
    static Scene loadWarned(const std::string& path, const LoadParams& load) {
        Scene scene = loadScene(path, load);
        for (const std::string& warning : scene.warnings) {
            warn(warning);
        }
        return scene;
    }
    static RenderParams sized(RenderParams render, const ivec2& size) {
        render.width = std::max(size.x, 1);
        render.height = std::max(size.y, 1);
        return render;
    }
    Opened(const ViewerParams& params, const std::string& path, const ivec2& size, Scene scene)
        : file(path),
          bounds(scene.bounds),
          control(viewOf(scene, params.render), scene.bounds),
          state(stateOf(scene, sized(params.render, size), params.display)) {
        auto image = std::make_unique<LiveImage>(std::move(scene), state.render);
        live = std::make_unique<LiveThread>(std::move(image), kStepSeconds);
        live->display(state.display);
    }
};

class Viewer {
  public:
    explicit Viewer(const ViewerParams& params)
        : params_(params),
          window_(params.render.width, params.render.height, "Sheen"),
          size_(window_.pixels()) {
        open(params.scene);
        if (params.benchmark > 0) {
            benchmark_.emplace(params.benchmark, opened_->control);
        }
    }

    std::optional<ViewerFigures> run() {
        while (window_.open()) {
            frame();
        }
        if (!benchmark_) {
            return std::nullopt;
        }
        ViewerFigures figures = benchmark_->figures();
        figures.seconds_gbuffer = gbufferSeconds();
        return figures;
    }

  private:
    void open(const std::string& path) {
        auto opened = std::make_unique<Opened>(params_, path, size_);
        opened_ = std::move(opened);
        shown_.reset();
        held_.reset();
        entitle(false);
    }

    void entitle(bool complete) {
        window_.setTitle(fmt::format("Sheen - {}{}",
                                     std::filesystem::path(opened_->file).filename().string(),
                                     complete ? "" : " (refining)"));
        entitled_complete_ = complete;
    }

    double gbufferSeconds() const {
        const Scene scene = loadScene(params_.scene, params_.load);
        const Tracer tracer(scene);
        constexpr int kYardstick = 512;
        const Timer timer;
        renderGBuffer(tracer, viewOf(scene, params_.render), kYardstick, kYardstick);
        return timer.seconds();
    }

    void frame() {
        const std::shared_ptr<const Shown> newest = opened_->live->shown();
        const bool fresh = newest && newest != shown_;
        shown_ = newest;
        if (fresh) {
            followNewImage();
        }
        const Image<Rgb8>* image = shown_ ? &shown_->pixels : nullptr;
        if (held_ && showing_held_) {
            image = &*held_;
        }
        const double wait = fresh ? 0.0 : opened_->live->idle() ? kIdleWait : kWait;
        window_.draw(
            image, [this, fresh] { interface(fresh); }, wait);
        resize();
        for (const std::string& path : window_.dropped()) {
            drop(path);
        }
        if (std::optional<Failure> failure = opened_->live->failure()) {
            if (benchmark_ || !params_.screenshot.empty()) {
                throw Error(failure->code, failure->message);  // no hand is there to try again
            }
            tell(std::move(failure->message));
        }
    }

    void followNewImage() {
        if (shown_->complete != entitled_complete_) {
            entitle(shown_->complete);
        }
        if (benchmark_ && benchmark_->follow(*shown_, *opened_->live)) {
            window_.close();
        }
        const bool wanted = params_.screenshot_after > 0
                                ? shown_->number >= params_.screenshot_after
                                : shown_->complete;
        if (!params_.screenshot.empty() && wanted && !screenshot_taken_) {
            screenshot_taken_ = true;
            writePng(params_.screenshot, shown_->pixels);
            window_.close();
        }
    }

    void tell(std::string message) {
        say(fmt::format("sheen: {}\n", message));
        opened_->state.message = std::move(message);
    }

    // A scene is opened, an image of a render held to compare with; what is neither, or broken,
    // leaves all as it is.
    void drop(const std::string& path) {
        try {
            if (hasExtension(path, ".exr")) {
                const LoadedExr exr = readExr(path);
                hold(displayImage(colorLayer(exr, "beauty"),
                                  shown_ ? std::optional(shown_->exposure) : std::nullopt,
                                  toSrgb(opened_->state.display.tone)));
                tell(fmt::format("{}: held to compare with; B shows it", path));
            } else {
                open(path);
            }
        } catch (const Error& e) {
            tell(e.what());
        }
    }

    void hold(Image<Rgb8> image) {
        held_ = std::move(image);
        showing_held_ = false;
    }

    void resize() {
        const ivec2 size = window_.pixels();
        if (size == size_ || size.x < 1 || size.y < 1) {
            return;
        }
        size_ = size;
        opened_->state.render.width = size.x;
        opened_->state.render.height = size.y;
        postParams();
    }

    void postParams() {
        const RenderParams render = opened_->state.render;
        opened_->live->post([render](LiveImage& image) { image.setParams(render); }, kParamsJob);
    }

    void postCamera() {
        const Camera camera = opened_->control.camera();
        opened_->live->post([camera](LiveImage& image) { image.look(camera); }, kCameraJob);
    }

    void goTo(const Camera& camera) {
        opened_->control = CameraControl(camera, opened_->bounds);
        postCamera();
    }

    void savePng() {
        if (!shown_) {
            return;
        }
        const std::string path = freeName(opened_->file, "png");
        try {
            writePng(path, shown_->pixels);
            tell(fmt::format("wrote {}", path));
        } catch (const Error& e) {
            tell(e.what());
        }
    }

    void saveExr() {
        const std::string scene = opened_->file;
        opened_->live->post([scene](LiveImage& image) {
            writeExr(freeName(scene, "exr"), image.frame(), ExrLayers::kBasic);
        });
        tell("writing an EXR");
    }

    void sayCamera() {
        const vec3 eye = opened_->control.eye();
        const vec3 target = opened_->control.target();
        tell(fmt::format("--camera-at {},{},{} --look-at {},{},{} --fov {}", eye.x, eye.y, eye.z,
                         target.x, target.y, target.z, glm::degrees(opened_->control.yFov())));
    }

    void interface(bool fresh) {
        ViewerState& state = opened_->state;
        if (state.records && shown_) {
            const ImVec2 size = ImGui::GetIO().DisplaySize;
            drawMarks(*shown_, {size.x, size.y});
        }
        pixel_panel_.draw(opened_->live->picked(), shown_ ? shown_->exposure : 0.0f,
                          state.display.tone);
        const Wishes wishes = drawPanels(state, fresh ? shown_.get() : nullptr, shown_.get(),
                                         opened_->control.yFov());
        apply(wishes);
        followKeys();
        followMouse();
        state.display.marks = state.records;
        opened_->live->display(state.display);
    }

    void apply(const Wishes& wishes) {
        const ViewerState& state = opened_->state;
        if (wishes.render) {
            postParams();
        }
        if (wishes.lights) {
            const auto lights = state.lights;
            opened_->live->post(
                [lights](LiveImage& image) {
                    image.edit([&](Scene& scene) { scene.lights = lights; });
                },
                kLightsJob);
        }
        if (wishes.materials) {
            const auto materials = state.materials;
            opened_->live->post(
                [materials](LiveImage& image) {
                    image.edit([&](Scene& scene) {
                        for (size_t i = 0; i < materials.size(); ++i) {
                            scene.materials[i].params = materials[i];
                        }
                    });
                },
                kMaterialsJob);
        }
        if (wishes.camera >= 0) {
            goTo(state.cameras[static_cast<size_t>(wishes.camera)]);
        }
        if (wishes.y_fov > 0.0f) {
            opened_->control.setYFov(wishes.y_fov);
            postCamera();
        }
        if (wishes.save_png) {
            savePng();
        }
        if (wishes.save_exr) {
            saveExr();
        }
        if (wishes.save_camera) {
            sayCamera();
        }
    }

    void followKeys() {
        const std::vector<Window::Key> keys = window_.pressed();
        if (ImGui::GetIO().WantTextInput) {
            return;
        }
        for (const Window::Key& key : keys) {
            follow(key);
        }
        fly();
    }

    void follow(const Window::Key& key) {
        ViewerState& state = opened_->state;
        const auto camera = static_cast<size_t>(key.key - GLFW_KEY_1);
        if (key.key >= GLFW_KEY_1 && key.key <= GLFW_KEY_9 && camera < state.cameras.size()) {
            goTo(state.cameras[camera]);
            return;
        }
        switch (key.key) {
            case GLFW_KEY_ESCAPE:
                window_.close();
                break;
            case GLFW_KEY_TAB:
                state.panel = !state.panel;
                break;
            case GLFW_KEY_R:
                state.records = !state.records;
                break;
            case GLFW_KEY_C:
                state.display.channel = nextChannel(state.display.channel);
                break;
            case GLFW_KEY_P:
                savePng();
                break;
            case GLFW_KEY_B:
                compareNext();
                break;
            case GLFW_KEY_SLASH:
                state.shortcuts = state.shortcuts != key.shift;
                break;
            case GLFW_KEY_LEFT_BRACKET:
            case GLFW_KEY_RIGHT_BRACKET: {
                float& accuracy = state.render.placement.accuracy;
                const float factor = key.key == GLFW_KEY_LEFT_BRACKET ? 0.8f : 1.25f;
                accuracy = std::clamp(accuracy * factor, 0.05f, 2.0f);
                postParams();
                break;
            }
            default:
                break;
        }
    }

    void fly() {
        const auto along = [](int plus, int minus) {
            return (ImGui::IsKeyDown(plus) ? 1.0f : 0.0f) - (ImGui::IsKeyDown(minus) ? 1.0f : 0.0f);
        };
        const vec3 direction(along(GLFW_KEY_D, GLFW_KEY_A), along(GLFW_KEY_E, GLFW_KEY_Q),
                             along(GLFW_KEY_W, GLFW_KEY_S));
        if (direction == vec3(0.0f)) {
            return;
        }
        constexpr float kSpeed = 0.15f, kFast = 4.0f;  // sizes of the scene a second
        constexpr float kLongest = 0.1f;               // of a frame, seconds
        const float seconds = std::min(ImGui::GetIO().DeltaTime, kLongest);
        const float step = kSpeed * (ImGui::GetIO().KeyShift ? kFast : 1.0f) * seconds;
        opened_->control.move(step * opened_->control.scale() * direction);
        postCamera();
    }

    void followMouse() {
        const ImGuiIO& io = ImGui::GetIO();
        if (io.WantCaptureMouse) {
            return;
        }
        constexpr float kTurn = 0.005f;  // radians a unit of the window
        constexpr float kNearer = 0.9f;  // a notch of the wheel
        const vec2 moved(io.MouseDelta.x, io.MouseDelta.y);
        // Not by the way to where the button went down.
        const auto dragged = [&](ImGuiMouseButton button) {
            return io.MouseDownDuration[button] > 0.0f && moved != vec2(0.0f);
        };
        CameraControl& control = opened_->control;
        bool changed = false;
        constexpr float kStill = 4.0f;  // of a click, squared, units of the window
        if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) &&
            io.MouseDragMaxDistanceSqr[ImGuiMouseButton_Left] < kStill) {
            opened_->live->pick(vec2(io.MousePos.x, io.MousePos.y) /
                                vec2(io.DisplaySize.x, io.DisplaySize.y));
        }
        if (dragged(ImGuiMouseButton_Left)) {
            control.orbit(kTurn * moved.x, -kTurn * moved.y);
            changed = true;
        }
        if (dragged(ImGuiMouseButton_Right)) {
            control.turn(kTurn * moved.x, -kTurn * moved.y);
            changed = true;
        }
        if (dragged(ImGuiMouseButton_Middle)) {
            const float unit =
                2.0f * std::tan(0.5f * control.yFov()) / std::max(io.DisplaySize.y, 1.0f);
            const float way = unit * glm::length(control.target() - control.eye());
            control.move({-way * moved.x, way * moved.y, 0.0f});
            changed = true;
        }
        if (io.MouseWheel != 0.0f) {
            control.approach(std::pow(kNearer, io.MouseWheel));
            changed = true;
        }
        if (changed) {
            postCamera();
        }
    }

    static Channel nextChannel(Channel channel) {
        return channel == Channel::kOrder ? Channel::kImage
                                          : static_cast<Channel>(static_cast<int>(channel) + 1);
    }

    // Holds what is seen; shows it; lets it go.
    void compareNext() {
        if (!held_ && shown_) {
            hold(shown_->pixels);
            tell("held; B shows it");
        } else if (held_ && !showing_held_) {
            showing_held_ = true;
            tell("shown: what was held; B lets it go");
        } else {
            held_.reset();
            showing_held_ = false;
            tell("shown: the image");
        }
    }

    const ViewerParams& params_;
    Window window_;
    ivec2 size_;
    std::unique_ptr<Opened> opened_;
    std::shared_ptr<const Shown> shown_;
    std::optional<Image<Rgb8>> held_;
    bool showing_held_ = false, screenshot_taken_ = false, entitled_complete_ = false;
    std::optional<Benchmark> benchmark_;
    PixelPanel pixel_panel_;
};

}  // namespace

std::optional<ViewerFigures> runViewer(const ViewerParams& params) { return Viewer(params).run(); }

}  // namespace sheen
