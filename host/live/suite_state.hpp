// Holds a copy of everything about a session that the GUI window shows besides pictures. The physics' thread
// publishes a new copy about 50 times a second, and never changes a published copy.
#pragma once
#include "host/base/thread_urgency.hpp"
#include "host/effects/pulse.hpp"
#include "host/model/tool_line.hpp"
#include "host/room/room.hpp"
#include "host/session/frame_sink.hpp"
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// States how punctual the physics is.
struct PaceFigures {
    double real_time_factor = 1.0;                   // simulated seconds per second, over the last second
    std::uint64_t ticks = 0, late_ticks = 0;         // more than 2 ms after their time
    double lost_s = 0.0;                             // by which the session has become later than the clock
    ThreadUrgency urgency = ThreadUrgency::ordinary; // that the kernel granted to the physics
};

struct SuiteState {
    std::uint32_t tick = 0;
    Room room;
    LineNumbers line;   // the tools at the positions of the line
    SessionFrame frame; // the shape and the readings of the tools, at most 20 ms old
    double contrast_ml = 0.0, contrast_ml_s = 0.0;
    // Holds the pressure that an injection of 1 ml/s needs with the present tools, or no value if no tool can
    // inject. The flow is laminar, so the pressure grows in proportion to the flow.
    std::optional<double> injection_kPa_per_ml_s;
    double inflator_kPa = 0.0; // as set by the user
    crn_wire_tick_state core{};
    std::string stent; // stage of the last stent; empty: none
    PulseMonitor pulse;
    bool is_pressure_damped = false; // the tip of the catheter blocks its vessel
    std::string pressure_tool;       // with the transducer; empty: the pressure is that of the aorta
    RoomNotice notice, refused;      // of syringe and stents; of the inflator
    std::string fault;
    bool has_left_range = false;
    PaceFigures pace;
};

} // namespace crn
