#include "host/picture/room_text.hpp"
#include "host/base/format.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

double finite_or_zero(double value)
{
    return std::isfinite(value) ? value : 0.0;
}

double rounded_to(double value, double steps)
{
    return std::round(finite_or_zero(value) * steps) / steps + 0.0;
}

std::string angles_text(const CArm &carm)
{
    const long primary = std::lround(std::clamp(finite_or_zero(carm.primary_deg), -999.0, 999.0));
    const long secondary = std::lround(std::clamp(finite_or_zero(carm.secondary_deg), -999.0, 999.0));
    return formatted("%s %ld\x7f  %s %ld\x7f", primary < 0 ? "RAO" : "LAO", std::labs(primary),
                     secondary < 0 ? "CAU" : "CRA", std::labs(secondary));
}

const char *name_of(RunKind kind)
{
    return kind == RunKind::fluoro ? "FLUORO" : kind == RunKind::cine ? "CINE" : "DSA";
}

std::string state_text(const RoomStatus &room)
{
    switch (room.source) {
    case ScreenSource::live:
        return formatted("X-RAY ON  %s %g/s", name_of(room.kind), room.pulses_per_s);
    case ScreenSource::held:
        return "LAST IMAGE HOLD";
    case ScreenSource::loop:
        return formatted("RUN %d LOOP  %d/%d", room.run, room.frame + 1, room.frames);
    case ScreenSource::still:
        return formatted("RUN %d FRAME  %d/%d", room.run, room.frame + 1, room.frames);
    case ScreenSource::nothing:
        break;
    }
    return room.is_beam_on ? "X-RAY ON" : "NO IMAGE YET";
}

std::vector<std::string> processing_texts(const RoomStatus &room)
{
    std::vector<std::string> lines;
    if (room.is_subtracted && room.mask_first == room.mask_last)
        lines.push_back(formatted("DSA  mask %d", room.mask_first + 1));
    else if (room.is_subtracted)
        lines.push_back(formatted("DSA  mask %d-%d", room.mask_first + 1, room.mask_last + 1));
    if (room.is_subtracted && (room.shift_right_px != 0.0 || room.shift_up_px != 0.0))
        lines.push_back(formatted("mask shifted %+.1f %+.1f px", room.shift_right_px, room.shift_up_px));
    if (room.roadmap == RoadmapState::waits) lines.push_back("ROADMAP: press the pedal");
    if (room.roadmap == RoadmapState::collects) lines.push_back("ROADMAP: collecting");
    if (room.roadmap == RoadmapState::shown) lines.push_back("ROADMAP");
    if (room.roadmap == RoadmapState::moved) lines.push_back("ROADMAP hidden: geometry changed");
    return lines;
}

std::string session_clock(double time_s)
{
    const long tenths = std::lround(std::clamp(finite_or_zero(time_s), 0.0, 1e6) * 10.0);
    return formatted("%02ld:%02ld.%ld", tenths / 600, tenths / 10 % 60, tenths % 10);
}

} // namespace crn
