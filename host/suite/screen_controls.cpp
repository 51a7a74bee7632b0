// Lists the controls of the start screen, the preparation, the debrief, the replay and the rig screen.
#include "host/suite/controls.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>

namespace crn
{
namespace
{

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

} // namespace

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
