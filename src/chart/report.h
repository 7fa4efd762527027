// A measured chart as files: a page to look at and explore, and its figures for other programs.
#pragma once

#include <string>

#include "chart/chart.h"

namespace sheen {

/// Writes chart.html (everything in it: works from file:// with no network), chart.csv (a row a
/// point) and chart.json into `folder`. Environment error where it cannot.
void writeReport(const std::string& folder, const Chart& chart);

/// Row by row as RFC 4180 has it, a header first; numbers as the shortest text that reads back
/// equal. Empty: not measured or not finite.
std::string chartCsv(const Chart& chart);

/// The figures and the Pareto fronts, without images; numbers that are not finite are null.
std::string chartJson(const Chart& chart);

/// The page, with its style, program, plotting library, figures and images.
std::string chartHtml(const Chart& chart);

/// RFC 4648, with padding.
std::string base64(const std::string& bytes);

}  // namespace sheen
