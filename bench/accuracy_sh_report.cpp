// The tables and plots' data of the study of projections.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy_sh.h"
#include "receivers/classes.h"
#include "sh/brdf_sh.h"

namespace sheen::bench {
namespace {

class Report {
  public:
    Report(const BenchScenes& scenes, const std::vector<Sums>& sums)
        : scenes_(scenes), sums_(sums) {}

    void write(const Output& output) const {
        writeOrders(output);
        writeNegative(output);
        writePrediction(output);
        writeBands(output);
    }

  private:
    // RMS over scenes and views (all, or one).
    double error(int order, int alpha, int view) const {
        std::vector<double> values;
        for (const Sums& s : sums_) {
            for (int v = 0; v < kViewCount; ++v) {
                if (view < 0 || v == view) {
                    values.push_back(s.relRmse(order, lobeIndex(alpha, v)));
                }
            }
        }
        return rms(values);
    }
    // Median over the sites of all scenes.
    double median(int order, int alpha, int view) const {
        std::vector<float> values;
        for (const Sums& s : sums_) {
            const auto& v = s.relative[order - kMinOrder][lobeIndex(alpha, view)];
            values.insert(values.end(), v.begin(), v.end());
        }
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    }
    double noise(int alpha) const {
        std::vector<double> values;
        for (const Sums& s : sums_) {
            for (int v = 0; v < kViewCount; ++v) {
                const int k = lobeIndex(alpha, v);
                values.push_back(std::sqrt(s.noise[k] / s.noise_sites) / (s.truth[k] / s.sites));
            }
        }
        return rms(values);
    }
    static int autoOrder(int alpha) {
        MaterialParams metal{};
        metal.base_color = vec3(kMetalF0);
        metal.metallic = 1.0f;
        metal.roughness = std::sqrt(kAlphas[alpha]);
        return materialOrder(metal, 0);
    }

    void writeOrders(const Output& output) const {
        std::vector<std::string> head = {"alpha", "view"};
        std::string csv = "order";
        for (int n = kMinOrder; n <= shared::SH_MAX_ORDER; ++n) {
            head.push_back(std::to_string(n));
        }
        head.insert(head.end(), {"auto", "noise"});
        Table table(head);
        for (int a = 0; a < kAlphaCount; ++a) {
            csv += fmt::format(",{}", kAlphas[a]);
            for (int v = -1; v < kViewCount; ++v) {
                std::vector<std::string> row = {v < 0 ? fmt::format("**{}**", kAlphas[a]) : "",
                                                v < 0 ? "all" : fmt::format("{}", kViewDegrees[v])};
                for (int n = kMinOrder; n <= shared::SH_MAX_ORDER; ++n) {
                    const std::string e = percent(error(n, a, v));
                    row.push_back(v < 0 ? e : e + " / " + percent(median(n, a, v)));
                }
                const int chosen = autoOrder(a);
                row.push_back(v < 0 ? std::to_string(chosen) : "");
                row.push_back(v < 0 ? percent(noise(a)) : "");
                table.add(row);
            }
        }
        csv += "\n";
        for (int n = kMinOrder; n <= shared::SH_MAX_ORDER; ++n) {
            csv += std::to_string(n);
            for (int a = 0; a < kAlphaCount; ++a) {
                csv += fmt::format(",{}", error(n, a, -1));
            }
            csv += "\n";
        }
        output.write("sh_orders.csv", csv);
        output.write("sh_orders.md", table.text());
    }

    // How often fits, and the outgoing light made of them, are negative.
    void writeNegative(const Output& output) const {
        Table negative({"order", "records", "alpha 0.5", "alpha 0.3", "alpha 0.2", "alpha 0.1"});
        for (int n = kMinOrder; n <= shared::SH_MAX_ORDER; ++n) {
            const int i = n - kMinOrder;
            double records = 0.0;
            double lights[kAlphaCount] = {};
            for (const Sums& s : sums_) {
                const double sites =
                    static_cast<double>(s.sites) * static_cast<double>(sums_.size());
                records += s.negative[i] / sites;
                for (int k = 0; k < kLobes; ++k) {
                    lights[k / kViewCount] += s.negative_light[i][k] / (sites * kViewCount);
                }
            }
            std::vector<std::string> row = {std::to_string(n), percent(records)};
            for (int a = 2; a < kAlphaCount; ++a) {
                row.push_back(percent(lights[a]));
            }
            negative.add(row);
        }
        output.write("sh_negative.md", negative.text());
    }

    // What the program predicts of the orders it chooses, and what these err by.
    Table predictedOrders() const {
        Table table({"alpha", "auto", "predicted, worst view", "measured, worst view",
                     "least order within 2.5%"});
        for (int a = 0; a < kAlphaCount; ++a) {
            // The views that the program weighs end at a cosine of 0.3, 72.5 degrees.
            constexpr int kWeighed = 3;
            const int chosen = autoOrder(a);
            const auto worst = [&](int order) {
                double e = 0.0;
                for (int v = 0; v < kWeighed; ++v) {
                    e = std::max(e, error(order, a, v));
                }
                return e;
            };
            double predicted = 0.0;
            for (int v = 0; v < kWeighed; ++v) {
                predicted = std::max<double>(
                    predicted,
                    predictLobeError(std::cos(glm::radians(kViewDegrees[v])), std::sqrt(kAlphas[a]))
                        .truncated[chosen]);
            }
            int needed = kMinOrder;
            while (needed <= shared::SH_MAX_ORDER && worst(needed) > kTruncationBudget) {
                ++needed;
            }
            table.add({fmt::format("{}", kAlphas[a]), std::to_string(chosen), percent(predicted),
                       percent(worst(chosen)),
                       needed > shared::SH_MAX_ORDER ? "above 10" : std::to_string(needed)});
        }
        return table;
    }

    void writePrediction(const Output& output) const {
        std::string csv = "scene,alpha,view,order,predicted,measured\n";
        // Correlation of logarithms.
        double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
        for (size_t s = 0; s < sums_.size(); ++s) {
            for (int a = 0; a < kAlphaCount; ++a) {
                for (int v = 0; v < kViewCount; ++v) {
                    const LobePrediction prediction = predictLobeError(
                        std::cos(glm::radians(kViewDegrees[v])), std::sqrt(kAlphas[a]));
                    for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
                        const double p = prediction.truncated[order];
                        const double m = sums_[s].relRmse(order, lobeIndex(a, v));
                        csv += fmt::format("{},{},{},{},{},{}\n", scenes_[s]->name, kAlphas[a],
                                           kViewDegrees[v], order, p, m);
                        const double lx = std::log(p), ly = std::log(m);
                        n += 1, x += lx, y += ly, xx += lx * lx, yy += ly * ly, xy += lx * ly;
                    }
                }
            }
        }
        const double variance_x = xx / n - x / n * x / n;
        const double variance_y = yy / n - y / n * y / n;
        const double covariance = xy / n - x / n * y / n;
        const double factor = (y - x) / n;
        const double spread = std::sqrt(variance_x + variance_y - 2.0 * covariance);

        output.write("sh_prediction.csv", csv);
        output.write(
            "sh_prediction.md",
            predictedOrders().text() +
                fmt::format("\nOver all {} combinations of scene, alpha, view and order: "
                            "correlation of the logarithms {:.2f}; measured over predicted: "
                            "geometric mean {:.2f}, spread a factor of {:.2f} either way.\n",
                            n, covariance / std::sqrt(variance_x * variance_y), std::exp(factor),
                            std::exp(spread)));
    }

    void writeBands(const Output& output) const {
        std::vector<std::string> head = {"band"};
        std::string csv = "band,model";
        for (const auto& scene : scenes_) {
            head.push_back(scene->name);
            csv += "," + scene->name;
        }
        head.emplace_back("1 / (l + 1)");
        Table table(head);
        csv += "\n";
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            const double model = 1.0 / (l + 1.0);
            std::vector<std::string> row = {std::to_string(l)};
            csv += fmt::format("{},{}", l, model);
            for (const Sums& s : sums_) {
                const double amplitude = std::sqrt(s.band_power[l] / s.band_power[0]);
                row.push_back(fmt::format("{:.3f}", amplitude));
                csv += fmt::format(",{}", amplitude);
            }
            row.push_back(fmt::format("{:.3f}", model));
            table.add(row);
            csv += "\n";
        }
        // Exponents: straight lines through (0, 1) in logarithms.
        std::vector<std::string> row = {"exponent"};
        for (const Sums& s : sums_) {
            double xx = 0.0, xy = 0.0;
            for (int l = 1; l < shared::SH_MAX_ORDER; ++l) {
                const double x = std::log(l + 1.0);
                xx += x * x;
                xy += x * 0.5 * std::log(s.band_power[l] / s.band_power[0]);
            }
            row.push_back(fmt::format("{:.2f}", xy / xx));
        }
        row.emplace_back("-1.00");
        table.add(row);
        output.write("sh_bands.csv", csv);
        output.write("sh_bands.md", table.text());
    }

    const BenchScenes& scenes_;
    const std::vector<Sums>& sums_;
};

}  // namespace

void writeProjectionReport(const BenchScenes& scenes, const std::vector<Sums>& sums,
                           const Output& output) {
    Report(scenes, sums).write(output);
}

}  // namespace sheen::bench
