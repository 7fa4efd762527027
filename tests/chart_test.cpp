// The chart's sweep: fronts, predicted times, what is stored and what is measured again.
#include "chart/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "chart/child.h"
#include "chart/point_file.h"
#include "core/bounces.h"
#include "test_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

TEST(ParetoFront, emptyAndSingle) {
    EXPECT_TRUE(paretoFront({}).empty());
    const TimeAndError one[] = {{1, 1}};
    EXPECT_EQ(paretoFront(one), (std::vector<size_t>{0}));
}

TEST(ParetoFront, leavesBeatenPointsOut) {
    const TimeAndError points[] = {{4, 1}, {1, 4}, {3, 3}, {2, 2}, {5, 5}, {8, 0.5}};
    EXPECT_EQ(paretoFront(points), (std::vector<size_t>{1, 3, 0, 5}));
}

TEST(ParetoFront, ties) {
    // Equal time: the more right one; equal error: the faster one; equal points: all of them.
    const TimeAndError points[] = {{1, 5}, {1, 4}, {2, 4}, {3, 2}, {3, 2}, {4, 2}};
    EXPECT_EQ(paretoFront(points), (std::vector<size_t>{1, 3, 4}));
}

TEST(ParetoFront, ignoresWhatIsNotMeasured) {
    const TimeAndError points[] = {{1, 0},   {0, 1},  {1, INFINITY}, {NAN, 1},
                                   {1, NAN}, {-1, 1}, {2, 3}};
    EXPECT_EQ(paretoFront(points), (std::vector<size_t>{6}));
}

TEST(SecondsLeft, unknownUntilSomethingIsDone) {
    const SweepJob jobs[] = {{.scene = 0, .cost = 1}, {.scene = 1, .cost = 2}};
    EXPECT_LT(secondsLeft(jobs), 0);
    EXPECT_LT(secondsLeft({}), 0);
}

TEST(SecondsLeft, scalesCostsByTheSameScene) {
    const SweepJob jobs[] = {{.scene = 0, .cost = 1, .seconds = 2, .repeats = 3, .runs = 3},
                             {.scene = 0, .cost = 3, .repeats = 3},
                             {.scene = 1, .cost = 1, .seconds = 10, .repeats = 3, .runs = 3},
                             {.scene = 1, .cost = 2, .repeats = 3},
                             {.scene = 2, .cost = 1, .repeats = 3}};
    // 3 runs of 6 s and of 20 s; the last scene knows only the mean of the others, 6 s.
    EXPECT_NEAR(secondsLeft(jobs), 18 + 60 + 18, 1e-9);
}

TEST(SecondsLeft, scalesCostsByTheSameMethod) {
    const SweepJob jobs[] = {
        {.scene = 0, .method = 2, .cost = 800, .seconds = 400, .runs = 1},
        {.scene = 0, .method = 0, .cost = 1, .seconds = 4, .repeats = 5, .runs = 5},
        {.scene = 0, .method = 0, .cost = 2, .repeats = 5},
        {.scene = 0, .method = 1, .cost = 2, .repeats = 5},
        {.scene = 1, .method = 2, .cost = 800}};
    // The first is a reference. 5 runs of 8 s; of method 1 nothing is known but the mean of 0.5 and
    // 4 s a unit, 4.5 s; the other reference runs once.
    EXPECT_NEAR(secondsLeft(jobs), 5 * 8 + 5 * 4.5 + 800 * 2.25, 1e-9);
}

TEST(SecondsLeft, longPointsRunLessOften) {
    const SweepJob jobs[] = {{.scene = 0, .cost = 1, .seconds = 10, .repeats = 5, .runs = 5},
                             {.scene = 0, .cost = 4, .repeats = 5},  // 40 s: two runs make a minute
                             {.scene = 0, .cost = 10, .repeats = 5}};  // 100 s: one does
    EXPECT_NEAR(secondsLeft(jobs), 80 + 100, 1e-9);
    const SweepJob done[] = {{.scene = 0, .cost = 1, .seconds = 10, .repeats = 5, .runs = 5}};
    EXPECT_EQ(secondsLeft(done), 0);
}

TEST(SecondsLeft, pointsThatHaveRunLackTheirOtherRuns) {
    const SweepJob jobs[] = {
        {.scene = 0, .cost = 1, .seconds = 7, .spent = 14, .repeats = 5, .runs = 2},
        // Three of 25 s make a minute; of 10, 24 and 25 s, a second is missing.
        {.scene = 0, .cost = 1, .seconds = 25, .spent = 25, .repeats = 5, .runs = 1},
        {.scene = 0, .cost = 1, .seconds = 24, .spent = 59, .repeats = 5, .runs = 3},
        {.scene = 0, .cost = 1, .seconds = 80, .repeats = 5, .runs = 5}};
    EXPECT_NEAR(secondsLeft(jobs), 3 * 7 + 2 * 25 + 24, 1e-9);
}

TEST(Measurement, medianAndItsStages) {
    Measurement m;
    m.runs = {{5, {{"a", 5}}}};
    EXPECT_EQ(m.seconds(), 5);
    EXPECT_EQ(m.stages()[0].second, 5);
    m.runs.push_back({2, {{"a", 2}}});
    EXPECT_EQ(m.seconds(), 3.5);
    m.runs.push_back({3, {{"a", 3}}});
    EXPECT_EQ(m.seconds(), 3);
    EXPECT_EQ(m.stages()[0].second, 3);
    m.runs = {{1e308, {}}, {1e308, {}}};
    EXPECT_EQ(m.seconds(), 1e308);
}

TEST(Measurement, isCompleteWithItsRunsOrAfterAMinute) {
    Measurement m;
    EXPECT_FALSE(m.isComplete(1));
    m.runs = {{20, {}}, {30, {}}};
    EXPECT_TRUE(m.isComplete(2));
    EXPECT_FALSE(m.isComplete(3));
    m.runs.push_back({10, {}});
    EXPECT_TRUE(m.isComplete(9));
    EXPECT_EQ(runsLeft(20, 0, 9), 3);
    EXPECT_EQ(runsLeft(20, 0, 2), 2);
    EXPECT_EQ(runsLeft(20, 20, 8), 2);
    EXPECT_EQ(runsLeft(100, 0, 9), 1);
    EXPECT_EQ(runsLeft(0, 0, 9), 9);
    EXPECT_EQ(runsLeft(1, 3, 0), 0);
}

TEST(SweepMethods, namesDifferAndSettingsAreWhole) {
    std::set<std::string> names, labels;
    for (const SweepMethod& method : sweepMethods()) {
        EXPECT_TRUE(names.insert(method.name).second) << method.name;
        EXPECT_TRUE(labels.insert(method.label).second) << method.label;
        EXPECT_FALSE(method.settings.empty()) << method.name;
        for (const SweepSetting& setting : method.settings) {
            const std::vector<std::string> arguments = settingArguments(method, setting);
            EXPECT_EQ(arguments.size() % 2, 0u);  // options and their values
            EXPECT_EQ(arguments.front(), "--method");
            EXPECT_EQ(arguments[arguments.size() - 2], method.option);
            EXPECT_EQ(arguments.back(), setting.value);
            EXPECT_GT(setting.cost, 0);
        }
    }
}

TEST(SweepMethods, chosenByName) {
    const std::vector<SweepMethod> chosen =
        chooseMethods({"reference", "radiance", "reference"}, 1);
    ASSERT_EQ(chosen.size(), 2u);
    EXPECT_EQ(chosen[0].name, "radiance");
    EXPECT_EQ(chosen[1].name, "reference");
    EXPECT_THROW(chooseMethods({"radiance", "magic"}, 1), Error);
    EXPECT_THROW(chooseMethods({""}, 1), Error);
}

TEST(SweepMethods, thoseOfOneBounceAndOfMore) {
    const auto names = [](int bounces) {
        std::set<std::string> chosen;
        for (const SweepMethod& method : chooseMethods({}, bounces)) {
            chosen.insert(method.name);
        }
        return chosen;
    };
    const std::set<std::string> one = names(1), all = names(kAllBounces);
    EXPECT_EQ(names(2), all);
    for (const char* name : {"octree", "rasterised"}) {
        EXPECT_TRUE(one.contains(name) && !all.contains(name)) << name;
        EXPECT_THROW(chooseMethods({"radiance", name}, kAllBounces), Error);
    }
    EXPECT_TRUE(all.contains("photons") && !one.contains("photons"));
    EXPECT_THROW(chooseMethods({"photons"}, 1), Error);
    EXPECT_EQ(one.size() + all.size(), 2 * sweepMethods().size() - 3);
}

StoredPoint storedPoint() {
    StoredPoint point;
    point.key = {.scene = "abc",
                 .camera = 1,
                 .width = 640,
                 .height = 480,
                 .arguments = {"--method", "radiance", "--accuracy", "0.5"},
                 .gl = "egl"};
    point.measured.host = {.version = "1.2", .build = "f00", .cpu = "C \"P\" U", .threads = 7};
    point.measured.runs = {{0.1, {}}, {1.0 / 3.0, {{"write", 0.25}, {"load", 0.125}}}, {2, {}}};
    point.measured.cold_seconds = 2.5;
    point.measured.records = 12;
    point.measured.gl_renderer = "r\xc3\xa9nderer";
    return point;
}

TEST(PointFile, readsBack) {
    const StoredPoint point = storedPoint();
    const std::optional<StoredPoint> read = parsePoint(jsonText(point));
    ASSERT_TRUE(read);
    EXPECT_TRUE(sameImage(read->key, point.key));
    const Measurement &a = read->measured, &b = point.measured;
    EXPECT_EQ(a.host.version, b.host.version);
    EXPECT_EQ(a.host.build, b.host.build);
    EXPECT_EQ(a.host.cpu, b.host.cpu);
    EXPECT_EQ(a.host.threads, b.host.threads);
    ASSERT_EQ(a.runs.size(), b.runs.size());
    for (size_t i = 0; i < a.runs.size(); ++i) {
        EXPECT_EQ(a.runs[i].seconds, b.runs[i].seconds);
        EXPECT_EQ(a.runs[i].stages, b.runs[i].stages);
    }
    EXPECT_EQ(a.cold_seconds, b.cold_seconds);
    EXPECT_EQ(a.records, b.records);
    EXPECT_EQ(a.gl_renderer, b.gl_renderer);
}

TEST(PointFile, rejectsWhatIsNone) {
    const std::string good = jsonText(storedPoint());
    for (size_t length : {size_t{0}, size_t{1}, good.size() / 2, good.size() - 3}) {
        EXPECT_FALSE(parsePoint(good.substr(0, length))) << length;
    }
    for (const char* text : {"[]", "{}", "null", "7", "{\"image\": 3}", "\xff\xfe"}) {
        EXPECT_FALSE(parsePoint(text)) << text;
    }
    for (const char* runs :
         {"[]", "null", "[1.5]", "[{\"seconds\": 1}]", "[{\"seconds\": 0, \"stages\": {}}]",
          "[{\"seconds\": 1, \"stages\": {}}, {\"seconds\": -1, \"stages\": {}}]"}) {
        Json damaged = Json::parse(good);
        damaged["runs"] = Json::parse(runs);
        EXPECT_FALSE(parsePoint(damaged.dump())) << runs;
    }
    for (const char* part : {"\"runs\"", "\"seconds\"", "\"stages\"", "\"threads\"", "640"}) {
        std::string damaged = good;
        damaged.replace(damaged.find(part), std::string(part).size(), "\"\"");
        EXPECT_FALSE(parsePoint(damaged)) << part;
    }
    for (const char* number : {"1e300", "-1e300", "640.5", "4294967936", "18446744073709551615"}) {
        std::string damaged = good;
        damaged.replace(damaged.find("640"), 3, number);
        EXPECT_FALSE(parsePoint(damaged)) << number;
    }
}

TEST(PointFile, keysTellImagesApart) {
    const ImageKey key = storedPoint().key;
    std::vector<ImageKey> others(6, key);
    others[0].scene = "abd";
    others[1].camera = 0;
    others[2].width = 641;
    others[3].height = 481;
    others[4].arguments.back() = "0.6";
    others[5].gl = "";
    for (const ImageKey& other : others) {
        EXPECT_FALSE(sameImage(key, other));
        EXPECT_NE(shortHash(key), shortHash(other));
    }
}

TEST(PointFile, fileNamesArePlain) {
    EXPECT_EQ(fileNamePart("cornell_glossy-2"), "cornell_glossy-2");
    EXPECT_EQ(fileNamePart("../a b\xc3\xa9.glb"), "___a_b___glb");
    EXPECT_EQ(fileNamePart(std::string(300, 'x')).size(), 40u);
}

TEST(ContentHash, sceneDecides) {
    const Scene scene = loadScene(SHEEN_SCENES "/cornell_diffuse.glb");
    const std::string hash = contentHash(scene);
    EXPECT_EQ(hash.size(), 16u);
    EXPECT_EQ(hash, contentHash(loadScene(SHEEN_SCENES "/cornell_diffuse.glb")));
    const auto changed = [&scene, &hash](const std::function<void(Scene&)>& change) {
        Scene other = scene;
        change(other);
        return contentHash(other) != hash;
    };
    EXPECT_TRUE(changed([](Scene& s) { s.positions[0].x += 1e-3f; }));
    EXPECT_TRUE(changed([](Scene& s) { s.materials[0].params.roughness *= 0.5f; }));
    EXPECT_TRUE(changed([](Scene& s) { s.lights.at(0).intensity *= 2.0f; }));
    EXPECT_TRUE(changed([](Scene& s) { s.cameras[0].y_fov *= 1.1f; }));
    EXPECT_TRUE(changed([](Scene& s) { s.triangles.pop_back(); }));
    EXPECT_FALSE(changed([](Scene& s) { s.materials[0].name = "other"; }));
}

ExitCode codeOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.code();
    }
    return ExitCode::kDone;
}

TEST(Child, outputAndTime) {
    const ChildRun run =
        runChild({"/bin/sh", "-c", "echo $SHEEN_WORD; echo no >&2"}, {"SHEEN_WORD=a word"});
    EXPECT_EQ(run.out, "a word\n");
    EXPECT_GT(run.seconds, 0);
    // More than a pipe holds, on both of them.
    EXPECT_EQ(
        runChild({"/bin/sh", "-c", "head -c 300000 /dev/zero >&2; head -c 300000 /dev/zero"}, {})
            .out.size(),
        300000u);
}

TEST(Child, warningsAreHandedOn) {
    const char* script = "printf 'sheen: warning: a\\nother\\nsheen: warning: b c\\n' >&2";
    EXPECT_EQ(runChild({"/bin/sh", "-c", script}, {}).warnings,
              (std::vector<std::string>{"a", "b c"}));
}

TEST(Child, errorsKeepTheirCode) {
    const auto end = [](const char* script) {
        return codeOf([script] { runChild({"/bin/sh", "-c", script}, {}); });
    };
    EXPECT_EQ(end("echo 'sheen: error: bad scene' >&2; exit 3"), ExitCode::kInput);
    EXPECT_EQ(end("echo 'sheen: error: bad option' >&2; exit 2"), ExitCode::kUsage);
    EXPECT_EQ(end("exit 3"), ExitCode::kEnvironment);
    EXPECT_EQ(end("kill -KILL $$"), ExitCode::kEnvironment);
    EXPECT_EQ(codeOf([] { runChild({"/none/at/all"}, {}); }), ExitCode::kEnvironment);
}

SweepMethod tracer(const std::vector<SweepSetting>& settings) {
    return {"reference", "p", {"--method", "reference"}, "--spp", settings};
}

class SweepTest : public testing::Test {
  protected:
    void SetUp() override {
        params_.scenes = {SHEEN_SCENES "/cornell_diffuse.glb"};
        params_.folder = (folder_ / "chart").string();
        params_.program = SHEEN_PROGRAM;
        params_.version = "test";
        params_.width = params_.height = 16;
        params_.reference_spp = 16;
        params_.repeats = 1;
        params_.methods = {tracer({{"16", 1}, {"32", 2}, {"48", 3}})};
    }

    // Names of the images that a chart renders anew.
    std::set<std::string> rendered(Chart* chart = nullptr) {
        const auto times = [this] {
            std::map<std::string, fs::file_time_type> times;
            for (const auto& entry : fs::recursive_directory_iterator(params_.folder)) {
                if (entry.path().extension() == ".exr") {
                    times[entry.path().filename().string()] = entry.last_write_time();
                }
            }
            return times;
        };
        fs::create_directories(params_.folder);
        const auto before = times();
        const Chart made = measureChart(params_);
        std::set<std::string> names;
        for (const auto& [name, time] : times()) {
            if (before.count(name) == 0 || before.at(name) != time) {
                names.insert(name);
            }
        }
        if (chart != nullptr) {
            *chart = made;
        }
        return names;
    }

    TestFolder own_;
    fs::path folder_ = own_.path();
    ChartParams params_;
};

TEST_F(SweepTest, measuresEveryPoint) {
    params_.methods = {{"coarse", "c", {"--method", "radiance"}, "--gather-size", {{"8", 1}}},
                       tracer({{"16", 1}, {"32", 2}})};
    Chart chart;
    EXPECT_EQ(rendered(&chart).size(), 4u);  // a reference and three points
    ASSERT_EQ(chart.scenes.size(), 1u);
    const ChartScene& scene = chart.scenes[0];
    EXPECT_EQ(scene.name, "cornell_diffuse");
    EXPECT_GT(scene.noise_rel_rmse, 0);
    EXPECT_EQ(scene.reference_png.substr(1, 3), "PNG");
    ASSERT_EQ(scene.points.size(), 3u);
    for (const ChartPoint& point : scene.points) {
        double stages = 0;
        for (const auto& [stage, seconds] : point.measured.stages()) {
            stages += seconds;
        }
        EXPECT_NEAR(stages, point.measured.seconds(), 1e-9);
        EXPECT_EQ(point.measured.runs.size(), 1u);
        EXPECT_GT(point.errors.compared, 0);
        EXPECT_EQ(point.image_png.substr(1, 3), "PNG");
        EXPECT_EQ(point.heatmap_png.substr(1, 3), "PNG");
    }
    EXPECT_GT(scene.points[0].measured.cold_seconds, 0);
    EXPECT_GT(scene.points[0].measured.records, 0);
    EXPECT_LT(scene.points[2].measured.cold_seconds, 0);
    EXPECT_FALSE(fs::exists(fs::path(params_.folder) / "shader_cache"));
    // The judge's noise is not the path tracer's: equal samples would agree exactly.
    EXPECT_GT(scene.points[1].errors.median, 0);
}

TEST_F(SweepTest, continuesWhereItWas) {
    Chart first, second;
    ASSERT_EQ(rendered(&first).size(), 4u);
    EXPECT_EQ(rendered(&second).size(), 0u);
    EXPECT_EQ(first.scenes[0].points[2].measured.seconds(),
              second.scenes[0].points[2].measured.seconds());
    EXPECT_EQ(first.scenes[0].points[2].errors.rel_rmse,
              second.scenes[0].points[2].errors.rel_rmse);

    // A point that is gone, one whose figures are damaged, one whose image is, and a reference.
    const fs::path root = params_.folder;
    const auto& points = first.scenes[0].points;
    fs::remove((root / points[0].file).replace_extension(".json"));
    std::ofstream((root / points[1].file).replace_extension(".json")) << "{\"image\": ";
    std::ofstream(root / points[2].file) << "no image";
    std::ofstream((root / first.scenes[0].reference_file).replace_extension(".json")) << "{}";
    testing::internal::CaptureStderr();
    EXPECT_EQ(rendered().size(), 4u);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("tracing this reference again"), std::string::npos) << said;
    EXPECT_EQ(rendered().size(), 0u);
}

TEST_F(SweepTest, pointsLackingRunsGetThoseThatTheyLack) {
    Chart first, second;
    ASSERT_EQ(rendered(&first).size(), 4u);
    params_.repeats = 3;
    testing::internal::CaptureStderr();
    EXPECT_EQ(rendered(&second).size(), 3u);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(said.substr(0, said.find('\n')), "3 of 9 runs were measured before");
    for (const char* count : {"\n[4/9] ", "\n[9/9] "}) {
        EXPECT_NE(said.find(count), std::string::npos) << said;
    }
    for (size_t i = 0; i < 3; ++i) {
        const std::vector<TimedRun>& runs = second.scenes[0].points[i].measured.runs;
        ASSERT_EQ(runs.size(), 3u);
        EXPECT_EQ(runs[0].seconds, first.scenes[0].points[i].measured.runs[0].seconds);
        EXPECT_EQ(second.scenes[0].points[i].measured.cold_seconds,
                  first.scenes[0].points[i].measured.cold_seconds);
    }
    params_.repeats = 2;  // enough, and none is thrown away
    EXPECT_EQ(rendered(&second).size(), 0u);
    EXPECT_EQ(second.scenes[0].points[0].measured.runs.size(), 3u);
}

// A point's runs lie as far apart as they can.
TEST_F(SweepTest, pointsOfASceneTakeTurns) {
    params_.repeats = 2;
    params_.methods = {tracer({{"16", 1}, {"32", 2}})};
    testing::internal::CaptureStderr();
    measureChart(params_);
    std::istringstream said(testing::internal::GetCapturedStderr());
    std::vector<std::string> runs;  // up to the time, which differs
    for (std::string line; std::getline(said, line);) {
        if (line[0] == '[' && line.find("spp") != std::string::npos) {
            runs.push_back(line.substr(0, line.find(':')));
        }
    }
    EXPECT_EQ(runs, (std::vector<std::string>{
                        "[2/5] cornell_diffuse, p, spp 16", "[3/5] cornell_diffuse, p, spp 32",
                        "[4/5] cornell_diffuse, p, spp 16", "[5/5] cornell_diffuse, p, spp 32"}));
}

TEST_F(SweepTest, measuresAgainWhatNoLongerFits) {
    ASSERT_EQ(rendered().size(), 4u);
    params_.version = "newer";
    params_.any_build = true;
    params_.repeats = 2;  // every point lacks a run, and the runs of one build make a point
    Chart chart;
    EXPECT_EQ(rendered(&chart).size(), 3u);
    EXPECT_EQ(chart.scenes[0].points[1].measured.host.version, "newer");
    EXPECT_EQ(chart.scenes[0].points[1].measured.runs.size(), 2u);
    params_.reference_spp = 32;  // times stay, errors are judged anew
    EXPECT_EQ(rendered().size(), 1u);
    params_.version = "newest";
    EXPECT_EQ(rendered().size(), 0u);
    params_.any_build = false;
    EXPECT_EQ(rendered().size(), 3u);
}

TEST_F(SweepTest, scenesOfOneStemGoByTheirWholeNames) {
    fs::create_directories(folder_ / "a");
    const fs::path copy = folder_ / "a" / "cornell_diffuse.glb";
    fs::copy(SHEEN_SCENES "/cornell_glossy.glb", copy);
    params_.scenes.push_back(copy.string());
    params_.methods = {tracer({{"16", 1}})};
    Chart chart;
    EXPECT_EQ(rendered(&chart).size(), 4u);
    EXPECT_EQ(chart.scenes[0].name, params_.scenes[0]);
    EXPECT_EQ(chart.scenes[1].name, params_.scenes[1]);
    params_.scenes.push_back((folder_ / "a" / ".." / "a" / "cornell_diffuse.glb").string());
    EXPECT_EQ(codeOf([this] { measureChart(params_); }), ExitCode::kUsage);
}

}  // namespace
}  // namespace sheen
