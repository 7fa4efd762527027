// A folder for a test's files.
#pragma once

#include <stdlib.h>  // mkdtemp

#include <filesystem>
#include <stdexcept>
#include <string>

namespace sheen {

/// A new folder of its own, which goes away with all that is in it.
class TestFolder {
  public:
    TestFolder() {
        std::string folder = (std::filesystem::temp_directory_path() / "sheen-XXXXXX").string();
        if (mkdtemp(folder.data()) == nullptr) {
            throw std::runtime_error(folder + ": a temporary folder cannot be made");
        }
        path_ = folder;
    }
    ~TestFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace sheen
