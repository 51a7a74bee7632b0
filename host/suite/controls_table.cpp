#include "host/suite/controls.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>

namespace crn
{
namespace
{

using enum ControlId;
using enum ControlKind;
constexpr int shift = GLFW_MOD_SHIFT, ctrl = GLFW_MOD_CONTROL;
constexpr std::string_view devices = "Devices", xray = "X-ray", syringe = "Syringe and inflator",
                           carm = "C-arm", table = "Table", field = "Field", pictures = "Pictures",
                           patient = "Patient", program_group = "Program";
constexpr std::string_view button = "button";

constexpr std::array<Control, control_count> rows = {{
    {push, hold, devices, "push", GLFW_KEY_UP, 0, "Up",
     "drag the device's row to the right, or the wheel over it", -1, "right stick up",
     "Pushes the chosen device into the patient; with Shift slowly."},
    {pull, hold, devices, "pull", GLFW_KEY_DOWN, 0, "Down",
     "drag the device's row to the left, or the wheel over it", -1, "right stick down",
     "Pulls the chosen device out of the patient; with Shift slowly."},
    {turn_right, hold, devices, "turn right", GLFW_KEY_RIGHT, 0, "Right",
     "drag the device's row upwards, or Shift and the wheel", -1, "left stick right",
     "Turns the chosen device to the right; with Shift slowly."},
    {turn_left, hold, devices, "turn left", GLFW_KEY_LEFT, 0, "Left",
     "drag the device's row downwards, or Shift and the wheel", -1, "left stick left",
     "Turns the chosen device to the left; with Shift slowly."},
    {tool_1, press, devices, "device 1", GLFW_KEY_1, 0, "1", "click the device's row", -1, "",
     "Chooses the innermost device."},
    {tool_2, press, devices, "device 2", GLFW_KEY_2, 0, "2", "click the device's row", -1, "",
     "Chooses the second device from the inside."},
    {tool_3, press, devices, "device 3", GLFW_KEY_3, 0, "3", "click the device's row", -1, "",
     "Chooses the third device from the inside."},
    {tool_next, press, devices, "next device", GLFW_KEY_TAB, 0, "Tab", "", GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER,
     "right bumper", "Chooses the next device towards the outside."},
    {tool_previous, press, devices, "previous device", GLFW_KEY_TAB, shift, "Shift Tab", "",
     GLFW_GAMEPAD_BUTTON_LEFT_BUMPER, "left bumper", "Chooses the next device towards the inside."},
    {move_all, press, devices, "all together", GLFW_KEY_G, 0, "G", button, GLFW_GAMEPAD_BUTTON_RIGHT_THUMB,
     "press right stick", "Moves all devices together, or only the chosen one."},
    {rack_next, press, devices, "next to load", GLFW_KEY_SLASH, 0, "/", "click a device of the device table",
     -1, "", "Selects the next device of the device table, which is the one to be loaded."},
    {rack_previous, press, devices, "previous to load", GLFW_KEY_SLASH, shift, "Shift /",
     "click a device of the device table", -1, "", "Selects the device before it of the device table."},
    {load_tool, press, devices, "load", GLFW_KEY_INSERT, 0, "Insert", button, -1, "",
     "Loads the selected device at the chosen position; a device there must be withdrawn."},
    {take_off, press, devices, "take off", GLFW_KEY_DELETE, 0, "Delete", button, -1, "",
     "Takes the chosen device off the line, when it is withdrawn, and puts it on the device table."},
    {fluoro, hold, xray, "fluoro", GLFW_KEY_SPACE, 0, "Space", button, -1, "right trigger",
     "Pedal: fluoroscopy as long as it is held."},
    {acquire, hold, xray, "acquire", GLFW_KEY_C, 0, "C", button, -1, "left trigger",
     "Pedal: a cine or DSA run as long as it is held."},
    {fluoro_latch, press, xray, "fluoro stays on", GLFW_KEY_F, 0, "F", button, -1, "",
     "Keeps fluoroscopy on without the pedal, or ends that."},
    {fluoro_rate, press, xray, "fluoro rate", GLFW_KEY_P, 0, "P", button, -1, "",
     "Selects the next pulse rate of fluoroscopy."},
    {program, press, xray, "cine or DSA", GLFW_KEY_X, 0, "X", button, -1, "",
     "Selects what the acquisition pedal makes: cine or DSA."},
    {acquire_rate, press, xray, "run rate", GLFW_KEY_O, 0, "O", button, -1, "",
     "Selects the next frame rate of the run."},
    {roadmap, press, xray, "roadmap", GLFW_KEY_M, 0, "M", button, GLFW_GAMEPAD_BUTTON_BACK, "Back",
     "Shows a roadmap of the last DSA run or of the next fluoroscopy, or removes it."},
    {acknowledge, press, xray, "seen", GLFW_KEY_BACKSPACE, 0, "Backspace", button, -1, "",
     "Acknowledges a dose alert or the reminder after five minutes of fluoroscopy."},
    {inject, hold, syringe, "inject", GLFW_KEY_E, 0, "E", button, GLFW_GAMEPAD_BUTTON_A, "A",
     "Injects contrast medium as long as it is held."},
    {inject_rate, press, syringe, "injection rate", GLFW_KEY_Y, 0, "Y", button, -1, "",
     "Selects the next injection rate."},
    {aspirate, press, syringe, "aspirate", GLFW_KEY_E, shift, "Shift E", button, -1, "",
     "Aspirates 5 ml of blood through the outermost device with a lumen."},
    {inflate, hold, syringe, "inflate", GLFW_KEY_U, 0, "U", button, GLFW_GAMEPAD_BUTTON_X, "X",
     "Raises the inflator's pressure by 1 bar per second."},
    {deflate, hold, syringe, "deflate", GLFW_KEY_U, shift, "Shift U", button, GLFW_GAMEPAD_BUTTON_Y, "Y",
     "Lowers the inflator's pressure by 4 bar per second."},
    {load_stent, press, syringe, "load stent", GLFW_KEY_9, 0, "9", button, -1, "",
     "Loads the next stent onto the balloon, which must be withdrawn."},
    {lao, repeat, carm, "LAO", GLFW_KEY_D, 0, "D", button, GLFW_GAMEPAD_BUTTON_DPAD_RIGHT, "cross right",
     "Turns the C-arm by 5 degrees towards LAO."},
    {rao, repeat, carm, "RAO", GLFW_KEY_A, 0, "A", button, GLFW_GAMEPAD_BUTTON_DPAD_LEFT, "cross left",
     "Turns the C-arm by 5 degrees towards RAO."},
    {cranial, repeat, carm, "CRA", GLFW_KEY_W, 0, "W", button, GLFW_GAMEPAD_BUTTON_DPAD_UP, "cross up",
     "Tilts the C-arm by 5 degrees towards the head."},
    {caudal, repeat, carm, "CAU", GLFW_KEY_S, 0, "S", button, GLFW_GAMEPAD_BUTTON_DPAD_DOWN, "cross down",
     "Tilts the C-arm by 5 degrees towards the feet."},
    {sid_more, repeat, carm, "SID +", GLFW_KEY_HOME, 0, "Home", button, -1, "",
     "Moves the detector 5 cm away from the source."},
    {sid_less, repeat, carm, "SID -", GLFW_KEY_END, 0, "End", button, -1, "",
     "Moves the detector 5 cm towards the source."},
    {halt, press, carm, "stop", GLFW_KEY_Z, 0, "Z", button, GLFW_GAMEPAD_BUTTON_B, "B",
     "Stops all motors of C-arm and table."},
    {view_ap, press, carm, "AP", GLFW_KEY_F2, 0, "F2", button, -1, "", "Standard view: from the front."},
    {view_spider, press, carm, "spider", GLFW_KEY_F3, 0, "F3", button, -1, "",
     "Standard view: LAO 45 CAU 30, for the left main artery."},
    {view_rao_caudal, press, carm, "RAO caudal", GLFW_KEY_F4, 0, "F4", button, -1, "",
     "Standard view: RAO 10 CAU 30, for the circumflex artery."},
    {view_rao_caudal_steep, press, carm, "RAO caudal steep", GLFW_KEY_F4, shift, "Shift F4", button, -1, "",
     "Standard view: RAO 30 CAU 35, for the marginal branches."},
    {view_rao_cranial, press, carm, "RAO cranial", GLFW_KEY_F5, 0, "F5", button, -1, "",
     "Standard view: RAO 5 CRA 40, for the left anterior descending artery."},
    {view_lao_cranial, press, carm, "LAO cranial", GLFW_KEY_F6, 0, "F6", button, -1, "",
     "Standard view: LAO 40 CRA 30, for the diagonal branches."},
    {view_lateral, press, carm, "lateral", GLFW_KEY_F7, 0, "F7", button, -1, "",
     "Standard view: from the patient's left side."},
    {view_rca_lao, press, carm, "RCA LAO", GLFW_KEY_F8, 0, "F8", button, -1, "",
     "Standard view: LAO 50, for the right coronary artery."},
    {view_rca_rao, press, carm, "RCA RAO", GLFW_KEY_F9, 0, "F9", button, -1, "",
     "Standard view: RAO 35, for the right coronary artery."},
    {view_arch, press, carm, "arch", GLFW_KEY_F10, 0, "F10", button, -1, "",
     "Standard view: LAO 45, for the aortic arch."},
    {view_renal_left, press, carm, "renal left", GLFW_KEY_F11, 0, "F11", button, -1, "",
     "Standard view: LAO 15, for the left renal artery."},
    {view_renal_right, press, carm, "renal right", GLFW_KEY_F11, shift, "Shift F11", button, -1, "",
     "Standard view: RAO 15, for the right renal artery."},
    {view_iliac_left, press, carm, "iliac left", GLFW_KEY_F12, 0, "F12", button, -1, "",
     "Standard view: RAO 25, for the left iliac arteries."},
    {view_iliac_right, press, carm, "iliac right", GLFW_KEY_F12, shift, "Shift F12", button, -1, "",
     "Standard view: LAO 25, for the right iliac arteries."},
    {angles_zero, press, carm, "angles 0", GLFW_KEY_0, 0, "0", button, -1, "",
     "Turns the C-arm back to AP, and keeps field and distance."},
    {table_head, repeat, table, "table head", GLFW_KEY_I, 0, "I", button, -1, "",
     "Shows what lies 2 cm nearer to the head; ends following of the tip."},
    {table_feet, repeat, table, "table feet", GLFW_KEY_K, 0, "K", button, -1, "",
     "Shows what lies 2 cm nearer to the feet; ends following of the tip."},
    {table_right, repeat, table, "table right", GLFW_KEY_J, 0, "J", button, -1, "",
     "Shows what lies 2 cm farther to the patient's right."},
    {table_left, repeat, table, "table left", GLFW_KEY_L, 0, "L", button, -1, "",
     "Shows what lies 2 cm farther to the patient's left."},
    {table_up, repeat, table, "table up", GLFW_KEY_PAGE_UP, 0, "Page Up", button, -1, "",
     "Raises the table by 1 cm."},
    {table_down, repeat, table, "table down", GLFW_KEY_PAGE_DOWN, 0, "Page Down", button, -1, "",
     "Lowers the table by 1 cm."},
    {follow, press, table, "follow tip", GLFW_KEY_T, 0, "T", button, GLFW_GAMEPAD_BUTTON_LEFT_THUMB,
     "press left stick", "Lets the table follow the leading tip, or ends that."},
    {field_smaller, repeat, field, "field -", GLFW_KEY_EQUAL, 0, "+", button, -1, "",
     "Selects the next smaller field, which enlarges the picture."},
    {field_larger, repeat, field, "field +", GLFW_KEY_MINUS, 0, "-", button, -1, "",
     "Selects the next larger field."},
    {blades_narrower, repeat, field, "blades narrower", GLFW_KEY_LEFT_BRACKET, 0, "[", button, -1, "",
     "Closes the blades at the left and the right."},
    {blades_wider, repeat, field, "blades wider", GLFW_KEY_RIGHT_BRACKET, 0, "]", button, -1, "",
     "Opens the blades at the left and the right."},
    {blades_lower, repeat, field, "blades lower", GLFW_KEY_LEFT_BRACKET, ctrl, "Ctrl [", button, -1, "",
     "Closes the blades above and below."},
    {blades_higher, repeat, field, "blades higher", GLFW_KEY_RIGHT_BRACKET, ctrl, "Ctrl ]", button, -1, "",
     "Opens the blades above and below."},
    {round, press, field, "round field", GLFW_KEY_Q, 0, "Q", button, -1, "",
     "Selects a round field, or a square one."},
    {loop, press, pictures, "loop", GLFW_KEY_V, 0, "V", button, -1, "",
     "Shows the last run as a loop, or ends the review."},
    {frame_back, repeat, pictures, "frame back", GLFW_KEY_COMMA, 0, ",", button, -1, "",
     "Shows the frame before the present one of the run."},
    {frame_on, repeat, pictures, "frame on", GLFW_KEY_PERIOD, 0, ".", button, -1, "",
     "Shows the frame after the present one of the run."},
    {store, press, pictures, "keep fluoro", GLFW_KEY_B, 0, "B", button, -1, "",
     "Keeps the last 10 s of fluoroscopy as a run."},
    {mask, press, pictures, "mask", GLFW_KEY_N, 0, "N", button, -1, "",
     "Makes the shown frame of a DSA run its mask."},
    {mask_right, repeat, pictures, "mask right", GLFW_KEY_RIGHT, ctrl, "Ctrl Right", "", -1, "",
     "Shifts the mask by half a pixel to the right."},
    {mask_left, repeat, pictures, "mask left", GLFW_KEY_LEFT, ctrl, "Ctrl Left", "", -1, "",
     "Shifts the mask by half a pixel to the left."},
    {mask_up, repeat, pictures, "mask up", GLFW_KEY_UP, ctrl, "Ctrl Up", "", -1, "",
     "Shifts the mask by half a pixel upwards."},
    {mask_down, repeat, pictures, "mask down", GLFW_KEY_DOWN, ctrl, "Ctrl Down", "", -1, "",
     "Shifts the mask by half a pixel downwards."},
    {to_reference, press, pictures, "to reference", GLFW_KEY_ENTER, 0, "Enter", button, -1, "",
     "Copies the live monitor's picture to the reference monitor."},
    {reference_run, press, pictures, "run to reference", GLFW_KEY_ENTER, shift, "Shift Enter", button, -1, "",
     "Shows the next stored run as a loop on the reference monitor."},
    {reference_off, press, pictures, "reference off", GLFW_KEY_ENTER, ctrl, "Ctrl Enter", button, -1, "",
     "Clears the reference monitor."},
    {pixels, press, pictures, "1:1", GLFW_KEY_GRAVE_ACCENT, 0, "`", button, -1, "",
     "Shows the live picture pixel by pixel, or as large as fits."},
    {heart_slower, press, patient, "heart slower", GLFW_KEY_4, 0, "4", button, -1, "",
     "Slows the heart by 10 beats per minute."},
    {heart_faster, press, patient, "heart faster", GLFW_KEY_5, 0, "5", button, -1, "",
     "Quickens the heart by 10 beats per minute."},
    {premature, press, patient, "premature beat", GLFW_KEY_6, 0, "6", button, -1, "",
     "Makes the next beat premature."},
    {asystole, press, patient, "asystole", GLFW_KEY_7, 0, "7", button, -1, "",
     "Stops the heart, or lets it beat again."},
    {breath_hold, press, patient, "breath hold", GLFW_KEY_8, 0, "8", button, -1, "",
     "Lets the patient hold the breath, or breathe again."},
    {help, press, program_group, "help", GLFW_KEY_H, 0, "H or F1", button, GLFW_GAMEPAD_BUTTON_START, "Start",
     "Shows this list, or hides it."},
    {hint, press, program_group, "hint", GLFW_KEY_H, ctrl, "Ctrl H", button, -1, "",
     "Shows the next hint of the case."},
    {restart, press, program_group, "start again", GLFW_KEY_R, 0, "R", button, -1, "",
     "Ends the session with its report, and starts it again."},
    {end, press, program_group, "end", GLFW_KEY_ESCAPE, 0, "Esc", button, -1, "",
     "Ends the session with its report."},
}};

constexpr bool is_in_order()
{
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (static_cast<std::size_t>(rows[i].id) != i) return false;
    return true;
}
static_assert(is_in_order(), "control() finds a row by its number");

// --- the screens without a session, and the replay ---

using ScreenRows = std::array<ScreenControl, screen_control_count>;

constexpr ScreenRows make_screen_rows()
{
    using enum ScreenControlId;
    return {{
        {card, ScreenId::start, "card", GLFW_KEY_1, GLFW_KEY_9, "1 to 9",
         "Opens the preparation of the case with this number on the page."},
        {cards_on, ScreenId::start, "next cards", GLFW_KEY_PAGE_DOWN, GLFW_KEY_PAGE_DOWN, "Page Down",
         "Shows the next nine cases."},
        {cards_back, ScreenId::start, "cards before", GLFW_KEY_PAGE_UP, GLFW_KEY_PAGE_UP, "Page Up",
         "Shows the nine cases before."},
        {practice, ScreenId::start, "practice", GLFW_KEY_A, GLFW_KEY_C, "A to C",
         "Begins the free practice with this letter."},
        {recording, ScreenId::start, "replay", GLFW_KEY_F1, GLFW_KEY_F7, "F1 to F7",
         "Replays the recording with this key."},
        {to_rig, ScreenId::start, "rig", GLFW_KEY_R, GLFW_KEY_R, "R", "Shows which rigs are plugged in."},
        {quit, ScreenId::start, "quit", GLFW_KEY_ESCAPE, GLFW_KEY_ESCAPE, "Esc", "Ends the program."},
        {cabinet, ScreenId::prep, "device", GLFW_KEY_1, GLFW_KEY_8, "1 to 8",
         "Puts the device with this number on the line, or takes it off."},
        {begin, ScreenId::prep, "start case", GLFW_KEY_ENTER, GLFW_KEY_ENTER, "Enter",
         "Starts the session, if the anatomy is ready and the devices fit."},
        {leave_prep, ScreenId::prep, "back", GLFW_KEY_ESCAPE, GLFW_KEY_ESCAPE, "Esc",
         "Leads back to the start screen, and cancels the making of the anatomy."},
        {to_replay, ScreenId::debrief, "replay", GLFW_KEY_1, GLFW_KEY_1, "1",
         "Shows any moment of the session from any angle."},
        {again, ScreenId::debrief, "again", GLFW_KEY_2, GLFW_KEY_2, "2", "Starts the same session again."},
        {save, ScreenId::debrief, "save", GLFW_KEY_S, GLFW_KEY_S, "S",
         "Writes the debrief as HTML, and the figures as JSON, beside the recording."},
        {leave_debrief, ScreenId::debrief, "start", GLFW_KEY_ESCAPE, GLFW_KEY_ESCAPE, "Esc",
         "Leads back to the start screen."},
        {play, ScreenId::replay, "play", GLFW_KEY_SPACE, GLFW_KEY_SPACE, "Space",
         "Plays the recording in real time, or pauses it."},
        {second_back, ScreenId::replay, "back 1 s", GLFW_KEY_LEFT, GLFW_KEY_LEFT, "Left",
         "Shows the moment one second before."},
        {second_on, ScreenId::replay, "on 1 s", GLFW_KEY_RIGHT, GLFW_KEY_RIGHT, "Right",
         "Shows the moment one second later."},
        {next_error, ScreenId::replay, "next error", GLFW_KEY_N, GLFW_KEY_N, "N",
         "Shows the second before the next handling error."},
        {error_before, ScreenId::replay, "error before", GLFW_KEY_P, GLFW_KEY_P, "P",
         "Shows the second before the previous handling error."},
        {expert, ScreenId::replay, "expert", GLFW_KEY_X, GLFW_KEY_X, "X",
         "Shows the expert's run beside it, at the same time of the session."},
        {leave_replay, ScreenId::replay, "end", GLFW_KEY_ESCAPE, GLFW_KEY_ESCAPE, "Esc",
         "Leads back to the screen before, or ends the program."},
        {leave_rig, ScreenId::rig, "start", GLFW_KEY_ESCAPE, GLFW_KEY_ESCAPE, "Esc",
         "Leads back to the start screen."},
    }};
}
constexpr ScreenRows screen_rows = make_screen_rows();

constexpr bool are_screens_in_order()
{
    for (std::size_t i = 0; i < screen_rows.size(); ++i)
        if (static_cast<std::size_t>(screen_rows[i].id) != i) return false;
    return true;
}
static_assert(are_screens_in_order(), "screen_control() finds a row by its number");

std::string_view title_of_screen(ScreenId screen)
{
    constexpr std::string_view titles[] = {"Start", "Prep", "Debrief", "Replay", "Rig"};
    return titles[static_cast<std::size_t>(screen)];
}

// Converts other keys for the same control, such as those of the number pad, to the usual key.
int usual_key(int key)
{
    switch (key) {
    case GLFW_KEY_KP_ADD:
        return GLFW_KEY_EQUAL;
    case GLFW_KEY_KP_SUBTRACT:
        return GLFW_KEY_MINUS;
    case GLFW_KEY_KP_0:
        return GLFW_KEY_0;
    case GLFW_KEY_KP_ENTER:
        return GLFW_KEY_ENTER;
    case GLFW_KEY_F1:
        return GLFW_KEY_H;
    default:
        return key;
    }
}

} // namespace

std::span<const Control> controls()
{
    return rows;
}

const Control &control(ControlId id)
{
    return rows[static_cast<std::size_t>(id)];
}

const Control *control_of_key(int key, int modifiers)
{
    key = usual_key(key);
    const int wanted = modifiers & (shift | ctrl);
    const Control *plain = nullptr;
    for (const Control &row : rows) {
        if (row.key != key || key == 0) continue;
        if (row.modifiers == wanted) return &row;
        if (row.modifiers == 0) plain = &row;
    }
    const bool is_hand = plain && plain->id <= turn_left;
    return is_hand && (wanted & ctrl) ? nullptr : plain;
}

const Control *control_of_pad(int pad)
{
    const auto *at =
        std::find_if(rows.begin(), rows.end(), [&](const Control &row) { return row.pad == pad; });
    return pad < 0 || at == rows.end() ? nullptr : at;
}

std::string controls_document()
{
    std::string text = "| control | key | mouse | gamepad | what it does |\n|---|---|---|---|---|\n";
    std::string_view group;
    const auto cell = [&](std::string_view value) { text.append(value).append(" | "); };
    for (const Control &row : rows) {
        if (row.group != group) {
            group = row.group;
            text.append("| **").append(group).append("** | | | | |\n");
        }
        text += "| ";
        cell(row.name);
        if (row.key_text == "`")
            cell("`` ` ``");
        else
            text.append("`").append(row.key_text).append("` | ");
        cell(row.mouse);
        cell(row.pad_text);
        text.append(row.what).append(" |\n");
    }
    return text;
}

std::span<const ScreenControl> screen_controls()
{
    return screen_rows;
}

const ScreenControl &screen_control(ScreenControlId id)
{
    return screen_rows[static_cast<std::size_t>(id)];
}

const ScreenControl *screen_control_of_key(ScreenId screen, int key)
{
    if (key == GLFW_KEY_KP_ENTER) key = GLFW_KEY_ENTER;
    const auto *at = std::find_if(screen_rows.begin(), screen_rows.end(), [&](const ScreenControl &row) {
        return row.screen == screen && key >= row.key && key <= row.key_last;
    });
    return at == screen_rows.end() ? nullptr : at;
}

std::string screen_key_text(ScreenControlId id, std::size_t index)
{
    const ScreenControl &row = screen_control(id);
    if (row.keys() < 2) return std::string(row.key_text);
    if (index >= static_cast<std::size_t>(row.keys())) return "";
    const int key = row.key + static_cast<int>(index);
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) return "F" + std::to_string(key - GLFW_KEY_F1 + 1);
    return std::string(1, static_cast<char>(key)); // GLFW numbers letters and digits as ASCII does
}

std::string screen_controls_document()
{
    std::string text = "| screen | key | what it does |\n|---|---|---|\n";
    for (const ScreenControl &row : screen_rows)
        text.append("| ")
            .append(title_of_screen(row.screen))
            .append(" | `")
            .append(row.key_text)
            .append("` | ")
            .append(row.what)
            .append(" |\n");
    return text;
}

} // namespace crn
