// Files in a folder of a test's own, and errors that must be.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "core/error.h"
#include "test_folder.h"

namespace sheen {

namespace fs = std::filesystem;

class FolderTest : public testing::Test {
  protected:
    std::string file(const std::string& name) const { return (folder_ / name).string(); }
    /// In a folder there, or in all of it.
    int fileCount(const std::string& folder = {}) const {
        return static_cast<int>(
            std::distance(fs::directory_iterator(folder_ / folder), fs::directory_iterator()));
    }

    TestFolder own_;
    fs::path folder_ = own_.path();
};

inline std::string textOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void writeText(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

/// Runs `act`, which must throw an Error with `code` whose message is one line holding `part`.
inline void expectError(ExitCode code, const std::string& part, const std::function<void()>& act) {
    try {
        act();
        FAIL() << "no error";
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(error.code(), code) << message;
        EXPECT_NE(message.find(part), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

}  // namespace sheen
