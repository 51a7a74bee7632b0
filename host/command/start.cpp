#include "host/command/start.hpp"
#include <cstdlib>

namespace crn
{

namespace
{

struct Hint {
    const char *text, *words; // what the command does, and its words behind the program's name
};
constexpr Hint hints[] = {
    {"push a guidewire from the groin into the aortic arch", "run demo"},
    {"see it as a film under X-ray", "run demo --mp4 demo.mp4"},
    {"lead a catheter over a wire, and keep a picture", "run over_the_wire --png two.png"},
    {"record a session, and replay it bit for bit", "run demo --record demo.rec"},
    {"", "replay demo.rec --verify"},
    {"list the guidewires and catheters", "instruments"},
    {"look at one of them, or at a session or scene", "info j_wire"},
    {"test a rig that exists in this program alone", "rig selftest --device sim"},
    {"explain a command", "run --help"},
};

} // namespace

bool has_display()
{
    for (const char *variable : {"DISPLAY", "WAYLAND_DISPLAY"})
        if (const char *value = std::getenv(variable); value && *value) return true;
    return false;
}

std::string start_text(const std::string &program)
{
    std::string text =
        "Cournand simulates endovascular interventions: guidewires, catheters, balloons and stents\n"
        "in living vessels under X-ray. There is no display here, so no window opens. You can\n";
    for (const Hint &hint : hints) {
        if (*hint.text) text += "- " + std::string(hint.text) + ":\n";
        text += "    " + program + " " + hint.words + "\n";
    }
    return text;
}

} // namespace crn
