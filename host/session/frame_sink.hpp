// Declares the interface for observers of a session, such as pictures and checks, which do not affect the
// session. An observer receives the shape of the nested tools at the ticks that it requests, after the
// patient has reached that tick.
#pragma once
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"
#include <algorithm>
#include <cstdint>
#include <vector>

namespace crn
{

// Describes how one hand has moved its tool, and the force and torque on that hand.
struct ToolReading {
    double inserted_m = 0.0;
    double turned_deg = 0.0; // of the hand since the start
    double axial_N = 0.0;    // on the hand, + pushes back out
    double torque_N_m = 0.0;
};

// Holds all data about one tick that a picture and the display around it need.
struct SessionFrame {
    WireFrame wire;
    std::vector<ToolReading> tools; // from the innermost
};

class FrameSink
{
  public:
    virtual ~FrameSink() = default;
    // Receives every tick in order, with its input and its result, before the frame of that tick.
    virtual void tick(const crn_wire_tick_input &, const crn_wire_tick_state &) {}
    // Receives the forces of the walls on the tools every ContactFigures::look_every_ticks ticks, before the
    // frame of that tick. A session in FREE_RUN does not read the forces of the walls, and does not call this
    // function.
    virtual void contacts(const crn_wire_contacts &) {}
    // Returns the next tick at which frame() must be called, as far as the observer knows it now.
    virtual std::uint32_t next_tick() const = 0;
    virtual void frame(const SessionFrame &frame) = 0;
    virtual void finish() {
    } // after the last frame; throws std::runtime_error when a file could not be written
};

// Returns the tick at which picture number `index` is due, at `per_second` pictures per second.
inline std::uint32_t picture_tick(std::uint32_t index, std::uint32_t per_second)
{
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(index) * 1000 + per_second - 1) /
                                      per_second);
}

// Observes a session at a steady number of frames per second, independently of the X-ray room.
class SteadySink : public FrameSink
{
  public:
    explicit SteadySink(std::uint32_t per_second) : per_second_(per_second) {}
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

// Passes every tick and every frame on to several observers. Every observer also receives the frames that
// another observer requested; an observer must ignore a frame that it does not need.
class FrameSinks final : public FrameSink
{
  public:
    void add(FrameSink *sink) // nullptr is ignored
    {
        if (sink) sinks_.push_back(sink);
    }
    bool is_empty() const { return sinks_.empty(); }
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state) override
    {
        for (FrameSink *sink : sinks_) sink->tick(input, state);
    }
    void contacts(const crn_wire_contacts &contacts) override
    {
        for (FrameSink *sink : sinks_) sink->contacts(contacts);
    }
    std::uint32_t next_tick() const override
    {
        std::uint32_t next = UINT32_MAX;
        for (const FrameSink *sink : sinks_) next = std::min(next, sink->next_tick());
        return next;
    }
    void frame(const SessionFrame &frame) override
    {
        for (FrameSink *sink : sinks_) sink->frame(frame);
    }
    void finish() override
    {
        for (FrameSink *sink : sinks_) sink->finish();
    }

  private:
    std::vector<FrameSink *> sinks_;
};

} // namespace crn
