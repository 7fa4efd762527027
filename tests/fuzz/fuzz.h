// What the fuzz targets share: the input as a file, and the promises that every error keeps.
#pragma once

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"
#include "test_folder.h"

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
    explicit InputFile(const std::string& name) : path_((folder_.path() / name).string()) {}

    const std::string& write(const uint8_t* data, size_t size) const {
        std::filesystem::remove(path_);  // some file systems wait for the disk when overwriting
        fill(path_, reinterpret_cast<const char*>(data), size);
        return path_;
    }

    /// Another file, which an input may name.
    void addNeighbour(const std::string& name, const std::string& bytes) const {
        fill(folder_.path() / name, bytes.data(), bytes.size());
    }

  private:
    // A full disk must not let targets read cut files and call that a test.
    static void fill(const std::filesystem::path& path, const char* data, size_t size) {
        std::ofstream file(path, std::ios::binary);
        file.write(data, static_cast<std::streamsize>(size));
        file.close();
        require(file.good(), "an input can be written", path.string());
    }

    TestFolder folder_;
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
