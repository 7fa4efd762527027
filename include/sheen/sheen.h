// Sheen in a program of one's own: glossy global illumination by radiance caching.
//
//     const sheen::Session session(sheen::Scene::load("scene.glb"));
//     session.render({{"size", "640x480"}, {"target-error", 0.02}}).write("out.exr");
//
// A thin wrapper of the C interface (sheen_c.h): all of it is in this header, so that the library's
// binary interface is C's. Options are those of `sheen render --help`, by their long names without
// dashes. Errors are exceptions; nothing is printed. docs/library.md.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "sheen/sheen_c.h"

namespace sheen {

/// What kind of failure: `bug` is the library's own; the others can be mended.
enum class ErrorKind {
    bug = SHEEN_BUG,
    usage = SHEEN_USAGE,
    input = SHEEN_INPUT,
    environment = SHEEN_ENVIRONMENT,
    cancelled = SHEEN_CANCELLED
};

/// One line: where, what and how to mend it.
class Error : public std::runtime_error {
  public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
    ErrorKind kind() const noexcept { return kind_; }

  private:
    ErrorKind kind_;
};

/// A setting: a name, and text, a number, or several of them ({"camera-at", {0, 1, 4}}).
class Option {
  public:
    Option(std::string name, std::string value)
        : name_(std::move(name)), value_(std::move(value)) {}
    Option(std::string name, const char* value) : name_(std::move(name)), value_(value) {}
    Option(std::string name, bool value)
        : name_(std::move(name)), value_(value ? "true" : "false") {}
    Option(std::string name, int value) : Option(std::move(name), std::to_string(value)) {}
    Option(std::string name, double value) : Option(std::move(name), textOf(value)) {}
    Option(std::string name, std::initializer_list<double> values) : name_(std::move(name)) {
        for (const double value : values) {
            value_ += value_.empty() ? "" : ",";
            value_ += textOf(value);
        }
    }
    const std::string& name() const { return name_; }
    const std::string& value() const { return value_; }

  private:
    static std::string textOf(double value) {  // whatever the locale
        char text[32];
        return {text, std::to_chars(text, text + sizeof(text), value).ptr};
    }
    std::string name_, value_;
};
using Options = std::vector<Option>;

/// Who hears of a call; each may be empty.
struct Listener {
    /// Of what is under way and the share of it that is done, from any thread, one at a time. False
    /// cancels the call, as does an exception, which the call then throws.
    std::function<bool(const std::string& what, double done)> progress = {};
    std::function<void(const std::string& message)> warning = {};
};

namespace detail {

// A listener as C has it. An exception must not pass through C: it is kept and thrown afterwards.
class Ear {
  public:
    explicit Ear(const Listener& listener) : listener_(listener) {
        c_.user = this;
        c_.progress = listener.progress ? &Ear::onProgress : nullptr;
        c_.warning = listener.warning ? &Ear::onWarning : nullptr;
    }
    const sheen_listener* c() const { return &c_; }
    void rethrow() const {
        if (thrown_) {
            std::rethrow_exception(thrown_);
        }
    }

  private:
    static int onProgress(void* user, const char* what, double done) noexcept {
        auto* ear = static_cast<Ear*>(user);
        try {
            return ear->listener_.progress(what, done) ? 0 : 1;
        } catch (...) {
            ear->thrown_ = std::current_exception();
            return 1;
        }
    }
    static void onWarning(void* user, const char* message) noexcept {
        auto* ear = static_cast<Ear*>(user);
        try {
            ear->listener_.warning(message);
        } catch (...) {
            ear->thrown_ = std::current_exception();
        }
    }
    const Listener& listener_;
    sheen_listener c_{};
    std::exception_ptr thrown_;
};

inline std::vector<sheen_option> cOptions(const Options& options) {
    std::vector<sheen_option> all;
    for (const Option& option : options) {
        all.push_back({option.name().c_str(), option.value().c_str()});
    }
    return all;
}

// Calls call(error) and throws where it fails.
template <class Call>
void check(const Call& call, const Ear* ear = nullptr) {
    sheen_error error{};
    const sheen_status status = call(&error);
    if (ear != nullptr) {
        ear->rethrow();
    }
    if (status != SHEEN_DONE) {
        throw Error(static_cast<ErrorKind>(status), error.message);
    }
}

}  // namespace detail

/// [height][width][4] bytes, the first row on top; must live until the scene is made.
using ImageView = sheen_image;
using LightKind = sheen_light_kind;

/// See sheen_material.
struct Material {
    std::string name = {};
    float base_color[3] = {0.8f, 0.8f, 0.8f};
    float metallic = 0.0f;
    float roughness = 1.0f;
    float emission[3] = {0.0f, 0.0f, 0.0f};
    const ImageView* color_image = nullptr;
    const ImageView* metallic_roughness_image = nullptr;
    const ImageView* normal_image = nullptr;
    const ImageView* emission_image = nullptr;
    bool single_sided = false;
};

/// See sheen_mesh. Three numbers a position, normal and triangle, two a texture coordinate.
struct Mesh {
    std::string name = {};
    std::vector<float> positions;
    std::vector<float> normals = {};
    std::vector<float> uvs = {};
    std::vector<std::uint32_t> indices = {};  ///< empty: three vertices each, in their order
    int material = -1;
};

/// See sheen_light.
struct Light {
    LightKind kind = SHEEN_POINT_LIGHT;
    float position[3] = {0.0f, 0.0f, 0.0f};
    float direction[3] = {0.0f, -1.0f, 0.0f};
    float intensity[3] = {1.0f, 1.0f, 1.0f};
    float inner_cone = 0.0f;
    float outer_cone = 0.785f;
};

/// See sheen_camera.
struct Camera {
    std::string name = {};
    float position[3] = {0.0f, 0.0f, 1.0f};
    float look_at[3] = {0.0f, 0.0f, 0.0f};
    float up[3] = {0.0f, 1.0f, 0.0f};
    float fov = 50.0f;
};

/// A scene by arrays, without a file.
struct Arrays {
    std::vector<Material> materials = {};
    std::vector<Mesh> meshes = {};
    std::vector<Light> lights = {};
    std::vector<Camera> cameras = {};
};

namespace detail {

template <std::size_t N>
void copy(const float (&from)[N], float (&to)[N]) {
    for (std::size_t i = 0; i < N; ++i) {
        to[i] = from[i];
    }
}

// Arrays of whose lengths do not fit are an error of their own, which C cannot see.
inline sheen_mesh cMesh(const Mesh& mesh) {
    const std::size_t vertices = mesh.positions.size() / 3;
    const std::size_t corners = mesh.indices.empty() ? vertices : mesh.indices.size();
    if (mesh.positions.size() % 3 != 0 || corners % 3 != 0 ||
        (!mesh.normals.empty() && mesh.normals.size() != 3 * vertices) ||
        (!mesh.uvs.empty() && mesh.uvs.size() != 2 * vertices)) {
        throw Error(ErrorKind::input,
                    "mesh " + mesh.name +
                        ": arrays must hold 3 numbers a position, normal and "
                        "triangle and 2 a texture coordinate, of as many vertices");
    }
    return {mesh.name.c_str(),
            vertices,
            mesh.positions.data(),
            mesh.normals.empty() ? nullptr : mesh.normals.data(),
            mesh.uvs.empty() ? nullptr : mesh.uvs.data(),
            corners / 3,
            mesh.indices.empty() ? nullptr : mesh.indices.data(),
            mesh.material};
}

inline sheen_material cMaterial(const Material& from) {
    sheen_material to{};
    to.name = from.name.c_str();
    copy(from.base_color, to.base_color);
    to.metallic = from.metallic;
    to.roughness = from.roughness;
    copy(from.emission, to.emission);
    to.color_image = from.color_image;
    to.metallic_roughness_image = from.metallic_roughness_image;
    to.normal_image = from.normal_image;
    to.emission_image = from.emission_image;
    to.single_sided = from.single_sided ? 1 : 0;
    return to;
}

inline sheen_light cLight(const Light& from) {
    sheen_light to{};
    to.kind = from.kind;
    copy(from.position, to.position);
    copy(from.direction, to.direction);
    copy(from.intensity, to.intensity);
    to.inner_cone = from.inner_cone;
    to.outer_cone = from.outer_cone;
    return to;
}

inline sheen_camera cCamera(const Camera& from) {
    sheen_camera to{};
    to.name = from.name.c_str();
    copy(from.position, to.position);
    copy(from.look_at, to.look_at);
    copy(from.up, to.up);
    to.fov = from.fov;
    return to;
}

// Each of them as C has it; pointers lead into `from`.
template <class From, class To>
std::vector<To> each(const std::vector<From>& from, To (*convert)(const From&)) {
    std::vector<To> all;
    for (const From& one : from) {
        all.push_back(convert(one));
    }
    return all;
}

}  // namespace detail

/// A scene, loaded; copies share it.
class Scene {
  public:
    /// A .glb or .gltf file; options and errors: sheen_scene_load().
    static Scene load(const std::string& path, const Options& options = {},
                      const Listener& listener = {}) {
        return made(options, listener,
                    [&](auto... rest) { return sheen_scene_load(path.c_str(), rest...); });
    }
    /// The same of a file's bytes.
    static Scene fromBytes(const void* bytes, std::size_t size, const Options& options = {},
                           const Listener& listener = {}) {
        return made(options, listener,
                    [&](auto... rest) { return sheen_scene_from_bytes(bytes, size, rest...); });
    }
    static Scene fromArrays(const Arrays& arrays, const Options& options = {},
                            const Listener& listener = {}) {
        const auto materials = detail::each(arrays.materials, detail::cMaterial);
        const auto meshes = detail::each(arrays.meshes, detail::cMesh);
        const auto lights = detail::each(arrays.lights, detail::cLight);
        const auto cameras = detail::each(arrays.cameras, detail::cCamera);
        const sheen_arrays c{materials.data(), materials.size(), meshes.data(),  meshes.size(),
                             lights.data(),    lights.size(),    cameras.data(), cameras.size()};
        return made(options, listener,
                    [&](auto... rest) { return sheen_scene_from_arrays(&c, rest...); });
    }

    std::size_t triangleCount() const { return sheen_scene_triangle_count(c()); }
    std::vector<std::string> cameras() const {
        std::vector<std::string> names;
        for (std::size_t i = 0; i < sheen_scene_camera_count(c()); ++i) {
            names.emplace_back(sheen_scene_camera_name(c(), i));
        }
        return names;
    }
    /// In the file's coordinates; false where there is nothing.
    bool bounds(double (&lower)[3], double (&upper)[3]) const {
        double both[6];
        if (sheen_scene_bounds(c(), both) != 0) {
            return false;
        }
        for (int i = 0; i < 3; ++i) {
            lower[i] = both[i];
            upper[i] = both[3 + i];
        }
        return true;
    }

    const sheen_scene* c() const { return scene_.get(); }

  private:
    explicit Scene(sheen_scene* scene) : scene_(scene, &sheen_scene_free) {}
    template <class Make>
    static Scene made(const Options& options, const Listener& listener, const Make& make) {
        const detail::Ear ear(listener);
        const std::vector<sheen_option> all = detail::cOptions(options);
        sheen_scene* scene = nullptr;
        const auto call = [&](sheen_error* error) {
            return make(all.data(), all.size(), ear.c(), &scene, error);
        };
        try {
            detail::check(call, &ear);
        } catch (...) {
            sheen_scene_free(scene);
            throw;
        }
        return Scene(scene);
    }
    std::shared_ptr<sheen_scene> scene_;
};

/// Points of surfaces: see sheen_points. Three numbers a position and a normal.
struct Points {
    std::vector<double> positions;
    std::vector<float> normals;
    float width = 0.0f;
};

/// Lux, three numbers a point; NaN where there is no surface.
struct Irradiance {
    std::vector<float> direct, indirect;
};

/// Light at points: sheen_irradiance().
inline Irradiance irradiance(const Scene& scene, const Points& points, const Options& options = {},
                             const Listener& listener = {}) {
    if (points.positions.size() % 3 != 0 || points.normals.size() != points.positions.size()) {
        throw Error(ErrorKind::usage, "points: must have 3 numbers a position and a normal");
    }
    const detail::Ear ear(listener);
    const std::vector<sheen_option> all = detail::cOptions(options);
    const sheen_points c{points.positions.size() / 3, points.positions.data(),
                         points.normals.data(), points.width};
    Irradiance light{std::vector<float>(points.positions.size()),
                     std::vector<float>(points.positions.size())};
    detail::check(
        [&](sheen_error* error) {
            return sheen_irradiance(scene.c(), &c, all.data(), all.size(), ear.c(),
                                    light.direct.data(), light.indirect.data(), error);
        },
        &ear);
    return light;
}

/// A layer of a frame, which must outlive it: [height][width][channels], the first row on top.
struct Layer {
    std::string name;
    int width = 0, height = 0, channels = 0;
    const float* values = nullptr;
    float at(int x, int y, int channel = 0) const {
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        return values[(row + static_cast<std::size_t>(x)) * static_cast<std::size_t>(channels) +
                      static_cast<std::size_t>(channel)];
    }
};

/// A frame, rendered; copies share it.
class Frame {
  public:
    int width() const { return sheen_frame_width(c()); }
    int height() const { return sheen_frame_height(c()); }
    /// Usage error that lists them where there is none of that name.
    Layer layer(const std::string& name) const {
        sheen_layer found{};
        detail::check([&](sheen_error* error) {
            return sheen_frame_layer(c(), name.c_str(), &found, error);
        });
        return {found.name, width(), height(), found.channels, found.values};
    }
    std::vector<std::string> layers() const {
        std::vector<std::string> names;
        sheen_layer layer{};
        while (sheen_frame_layer_at(c(), names.size(), &layer) == 0) {
            names.emplace_back(layer.name);
        }
        return names;
    }
    /// [height][width]: the triangle that is seen, 0xffffffff: none.
    const std::uint32_t* primitive() const { return sheen_frame_primitive(c()); }
    /// Figures of `sheen render --json`: one that is a number, NaN where it is not known, and all.
    double figure(const std::string& name) const {
        double value = 0.0;
        detail::check([&](sheen_error* error) {
            return sheen_frame_figure(c(), name.c_str(), &value, error);
        });
        return value;
    }
    std::string json() const { return sheen_frame_json(c()); }
    /// To .exr, or .png with the options exposure, tone, view and ocio.
    void write(const std::string& path, const Options& options = {}) const {
        const std::vector<sheen_option> all = detail::cOptions(options);
        detail::check([&](sheen_error* error) {
            return sheen_frame_write(c(), path.c_str(), all.data(), all.size(), error);
        });
    }

    const sheen_frame* c() const { return frame_.get(); }

  private:
    friend class Session;
    explicit Frame(sheen_frame* frame) : frame_(frame, &sheen_frame_free) {}
    std::shared_ptr<sheen_frame> frame_;
};

/// Renders frames of a scene, which share what is made of it; copies are one session.
class Session {
  public:
    explicit Session(const Scene& scene) {
        sheen_session* session = nullptr;
        detail::check(
            [&](sheen_error* error) { return sheen_session_new(scene.c(), &session, error); });
        session_ = {session, &sheen_session_free};
    }
    /// From now on a frame begins with the records of former ones: sheen_session_keep_records().
    void keepRecords() const {
        detail::check(
            [&](sheen_error* error) { return sheen_session_keep_records(session_.get(), error); });
    }
    /// Options and errors: sheen_render().
    Frame render(const Options& options = {}, const Listener& listener = {}) const {
        const detail::Ear ear(listener);
        const std::vector<sheen_option> all = detail::cOptions(options);
        sheen_frame* frame = nullptr;
        const auto call = [&](sheen_error* error) {
            return sheen_render(session_.get(), all.data(), all.size(), ear.c(), &frame, error);
        };
        try {
            detail::check(call, &ear);
        } catch (...) {
            sheen_frame_free(frame);
            throw;
        }
        return Frame(frame);
    }

  private:
    std::shared_ptr<sheen_session> session_;
};

}  // namespace sheen
