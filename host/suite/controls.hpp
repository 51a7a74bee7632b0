// Lists every control of the suite (the window of a live session) in one table: its name, key, mouse and
// gamepad binding, and one sentence about it; a second table lists the controls of the screens without a
// session. The key bindings, the tooltips, the help and the tables in docs/suite.md are made from the two
// tables of controls.
#pragma once
#include "host/room/room_screen.hpp"
#include "shared/wire/wire.h"
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

enum class ControlId : std::uint8_t {
    // hands
    push,
    pull,
    turn_right,
    turn_left,
    tool_1,
    tool_2,
    tool_3,
    tool_next,
    tool_previous,
    move_all,
    rack_next,
    rack_previous,
    load_tool,
    take_off,
    // X-ray
    fluoro,
    acquire,
    fluoro_latch,
    fluoro_rate,
    program,
    acquire_rate,
    roadmap,
    acknowledge,
    // syringe, inflator
    inject,
    inject_rate,
    aspirate,
    inflate,
    deflate,
    load_stent,
    // C-arm
    lao,
    rao,
    cranial,
    caudal,
    sid_more,
    sid_less,
    halt,
    view_ap,
    view_spider,
    view_rao_caudal,
    view_rao_caudal_steep,
    view_rao_cranial,
    view_lao_cranial,
    view_lateral,
    view_rca_lao,
    view_rca_rao,
    view_arch,
    view_renal_left,
    view_renal_right,
    view_iliac_left,
    view_iliac_right,
    angles_zero,
    // table
    table_head,
    table_feet,
    table_right,
    table_left,
    table_up,
    table_down,
    follow,
    // field
    field_smaller,
    field_larger,
    blades_narrower,
    blades_wider,
    blades_lower,
    blades_higher,
    round,
    // pictures
    loop,
    frame_back,
    frame_on,
    store,
    mask,
    mask_right,
    mask_left,
    mask_up,
    mask_down,
    to_reference,
    reference_run,
    reference_off,
    pixels,
    // patient
    heart_slower,
    heart_faster,
    premature,
    asystole,
    breath_hold,
    // program
    help,
    hint,
    restart,
    end
};
inline constexpr std::size_t control_count = static_cast<std::size_t>(ControlId::end) + 1;

// A control of the kind `press` acts once, one of the kind `repeat` acts again while its key is held, and one
// of the kind `hold` acts as long as it is held.
enum class ControlKind : std::uint8_t { press, repeat, hold };

struct Control {
    ControlId id;
    ControlKind kind;
    std::string_view group, name; // the name is short, for buttons and for the layout file
    int key = 0, modifiers = 0;   // GLFW_KEY_*, GLFW_MOD_*; key 0: none
    std::string_view key_text;
    std::string_view mouse; // what the mouse does for it, besides its button
    int pad = -1;           // GLFW_GAMEPAD_BUTTON_*; -1: none
    std::string_view pad_text;
    std::string_view what; // one sentence: tooltip, help and document
};

// Returns the table of controls, in the order in which the help shows them.
std::span<const Control> controls();
const Control &control(ControlId id);
// Returns the control to which a key belongs. If a key with Shift or Control has no control of its own, the
// control of the key alone is returned, except that Control with an arrow never moves a tool. The function
// returns null if the key has no control.
const Control *control_of_key(int key, int modifiers);
const Control *control_of_pad(int button);

// Returns the table of controls for docs/suite.md, in Markdown.
std::string controls_document();

// --- the screens without a session, and the replay ---

enum class ScreenId : std::uint8_t { start, prep, debrief, replay, rig };
enum class ScreenControlId : std::uint8_t {
    card,
    cards_on,
    cards_back,
    practice,
    recording,
    to_rig,
    quit,
    cabinet,
    begin,
    leave_prep,
    to_replay,
    again,
    save,
    leave_debrief,
    play,
    second_back,
    second_on,
    next_error,
    error_before,
    expert,
    leave_replay,
    leave_rig
};
inline constexpr std::size_t screen_control_count = static_cast<std::size_t>(ScreenControlId::leave_rig) + 1;

// Describes a key of a screen, or a range of neighbouring keys, in which the first key selects the first
// choice, the next key the second, and so on.
struct ScreenControl {
    ScreenControlId id;
    ScreenId screen;
    std::string_view name; // in the layout file
    int key = 0, key_last = 0;
    std::string_view key_text, what;
    int keys() const { return key_last - key + 1; }
};

std::span<const ScreenControl> screen_controls();
const ScreenControl &screen_control(ScreenControlId id);
// Returns the control of a key on a screen, or null if the key has no control there.
const ScreenControl *screen_control_of_key(ScreenId screen, int key);
// Returns the text of one key of a range: "F2" for the second of "F1 to F7".
std::string screen_key_text(ScreenControlId id, std::size_t index);
std::string screen_controls_document();

// Returns the commands to the X-ray room that a control causes, if its effect depends on the present state of
// the room. `screen` is the state of the live monitor's screen. Other controls give no commands.
std::vector<RoomCommand> commands_of(ControlId id, const Room &room, const RoomStatus &screen);

} // namespace crn
