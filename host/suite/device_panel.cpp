// Draws the panel of devices: one row per position with the travel and the turn of its tool, and the force
// and torque on the hand. The user drags a row with the mouse to push and turn its tool. Below the rows of
// the positions, the function draws the device table, which lists the session's devices that are not in use.
// In the device table the user selects the device to load. One button loads the selected device at the chosen
// position; another button removes the device at this position.
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
constexpr float force_share = 0.66f, torque_share = 0.83f; // of a row's width, where their bars begin
// Dragging by one layout unit moves a tool by half a millimetre or turns it by one degree; with Shift, by a
// fifth of that.
constexpr double um_per_unit = 500.0, counts_per_unit = counts_per_turn / 360.0, slow_share = 0.2;
const std::string free_text = "free: load a device of the device table";
constexpr double wheel_um = 2000.0, wheel_counts = counts_per_turn / 24.0;

ImU32 load_colour(double share)
{
    return share < 0.4 ? tint::sky : share < 0.75 ? tint::orange : tint::red;
}

// --- the device table ---

constexpr float head_units = 17.0f, row_units = 28.0f, buttons_units = 216.0f; // of the layout
constexpr std::size_t button_columns = 4;

// Returns the numbers of the tools in the table that are not in use.
std::vector<std::uint8_t> off_line(const SuiteView &view)
{
    std::vector<std::uint8_t> numbers;
    const LineNumbers &line = view.state->line;
    for (std::size_t number = 1; number <= view.table->size(); ++number)
        if (std::find(line.begin(), line.end(), number) == line.end())
            numbers.push_back(static_cast<std::uint8_t>(number));
    return numbers;
}

// The height of the device table depends only on the number of tools, so that an exchange of tools moves no
// panel.
std::size_t rack_rows(const SuiteView &view)
{
    const std::size_t positions = view.state->line.size(), count = view.table->size();
    const std::size_t most = std::max(count, positions + 1) - 1; // when one tool is on the line
    const std::size_t fewest = count > positions ? count - positions : 0;
    return std::clamp<std::size_t>(
        (std::max(fewest, std::min(most, button_columns)) + button_columns - 1) / button_columns, 1, 2);
}

} // namespace

void SuiteScreen::draw_devices(const UiRect &place)
{
    ui_.begin_panel("devices", place, "");
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {ui_.px(6.0f), ui_.px(2.0f)});
    ImGui::SetCursorScreenPos({place.x + ui_.px(9.0f), place.y + ui_.px(4.0f)});
    ui_.small_text(tint::dim,
                   "DEVICES, innermost first     drag a row: sideways to push and pull, up and down to turn");
    ImFont *font = ui_.fonts().small_text;
    const float inner = place.width - ui_.px(12.0f);
    for (const auto &[share, name] :
         {std::pair(force_share, "force on the hand"), std::pair(torque_share, "torque on the hand")})
        ImGui::GetWindowDrawList()->AddText(font, font->FontSize,
                                            {place.x + ui_.px(6.0f) + share * inner, place.y + ui_.px(4.0f)},
                                            tint::dim, name);
    for (std::size_t k = 0; k < view_->tools->size(); ++k) {
        ImGui::SetCursorScreenPos(
            {place.x + ui_.px(6.0f), place.y + ui_.px(25.0f + 34.0f * static_cast<float>(k))});
        draw_device(k, place.width - ui_.px(12.0f));
    }
    ImGui::PopStyleVar();
    ui_.end_panel();
}

// Reads the drag of the mouse, or the turn of its wheel, on the row that was drawn last.
void SuiteScreen::take_drag(std::size_t tool)
{
    const ImGuiIO &io = ImGui::GetIO();
    const double slow = io.KeyShift ? slow_share : 1.0;
    const double units = 1.0 / static_cast<double>(ui_.px(1.0f));
    // The code measures the drag from the point where the button was pressed. ImGui's motion of the pointer
    // per frame (`io.MouseDelta`) is unsuitable: in the frame in which the button is pressed, `io.MouseDelta`
    // may also contain the pointer's motion before the press.
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
}

void SuiteScreen::draw_device(std::size_t tool, float width)
{
    const SessionFrame &frame = view_->state->frame;
    const ToolReading reading = tool < frame.tools.size() ? frame.tools[tool] : ToolReading{};
    const Instrument &instrument = (*view_->tools)[tool];
    const bool is_free = instrument.name.empty();
    UserInput &input = ui_.input();
    const bool is_chosen = input.moves_all() || input.chosen_tool() == tool;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float height = ui_.px(32.0f);
    ImGui::PushID(static_cast<int>(tool));
    ImGui::InvisibleButton("row", {width, height});
    const std::string name = "row " + std::to_string(tool + 1);
    const std::string moved = formatted("%.0f mm  %+.0f\u00b0", rounded_to(reading.inserted_m * 1e3, 1.0),
                                        rounded_to(reading.turned_deg, 1.0));
    const bool is_out = reading.inserted_m <= 0.0; // and may be exchanged
    ui_.note_last_item(name,
                       is_free ? free_text : instrument.name + "  " + moved + (is_out ? "  withdrawn" : ""));
    if (view_->tips && tool < view_->tips->size() && !(*view_->tips)[tool].empty() && !is_free) {
        ui_.note_last_item("tip " + std::to_string(tool + 1), (*view_->tips)[tool]);
        ui_.tooltip("The tip is " + (*view_->tips)[tool] + ".");
    }
    if (ImGui::IsItemActivated()) input.choose(tool);
    take_drag(tool);
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(at, {at.x + width, at.y + height}, is_chosen ? tint::raised : tint::background,
                        ui_.px(4.0f));
    if (is_chosen) draw->AddRectFilled(at, {at.x + ui_.px(4.0f), at.y + height}, tint::orange, ui_.px(2.0f));
    if (is_free) {
        const std::string text = std::to_string(tool + 1) + "  " + free_text;
        draw->AddText({at.x + ui_.px(12.0f), at.y + ui_.px(7.0f)}, tint::dim, text.c_str());
        ImGui::PopID();
        return;
    }

    // Draws a bar that shows how much of the tool is inside the patient.
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
    draw->AddText({rail_x + rail_w + ui_.px(14.0f), text_y}, is_out ? tint::green : tint::text,
                  is_out ? "withdrawn" : moved.c_str());

    const double torque_mN_m = reading.torque_N_m * 1e3;
    const float bars_x = at.x + force_share * width, bar_w = 0.09f * width;
    const double force = std::fabs(reading.axial_N) / force_full_N,
                 torque = std::fabs(torque_mN_m) / torque_full_mN_m;
    ImGui::SetCursorScreenPos({bars_x, at.y + ui_.px(9.0f)});
    const std::string force_text = formatted("%.2f N", rounded_to(reading.axial_N, 100.0));
    ui_.bar(static_cast<float>(reading.axial_N / force_full_N), load_colour(force), force_text.c_str(),
            bar_w);
    ImGui::SetCursorScreenPos({at.x + torque_share * width, at.y + ui_.px(9.0f)});
    const std::string torque_text = formatted("%.1f mN\u00b7m", rounded_to(torque_mN_m, 10.0));
    ui_.bar(static_cast<float>(torque_mN_m / torque_full_mN_m), load_colour(torque), torque_text.c_str(),
            bar_w);
    ImGui::PopID();
}

// --- the device table ---

float SuiteScreen::rack_height() const
{
    if (view_->table->size() < 2) return 0.0f;
    return head_units + row_units * static_cast<float>(rack_rows(*view_)) + 5.0f;
}

void SuiteScreen::draw_rack_device(std::uint8_t number, float width, float height)
{
    const Instrument &tool = (*view_->table)[number - 1u];
    const bool is_selected = ui_.input().to_load() == number;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::PushID(100 + number);
    if (ImGui::InvisibleButton("device", {width, height})) ui_.input().select_to_load(number);
    ui_.note_last_item("table " + std::to_string(number), (is_selected ? "to load: " : "") + tool.name);
    ui_.tooltip(tool.name + ". " + tool.description +
                "\nClick selects it to be loaded.  Key: / for the next");
    ImDrawList *draw = ImGui::GetWindowDrawList();
    const ImVec2 end{at.x + width, at.y + height};
    draw->AddRectFilled(at, end, is_selected ? tint::raised : tint::background, ui_.px(4.0f));
    if (is_selected) draw->AddRect(at, end, tint::orange, ui_.px(4.0f), 0, ui_.px(1.5f));
    draw->PushClipRect(at, {end.x - ui_.px(4.0f), end.y}, true);
    ImFont *font = ui_.fonts().small_text;
    draw->AddText(font, font->FontSize, {at.x + ui_.px(8.0f), at.y + ui_.px(5.0f)},
                  is_selected ? tint::text : tint::dim, tool.name.c_str());
    draw->PopClipRect();
    ImGui::PopID();
}

void SuiteScreen::draw_rack(const UiRect &place)
{
    if (place.height <= 0.0f) return;
    ui_.begin_panel("rack", place, "");
    const std::vector<std::uint8_t> numbers = off_line(*view_);
    const std::size_t position = ui_.input().chosen_tool();
    const LineNumbers &line = view_->state->line;
    const bool is_free = position < line.size() && line[position] == 0;
    ImGui::SetCursorScreenPos({place.x + ui_.px(9.0f), place.y + ui_.px(1.0f)});
    ui_.small_text(tint::dim, numbers.empty() ? "DEVICE TABLE: every device is on the line" : "DEVICE TABLE");
    const float buttons = ui_.px(buttons_units);
    const float width = (place.width - buttons - ui_.px(12.0f)) / static_cast<float>(button_columns);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto column = static_cast<float>(i % button_columns),
                   row = static_cast<float>(i / button_columns);
        ImGui::SetCursorScreenPos(
            {place.x + ui_.px(6.0f) + column * width, place.y + ui_.px(head_units + row_units * row)});
        draw_rack_device(numbers[i], width - ui_.px(5.0f), ui_.px(row_units - 3.0f));
    }
    ImGui::SetCursorScreenPos({place.x + place.width - buttons, place.y + ui_.px(head_units - 1.0f)});
    const std::string load =
        is_free ? formatted("Load as %zu", position + 1) : formatted("Exchange %zu", position + 1);
    ui_.button(ControlId::load_tool, load.c_str(), 106.0f);
    ImGui::SameLine();
    ui_.button(ControlId::take_off, "Take off", 96.0f);
    ui_.end_panel();
}

} // namespace crn
