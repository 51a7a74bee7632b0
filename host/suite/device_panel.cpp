// Draws the device rail: one row per tool with its travel, its turn, and the force and torque on the hand.
// The mouse drags a row to push and turn its tool.
#include "host/base/format.hpp"
#include "host/picture/room_text.hpp"
#include "host/script/hand_motion.hpp"
#include "host/suite/suite_screen.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr double force_full_N = 2.0, torque_full_mN_m = 2.0;
// A drag of one unit moves a tool by half a millimetre or turns it by one degree; with Shift a fifth of that.
constexpr double um_per_unit = 500.0, counts_per_unit = counts_per_turn / 360.0, slow_share = 0.2;
constexpr double wheel_um = 2000.0, wheel_counts = counts_per_turn / 24.0;

ImU32 load_colour(double share)
{
    return share < 0.4 ? tint::sky : share < 0.75 ? tint::orange : tint::red;
}

} // namespace

void SuiteScreen::draw_devices(const UiRect &place)
{
    ui_.begin_panel("devices", place, "");
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {ui_.px(6.0f), ui_.px(2.0f)});
    ImGui::SetCursorScreenPos({place.x + ui_.px(9.0f), place.y + ui_.px(4.0f)});
    ui_.small_text(tint::dim,
                   "DEVICES, innermost first     drag a row: right and left to push and pull, up and "
                   "down to turn");
    for (std::size_t k = 0; k < view_->tools->size(); ++k) {
        ImGui::SetCursorScreenPos(
            {place.x + ui_.px(6.0f), place.y + ui_.px(25.0f + 34.0f * static_cast<float>(k))});
        draw_device(k, place.width - ui_.px(12.0f));
    }
    ImGui::PopStyleVar();
    ui_.end_panel();
}

void SuiteScreen::draw_device(std::size_t tool, float width)
{
    const SessionFrame &frame = view_->state->frame;
    const ToolReading reading = tool < frame.tools.size() ? frame.tools[tool] : ToolReading{};
    const Instrument &instrument = (*view_->tools)[tool];
    UserInput &input = ui_.input();
    const bool is_chosen = input.moves_all() || input.chosen_tool() == tool;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float height = ui_.px(32.0f);
    ImGui::PushID(static_cast<int>(tool));
    ImGui::InvisibleButton("row", {width, height});
    const std::string name = "row " + std::to_string(tool + 1);
    ui_.note_last_item(name);
    if (ImGui::IsItemActivated()) input.choose(tool);
    const ImGuiIO &io = ImGui::GetIO();
    const double slow = io.KeyShift ? slow_share : 1.0;
    const double units = 1.0 / static_cast<double>(ui_.px(1.0f));
    // The drag is measured from the place where the button was pressed, because the pointer may have moved
    // there in the same frame.
    const ImVec2 way = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0.0f);
    if (ImGui::IsItemActive() && (way.x != 0.0f || way.y != 0.0f)) {
        actions_.drags.push_back(
            {tool, static_cast<std::int32_t>(std::lround(way.x * units * um_per_unit * slow)),
             static_cast<std::int32_t>(std::lround(-way.y * units * counts_per_unit * slow))});
        ImGui::ResetMouseDragDelta(ImGuiMouseButton_Left);
    }
    if (ImGui::IsItemHovered() && io.MouseWheel != 0.0f)
        actions_.drags.push_back({tool, io.KeyShift ? 0 : static_cast<std::int32_t>(io.MouseWheel * wheel_um),
                                  io.KeyShift ? static_cast<std::int32_t>(io.MouseWheel * wheel_counts) : 0});
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(at, {at.x + width, at.y + height}, is_chosen ? tint::raised : tint::background,
                        ui_.px(4.0f));
    if (is_chosen) draw->AddRectFilled(at, {at.x + ui_.px(4.0f), at.y + height}, tint::orange, ui_.px(2.0f));

    // The rail: how much of the tool is inside the patient.
    const float text_y = at.y + ui_.px(7.0f), rail_x = at.x + 0.27f * width, rail_w = 0.24f * width;
    draw->PushClipRect(at, {rail_x - ui_.px(8.0f), at.y + height}, true);
    draw->AddText({at.x + ui_.px(12.0f), text_y}, tint::text,
                  (std::to_string(tool + 1) + "  " + instrument.name).c_str());
    draw->PopClipRect();
    const float share =
        static_cast<float>(std::clamp(reading.inserted_m / std::max(instrument.length_m, 1e-3), 0.0, 1.0));
    const float rail_y = at.y + 0.5f * height;
    draw->AddLine({rail_x, rail_y}, {rail_x + rail_w, rail_y}, tint::line, ui_.px(3.0f));
    draw->AddLine({rail_x, rail_y}, {rail_x + share * rail_w, rail_y}, tint::sky, ui_.px(3.0f));
    const ImVec2 knob{rail_x + share * rail_w, rail_y};
    draw->AddCircleFilled(knob, ui_.px(7.0f), is_chosen ? tint::orange : tint::dim);
    const double turn_rad = reading.turned_deg * 3.14159265 / 180.0;
    draw->AddLine(knob,
                  {knob.x + ui_.px(6.0f) * static_cast<float>(std::sin(turn_rad)),
                   knob.y - ui_.px(6.0f) * static_cast<float>(std::cos(turn_rad))},
                  tint::background, ui_.px(2.0f));
    const std::string moved = formatted("%.0f mm  %+.0f\u00b0", rounded_to(reading.inserted_m * 1e3, 1.0),
                                        rounded_to(reading.turned_deg, 1.0));
    draw->AddText({rail_x + rail_w + ui_.px(14.0f), text_y}, tint::text, moved.c_str());

    const double torque_mN_m = reading.torque_N_m * 1e3;
    const float bars_x = at.x + 0.66f * width, bar_w = 0.09f * width;
    const double force = std::fabs(reading.axial_N) / force_full_N,
                 torque = std::fabs(torque_mN_m) / torque_full_mN_m;
    ImGui::SetCursorScreenPos({bars_x, at.y + ui_.px(9.0f)});
    const std::string force_text = formatted("%.2f N", rounded_to(reading.axial_N, 100.0));
    ui_.bar(static_cast<float>(reading.axial_N / force_full_N), load_colour(force), force_text.c_str(),
            bar_w);
    ImGui::SetCursorScreenPos({bars_x + 0.17f * width, at.y + ui_.px(9.0f)});
    const std::string torque_text = formatted("%.1f mNm", rounded_to(torque_mN_m, 10.0));
    ui_.bar(static_cast<float>(torque_mN_m / torque_full_mN_m), load_colour(torque), torque_text.c_str(),
            bar_w);
    ImGui::PopID();
}

} // namespace crn
