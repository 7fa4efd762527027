#include "viewer/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/bounces.h"
#include "raster/view.h"

namespace sheen {
namespace {

constexpr size_t kRemembered = 120;  // steps

struct ChannelName {
    Channel channel;
    const char* name;
};
constexpr ChannelName kChannels[] = {{Channel::kImage, "image"},
                                     {Channel::kDirect, "direct light"},
                                     {Channel::kIndirect, "indirect light"},
                                     {Channel::kAlbedo, "diffuse reflectance"},
                                     {Channel::kNormal, "normal"},
                                     {Channel::kDepth, "depth"},
                                     {Channel::kRoughness, "roughness"},
                                     {Channel::kWeight, "records: weight"},
                                     {Channel::kError, "expected error"},
                                     {Channel::kOrder, "SH order"}};

// A combo box over numbers with names; whether another was chosen.
bool choose(const char* label, std::initializer_list<std::pair<int, const char*>> items,
            int& value) {
    const auto current = std::find_if(items.begin(), items.end(),
                                      [&](const auto& item) { return item.first == value; });
    bool chosen = false;
    if (ImGui::BeginCombo(label, current == items.end() ? "?" : current->second)) {
        for (const auto& [number, name] : items) {
            if (ImGui::Selectable(name, number == value) && number != value) {
                value = number;
                chosen = true;
            }
        }
        ImGui::EndCombo();
    }
    return chosen;
}

bool qualityPanel(RenderParams& p) {
    bool changed = ImGui::SliderFloat("accuracy", &p.placement.accuracy, 0.05f, 2.0f, "%.2f",
                                      ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    changed |= choose("bounces", {{1, "1"}, {2, "2"}, {3, "3"}, {kAllBounces, "all"}}, p.bounces);
    changed |=
        choose("SH order", {{0, "by material"}, {2, "2"}, {3, "3"}, {4, "4"}, {6, "6"}, {10, "10"}},
               p.sh_order);
    changed |=
        choose("gather size", {{0, "by accuracy"}, {8, "8"}, {16, "16"}, {32, "32"}, {64, "64"}},
               p.gather.size);
    return changed;
}

void displayPanel(DisplaySettings& s, const Shown* shown, bool& records) {
    bool by_image = !s.exposure.has_value();
    if (ImGui::Checkbox("exposure by image", &by_image)) {
        s.exposure =
            by_image ? std::nullopt : std::optional(shown != nullptr ? shown->exposure : 0.0f);
    }
    if (s.exposure) {
        ImGui::SliderFloat("stops", &*s.exposure, -12.0f, 12.0f, "%.1f",
                           ImGuiSliderFlags_AlwaysClamp);
    }
    int tone = static_cast<int>(s.tone);
    if (choose("tone curve",
               {{static_cast<int>(ToneCurve::kNeutral), "neutral"},
                {static_cast<int>(ToneCurve::kNone), "none"}},
               tone)) {
        s.tone = static_cast<ToneCurve>(tone);
    }
    ImGui::SliderFloat("direct", &s.direct, 0.0f, 4.0f, "%.2f", ImGuiSliderFlags_AlwaysClamp);
    ImGui::SliderFloat("indirect", &s.indirect, 0.0f, 4.0f, "%.2f", ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::BeginCombo("channel", kChannels[static_cast<size_t>(s.channel)].name)) {
        for (const ChannelName& c : kChannels) {
            if (ImGui::Selectable(c.name, c.channel == s.channel)) {
                s.channel = c.channel;
            }
        }
        ImGui::EndCombo();
    }
    ImGui::Checkbox("mark records", &records);
}

bool lightsPanel(ViewerState& state) {
    bool changed = false;
    for (size_t i = 0; i < state.lights.size(); ++i) {
        PunctualLight& light = state.lights[i];
        ImGui::PushID(static_cast<int>(i));
        ImGui::TextUnformatted(state.light_names[i].c_str());
        if (light.kind != shared::LIGHT_DIRECTIONAL) {
            changed |= ImGui::DragFloat3("position", &light.position.x, 0.01f);
        }
        float strength = std::max({light.intensity.x, light.intensity.y, light.intensity.z});
        vec3 color = strength > 0.0f ? light.intensity / strength : vec3(1.0f);
        bool edited = ImGui::ColorEdit3("colour", &color.x, ImGuiColorEditFlags_Float);
        edited |= ImGui::DragFloat("strength", &strength, 0.01f * std::max(strength, 0.1f), 0.0f,
                                   1e9f, "%.4g");
        if (edited) {
            light.intensity = std::max(strength, 0.0f) * glm::max(color, vec3(0.0f));
            changed = true;
        }
        ImGui::PopID();
    }
    return changed;
}

bool materialsPanel(ViewerState& state) {
    if (state.materials.empty()) {
        return false;
    }
    const auto shown = static_cast<size_t>(state.material);
    if (ImGui::BeginCombo("material", state.material_names[shown].c_str())) {
        for (size_t i = 0; i < state.materials.size(); ++i) {
            ImGui::PushID(static_cast<int>(i));
            if (ImGui::Selectable(state.material_names[i].c_str(), i == shown)) {
                state.material = static_cast<int>(i);
            }
            ImGui::PopID();
        }
        ImGui::EndCombo();
    }
    MaterialParams& m = state.materials[static_cast<size_t>(state.material)];
    bool changed = ImGui::SliderFloat("roughness", &m.roughness, 0.0f, 1.0f, "%.3f",
                                      ImGuiSliderFlags_AlwaysClamp);
    changed |= ImGui::SliderFloat("metallic", &m.metallic, 0.0f, 1.0f, "%.3f",
                                  ImGuiSliderFlags_AlwaysClamp);
    changed |= ImGui::ColorEdit3("base colour", &m.base_color.x, ImGuiColorEditFlags_Float);
    m.base_color = glm::clamp(m.base_color, vec3(0.0f), vec3(1.0f));  // what is typed too
    return changed;
}

void progressPanel(ViewerState& state, const Shown& shown) {
    const LiveProgress& p = shown.progress;
    ImGui::Text("%d x %d, %s", p.width, p.height, p.complete ? "complete" : "refining");
    ImGui::Text("%d records, %d of them new", p.records, p.records_new);
    if (p.uncovered > 0) {
        ImGui::Text("%d pixels wait for records", p.uncovered);
    }
    if (std::isfinite(p.estimated_rel_rmse)) {
        ImGui::Text("estimated error %.1f%%", 100.0 * p.estimated_rel_rmse);
    }
    const StageSeconds& s = p.seconds;
    const std::pair<const char*, double> stages[] = {
        {"G-buffer", s.gbuffer},  {"direct", s.shadow},  {"bounces", s.bounces},
        {"placing", s.placement}, {"rays", s.gather},    {"projection", s.project},
        {"splat", s.splat},       {"compose", s.compose}};
    std::array<float, std::size(stages)> ms{};
    std::transform(std::begin(stages), std::end(stages), ms.begin(),
                   [](const auto& stage) { return static_cast<float>(1000.0 * stage.second); });
    const float most = std::max(*std::max_element(ms.begin(), ms.end()), 1.0f);
    for (size_t i = 0; i < ms.size(); ++i) {
        ImGui::ProgressBar(ms[i] / most, {-1.0f, 0.0f},
                           fmt::format("{} {:.0f} ms", stages[i].first, ms[i]).c_str());
    }
    ImGui::PlotLines("step, ms", state.frame_ms.data(), static_cast<int>(state.frame_ms.size()), 0,
                     nullptr, 0.0f, FLT_MAX, {0.0f, 50.0f});
}

void shortcutsWindow(bool& open) {
    if (!open) {
        return;
    }
    ImGui::Begin("Shortcuts", &open, ImGuiWindowFlags_AlwaysAutoResize);
    for (const auto& [key, what] : std::initializer_list<std::pair<const char*, const char*>>{
             {"left button", "turn about what is looked at; a click: what a pixel is made of"},
             {"right button", "look around"},
             {"middle button", "move along the image"},
             {"wheel", "come nearer, go away"},
             {"W A S D Q E", "fly: ahead, left, back, right, down, up; Shift: faster"},
             {"1 .. 9", "the file's cameras"},
             {"[ ]", "accuracy: finer, coarser"},
             {"R", "mark records"},
             {"C", "next channel"},
             {"B", "compare: hold what is seen now, show it, let it go"},
             {"P", "save a PNG"},
             {"Tab", "hide the panel"},
             {"?", "this list"},
             {"Esc", "close"}}) {
        ImGui::Text("%-15s %s", key, what);
    }
    ImGui::End();
}

}  // namespace

ViewerState stateOf(const Scene& scene, const RenderParams& render,
                    const DisplaySettings& display) {
    ViewerState state;
    state.render = render;
    state.display = display;
    state.cameras = scene.cameras;
    state.lights = scene.lights;
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        const std::string name = i < scene.light_names.size() ? scene.light_names[i] : "";
        state.light_names.push_back(name.empty() ? fmt::format("light {}", i) : name);
    }
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const std::string& name = scene.materials[i].name;
        state.materials.push_back(scene.materials[i].params);
        state.material_names.push_back(name.empty() ? fmt::format("material {}", i) : name);
    }
    return state;
}

Wishes drawPanels(ViewerState& state, const Shown* fresh, const Shown* shown, float y_fov) {
    Wishes wishes;
    if (fresh != nullptr && std::exchange(state.last_step, fresh->number) != fresh->number) {
        state.frame_ms.push_back(static_cast<float>(1000.0 * fresh->progress.seconds.total));
        if (state.frame_ms.size() > kRemembered) {
            state.frame_ms.erase(state.frame_ms.begin());
        }
    }
    shortcutsWindow(state.shortcuts);
    if (!state.panel) {
        return wishes;
    }
    ImGui::SetNextWindowPos({8.0f, 8.0f}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({280.0f, 460.0f}, ImGuiCond_FirstUseEver);
    ImGui::Begin("Sheen");
    if (!state.message.empty()) {
        ImGui::TextWrapped("%s", state.message.c_str());
    }
    if (shown != nullptr && ImGui::CollapsingHeader("Progress", ImGuiTreeNodeFlags_DefaultOpen)) {
        progressPanel(state, *shown);
    }
    if (ImGui::CollapsingHeader("Quality", ImGuiTreeNodeFlags_DefaultOpen)) {
        wishes.render = qualityPanel(state.render);
    }
    if (ImGui::CollapsingHeader("Display")) {
        displayPanel(state.display, shown, state.records);
    }
    if (ImGui::CollapsingHeader("Camera")) {
        for (size_t i = 0; i < state.cameras.size(); ++i) {
            const std::string& name = state.cameras[i].name;
            ImGui::PushID(static_cast<int>(i));
            if (ImGui::Button(name.empty() ? fmt::format("camera {}", i).c_str() : name.c_str())) {
                wishes.camera = static_cast<int>(i);
            }
            ImGui::PopID();
        }
        float degrees = glm::degrees(y_fov);
        if (ImGui::SliderFloat("field of view", &degrees, 5.0f, 120.0f, "%.0f",
                               ImGuiSliderFlags_AlwaysClamp)) {
            wishes.y_fov = glm::radians(degrees);
        }
    }
    if (!state.lights.empty() && ImGui::CollapsingHeader("Lights")) {
        wishes.lights = lightsPanel(state);
    }
    if (ImGui::CollapsingHeader("Materials")) {
        wishes.materials = materialsPanel(state);
    }
    wishes.save_png = ImGui::Button("Save PNG");
    ImGui::SameLine();
    wishes.save_exr = ImGui::Button("Save EXR");
    ImGui::SameLine();
    wishes.save_camera = ImGui::Button("Camera");
    ImGui::SameLine();
    if (ImGui::Button("?")) {
        state.shortcuts = !state.shortcuts;
    }
    ImGui::End();
    return wishes;
}

void drawMarks(const Shown& shown, const vec2& size) {
    constexpr int kCorners = 12;
    const PixelGrid image =
        pixelGrid(shown.camera, static_cast<int>(size.x), static_cast<int>(size.y));
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto place = [&](const vec3& p) -> std::optional<ImVec2> {
        const vec3 c = viewCoordinates(image.view, p);
        if (!(c.z > 1e-6f)) {
            return std::nullopt;
        }
        return ImVec2((0.5f * c.x / c.z + 0.5f) * size.x, (0.5f * c.y / c.z + 0.5f) * size.y);
    };
    for (const LiveMark& mark : shown.marks) {
        const mat3 frame = tangentFrame(mark.normal);
        std::array<ImVec2, kCorners> corners;
        bool ahead = true;
        for (int k = 0; k < kCorners && ahead; ++k) {
            const float angle = 2.0f * kPi * static_cast<float>(k) / kCorners;
            const auto corner = place(mark.position + mark.reach * (std::cos(angle) * frame[0] +
                                                                    std::sin(angle) * frame[1]));
            ahead = corner.has_value();
            corners[static_cast<size_t>(k)] = corner.value_or(ImVec2());
        }
        const ImU32 color =
            mark.order > 0 ? IM_COL32(255, 170, 60, 160) : IM_COL32(90, 200, 255, 160);
        if (ahead) {
            list.AddPolyline(corners.data(), kCorners, color, ImDrawFlags_Closed, 1.0f);
        }
        if (const auto middle = place(mark.position)) {
            list.AddCircleFilled(*middle, 1.5f, color);
        }
    }
}

}  // namespace sheen
