#include "cli/output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/error.h"
#include "image/atomic_file.h"

namespace sheen::cli {

void flushOutput() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        throwEnvironment("standard output: cannot write: {}", std::strerror(errno));
    }
}

void checkOutputs(const std::vector<OutputFile>& outputs, const std::vector<std::string>& inputs) {
    std::vector<OutputFile> files;
    for (const OutputFile& output : outputs) {
        if (output.path.empty() || output.path == "-") {
            continue;
        }
        for (const std::string& input : inputs) {
            if (isSameFile(output.path, input)) {
                throwUsage("{} {}: would overwrite {}, which is read; choose another name",
                           output.option, output.path, input);
            }
        }
        for (const OutputFile& other : files) {
            if (isSameFile(output.path, other.path)) {
                throwUsage("{} {}: is the file of {} as well; choose another name", output.option,
                           output.path, other.option);
            }
        }
        files.push_back(output);
    }
    for (const OutputFile& file : files) {
        checkWritable(file.path);
    }
}

void writeJson(const std::string& json_path, const Json& json, bool compact) {
    if (json_path.empty()) {
        return;
    }
    // Names come from scene files and need not be valid UTF-8.
    const std::string text =
        json.dump(compact ? -1 : 2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (json_path == "-") {
        std::fwrite(text.data(), 1, text.size(), stdout);
        flushOutput();
        return;
    }
    AtomicFile file(json_path);
    file.write(text);
    file.commit();
}

Json jsonFrom(const dvec3& v) { return Json::array({v.x, v.y, v.z}); }

}  // namespace sheen::cli
