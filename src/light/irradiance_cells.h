// Light on small cells of triangles, found where it is first asked for and kept.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "light/triangle_grid.h"
#include "rays/tracer.h"

namespace sheen {

/// Safe to use from many threads: whichever asks first, a cell says the same.
class IrradianceCells {
  public:
    /// `near`: as LightCells has them. The tracer must outlive it.
    IrradianceCells(const Tracer& tracer, const std::vector<Bounds>& near);

    /// A cell of a side of a triangle, counted through the whole scene.
    using Cell = TriangleGrid::Place;

    /// The cell of a hit; none where cells are larger by much than `area`, which the ray stands
    /// for, and none where something stands in the cell, which may part light from shadow.
    std::optional<Cell> cellOf(const Hit& hit, float area) const {
        if (triangles_[hit.triangle].cell_area > kLargestOfRay * area) {
            return std::nullopt;
        }
        const Cell place = placeOf(hit);
        std::atomic<uint64_t>& cell = cells_[place.cell];
        const uint64_t packed = cell.load(std::memory_order_relaxed);
        if (packed == kUnknown && parted(hit, place)) {
            cell.store(kParted, std::memory_order_relaxed);
            return std::nullopt;
        }
        return packed == kParted ? std::nullopt : std::optional(place);
    }
    /// What find(), an optional colour, says of the cell. Whichever find() asks first must be as
    /// good as any other.
    template <class Find>
    std::optional<vec3> at(const Cell& place, const Find& find) const {
        std::atomic<uint64_t>& cell = cells_[place.cell];
        uint64_t packed = cell.load(std::memory_order_relaxed);
        if (packed == kUnknown) {
            const std::optional<vec3> found = find();
            packed = found ? pack(*found) : kNothing;
            cell.store(packed, std::memory_order_relaxed);
        }
        return (packed & kNoAnswer) != 0 ? std::nullopt : std::optional(unpack(packed));
    }
    /// What gather(), a colour, says of a cell of which find() said nothing: likewise the same
    /// whoever asks. What at() says does not depend on whether anybody has.
    template <class Gather>
    vec3 gatheredAt(const Cell& place, const Gather& gather) const {
        std::atomic<uint64_t>& cell = cells_[place.cell];
        uint64_t packed = cell.load(std::memory_order_relaxed);
        if (packed == kNothing) {
            packed = pack(gather()) | kNoAnswer;
            cell.store(packed, std::memory_order_relaxed);
        }
        return unpack(packed);
    }
    /// Cells lie anywhere in memory: by the time that one is read, it has arrived.
    void prefetch(const Hit& hit) const { __builtin_prefetch(&cells_[placeOf(hit).cell]); }

  private:
    static constexpr float kLargestOfRay = 16.0f;
    // A bit beyond those of three channels: find() did not say what else there is.
    static constexpr uint64_t kNoAnswer = uint64_t{1} << 63u;
    // No numbers.
    static constexpr uint64_t kUnknown = ~uint64_t{0};
    static constexpr uint64_t kNothing = kUnknown - 1;
    static constexpr uint64_t kParted = kUnknown - 2;
    // Of each channel the 21 leading bits, the sign left out: 13 of its mantissa.
    static constexpr int kBits = 21;
    static constexpr int kCut = 10;

    static uint64_t pack(const vec3& irradiance) {
        uint64_t packed = 0;
        for (int channel = 0; channel < 3; ++channel) {
            const uint64_t bits =
                (std::bit_cast<uint32_t>(irradiance[channel] > 0.0f ? irradiance[channel] : 0.0f) +
                 (1u << (kCut - 1))) >>
                kCut;
            packed |= bits << (kBits * channel);
        }
        return packed;
    }
    static vec3 unpack(uint64_t packed) {
        vec3 irradiance;
        for (int channel = 0; channel < 3; ++channel) {
            const auto bits =
                static_cast<uint32_t>(packed >> (kBits * channel)) & ((1u << kBits) - 1);
            irradiance[channel] = std::bit_cast<float>(bits << kCut);
        }
        return irradiance;
    }

    bool parted(const Hit& hit, const Cell& cell) const;
    Cell placeOf(const Hit& hit) const {
        const Triangle& triangle = triangles_[hit.triangle];
        const TriangleGrid grid{triangle.n};
        Cell place = grid.placeOf(hit.u, hit.v);
        place.cell += triangle.first + (hit.back ? static_cast<uint32_t>(grid.cellCount()) : 0);
        return place;
    }

    struct Triangle {
        uint32_t first;  // cell of its front; those of its back follow
        uint32_t n;      // an edge is divided so often
        float cell_area;
    };
    const Tracer& tracer_;
    std::vector<Triangle> triangles_;
    std::unique_ptr<std::atomic<uint64_t>[]> cells_;
};

}  // namespace sheen
