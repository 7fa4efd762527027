// A chart's report: every figure reads back from CSV and JSON, and no name breaks the page.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "chart/report.h"
#include "chart_test_sample.h"
#include "test_folder.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

// RFC 4180: rows of cells.
std::vector<std::vector<std::string>> parseCsv(const std::string& text) {
    std::vector<std::vector<std::string>> rows(1);
    std::string cell;
    bool quoted = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
                cell += text[++i];
            } else if (c == '"') {
                quoted = false;
            } else {
                cell += c;
            }
        } else if (c == '"') {
            quoted = true;
        } else if (c == ',' || c == '\n') {
            rows.back().push_back(cell);
            cell.clear();
            if (c == '\n') {
                rows.emplace_back();
            }
        } else if (c != '\r') {
            cell += c;
        }
    }
    rows.pop_back();
    return rows;
}

TEST(ChartCsv, readsBack) {
    const Chart chart = sampleChart();
    const auto rows = parseCsv(chartCsv(chart));
    const std::vector<std::string>& header = rows[0];
    const auto column = [&header](const std::string& name) {
        const auto found = std::find(header.begin(), header.end(), name);
        EXPECT_NE(found, header.end()) << name;
        return static_cast<size_t>(found - header.begin());
    };
    size_t r = 1;
    for (const ChartScene& scene : chart.scenes) {
        for (const ChartPoint& point : scene.points) {
            const std::vector<std::string>& row = rows.at(r++);
            ASSERT_EQ(row.size(), header.size());
            const auto number = [&](const char* name) { return std::stod(row[column(name)]); };
            EXPECT_EQ(row[column("scene")], scene.name);
            EXPECT_EQ(row[column("method")], point.method);
            EXPECT_EQ(row[column("setting")], point.setting);
            EXPECT_EQ(number("seconds"), point.measured.seconds());
            EXPECT_EQ(number("bias"), point.errors.bias);
            EXPECT_EQ(number("tile_max"), point.errors.tile_max);
            EXPECT_EQ(number("seconds_gather"), point.measured.stages()[1].second);
            EXPECT_EQ(row[column("judged")], point.errors.judged ? "yes" : "no");
            EXPECT_EQ(row[column("cold_seconds")].empty(), point.measured.cold_seconds < 0);
            EXPECT_EQ(row[column("rel_rmse")].empty(), !std::isfinite(point.errors.rel_rmse));
        }
    }
    EXPECT_EQ(r, rows.size());
}

TEST(ChartJson, readsBack) {
    const Chart chart = sampleChart();
    const Json json = Json::parse(chartJson(chart));
    EXPECT_EQ(json["size"], Json::array({8, 8}));
    EXPECT_EQ(json["reference_spp"], 64);
    ASSERT_EQ(json["scenes"].size(), 2u);
    for (size_t s = 0; s < 2; ++s) {
        const ChartScene& scene = chart.scenes[s];
        ASSERT_EQ(json["scenes"][s]["points"].size(), scene.points.size());
        for (size_t p = 0; p < scene.points.size(); ++p) {
            const ChartPoint& point = scene.points[p];
            const Json& found = json["scenes"][s]["points"][p];
            EXPECT_EQ(found["seconds"], point.measured.seconds());
            ASSERT_EQ(found["runs"].size(), 3u);
            EXPECT_EQ(found["runs"][2], point.measured.runs[2].seconds);
            EXPECT_EQ(found["errors"]["median"], point.errors.median);
            EXPECT_EQ(found["errors"]["judged"], point.errors.judged);
            EXPECT_EQ(found["stages"]["gather"], point.measured.stages()[1].second);
            EXPECT_EQ(found["cold_seconds"].is_null(), point.measured.cold_seconds < 0);
        }
    }
    const Json& hostile = json["scenes"][1];
    EXPECT_TRUE(hostile["points"][2]["errors"]["rel_rmse"].is_null());
    EXPECT_EQ(hostile["name"].get<std::string>().substr(0, 9), "</script>");
    // Of the first scene each method's points 1 and 2 are best, and the first method is.
    EXPECT_EQ(json["scenes"][0]["pareto"]["rel_rmse"], Json::array({1, 2}));
    // Not judged, of no error and of infinite error: none of them is on a front.
    for (const Json& index : hostile["pareto"]["rel_rmse"]) {
        EXPECT_GT(index.get<int>(), 2);
    }
}

TEST(ChartJson, holdsSequencesAndBakesThatWereMeasured) {
    Chart chart = sampleChart();
    const Json json = Json::parse(chartJson(chart));
    const Json& sequences = json["sequences"];
    EXPECT_EQ(sequences["measured"], "By hand.");
    ASSERT_EQ(sequences["points"].size(), 3u);
    EXPECT_EQ(sequences["points"][1], Json({{"scene", "kite"},
                                            {"method", "temporal"},
                                            {"error", 0.02},
                                            {"flicker", 0.0005},
                                            {"resolution", 0.001},
                                            {"seconds", 1.0}}));
    EXPECT_EQ(json["bakes"]["measured"], "Baked by hand.");
    ASSERT_EQ(json["bakes"]["points"].size(), 4u);
    EXPECT_EQ(json["bakes"]["points"][2], Json({{"scene", "cornell"},
                                                {"method", "paths"},
                                                {"setting", "spp 16"},
                                                {"error", 0.08},
                                                {"judged", false},
                                                {"share", 0.0},
                                                {"seconds", 2.0}}));
    chart.sequences.reset();
    chart.bakes.reset();
    EXPECT_TRUE(Json::parse(chartJson(chart))["sequences"].is_null());
    EXPECT_TRUE(Json::parse(chartJson(chart))["bakes"].is_null());
}

TEST(Benches, readBack) {
    const TestFolder folder;
    const std::string path = folder.path() / "bench.json";
    const Json json = Json::parse(chartJson(sampleChart()));
    std::ofstream(path) << json["sequences"];
    const Sequences sequences = readSequences(path);
    EXPECT_EQ(sequences.measured, "By hand.");
    ASSERT_EQ(sequences.points.size(), 3u);
    EXPECT_EQ(sequences.points[0].method, "anew");
    EXPECT_EQ(sequences.points[0].seconds, 4.0);
    EXPECT_EQ(sequences.points[1].flicker, 0.0005);
    std::ofstream(path) << json["bakes"];
    const Bakes bakes = readBakes(path);
    ASSERT_EQ(bakes.points.size(), 4u);
    EXPECT_EQ(bakes.points[1].setting, "accuracy 0.4");
    EXPECT_EQ(bakes.points[1].share, 0.13);
    EXPECT_FALSE(bakes.points[2].judged);
}

TEST(Benches, ofBrokenFilesAreErrors) {
    const TestFolder folder;
    const std::string path = folder.path() / "bench.json";
    const auto expect_refused = [&](const auto& read, const std::string& text) {
        try {
            read(path);
            FAIL() << text;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::kInput) << text;
            EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << text;
        }
    };
    expect_refused(readSequences, "no file");
    expect_refused(readBakes, "no file");
    for (const char* text :
         {"", "{", "[]", "{}", R"({"measured": "", "points": [{"scene": "a"}]})",
          R"({"measured": "", "points": [{"scene": "a", "method": "b", "error": -1,
              "flicker": 0, "resolution": 0, "seconds": 1,
              "setting": "", "judged": true, "share": 0}]})"}) {
        std::ofstream(path) << text;
        expect_refused(readSequences, text);
        expect_refused(readBakes, text);
    }
}

TEST(ChartHtml, namesCannotBreakThePage) {
    const std::string html = chartHtml(sampleChart());
    const std::string open = "<script id=\"data\" type=\"application/json\">";
    const size_t begin = html.find(open) + open.size();
    ASSERT_NE(html.find(open), std::string::npos);
    const std::string data = html.substr(begin, html.find("</script>", begin) - begin);
    EXPECT_EQ(data.find('<'), std::string::npos);
    const Json json = Json::parse(data);
    const std::string name = json["scenes"][1]["name"];
    EXPECT_EQ(name.substr(0, name.size() - 3), std::string(kHostileName, name.size() - 3));
    EXPECT_EQ(name.substr(name.size() - 3), "\xef\xbf\xbd");  // U+FFFD for what is not UTF-8
    EXPECT_EQ(json["scenes"][0]["points"][0]["image"].get<std::string>().rfind(
                  "data:image/png;base64,iVBORw0KGgo", 0),
              0u);
}

TEST(ChartHtml, isComplete) {
    const std::string html = chartHtml(sampleChart());
    for (const char* mark : {"{{style}}", "{{library}}", "{{program}}"}) {
        EXPECT_EQ(html.find(mark), std::string::npos) << mark;
    }
    EXPECT_NE(html.find("Chart.js v3"), std::string::npos) << "the library's licence stays with it";
    for (const char* reference : {"src=\"http", "href=", "@import", "url("}) {
        EXPECT_EQ(html.find(reference), std::string::npos) << reference;
    }
}

TEST(Base64, vectorsOfRfc4648) {
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("foob"), "Zm9vYg==");
    EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64(std::string("\xff\xfe\x00", 3)), "//4A");
}

}  // namespace
}  // namespace sheen
