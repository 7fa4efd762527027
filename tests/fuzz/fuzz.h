// What the fuzz targets share: the input as a file, and the promises that every error keeps.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"

namespace sheen::fuzz {

/// Ends the process where a promise is broken: libFuzzer then keeps the input.
inline void require(bool kept, const char* promise, const std::string& found = {}) {
    if (!kept) {
        fmt::print(stderr, "broken promise: {}: {}\n", promise, found);
        std::abort();
    }
}

/// No line breaks, escape sequences or other control characters; short enough to read.
inline void requireOneLine(const std::string& text) {
    constexpr size_t kLongest = 1000;
    require(text.size() <= kLongest, "a message is short", text);
    for (const char c : text) {
        require(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f, "a message is one line", text);
    }
}

/// A file in a folder of this process that holds one input after the other.
class InputFile {
  public:
    explicit InputFile(const std::string& name) {
        std::string folder =
            (std::filesystem::temp_directory_path() / "sheen-fuzz-XXXXXX").string();
        require(mkdtemp(folder.data()) != nullptr, "a temporary folder can be made", folder);
        folder_ = folder;
        path_ = (folder_ / name).string();
    }
    ~InputFile() {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    const std::string& write(const uint8_t* data, size_t size) const {
        std::filesystem::remove(path_);  // some file systems wait for the disk when overwriting
        std::ofstream(path_, std::ios::binary)
            .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
        return path_;
    }

    /// Another file, which an input may name.
    void addNeighbour(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }

  private:
    std::filesystem::path folder_;
    std::string path_;
};

/// What an error about the file at `path` must be.
inline void requireInputError(const Error& error, const std::string& path) {
    const std::string message = error.what();
    require(error.code() == ExitCode::kInput, "bad input has exit code 3", message);
    require(message.rfind(path + ": ", 0) == 0, "an error names its file first", message);
    requireOneLine(message);
}

}  // namespace sheen::fuzz
