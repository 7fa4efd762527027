// Records in a file, for another view or another run.
#pragma once

#include <string>

#include "cache/record_field.h"
#include "scene/scene.h"

namespace sheen {

/// A scene's content as far as records depend on it, as 32 hexadecimal digits: its geometry, the
/// bytes of the files that it was read from, its lights and its surroundings. Environment error
/// where a file can no longer be read.
std::string sceneFingerprint(const Scene& scene);

/// What records are good for.
struct RecordOrigin {
    std::string scene;   ///< sceneFingerprint()
    std::string recipe;  ///< recordRecipe()
};

/// Writes them, whole or not at all. Environment error where that fails.
void saveRecords(const std::string& path, const KeptRecords& records, const RecordOrigin& origin);

/// Reads what saveRecords() wrote. Input error, one line, for what is no such file, of another
/// version, damaged, or of another origin.
KeptRecords loadRecords(const std::string& path, const RecordOrigin& origin);

}  // namespace sheen
