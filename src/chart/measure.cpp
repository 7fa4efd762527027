#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "chart/chart.h"
#include "chart/chart_scenes.h"
#include "chart/child.h"
#include "chart/point_file.h"
#include "core/bounces.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/atomic_file.h"
#include "image/exr.h"
#include "render/render.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

// The path tracer's points use seed 0: the judge's noise must be independent of theirs.
constexpr uint32_t kReferenceSeed = 1;

void makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
        throwEnvironment("{}: cannot make this folder: {}", folder.string(), error.message());
    }
}

void writeText(const fs::path& path, const std::string& text) {
    AtomicFile file(path.string());
    file.write(text);
    file.commit();
}

std::string timeText(double seconds) {
    if (seconds < 90) {
        return fmt::format("{:.0f} s", seconds);
    }
    const int minutes = static_cast<int>(std::lround(seconds / 60));
    return minutes < 90 ? fmt::format("{} min", minutes)
                        : fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

bool isReadable(const fs::path& exr, int width, int height, const std::string& layer) {
    try {
        const LoadedExr image = readExr(exr.string());
        colorLayer(image, layer);
        return image.width == width && image.height == height && !image.primitive.empty();
    } catch (const Error&) {
        return false;
    }
}

// One chart in the making.
class Sweep {
  public:
    explicit Sweep(const ChartParams& params)
        : params_(params),
          root_(params.folder),
          points_(root_ / "points"),
          references_(root_ / "references"),
          shader_cache_(root_ / params.shader_cache),
          scenes_(nameScenes(params.scenes)) {}

    Chart run() {
        // Everything that can be wrong is looked at before the long work.
        for (ChartScene& chart_scene : scenes_) {
            const Scene scene = loadScene(chart_scene.file, loadParams());
            checkNotOverwritten(scene.files);
            checkSky(scene, chart_scene);
            identities_.push_back(identify(scene, params_.camera, chart_scene));
        }
        for (const fs::path& folder : {root_, points_, references_}) {
            makeFolder(folder);
            checkWritable((folder / "probe").string());
        }
        for (const char* file : kReportFiles) {
            checkWritable((root_ / file).string());
        }
        host_ = hostOf(params_);
        std::vector<Reference> references = listReferences();
        std::vector<Task> tasks = listTasks();
        plan(references, tasks);
        for (Reference& reference : references) {
            if (!reference.stored) {
                renderReference(reference);
            }
            ChartScene& scene = scenes_[reference.scene];
            scene.reference_file = fs::relative(reference.file.string() + ".exr", root_).string();
            scene.reference_seconds = reference.stored->measured.seconds();
            judgeScene(params_.folder, scene);  // a black reference is found here
        }
        measurePoints(tasks);
        for (ChartScene& scene : scenes_) {
            judgeScene(params_.folder, scene);
        }
        return {.host = host_,
                .width = params_.width,
                .height = params_.height,
                .bounces = params_.bounces,
                .reference_spp = params_.reference_spp,
                .repeats = params_.repeats,
                .methods = params_.methods,
                .scenes = std::move(scenes_)};
    }

  private:
    void tell(const std::string& text) const {
        if (!params_.quiet) {
            say(text);
        }
    }

    LoadParams loadParams() const {
        return {.camera = params_.camera, .environment = params_.environment};
    }

    // Methods of one scene must see one light.
    void checkSky(const Scene& scene, const ChartScene& chart_scene) const {
        const bool rasterised =
            std::any_of(params_.methods.begin(), params_.methods.end(),
                        [](const SweepMethod& method) { return method.name == "rasterised"; });
        if (rasterised && !scene.environment.empty()) {
            throwUsage(
                "{}: lit by a sky, which rasterised records do not see; leave rasterised out by "
                "--methods",
                chart_scene.file);
        }
    }

    void checkNotOverwritten(const std::vector<std::string>& inputs) const {
        for (const char* report : kReportFiles) {
            for (const std::string& input : inputs) {
                if (isSameFile((root_ / report).string(), input)) {
                    throwUsage("--output {}: {} in it would overwrite {}; choose another folder",
                               params_.folder, report, input);
                }
            }
        }
    }

    // What a scene's points are judged by, to be rendered or already stored.
    struct Reference {
        size_t scene = 0;
        RenderParams params;
        ImageKey key;
        fs::path file;   ///< without its extension
        size_t job = 0;  ///< index in jobs_, where it is not stored
        std::optional<StoredPoint> stored;
    };

    // A point to be measured, or measured in whole or in part.
    struct Task {
        size_t scene = 0;
        const SweepMethod* method = nullptr;
        const SweepSetting* setting = nullptr;
        ImageKey key;
        fs::path file;   ///< without its extension
        size_t job = 0;  ///< index in jobs_
        double cold_seconds = -1;
        std::optional<StoredPoint> stored;  ///< with the runs so far
    };

    bool isDone(const Task& task) const {
        return task.stored && task.stored->measured.isComplete(params_.repeats);
    }

    std::string bouncesText() const {
        return params_.bounces == kAllBounces ? "all" : fmt::format("{}", params_.bounces);
    }

    // One bounce, which is the default, is not said: what was stored before stays.
    ImageKey keyOf(size_t scene, std::vector<std::string> arguments) const {
        if (params_.bounces != 1) {
            arguments.insert(arguments.end(), {"--bounces", bouncesText()});
        }
        return {.scene = identities_[scene].hash,
                .camera = identities_[scene].camera,
                .width = params_.width,
                .height = params_.height,
                .arguments = arguments,
                .gl = params_.gl};
    }

    std::string filePart(size_t scene) const {
        return fileNamePart(fs::path(scenes_[scene].file).stem().string());
    }

    // One a scene. The file's name tells what it shows.
    std::vector<Reference> listReferences() const {
        std::vector<Reference> references;
        for (size_t s = 0; s < scenes_.size(); ++s) {
            Reference reference = {
                .scene = s, .params = {}, .key = {}, .file = {}, .job = 0, .stored = {}};
            RenderParams& params = reference.params;
            params.method = Method::kReference;
            params.width = params_.width;
            params.height = params_.height;
            params.camera = params_.camera;
            params.bounces = params_.bounces;
            params.caustics = 0;
            params.spp = params_.reference_spp;
            params.seed = kReferenceSeed;
            reference.key = keyOf(s, {"reference", fmt::format("{}", params.spp)});
            reference.key.gl.clear();  // traced without it
            reference.file =
                references_ / fmt::format("{}.{}x{}.{}spp.{}", filePart(s), params.width,
                                          params.height, params.spp, shortHash(reference.key));
            const std::string exr = reference.file.string() + ".exr";
            const std::optional<std::string> text = readText(reference.file.string() + ".json");
            reference.stored = text ? parsePoint(*text) : std::nullopt;
            const bool readable =
                reference.stored && isReadable(exr, params.width, params.height, "variance");
            if (text && !readable) {
                warn(fmt::format(
                    "{}.json: damaged, or of another version; tracing this reference again",
                    reference.file.string()));
            }
            if (!readable || !sameImage(reference.stored->key, reference.key)) {
                reference.stored.reset();
            }
            references.push_back(std::move(reference));
        }
        return references;
    }

    void renderReference(Reference& reference) {
        const ChartScene& scene = scenes_[reference.scene];
        const std::string what =
            fmt::format("{}, reference, {} paths a pixel", scene.name, reference.params.spp);
        tell(fmt::format("{} ...\n", what));
        const Timer timer;
        const RenderResult result =
            renderFrame(loadScene(scene.file, loadParams()), reference.params);
        writeExr(reference.file.string() + ".exr", result.frame, ExrLayers::kBasic);
        StoredPoint point = {.key = reference.key, .measured = {}};
        point.measured.host = host_;
        point.measured.runs = {{.seconds = timer.seconds(), .stages = {}}};
        writeText(reference.file.string() + ".json", jsonText(point));
        reference.stored = std::move(point);
        count(reference.job, *reference.stored, true, what);
    }

    // Lists as jobs all points and the references that are to be rendered. (Those that are stored
    // may be of another machine, whose times say nothing.)
    void plan(std::vector<Reference>& references, std::vector<Task>& tasks) {
        const size_t reference_method = params_.methods.size();
        for (Reference& reference : references) {
            if (!reference.stored) {
                reference.job = jobs_.size();
                jobs_.push_back({.scene = reference.scene,
                                 .method = reference_method,
                                 .cost = kPathCost * params_.reference_spp});
            }
        }
        int runs = 0;
        int all = 0;
        for (Task& task : tasks) {
            task.job = jobs_.size();
            jobs_.push_back({.scene = task.scene,
                             .method = static_cast<size_t>(task.method - params_.methods.data()),
                             .cost = task.setting->cost,
                             .repeats = params_.repeats});
            if (task.stored) {
                update(task.job, *task.stored, isDone(task));
            }
            runs += jobs_.back().runs;
            all += jobs_.back().repeats;
        }
        if (runs > 0) {
            tell(fmt::format("{} of {} runs were measured before\n", runs, all));
        }
    }

    void update(size_t job, const StoredPoint& point, bool done) {
        jobs_[job].seconds = point.measured.seconds();
        jobs_[job].spent = point.measured.spent();
        jobs_[job].runs = done ? jobs_[job].repeats : static_cast<int>(point.measured.runs.size());
    }

    // Says that a run has ended, and how long the others will take. What needs no more runs counts
    // as if it had had all.
    void count(size_t job, const StoredPoint& point, bool done, const std::string& what) {
        update(job, point, done);
        int runs = 0;
        int all = 0;
        for (const SweepJob& other : jobs_) {
            runs += other.runs;
            all += other.repeats;
        }
        tell(fmt::format("[{}/{}] {}: {:.2f} s{}\n", runs, all, what,
                         point.measured.runs.back().seconds,
                         runs == all ? "" : "; about " + timeText(secondsLeft(jobs_)) + " left"));
    }

    std::vector<Task> listTasks() const {
        std::vector<Task> tasks;
        for (size_t s = 0; s < scenes_.size(); ++s) {
            for (const SweepMethod& method : params_.methods) {
                for (const SweepSetting& setting : method.settings) {
                    if (!params_.only_setting.empty() && setting.value != params_.only_setting) {
                        continue;
                    }
                    Task task = {.scene = s,
                                 .method = &method,
                                 .setting = &setting,
                                 .key = keyOf(s, settingArguments(method, setting)),
                                 .file = {},
                                 .job = 0,
                                 .cold_seconds = -1,
                                 .stored = {}};
                    task.file = points_ / fmt::format("{}.{}.{}", filePart(s), method.name,
                                                      shortHash(task.key));
                    task.stored = findStored(task);
                    tasks.push_back(std::move(task));
                }
            }
        }
        return tasks;
    }

    std::optional<StoredPoint> findStored(const Task& task) const {
        const std::string json = task.file.string() + ".json";
        const std::optional<std::string> text = readText(json);
        if (!text) {
            return std::nullopt;
        }
        std::optional<StoredPoint> point = parsePoint(*text);
        if (!point ||
            !isReadable(task.file.string() + ".exr", params_.width, params_.height, "indirect")) {
            warn(fmt::format("{}: damaged, or of another version; measuring this point again",
                             json));
            return std::nullopt;
        }
        const ChartHost& host = point->measured.host;
        const bool same_machine = host.cpu == host_.cpu && host.threads == host_.threads;
        // What another build began cannot be continued.
        const bool same_build = (host.version == host_.version && host.build == host_.build) ||
                                (params_.any_build && point->measured.isComplete(params_.repeats));
        const bool fits = same_build && same_machine && sameImage(point->key, task.key);
        return fits ? std::move(point) : std::nullopt;
    }

    // A scene's points in turns, a run each, until all have theirs: where a machine's speed drifts,
    // it drifts for all alike.
    void measurePoints(std::vector<Task>& tasks) {
        for (auto first = tasks.begin(); first != tasks.end();) {
            const auto end = std::find_if(
                first, tasks.end(), [&](const Task& task) { return task.scene != first->scene; });
            const std::span<Task> of_scene(first, end);
            warmUp(of_scene);
            const auto is_done = [this](const Task& task) { return isDone(task); };
            while (!std::all_of(of_scene.begin(), of_scene.end(), is_done)) {
                for (Task& task : of_scene) {
                    if (!isDone(task)) {
                        measure(task);
                    }
                }
            }
            first = end;
        }
        for (const Task& task : tasks) {
            scenes_[task.scene].points.push_back(
                {.method = task.method->name,
                 .setting = settingLabel(*task.method, *task.setting),
                 .file = fs::relative(task.file.string() + ".exr", root_).string(),
                 .measured = task.stored->measured,
                 .errors = {},
                 .image_png = {},
                 .heatmap_png = {}});
        }
        std::error_code ignored;
        fs::remove_all(shader_cache_, ignored);
    }

    // A cache for each method, whose cold run empties it and no other's. The user's is left alone.
    fs::path shaderCache(const SweepMethod& method) const {
        return shader_cache_ / fileNamePart(method.name);
    }

    ChildRun runPoint(const Task& task, const SweepSetting& setting,
                      const std::string& output) const {
        return runChild(
            commandOf(task, setting, output),
            {"MESA_SHADER_CACHE_DIR=" + fs::absolute(shaderCache(*task.method)).string()});
    }

    // Runs each method that lacks runs once with an empty cache of shaders: its first setting,
    // which is itself a figure of that setting's point.
    void warmUp(std::span<Task> tasks) const {
        const SweepMethod* warmed = nullptr;
        for (const Task& task : tasks) {
            if (isDone(task) || task.method == warmed) {
                continue;
            }
            warmed = task.method;
            const fs::path cache = shaderCache(*task.method);
            std::error_code ignored;
            fs::remove_all(cache, ignored);
            makeFolder(cache);
            const SweepSetting& first = task.method->settings.front();
            const fs::path image = cache / "cold.exr";
            const double seconds = runPoint(task, first, image.string()).seconds;
            fs::remove(image, ignored);
            tell(fmt::format("{}, {}, cold: {:.2f} s\n", scenes_[task.scene].name,
                             task.method->label, seconds));
            for (Task& other : tasks) {
                if (other.method == warmed && other.setting == &first) {
                    other.cold_seconds = seconds;
                }
            }
        }
    }

    std::vector<std::string> commandOf(const Task& task, const SweepSetting& setting,
                                       const std::string& output) const {
        std::vector<std::string> command = {params_.program, "render", scenes_[task.scene].file};
        for (const std::string& argument : settingArguments(*task.method, setting)) {
            command.push_back(argument);
        }
        for (const std::string& argument :
             {std::string("--size"), fmt::format("{}x{}", params_.width, params_.height),
              // As references are.
              std::string("--aa"), std::string("1"), std::string("--bounces"), bouncesText(),
              // Some methods cannot tell them from other indirect light.
              std::string("--caustics"), std::string("none"), std::string("-o"), output,
              std::string("--json"), std::string("-")}) {
            command.push_back(argument);
        }
        if (!params_.gl.empty()) {
            command.insert(command.end(), {"--gl", params_.gl});
        }
        if (!params_.camera.empty()) {
            command.insert(command.end(), {"--camera", params_.camera});
        }
        const EnvironmentParams& sky = params_.environment;
        if (!sky.source.empty()) {
            command.insert(command.end(),
                           {"--environment", sky.source, "--environment-rotation",
                            fmt::format("{}", sky.rotation), "--environment-strength",
                            fmt::format("{}", sky.strength)});
        }
        if (sky.transparent) {
            command.push_back("--transparent");
        }
        return command;
    }

    // Runs a point once more and stores what is known of it.
    void measure(Task& task) {
        const std::string label =
            fmt::format("{}, {}, {}", scenes_[task.scene].name, task.method->label,
                        settingLabel(*task.method, *task.setting));
        const std::string json = task.file.string() + ".json";
        if (!task.stored) {
            std::error_code ignored;
            fs::remove(json, ignored);  // what it says is not of this image
        }
        const ChildRun run = runPoint(task, *task.setting, task.file.string() + ".exr");
        if (!task.stored) {
            task.stored = {.key = task.key, .measured = {}};
            task.stored->measured.host = host_;
            task.stored->measured.cold_seconds = task.cold_seconds;
            for (const std::string& warning : run.warnings) {  // all runs say the same
                warn(fmt::format("{}: {}", label, warning));
            }
        }
        addRun(task.stored->measured, run.seconds, run.out);
        writeText(json, jsonText(*task.stored));
        count(task.job, *task.stored, isDone(task), label);
    }

    const ChartParams& params_;
    fs::path root_, points_, references_, shader_cache_;
    std::vector<ChartScene> scenes_;
    std::vector<SceneIdentity> identities_;  ///< [scene]
    std::vector<SweepJob> jobs_;             ///< references, then points
    ChartHost host_;
};

}  // namespace

ChartHost hostOf(const ChartParams& params) {
    return {.version = params.version,
            .build = fileHash(params.program),
            .cpu = processorName(),
            .threads = threadCount()};
}

Chart measureChart(const ChartParams& params) {
    SHEEN_CHECK(params.repeats > 0 && !params.scenes.empty() && !params.methods.empty());
    return Sweep(params).run();
}

}  // namespace sheen
