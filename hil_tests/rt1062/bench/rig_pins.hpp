// Connects the simulated rig (hil_tests/plant) with the pins of the emulated board: sensor values become
// quadrature edges, voltages and levels; duties, directions and lines become outputs of the device.
#pragma once
#include "firmware/port/port.h"
#include <array>
#include <cstdint>

#define _Static_assert static_assert // for the C headers below
extern "C" {
#include "hil_tests/rt1062/stream.h"
}
#undef _Static_assert

namespace hil
{

class RigPins
{
  public:
    explicit RigPins(rt_chip &chip) : chip_(chip) {}
    // Drives the pins as the rig does at the end of a millisecond. The edges of the encoders lie in the
    // millisecond that has just passed.
    void put(const crn_port_inputs &inputs);
    // The outputs at the end of a millisecond. The power stage is held by edges of the drive line, so `drive`
    // differs from the previous call's if the line had an edge in between, even if an even number of edges
    // restored its level.
    crn_port_outputs outputs();
    // The cable between the motor drivers' fault outputs and the board is broken.
    void cut_fault_line();

  private:
    struct Encoder {
        std::int32_t wanted = 0, counts = 0;
        bool is_known = false;
    };
    void turn(std::uint32_t encoder, std::int32_t counts, bool is_healthy);
    void drive_phases(std::uint32_t encoder, std::int32_t counts, std::uint64_t instant);
    void put_analog(rt_pin pin, std::int32_t raw);
    void put_level(rt_pin pin, bool level);

    rt_chip &chip_;
    std::array<Encoder, 7> encoders_{};
    bool is_fault_line_cut_ = false;
    std::uint32_t drive_edges_ = 0;
    bool has_flipped_ = false;
};

} // namespace hil
