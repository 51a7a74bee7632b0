// This header describes a device on a test bench: the pipe to the device, the rig around it, and time. The
// interface of a test bench is the same at every test level (L0 to L3), and the test cases use only this
// interface.
//
//   L0  SimBench        the app as a library in this process            (hil_tests/l0)
//   L1  EmulatedBench   the image on an emulated Cortex-M7              (hil_tests/l1)
//   L2, L3  RemoteBench the image beside a program hil_rig, by USB      (remote_bench.hpp)
//
// The bench controls time: the function advance() runs the device and the simulated rig (plant) alternately,
// for one millisecond each. While advance() does not run, the device does nothing.
#pragma once
#include "hil_tests/plant/plant.hpp"
#include "host/link/transport.hpp"
#include <algorithm>
#include <memory>

namespace hil
{

class Bench
{
  public:
    explicit Bench(const PlantSettings &settings) : plant_(settings) {}
    virtual ~Bench() = default;

    virtual crn::Transport &pipe() = 0;

    Plant &plant() { return plant_; }
    const crn_port_outputs &outputs() const { return outputs_; }

    // Runs the device together with its rig for the given number of milliseconds of the rig's time.
    void advance(std::uint32_t milliseconds)
    {
        for (std::uint32_t i = 0; i < milliseconds; i++) {
            outputs_ = edge(plant_.inputs());
            plant_.step(outputs_);
        }
    }

    // Halts the processor for `milliseconds` of the rig's time, as under a debugger, while the rig runs on.
    // The halt also lasts `wall_s` seconds of wall-clock time.
    void freeze(std::uint32_t milliseconds, double wall_s = 0.0)
    {
        hold(true);
        for (std::uint32_t i = 0; i < milliseconds; i++) {
            pass_frozen_ms();
            plant_.step(outputs_);
        }
        if (wall_s > 0.0) sleep(wall_s);
        hold(false);
    }

    // Arranges that the device's cable is pulled in the middle of a transfer, after `bytes` more bytes have
    // been sent to the device. The cable is plugged in again after `away_ms` of the rig's time. Returns false
    // if the device has no cable at this test level.
    virtual bool pull_cable(std::uint32_t bytes, std::uint32_t away_ms)
    {
        static_cast<void>(bytes), static_cast<void>(away_ms);
        return false;
    }

    // Cuts the rig's power supply for `milliseconds`, and then restores it; the device restarts.
    void brown_out(std::uint32_t milliseconds)
    {
        plant_.supply_good = false;
        for (std::uint32_t i = 0; i < milliseconds; i++) plant_.step(outputs_);
        outputs_ = restart();
        plant_.supply_good = true;
        plant_.step(outputs_);
    }

  protected:
    // Passes the sensor values `inputs` to the device, lets the device do the work of one millisecond, and
    // returns the outputs that the device sends to the rig.
    virtual crn_port_outputs edge(const crn_port_inputs &inputs) = 0;
    virtual void hold(bool held) = 0;
    virtual void pass_frozen_ms() {} // for levels where the device's clock is not its own
    virtual crn_port_outputs restart() = 0;

  private:
    static void sleep(double seconds);

    Plant plant_;
    crn_port_outputs outputs_{};
};

// Makes test benches of one level (L0 to L3); every new bench has a device that has just been powered up.
class Level
{
  public:
    virtual ~Level() = default;
    virtual const char *name() const = 0;
    virtual std::unique_ptr<Bench> make(const PlantSettings &settings) = 0;
    // Returns false if the encoders reach the device as edges on lines, of which only so many fit into a
    // millisecond; a count that jumps cannot exist there.
    virtual bool has_jumping_encoders() const { return true; }
};

} // namespace hil
