// Whoever wants pictures of a session: told what the room was asked for, and given the instrument at the ticks it names.
// May include: shared/wire, model, room/command. Called by: run, replay.
#pragma once
#include "host/model/wire_frame.hpp"
#include "host/room/command.hpp"
#include "shared/wire/wire.h"
#include <cstdint>
#include <optional>
#include <vector>

namespace crn
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
    std::vector<ToolReading> tools; // from the innermost
};

class FrameSink
{
  public:
    virtual ~FrameSink() = default;
    // Every tick in order, with what went in and what came out; before the frame of that tick.
    virtual void tick(const crn_wire_encoders &, const crn_wire_tick_state &) {}
    // In force from that tick on; before the frame of that tick.
    virtual void command(std::uint32_t tick, const RoomCommand &command) = 0;
    // The next tick at which frame() is wanted, after all that was told up to now.
    virtual std::uint32_t next_tick() const = 0;
    virtual void frame(const SessionFrame &frame) = 0;
    // Of a replay that begins later: the same without pictures, for what is still there when they begin.
    virtual std::uint32_t next_look() const { return UINT32_MAX; }
    virtual void look(const SessionFrame &) {}
    // What it knows hangs on everything since the first tick: a replay that begins later goes through all of it.
    virtual bool needs_beginning() const { return false; }
    // What the core has to be told in the next tick; asked for before each. In a replay nobody asks: it is in the recording.
    virtual std::optional<crn_wire_scaffold> order() { return {}; }
    virtual std::optional<crn_wire_strut> strut_order() { return {}; }
    virtual void
    finish() = 0; // after the last frame; throws std::runtime_error when a file could not be written
};

// Tick of picture number `index` at `per_second` pictures per second.
inline std::uint32_t picture_tick(std::uint32_t index, std::uint32_t per_second)
{
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(index) * 1000 + per_second - 1) /
                                      per_second);
}

// A sink that wants its frames at a steady rate, whatever the room does.
class SteadySink : public FrameSink
{
  public:
    explicit SteadySink(std::uint32_t per_second) : per_second_(per_second) {}
    void command(std::uint32_t, const RoomCommand &) override {}
    std::uint32_t next_tick() const override { return picture_tick(index_, per_second_); }
    void frame(const SessionFrame &frame) final
    {
        while (next_tick() <= frame.wire.tick) ++index_;
        picture(frame);
    }
    virtual void picture(const SessionFrame &frame) = 0;

  private:
    std::uint32_t per_second_, index_ = 0;
};

} // namespace crn
