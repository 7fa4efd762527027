#include "viewer/pixel_panel.h"

#include <imgui.h>

#include <algorithm>

namespace sheen {
namespace {

constexpr size_t kListed = 8;  // records
constexpr float kCell = 2.0f;  // of a disc's pixel, units of the window

void drawDisc(const char* title, const Image<Rgb8>& disc) {
    ImGui::BeginGroup();
    ImGui::TextUnformatted(title);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    for (int y = 0; y < disc.height; ++y) {
        for (int x = 0; x < disc.width; ++x) {
            const Rgb8& c = disc.at(x, y);
            const ImVec2 from(corner.x + kCell * static_cast<float>(x),
                              corner.y + kCell * static_cast<float>(y));
            list.AddRectFilled(from, ImVec2(from.x + kCell, from.y + kCell),
                               IM_COL32(c.r, c.g, c.b, 255));
        }
    }
    ImGui::Dummy(
        ImVec2(kCell * static_cast<float>(disc.width), kCell * static_cast<float>(disc.height)));
    ImGui::EndGroup();
}

void showLight(const char* name, const vec3& light) {
    ImGui::Text("%-9s %.4g %.4g %.4g", name, light.x, light.y, light.z);
}

void listRecords(const PixelParts& parts) {
    ImGui::Text("%d records serve it", static_cast<int>(parts.records.size()));
    for (size_t i = 0; i < std::min(parts.records.size(), kListed); ++i) {
        const PixelParts::Serving& s = parts.records[i];
        ImGui::Text("%6d: %3.0f%%, %.3g away of %.3g", static_cast<int>(s.record), 100.0f * s.share,
                    s.distance, s.reach);
    }
}

}  // namespace

void PixelPanel::draw(const std::shared_ptr<const PixelParts>& parts, float exposure,
                      ToneCurve tone) {
    if (parts != parts_) {
        parts_ = parts;
        open_ = parts != nullptr;
        const auto shown = [&](const Image<vec3>& disc) {
            return disc.empty() ? Image<Rgb8>() : displayImage(disc, exposure, toSrgb(tone));
        };
        hemisphere_ = parts ? shown(parts->hemisphere) : Image<Rgb8>();
        reconstruction_ = parts ? shown(parts->reconstruction) : Image<Rgb8>();
    }
    if (!open_ || !parts_) {
        return;
    }
    ImGui::SetNextWindowPos({ImGui::GetIO().DisplaySize.x - 8.0f, 8.0f}, ImGuiCond_FirstUseEver,
                            {1.0f, 0.0f});
    ImGui::Begin("Pixel", &open_, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::Text("%d, %d", parts_->pixel.x, parts_->pixel.y);
    showLight("direct", parts_->direct);
    showLight("indirect", parts_->indirect);
    showLight("caustic", parts_->caustic);
    showLight("emission", parts_->emission);
    if (parts_->seen) {
        ImGui::Text("at        %.4g %.4g %.4g", parts_->position.x, parts_->position.y,
                    parts_->position.z);
        ImGui::Text("normal    %.3f %.3f %.3f", parts_->normal.x, parts_->normal.y,
                    parts_->normal.z);
        ImGui::Text("roughness %.2f, SH order %d", parts_->roughness, parts_->order);
        listRecords(*parts_);
    }
    if (!hemisphere_.empty()) {
        ImGui::TextUnformatted("The heaviest record's hemisphere");
        drawDisc("by rays", hemisphere_);
    }
    if (!reconstruction_.empty()) {
        ImGui::SameLine();
        drawDisc("by its SH", reconstruction_);
    }
    ImGui::End();
}

}  // namespace sheen
