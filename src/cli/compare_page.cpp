#include "cli/compare_page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "chart/report.h"
#include "cli/compare_pair.h"
#include "image/atomic_file.h"
#include "image/png.h"

namespace sheen::cli {
namespace {

namespace fs = std::filesystem;

// Pictures as PNG files' bytes; none of a pair that could not be compared.
struct Row {
    std::string name;
    std::string reason;  // why it is not judged; empty: it is
    Comparison comparison;
    std::string image, reference, heatmap;
};

std::set<std::string> imagesIn(const std::string& folder) {
    std::error_code error;
    fs::directory_iterator files(folder, error);
    if (error) {
        throwInput("{}: cannot be listed: {}; give a folder of EXR files", folder, error.message());
    }
    std::set<std::string> names;
    for (const fs::directory_entry& file : files) {
        if (file.path().extension() == ".exr" && file.is_regular_file(error)) {
            names.insert(file.path().filename().string());
        }
    }
    return names;
}

Row rowOf(const std::string& name, const std::string& test, const std::string& reference,
          const std::string& layer) {
    Row row{
        .name = name, .reason = {}, .comparison = {}, .image = {}, .reference = {}, .heatmap = {}};
    try {
        const ComparedPair pair(test, reference, layer);
        const CompareInput input = pair.input();
        row.comparison = compareImages(input);
        const float exposure = autoExposure(input.reference);
        row.image = pngBytes(displayImage(input.test, exposure));
        row.reference = pngBytes(displayImage(input.reference, exposure));
        row.heatmap = pngBytes(bytesFromDisplay(heatmap(input)));
        checkJudged(row.comparison, test, reference);
    } catch (const Error& error) {
        if (error.code() != ExitCode::kInput) {
            throw;
        }
        row.reason = error.what();
    }
    return row;
}

// The worst first; what could not be compared at all before.
bool isWorse(const Row& a, const Row& b) {
    const auto rank = [](const Row& row) {
        const bool known = !row.image.empty() && std::isfinite(row.comparison.rel_rmse);
        return known ? static_cast<double>(row.comparison.rel_rmse) : HUGE_VAL;
    };
    return rank(a) > rank(b);
}

std::string htmlText(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '<':
                result += "&lt;";
                break;
            case '&':
                result += "&amp;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += c;
        }
    }
    return result;
}

std::string picture(const std::string& png, const std::string& alt) {
    return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", htmlText(alt),
                       base64(png));
}

std::string htmlOf(const Row& row) {
    std::string html = fmt::format("<section><h2>{}</h2>\n", htmlText(row.name));
    if (!row.reason.empty()) {
        html += fmt::format("<p class=\"reason\">{}</p>\n", htmlText(row.reason));
    }
    if (!row.image.empty()) {
        const Comparison& c = row.comparison;
        html += fmt::format(
            "<p>rel_rmse {:.2f}%, bias {:+.2f}%, worst tile {:.2f}% at {}, {}; {:.0f}% of the "
            "difference is the reference's noise</p>\n<div class=\"row\"><figure "
            "class=\"flip\">{}{}<figcaption>image; under the pointer its "
            "reference</figcaption></figure><figure>{}<figcaption>reference</figcaption></figure>"
            "<figure>{}<figcaption>relative error, 0.1% (violet) to 100% "
            "(yellow)</figcaption></figure></div>\n",
            100.0 * c.rel_rmse, 100.0 * c.bias, 100.0 * c.tile_max, c.worst_tile.x, c.worst_tile.y,
            100.0 * c.noise_share, picture(row.image, row.name + ", image"),
            picture(row.reference, row.name + ", reference, in its place"),
            picture(row.reference, row.name + ", reference"),
            picture(row.heatmap, row.name + ", error"));
    }
    return html + "</section>\n";
}

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Sheen: images and references</title><style>
body { font: 15px/1.4 sans-serif; margin: 1.5em; background: #fff; color: #222 }
.row { display: flex; flex-wrap: wrap; gap: 1em }
figure { margin: 0 }
img { display: block; max-width: 100%; image-rendering: pixelated; min-width: 256px }
figcaption { color: #555; font-size: 13px }
.flip img + img, .flip:hover img { display: none }
.flip:hover img + img { display: block }
.reason { color: #a00 }
</style></head><body>
)";

std::string pageOf(const std::vector<Row>& rows, const std::string& tests,
                   const std::string& references, const std::string& layer) {
    std::string html = fmt::format(
        "{}<h1>{} by {}</h1>\n<p>Layer {}, {} images, the worst "
        "first.</p>\n",
        kHead, htmlText(tests), htmlText(references), layer, rows.size());
    for (const Row& row : rows) {
        html += htmlOf(row);
    }
    return html + "</body></html>\n";
}

void warnOfMissing(const std::set<std::string>& here, const std::set<std::string>& there,
                   const std::string& folder) {
    for (const std::string& name : here) {
        if (there.count(name) == 0) {
            warn(fmt::format("{}: {} is not there: left out", folder, name));
        }
    }
}

}  // namespace

ExitCode comparePage(const std::string& tests, const std::string& references,
                     const std::string& layer, const std::string& page, const std::string& json) {
    const std::set<std::string> of_tests = imagesIn(tests), of_references = imagesIn(references);
    std::vector<std::string> inputs;
    for (const auto& [folder, names] :
         {std::pair(tests, of_tests), std::pair(references, of_references)}) {
        for (const std::string& name : names) {
            inputs.push_back((fs::path(folder) / name).string());
        }
    }
    checkOutputs({{"--page", page}, {"--json", json}}, inputs);
    warnOfMissing(of_tests, of_references, references);
    warnOfMissing(of_references, of_tests, tests);
    std::vector<Row> rows;
    for (const std::string& name : of_tests) {
        if (of_references.count(name) > 0) {
            rows.push_back(rowOf(name, (fs::path(tests) / name).string(),
                                 (fs::path(references) / name).string(), layer));
        }
    }
    if (rows.empty()) {
        throwInput("{}: has no EXR file that {} has as well", tests, references);
    }
    std::stable_sort(rows.begin(), rows.end(), isWorse);
    AtomicFile file(page);
    file.write(pageOf(rows, tests, references, layer));
    file.commit();
    Json list = Json::array();
    size_t unjudged = 0;
    for (const Row& row : rows) {
        list.push_back({{"image", row.name}});
        if (!row.image.empty()) {
            list.back().update(comparisonJson(row.comparison));
        }
        list.back()["reason"] = row.reason.empty() ? Json() : Json(row.reason);
        unjudged += row.reason.empty() ? 0 : 1;
    }
    writeJson(json, list);
    if (wantsText(json)) {
        fmt::print("wrote     {} ({} images)\n", page, rows.size());
    }
    if (unjudged > 0) {
        throwInput("{}: {} of {} images are not judged: the page says why", page, unjudged,
                   rows.size());
    }
    return ExitCode::kDone;
}

}  // namespace sheen::cli
