// Whoever wants pictures of a session: called at fixed ticks with the instrument and what the C-arm was asked for.
// May include: model, view_state. Called by: run, replay.
#pragma once
#include "host/app/view_state.hpp"
#include "host/model/wire_frame.hpp"
#include <cstdint>
#include <vector>

namespace seld
{

// One tool as its hand knows it.
struct ToolReading {
    double inserted_m = 0.0;
    double turned_deg = 0.0; // of the hand since the start
    double axial_N = 0.0;    // on the hand, + pushes back out
    double torque_N_m = 0.0;
};

// Everything of one moment that a picture and its display show.
struct SessionFrame {
    WireFrame wire;
    ViewState view;
    std::vector<ToolReading> tools; // from the innermost
};

class FrameSink
{
  public:
    virtual ~FrameSink() = default;
    virtual void frame(const SessionFrame &frame) = 0;
    virtual void
    finish() = 0; // after the last frame; throws std::runtime_error when a file could not be written
};

// Tick of picture number `index` at `per_second` pictures per second.
inline std::uint32_t picture_tick(std::uint32_t index, std::uint32_t per_second)
{
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(index) * 1000 + per_second - 1) /
                                      per_second);
}

} // namespace seld
