// make_sample_report FOLDER: writes the report of sampleChart(), for report_test.py.
#include <cstdio>

#include "chart/report.h"
#include "chart_test_sample.h"

int main(int argc, char** argv) {
    try {
        if (argc != 2) {
            throw sheen::Error(sheen::ExitCode::kUsage, "usage: make_sample_report FOLDER");
        }
        sheen::writeReport(argv[1], sheen::sampleChart());
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_sample_report: %s\n", error.what());
        return 1;
    }
}
