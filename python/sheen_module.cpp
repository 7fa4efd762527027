// The Python module `sheen`: scenes, sessions and frames of libsheen, with numpy arrays in and out.
// It stands on the C++ header alone. docs/library.md.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <sheen/sheen.h>

#include <algorithm>
#include <deque>

namespace py = pybind11;

namespace {

using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;
using IndexArray = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using ByteArray = py::array_t<std::uint8_t, py::array::c_style>;

[[noreturn]] void failUsage(const std::string& message) {
    throw sheen::Error(sheen::ErrorKind::usage, message);
}

// As the command line has it: True, 0.5, "auto", (0, 1, 4).
std::string textOf(const py::handle& value) {
    if (value.is_none()) {
        return "";  // the default
    }
    if (py::isinstance<py::bool_>(value)) {
        return value.cast<bool>() ? "true" : "false";
    }
    if (py::isinstance<py::str>(value)) {
        return value.cast<std::string>();
    }
    if (py::isinstance<py::tuple>(value) || py::isinstance<py::list>(value) ||
        py::isinstance<py::array>(value)) {
        std::string text;
        for (const py::handle part : value) {
            text += (text.empty() ? "" : ",") + textOf(part);
        }
        return text;
    }
    // Numbers of numpy as well; what is none says so where it is parsed.
    const py::object plain = py::hasattr(value, "item") ? value.attr("item")()
                                                        : py::reinterpret_borrow<py::object>(value);
    return py::str(plain).cast<std::string>();
}

// target_error=0.02 as {"target-error", "0.02"}.
sheen::Options optionsOf(const py::kwargs& kwargs) {
    sheen::Options options;
    for (const auto& [key, value] : kwargs) {
        auto name = key.cast<std::string>();
        std::replace(name.begin(), name.end(), '_', '-');
        options.emplace_back(name, textOf(value));
    }
    return options;
}

// Takes out what is not an option.
py::object taken(py::kwargs& kwargs, const char* name) {
    return kwargs.contains(name) ? kwargs.attr("pop")(name).cast<py::object>() : py::none();
}

using Progress = std::function<bool(const std::string& what, double done)>;

// Warnings are Python's; between two percents Ctrl-C ends the work, as does what `progress` raises
// or its False (None goes on).
sheen::Listener listenerOf(const py::object& progress) {
    sheen::Listener listener;
    listener.warning = [](const std::string& message) {
        const py::gil_scoped_acquire gil;
        if (PyErr_WarnEx(PyExc_UserWarning, message.c_str(), 1) != 0) {
            throw py::error_already_set();
        }
    };
    listener.progress = [progress](const std::string& what, double done) {
        const py::gil_scoped_acquire gil;
        if (PyErr_CheckSignals() != 0) {
            throw py::error_already_set();
        }
        if (progress.is_none()) {
            return true;
        }
        const py::object result = progress(what, done);
        return result.is_none() || result.cast<bool>();
    };
    return listener;
}

// Without the interpreter's lock.
template <class Work>
auto unlocked(const Work& work) {
    const py::gil_scoped_release release;
    return work();
}

sheen::Scene loadScene(const py::object& source, py::kwargs kwargs) {
    const sheen::Listener listener = listenerOf(taken(kwargs, "progress"));
    const sheen::Options options = optionsOf(kwargs);
    if (py::isinstance<py::bytes>(source)) {
        const auto bytes = source.cast<std::string_view>();
        return unlocked(
            [&] { return sheen::Scene::fromBytes(bytes.data(), bytes.size(), options, listener); });
    }
    // Whatever open() takes for a name.
    const auto path = py::module_::import("os").attr("fspath")(source).cast<std::string>();
    return unlocked([&] { return sheen::Scene::load(path, options, listener); });
}

// ---- Scenes of arrays: lists of dictionaries whose keys are the members of sheen.h's structs ----

// Checks the keys too: a misspelt one would be a default in silence.
class Fields {
  public:
    Fields(const py::handle& from, std::string where) : where_(std::move(where)) {
        if (!py::isinstance<py::dict>(from)) {
            failUsage(where_ + ": must be a dict");
        }
        left_ = py::dict(from.cast<py::dict>().attr("copy")());
    }
    py::object take(const char* key) {
        return left_.contains(key) ? left_.attr("pop")(key).cast<py::object>() : py::none();
    }
    template <class T>
    void take(const char* key, T& to) {
        const py::object value = take(key);
        if (value.is_none()) {
            return;
        }
        try {
            to = value.cast<T>();
        } catch (const py::cast_error&) {
            fail(key, "is of the wrong type");
        }
    }
    void take(const char* key, float (&to)[3]) {
        const py::object value = take(key);
        if (value.is_none()) {
            return;
        }
        const FloatArray array = floats(key, value);
        if (array.size() != 3) {
            fail(key, "must have 3 numbers");
        }
        std::copy(array.data(), array.data() + 3, to);
    }
    // An array of rows of that width; flat ones are taken as such.
    template <class Array, class T>
    void takeRows(const char* key, py::ssize_t width, std::vector<T>& to) {
        const py::object value = take(key);
        if (value.is_none()) {
            return;
        }
        const Array array = Array::ensure(value);
        if (!array) {
            PyErr_Clear();
            fail(key, "is no array of numbers");
        }
        if (array.ndim() < 1 || (array.ndim() > 1 && array.shape(array.ndim() - 1) != width)) {
            fail(key, "must have rows of " + std::to_string(width));
        }
        to.assign(array.data(), array.data() + array.size());
    }
    // Triangles' corners: negative and fractional ones would become others.
    void takeIndices(const char* key, std::vector<std::uint32_t>& to) {
        const py::object value = take(key);
        if (value.is_none()) {
            return;
        }
        const py::array array = py::array::ensure(value);
        if (!array || (array.dtype().kind() != 'u' && array.dtype().kind() != 'i')) {
            PyErr_Clear();
            fail(key, "must be integers");
        }
        if (array.size() > 0 && py::int_(array.attr("min")()) < py::int_(0)) {
            fail(key, "must not be negative");
        }
        if (array.size() > 0 &&
            py::int_(array.attr("max")()).attr("bit_length")().cast<int>() > 32) {
            fail(key, "must be below 2^32");
        }
        left_[key] = array;
        takeRows<IndexArray>(key, 3, to);
    }
    void takeImage(const char* key, std::deque<sheen::ImageView>& images,
                   std::vector<py::object>& kept, const sheen::ImageView*& to) {
        const py::object value = take(key);
        if (value.is_none()) {
            return;
        }
        if (!py::isinstance<py::array_t<std::uint8_t>>(value)) {
            fail(key, "must be an array of uint8");
        }
        const auto array = ByteArray::ensure(value);
        if (!array || array.ndim() != 3 || array.shape(2) != 4) {
            fail(key, "must be an array [height][width][4]");
        }
        images.push_back(
            {static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), array.data()});
        kept.push_back(array);
        to = &images.back();
    }
    void end() const {
        for (const auto& [key, value] : left_) {
            failUsage(where_ + ": has no '" + py::str(key).cast<std::string>() + "'");
        }
    }

  private:
    FloatArray floats(const char* key, const py::object& value) const {
        FloatArray array = FloatArray::ensure(value);
        if (!array) {
            PyErr_Clear();
            fail(key, "is no array of numbers");
        }
        return array;
    }
    [[noreturn]] void fail(const char* key, const std::string& what) const {
        failUsage(where_ + ": " + key + " " + what);
    }
    std::string where_;
    py::dict left_;
};

template <class T, class Convert>
std::vector<T> listOf(const py::handle& list, const char* what, const Convert& convert) {
    std::vector<T> all;
    for (const py::handle one : list) {
        Fields fields(one, std::string(what) + " " + std::to_string(all.size()));
        all.push_back(convert(fields));
        fields.end();
    }
    return all;
}

sheen::Light lightOf(Fields& f) {
    sheen::Light light;
    std::string kind = "point";
    f.take("kind", kind);
    const char* const kinds[] = {"point", "spot", "directional"};
    const auto found = std::find(std::begin(kinds), std::end(kinds), kind);
    if (found == std::end(kinds)) {
        failUsage("light: kind '" + kind + "' must be point, spot or directional");
    }
    light.kind = static_cast<sheen::LightKind>(found - std::begin(kinds));
    f.take("position", light.position);
    f.take("direction", light.direction);
    f.take("intensity", light.intensity);
    f.take("inner_cone", light.inner_cone);
    f.take("outer_cone", light.outer_cone);
    return light;
}

sheen::Scene sceneFromArrays(const py::list& meshes, const py::list& materials,
                             const py::list& lights, const py::list& cameras, py::kwargs kwargs) {
    std::deque<sheen::ImageView> images;
    std::vector<py::object> kept;
    sheen::Arrays arrays;
    arrays.materials = listOf<sheen::Material>(materials, "material", [&](Fields& f) {
        sheen::Material m;
        f.take("name", m.name);
        f.take("base_color", m.base_color);
        f.take("metallic", m.metallic);
        f.take("roughness", m.roughness);
        f.take("emission", m.emission);
        f.take("single_sided", m.single_sided);
        f.takeImage("color_image", images, kept, m.color_image);
        f.takeImage("metallic_roughness_image", images, kept, m.metallic_roughness_image);
        f.takeImage("normal_image", images, kept, m.normal_image);
        f.takeImage("emission_image", images, kept, m.emission_image);
        return m;
    });
    arrays.meshes = listOf<sheen::Mesh>(meshes, "mesh", [](Fields& f) {
        sheen::Mesh m;
        f.take("name", m.name);
        f.takeRows<FloatArray>("positions", 3, m.positions);
        f.takeRows<FloatArray>("normals", 3, m.normals);
        f.takeRows<FloatArray>("uvs", 2, m.uvs);
        f.takeIndices("indices", m.indices);
        f.take("material", m.material);
        return m;
    });
    arrays.lights = listOf<sheen::Light>(lights, "light", lightOf);
    arrays.cameras = listOf<sheen::Camera>(cameras, "camera", [](Fields& f) {
        sheen::Camera c;
        f.take("name", c.name);
        f.take("position", c.position);
        f.take("look_at", c.look_at);
        f.take("up", c.up);
        f.take("fov", c.fov);
        return c;
    });
    const sheen::Listener listener = listenerOf(taken(kwargs, "progress"));
    const sheen::Options options = optionsOf(kwargs);
    return unlocked([&] { return sheen::Scene::fromArrays(arrays, options, listener); });
}

// ---- Light at points ----

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::tuple irradianceAt(const sheen::Scene& scene, const DoubleArray& positions,
                       const FloatArray& normals, float width, py::kwargs kwargs) {
    const auto is_rows = [](const py::array& array) {
        return array.ndim() == 2 && array.shape(1) == 3;
    };
    if (!is_rows(positions) || !is_rows(normals) || positions.shape(0) != normals.shape(0)) {
        failUsage("points: positions and normals must be as many rows of 3");
    }
    sheen::Points points;
    points.positions.assign(positions.data(), positions.data() + positions.size());
    points.normals.assign(normals.data(), normals.data() + normals.size());
    points.width = width;
    const sheen::Listener listener = listenerOf(taken(kwargs, "progress"));
    const sheen::Options options = optionsOf(kwargs);
    const sheen::Irradiance light =
        unlocked([&] { return sheen::irradiance(scene, points, options, listener); });
    const std::vector<py::ssize_t> shape = {positions.shape(0), 3};
    return py::make_tuple(py::array_t<float>(shape, light.direct.data()),
                          py::array_t<float>(shape, light.indirect.data()));
}

// ---- Frames ----

// A view of the frame's own memory, which it keeps alive and nobody may write.
template <class T>
py::array_t<T> readOnly(const py::object& frame, std::vector<py::ssize_t> shape, const T* values) {
    py::array_t<T> array(std::move(shape), values, frame);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

py::array layerOf(const py::object& self, const std::string& name) {
    const auto& frame = self.cast<const sheen::Frame&>();
    if (name == "primitive") {
        return readOnly(self, {frame.height(), frame.width()}, frame.primitive());
    }
    const sheen::Layer layer = frame.layer(name);
    return layer.channels == 1
               ? readOnly(self, {layer.height, layer.width}, layer.values)
               : readOnly(self, {layer.height, layer.width, layer.channels}, layer.values);
}

std::vector<std::string> layersOf(const sheen::Frame& frame) {
    std::vector<std::string> names = frame.layers();
    names.emplace_back("primitive");
    return names;
}

sheen::Frame renderFrame(const sheen::Session& session, py::kwargs kwargs) {
    const sheen::Listener listener = listenerOf(taken(kwargs, "progress"));
    const sheen::Options options = optionsOf(kwargs);
    return unlocked([&] { return session.render(options, listener); });
}

// Options of both in one call: those of the scene are few.
sheen::Frame renderFile(const py::object& scene, py::kwargs kwargs) {
    if (py::isinstance<sheen::Scene>(scene)) {
        return renderFrame(sheen::Session(scene.cast<const sheen::Scene&>()), kwargs);
    }
    py::kwargs of_scene;
    for (const char* name : {"variant", "environment", "environment_rotation",
                             "environment_strength", "transparent"}) {
        const py::object value = taken(kwargs, name);
        if (!value.is_none()) {
            of_scene[name] = value;
        }
    }
    // Those of the view belong to both.
    for (const char* name : {"camera", "camera_at", "look_at", "fov", "progress"}) {
        if (kwargs.contains(name)) {
            of_scene[name] = kwargs[name];
        }
    }
    return renderFrame(sheen::Session(loadScene(scene, of_scene)), kwargs);
}

// Raises sheen.Error by its kind: UsageError, InputError, EnvironmentError, CancelledError,
// BugError.
void addErrors(py::module_& module) {
    static py::handle error, kinds[6];  // immortal, as the module is
    error = PyErr_NewException("sheen.Error", PyExc_RuntimeError, nullptr);
    module.attr("Error") = error;
    const std::pair<sheen::ErrorKind, const char*> names[] = {
        {sheen::ErrorKind::bug, "BugError"},
        {sheen::ErrorKind::usage, "UsageError"},
        {sheen::ErrorKind::input, "InputError"},
        {sheen::ErrorKind::environment, "EnvironmentError"},
        {sheen::ErrorKind::cancelled, "CancelledError"}};
    for (const auto& [kind, name] : names) {
        py::handle& one = kinds[static_cast<int>(kind)];
        one = PyErr_NewException((std::string("sheen.") + name).c_str(), error.ptr(), nullptr);
        module.attr(name) = one;
    }
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(thrown);
        } catch (const sheen::Error& e) {
            PyErr_SetString(kinds[static_cast<int>(e.kind())].ptr(), e.what());
        }
    });
}

}  // namespace

PYBIND11_MODULE(sheen, module) {
    module.doc() = "Glossy global illumination without noise, by radiance caching.";
    module.attr("__version__") = sheen_version();
    addErrors(module);

    py::class_<sheen::Scene>(module, "Scene", "A scene, loaded; it never changes.")
        .def(py::init(&loadScene), py::arg("source"),
             "Scene(file name or bytes of a .glb or .gltf, **options): variant, environment, "
             "environment_rotation, environment_strength, transparent; camera, camera_at, look_at, "
             "fov. Warnings are Python's.")
        .def_static(
            "from_arrays", &sceneFromArrays, py::arg("meshes"), py::arg("materials") = py::list(),
            py::arg("lights") = py::list(), py::arg("cameras") = py::list(),
            "A scene of lists of dicts: meshes {positions [n][3], normals, uvs, indices "
            "[n][3], material, name}, materials {base_color, metallic, roughness, emission, "
            "color_image [h][w][4] uint8, ...}, lights {kind, position, direction, "
            "intensity, ...}, cameras {position, look_at, up, fov, name}.")
        .def("irradiance", &irradianceAt, py::arg("positions"), py::arg("normals"),
             py::arg("width"),
             "(direct, indirect) irradiance, lux, float32 [n][3], at points of surfaces: positions "
             "[n][3] in the file's coordinates, normals [n][3] on the side that is asked for; "
             "width: about as far as points lie apart. NaN where there is no surface. Options: "
             "accuracy, bounces, threads; progress.")
        .def_property_readonly("triangle_count", &sheen::Scene::triangleCount)
        .def_property_readonly("cameras", &sheen::Scene::cameras, "Their names.")
        .def_property_readonly(
            "bounds",
            [](const sheen::Scene& scene) -> py::object {
                double lower[3], upper[3];
                if (!scene.bounds(lower, upper)) {
                    return py::none();
                }
                return py::make_tuple(py::make_tuple(lower[0], lower[1], lower[2]),
                                      py::make_tuple(upper[0], upper[1], upper[2]));
            },
            "(least, greatest) of x, y, z in the file's coordinates; None where there is nothing.");

    py::class_<sheen::Session>(module, "Session",
                               "Renders frames of a scene, which share what is "
                               "made of it.")
        .def(py::init([](const sheen::Scene& scene, bool keep_records) {
                 sheen::Session session(scene);
                 if (keep_records) {
                     session.keepRecords();
                 }
                 return session;
             }),
             py::arg("scene"), py::arg("keep_records") = false,
             "keep_records: a frame begins with the records of former ones.")
        .def("render", &renderFrame,
             "A Frame. Options: those of `sheen render --help`, such as target_error=0.02; width "
             "and height; progress=function(what, done), whose False cancels.");

    py::class_<sheen::Frame>(module, "Frame", "A frame: its layers as numpy arrays.")
        .def_property_readonly("width", &sheen::Frame::width)
        .def_property_readonly("height", &sheen::Frame::height)
        .def_property_readonly("layers", &layersOf, "Their names.")
        .def("__getitem__", &layerOf, py::arg("layer"),
             "float32 [height][width] or [height][width][3], primitive uint32; not writable.")
        .def_property_readonly(
            "figures",
            [](const sheen::Frame& frame) {
                return py::module_::import("json").attr("loads")(frame.json());
            },
            "The figures of `sheen render --json`, a dict.")
        .def(
            "write",
            [](const sheen::Frame& frame, const py::object& path, const py::kwargs& kwargs) {
                const auto name =
                    py::module_::import("os").attr("fspath")(path).cast<std::string>();
                const sheen::Options options = optionsOf(kwargs);
                unlocked([&] { frame.write(name, options); });
            },
            py::arg("path"), "To .exr, or .png with the options exposure, tone, view and ocio.");

    module.def("render", &renderFile, py::arg("scene"),
               "A Frame of a file, of its bytes or of a Scene; options of both: see Scene and "
               "Session.render.");
}
