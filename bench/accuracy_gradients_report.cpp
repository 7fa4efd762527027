// The tables and plots' data of the study of gradients.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy_gradients.h"

namespace sheen::bench::gradients {
namespace {

// Squares, summed over both axes and a band's coefficients.
struct Squares {
    double error = 0.0, truth = 0.0, noise = 0.0;
};

// Of irradiance's gradient (band -1) or a band's at one site; `layout` beyond the last: the noise
// stands in for the error.
Squares squaresOf(const Judgement& j, size_t layout, int band) {
    Squares s;
    const auto add = [&](float estimate, float truth, float half) {
        const double e = layout < kLayoutCount ? estimate - truth : half;
        s.error += e * e;
        s.truth += static_cast<double>(truth) * truth;
        s.noise += static_cast<double>(half) * half;
    };
    for (size_t axis = 0; axis < 2; ++axis) {
        const Light& truth = j.truth[axis];
        const Light& half = j.half_difference[axis];
        const Light& estimate = layout < kLayoutCount ? j.program[layout][axis] : truth;
        if (band < 0) {
            add(estimate.irradiance, truth.irradiance, half.irradiance);
        }
        for (int k = band * band; band >= 0 && k < (band + 1) * (band + 1); ++k) {
            const auto i = static_cast<size_t>(k);
            add(estimate.c[i], truth.c[i], half.c[i]);
        }
    }
    return s;
}

// RMS error over RMS truth, the truth's noise taken off both; and the median of the sites' errors.
std::string gradientError(const std::vector<const Judgement*>& judgements, size_t layout,
                          int band) {
    Squares sum;
    std::vector<double> relative;
    for (const Judgement* j : judgements) {
        const Squares s = squaresOf(*j, layout, band);
        sum.error += s.error;
        sum.truth += s.truth;
        sum.noise += s.noise;
        relative.push_back(std::sqrt(s.error / std::max(s.truth, 1e-30)));
    }
    if (relative.empty()) {
        return "";
    }
    const double error = layout < kLayoutCount ? sum.error - sum.noise : sum.error;
    const auto middle = relative.begin() + static_cast<std::ptrdiff_t>(relative.size() / 2);
    std::nth_element(relative.begin(), middle, relative.end());
    return percent(std::sqrt(std::max(0.0, error) / std::max(sum.truth - sum.noise, 1e-30))) +
           " / " + percent(*middle);
}

// RMS error over mean truth at moved points with the gradients of the first `bands` bands.
double movedError(const std::vector<Judgement>& judgements, int kind, int bands, int source) {
    double error = 0.0, sum = 0.0, n = 0.0;
    for (const Judgement& j : judgements) {
        for (const Judgement::Moved& m : j.moved) {
            for (int lobe = 0; lobe < kLobes && (kind == kClasses || kind == j.kind); ++lobe) {
                const double e = m.predicted[source][bands][lobe] - m.truth[lobe];
                error += e * e;
                sum += m.truth[lobe];
                n += 1.0;
            }
        }
    }
    return std::sqrt(error / std::max(n, 1.0)) / (sum / std::max(n, 1.0));
}

template <class Wanted>
std::vector<const Judgement*> select(const std::vector<Judgement>& judgements,
                                     const Wanted& wanted) {
    std::vector<const Judgement*> selected;
    for (const Judgement& j : judgements) {
        if (wanted(j)) {
            selected.push_back(&j);
        }
    }
    return selected;
}

// Rows of one group of judgements: the layouts from `first` to `last`, then the truth's noise.
void addRows(const std::string& name, const std::vector<const Judgement*>& judgements, size_t first,
             size_t last, Table& table) {
    for (size_t layout = first; layout <= last + 1; ++layout) {
        const bool noise = layout == last + 1;
        std::vector<std::string> row = {layout == first ? name : "",
                                        layout == first ? std::to_string(judgements.size()) : "",
                                        noise ? "noise of the truth" : kLayouts[layout].name};
        for (int band = -1; band < kBands; ++band) {
            row.push_back(gradientError(judgements, noise ? kLayoutCount : layout, band));
        }
        table.add(row);
    }
}

}  // namespace

void report(const std::vector<Judgement>& judgements, const BenchScenes& scenes,
            const Output& output) {
    std::vector<std::string> head = {"place", "points", "texels", "irradiance"};
    for (int l = 0; l < kBands; ++l) {
        head.push_back(fmt::format("band {}", l));
    }
    Table places(head);
    for (int kind = 0; kind < kClasses; ++kind) {
        addRows(kClassNames[kind],
                select(judgements, [&](const Judgement& j) { return j.kind == kind; }), 0,
                kLayoutCount - 1, places);
    }
    output.write("gradients.md", places.text());
    head[0] = "open places of";
    Table by_scene(head);
    for (size_t s = 0; s < scenes.size(); ++s) {
        addRows(
            scenes[s]->name,
            select(judgements, [&](const Judgement& j) { return j.scene == s && j.kind == kOpen; }),
            kProgramLayout, kProgramLayout, by_scene);
    }
    output.write("gradients_scenes.md", by_scene.text());

    head = {"place", "gradients"};
    for (int bands = 0; bands <= kBands; ++bands) {
        head.push_back(bands == 0 ? "none" : fmt::format("bands 0 to {}", bands - 1));
    }
    Table moved(head);
    std::string csv = "bands";
    for (int kind = 0; kind <= kClasses; ++kind) {
        const char* place = kind < kClasses ? kClassNames[kind] : "all";
        for (int source = 0; source < kSources; ++source) {
            std::vector<std::string> row = {source == 0 ? place : "", kSourceNames[source]};
            for (int bands = 0; bands <= kBands; ++bands) {
                row.push_back(percent(movedError(judgements, kind, bands, source)));
            }
            moved.add(row);
            csv += fmt::format(",{} {}", place, source);
        }
    }
    csv += "\n";
    for (int bands = 0; bands <= kBands; ++bands) {
        csv += std::to_string(bands);
        for (int kind = 0; kind <= kClasses; ++kind) {
            for (int source = 0; source < kSources; ++source) {
                csv += fmt::format(",{}", movedError(judgements, kind, bands, source));
            }
        }
        csv += "\n";
    }
    output.write("gradients_moved.csv", csv);
    output.write("gradients_moved.md", moved.text());
}

}  // namespace sheen::bench::gradients
