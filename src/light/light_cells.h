// What the lights do to every small piece of surface, found once for all records.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "rays/tracer.h"

namespace sheen {

/// Divides the triangles into cells and finds which lights reach all of a cell and which none of
/// it. Most rays that meet a surface then need no shadow ray, and no shading where it is
/// Lambertian. Safe to use from many threads.
class LightCells {
  public:
    /// How long a cell may be, over the scene's size: where records are gathered for all of an
    /// image, and where few are.
    static constexpr float kLength = 1.0f / 256.0f;
    static constexpr float kLengthForFew = 1.0f / 64.0f;

    /// Of `lights`, which are not kept. `near`: boxes around what is near whoever sees the scene;
    /// what lies in one gets cells as small as if the box were the scene.
    LightCells(const Tracer& tracer, std::span<const PunctualLight> lights,
               const std::vector<Bounds>& near, float length = kLength);

    struct Cell {
        /// On a Lambertian surface the light of what reaches all of the cell.
        vec3 radiance{0.0f};
        uint16_t shade = 0;  ///< lights that are yet to be added, by bit()
        uint16_t trace = 0;  ///< those of them that may be hidden from a part of the cell
    };

    /// A light's bit in a cell's masks; lights that have none of their own share the last.
    static constexpr uint32_t bit(size_t light) { return 1u << std::min(light, kOtherLights); }

    /// The cell of a triangle at Embree's barycentric (u, v), seen from the back or the front; null
    /// where cells are larger than what the ray stands for, `area`, by much.
    const Cell* find(uint32_t triangle, float u, float v, bool back, float area) const;

  private:
    static constexpr size_t kOtherLights = 15;

    struct Side {
        uint32_t first = 0;  // cell
        uint32_t n = 1;      // an edge is divided so often
        float area = 0.0f;   // of a cell; 0 where no light is on this side: one cell, for all rays
    };
    struct LitTriangle;
    static LitTriangle light(const Tracer& tracer, std::span<const PunctualLight> lights,
                             uint32_t index, uint32_t n);

    std::vector<Side> sides_;  // front and back of each triangle
    std::vector<Cell> cells_;
};

}  // namespace sheen
