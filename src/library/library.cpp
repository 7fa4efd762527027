// The functions of sheen_c.h. Nothing that is thrown leaves them.
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>

#include "cli/mattes.h"
#include "cli/render_report.h"
#include "cli/render_wanted.h"
#include "core/failure.h"
#include "core/listener.h"
#include "core/timer.h"
#include "image/exr.h"
#include "image/png.h"
#include "library/arrays.h"
#include "library/points.h"
#include "library/requests.h"
#include "scene/defaults.h"
#include "scene/scene_bytes.h"

struct sheen_scene {
    std::string name;
    bool from_file = false;
    std::shared_ptr<const sheen::Scene> scene;
    std::vector<sheen::library::NamedValue> options;  // that it was loaded with
};

struct sheen_session {
    std::string name;
    bool from_file;
    std::shared_ptr<const sheen::Scene> scene;
    std::vector<sheen::library::NamedValue> scene_options;
    sheen::Session session;
    std::mutex mutex;  // of one frame at a time

    explicit sheen_session(const sheen_scene& of)
        : name(of.name),
          from_file(of.from_file),
          scene(of.scene),
          scene_options(of.options),
          session(*scene) {}
};

struct sheen_frame {
    sheen::Frame frame;
    bool all_layers = false;
    sheen::ExrNotes notes;
    std::vector<sheen::Matte> mattes;  // with all layers
    sheen::Image<sheen::vec3> beauty;
    sheen::Image<float> alpha;
    std::vector<sheen_layer> layers;  // which point into the images above
    sheen::cli::Json figures;
    std::string json;
};

namespace sheen::library {
namespace {

// The listener asked for the end.
struct Cancelled {};

void fill(sheen_error* error, sheen_status status, const std::string& message) {
    if (error == nullptr) {
        return;
    }
    error->status = status;
    size_t length = std::min(message.size(), sizeof(error->message) - 1);
    // Not within a UTF-8 character.
    while (length < message.size() && length > 0 &&
           (static_cast<unsigned char>(message[length]) & 0xC0) == 0x80) {
        --length;
    }
    std::memcpy(error->message, message.data(), length);
    error->message[length] = '\0';
}

sheen_status statusOf(ExitCode code) { return static_cast<sheen_status>(code); }

// Calls body(); what it throws becomes the result and `error`.
template <class Body>
sheen_status guarded(sheen_error* error, const Body& body) {
    const auto failed = [error](sheen_status status, const std::string& message) {
        fill(error, status, message);
        return status;
    };
    try {
        body();
        fill(error, SHEEN_DONE, "");
        return SHEEN_DONE;
    } catch (const Cancelled&) {
        return failed(SHEEN_CANCELLED, "cancelled by the listener");
    } catch (...) {
        const Failure failure = failureOf(std::current_exception());
        return failed(statusOf(failure.code), failure.message);
    }
}

template <class T>
void checkGiven(const T* pointer, const char* what) {
    if (pointer == nullptr) {
        throwUsage("{} is NULL", what);
    }
}

std::span<const sheen_option> spanOf(const sheen_option* options, size_t count) {
    if (count > 0) {
        checkGiven(options, "options");
    }
    return {options, count};
}

Listener listenerOf(const sheen_listener* c) {
    Listener listener;
    if (c != nullptr && c->progress != nullptr) {
        // Other threads may come here before the work has ended.
        const auto cancelled = std::make_shared<std::atomic<bool>>(false);
        listener.progress = [c, cancelled](const std::string& what, double done) {
            if (*cancelled || c->progress(c->user, what.c_str(), done) != 0) {
                *cancelled = true;
                throw Cancelled();
            }
        };
    }
    if (c != nullptr && c->warning != nullptr) {
        listener.warning = [c](const std::string& message) {
            c->warning(c->user, message.c_str());
        };
    }
    return listener;
}

struct OptionList {
    const sheen_option* options;
    size_t count;
};

// A scene that load(params) makes.
template <class Load>
sheen_status makeScene(const std::string& name, bool from_file, const OptionList& options,
                       const sheen_listener* c_listener, sheen_scene** result, sheen_error* error,
                       const Load& load) {
    return guarded(error, [&] {
        checkGiven(result, "scene");
        *result = nullptr;
        const Listener listener = listenerOf(c_listener);
        const ListenerScope scope(listener);
        const auto given = spanOf(options.options, options.count);
        const auto request = requestOf(Call::kScene, given);
        auto scene = std::make_shared<const Scene>(load(request->options.load));
        for (const std::string& warning : scene->warnings) {
            warn(warning);
        }
        *result = new sheen_scene{name, from_file, std::move(scene), namedValues(given)};
    });
}

// By at most so many threads; 0: all that there are.
template <class Work>
void withThreads(int threads, const Work& work) {
    if (threads > 0) {
        tbb::task_arena(threads).execute(work);
    } else {
        work();
    }
}

// A camera that the request moves or turns, of those of the scene.
void chooseView(const Scene& scene, cli::RenderOptions& options) {
    if (options.load.view.given()) {
        options.params.view = seenFrom(scene, options.load);
    }
}

void addLayers(sheen_frame& frame) {
    const auto add = [&](const char* name, int channels, const float* values) {
        frame.layers.push_back({name, channels, values});
    };
    frame.beauty = beauty(frame.frame);
    frame.alpha = alpha(frame.frame);
    add("beauty", 3, &frame.beauty.pixels[0].x);
    add("alpha", 1, frame.alpha.pixels.data());
    for (const FrameLayer& layer : layersOf(frame.frame)) {
        if (frame.all_layers || layer.basic) {
            const bool triples = layer.triples != nullptr;
            add(layer.name, triples ? 3 : 1,
                triples ? &layer.triples->pixels[0].x : layer.numbers->pixels.data());
        }
    }
}

std::unique_ptr<sheen_frame> renderedFrame(sheen_session& session, cli::RenderOptions& options) {
    const Timer timer;
    const Scene& scene = *session.scene;
    options.scene = session.name;
    options.output = "frame";  // in warnings
    chooseView(scene, options);
    if (!options.cache.empty() && !session.from_file) {
        throwUsage("option cache: records are kept only of scenes that are loaded from a file");
    }
    RenderResult result;
    const auto render = [&] {
        // Records of a file are that frame's: the session's own stay what they are.
        std::optional<Session> own;
        if (!options.cache.empty()) {
            own.emplace(scene);
        }
        result = cli::renderWanted(own ? *own : session.session, scene, options);
    };
    withThreads(options.threads, render);
    result.stats.seconds.total = timer.seconds();
    cli::warnOf(options, scene, result, options.params.time_limit);
    auto frame = std::make_unique<sheen_frame>();
    frame->frame = std::move(result.frame);
    frame->all_layers = options.params.all_layers;
    frame->notes = cli::notesOf(options, result.stats);
    if (frame->all_layers) {
        frame->mattes = cli::mattesOf(scene, frame->frame);
    }
    addLayers(*frame);
    frame->figures = cli::statsJson(options, result.stats);
    frame->figures.erase("output");
    frame->json = frame->figures.dump();
    return frame;
}

}  // namespace
}  // namespace sheen::library

using namespace sheen;
using namespace sheen::library;

const char* sheen_version(void) { return SHEEN_VERSION; }

sheen_status sheen_scene_load(const char* path, const sheen_option* options, size_t count,
                              const sheen_listener* listener, sheen_scene** scene,
                              sheen_error* error) {
    const std::string name = path == nullptr ? "" : path;
    return makeScene(name, true, {options, count}, listener, scene, error,
                     [&](const LoadParams& params) {
                         checkGiven(path, "path");
                         return loadScene(name, params);
                     });
}

sheen_status sheen_scene_from_bytes(const void* bytes, size_t size, const sheen_option* options,
                                    size_t count, const sheen_listener* listener,
                                    sheen_scene** scene, sheen_error* error) {
    const std::string name = "bytes";
    return makeScene(
        name, false, {options, count}, listener, scene, error, [&](const LoadParams& params) {
            checkGiven(bytes, "bytes");
            return sceneFromBytes(name, {static_cast<const char*>(bytes), size}, params);
        });
}

sheen_status sheen_scene_from_arrays(const sheen_arrays* arrays, const sheen_option* options,
                                     size_t count, const sheen_listener* listener,
                                     sheen_scene** scene, sheen_error* error) {
    return makeScene(kArrays, false, {options, count}, listener, scene, error,
                     [&](const LoadParams& params) {
                         checkGiven(arrays, "arrays");
                         return sceneFromBytes(kArrays, glbOf(*arrays), params);
                     });
}

void sheen_scene_free(sheen_scene* scene) { delete scene; }

size_t sheen_scene_triangle_count(const sheen_scene* scene) {
    return scene->scene->triangles.size();
}

size_t sheen_scene_camera_count(const sheen_scene* scene) { return scene->scene->cameras.size(); }

const char* sheen_scene_camera_name(const sheen_scene* scene, size_t camera) {
    const std::vector<Camera>& cameras = scene->scene->cameras;
    return camera < cameras.size() ? cameras[camera].name.c_str() : nullptr;
}

int sheen_scene_bounds(const sheen_scene* scene, double bounds[6]) {
    const Bounds& b = scene->scene->bounds;
    if (b.empty()) {
        return 1;
    }
    const dvec3 lower = scene->scene->inFile(b.lower);
    const dvec3 upper = scene->scene->inFile(b.upper);
    for (int i = 0; i < 3; ++i) {
        bounds[i] = lower[i];
        bounds[3 + i] = upper[i];
    }
    return 0;
}

sheen_status sheen_session_new(const sheen_scene* scene, sheen_session** session,
                               sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(session, "session");
        *session = nullptr;
        checkGiven(scene, "scene");
        *session = new sheen_session(*scene);
    });
}

sheen_status sheen_session_keep_records(sheen_session* session, sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(session, "session");
        const std::lock_guard<std::mutex> lock(session->mutex);
        session->session.keepRecords();
    });
}

void sheen_session_free(sheen_session* session) { delete session; }

sheen_status sheen_render(sheen_session* session, const sheen_option* options, size_t count,
                          const sheen_listener* c_listener, sheen_frame** frame,
                          sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(frame, "frame");
        *frame = nullptr;
        checkGiven(session, "session");
        const auto request =
            requestOf(Call::kRender, spanOf(options, count), session->scene_options);
        const Listener listener = listenerOf(c_listener);
        const ListenerScope scope(listener);
        const std::lock_guard<std::mutex> lock(session->mutex);
        *frame = renderedFrame(*session, request->options).release();
    });
}

sheen_status sheen_irradiance(const sheen_scene* scene, const sheen_points* points,
                              const sheen_option* options, size_t count,
                              const sheen_listener* c_listener, float* direct, float* indirect,
                              sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(scene, "scene");
        checkGiven(points, "points");
        const auto request = requestOf(Call::kPoints, spanOf(options, count));
        const Listener listener = listenerOf(c_listener);
        const ListenerScope scope(listener);
        withThreads(request->options.threads,
                    [&] { askPoints(*scene->scene, *points, *request, direct, indirect); });
    });
}

void sheen_frame_free(sheen_frame* frame) { delete frame; }

int sheen_frame_width(const sheen_frame* frame) { return frame->frame.width(); }
int sheen_frame_height(const sheen_frame* frame) { return frame->frame.height(); }

size_t sheen_frame_layer_count(const sheen_frame* frame) { return frame->layers.size(); }

int sheen_frame_layer_at(const sheen_frame* frame, size_t index, sheen_layer* layer) {
    if (index >= frame->layers.size()) {
        return 1;
    }
    *layer = frame->layers[index];
    return 0;
}

sheen_status sheen_frame_layer(const sheen_frame* frame, const char* name, sheen_layer* layer,
                               sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(frame, "frame");
        checkGiven(name, "name");
        checkGiven(layer, "layer");
        std::string known;
        for (const sheen_layer& one : frame->layers) {
            if (std::strcmp(one.name, name) == 0) {
                *layer = one;
                return;
            }
            known += (known.empty() ? "" : ", ") + std::string(one.name);
        }
        throwUsage("layer {}: the frame has none of that name; it has {}{}", oneLine(name), known,
                   frame->all_layers ? "" : ", and more where rendered with layers all");
    });
}

const uint32_t* sheen_frame_primitive(const sheen_frame* frame) {
    return frame->frame.primitive.pixels.data();
}

const char* sheen_frame_json(const sheen_frame* frame) { return frame->json.c_str(); }

sheen_status sheen_frame_figure(const sheen_frame* frame, const char* name, double* value,
                                sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(frame, "frame");
        checkGiven(name, "name");
        checkGiven(value, "value");
        cli::Json::json_pointer where;
        bool found = false;
        try {
            where = cli::Json::json_pointer("/" + std::string(name));
            found = frame->figures.contains(where);
        } catch (const nlohmann::json::exception&) {
            found = false;  // no name that any figure has
        }
        if (!found || !(frame->figures[where].is_number() || frame->figures[where].is_null())) {
            throwUsage("figure {}: there is no number of that name; sheen_frame_json() lists them",
                       oneLine(name));
        }
        // Those that are not known are NaN there, or null.
        *value = frame->figures[where].is_null() ? std::numeric_limits<double>::quiet_NaN()
                                                 : frame->figures[where].get<double>();
    });
}

sheen_status sheen_frame_write(const sheen_frame* frame, const char* path,
                               const sheen_option* options, size_t count, sheen_error* error) {
    return guarded(error, [&] {
        checkGiven(frame, "frame");
        checkGiven(path, "path");
        const auto request = requestOf(Call::kWrite, spanOf(options, count));
        if (cli::imageKind(path) == cli::FileKind::kExr) {
            writeExr(path, frame->frame, frame->all_layers ? ExrLayers::kAll : ExrLayers::kBasic,
                     frame->notes, frame->mattes);
        } else {
            writePng(path, frame->frame, cli::parseExposure(request->options.exposure),
                     request->options.to_display);
        }
    });
}
