// Small corridors, each of a kind that is hard for the cache: tests rebuild them, no file is kept.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/model.h"

namespace sheen {

/// A corridor of 22 m, lit by four spots on one wall and seen from 35 cm above its polished
/// dielectric floor, which reflects at grazing angles only.
scenes::Model polishedCorridor(double floor_roughness);

/// A corridor of 22 m with a rough dark floor, whose only lit surfaces lie at its end: little but a
/// rough surface's faint gloss, of light from one side. Seen from `eye_height`, looking down by
/// `slope` metres on a metre.
scenes::Model brightEndWall(double floor_roughness, double eye_height, double slope);

struct CaseScene {
    std::string name;
    scenes::Model model;
};
/// grazing, corridor_r25, corridor_r60, seam_r80 and seam_r100: both kinds at several roughnesses.
std::vector<CaseScene> caseScenes();

/// Writes a .glb file; environment error where that cannot be done.
void writeScene(const scenes::Model& model, const std::filesystem::path& path);

}  // namespace sheen
