// This header simulates a rig: three tracks with two axes each, syringe, inflator, switches and the power
// stage, advanced by one millisecond at a time. The class Plant reads the outputs of a device's port
// (crn_port_outputs), and makes the sensor values of that port (crn_port_inputs).
//
//   outputs of the device --> power stage --> motors --> axes --> encoders, force sensors --> inputs of the
//   device
//
// The power stage is on while the supply is good, the emergency stop is released, `enable` is set, and the
// drive line has changed within the last CRN_PORT_DRIVE_HOLD_ms milliseconds. The power stage monitors these
// conditions by itself, so a halted device loses motor power whatever the cause of the halt. The simulated
// rig is deterministic: if the seeds are the same and the device's outputs are the same, the sensor values
// are the same.
#pragma once
#include "firmware/port/port.h"
#include "hil_tests/plant/axis.hpp"
#include "hil_tests/plant/random.hpp"
#include <array>
#include <cstdint>

namespace hil
{

struct EncoderSettings {
    double per_count = 1e-6;  // m or rad
    double jitter_counts = 0; // uniform, +-
};

enum class SensorFault {
    none,
    stuck,    // the reading does not change, and nothing reports it
    jump,     // one step, then correct again relative to it
    reversed, // counts in the opposite direction from here on
    range,    // the electronics report it
    silent,   // no new sample, which the electronics report
};

// Simulates the counter of an encoder and the encoder's faults.
class Encoder
{
  public:
    explicit Encoder(const EncoderSettings &settings) : settings_(settings) {}
    void sample(double place, Random &random);
    void set_fault(SensorFault fault, std::int64_t jump_counts = 0);
    std::int32_t counts() const;
    std::uint8_t health() const; // CRN_PORT_SENSOR_*

  private:
    EncoderSettings settings_;
    SensorFault fault_ = SensorFault::none;
    std::int64_t counts_ = 0, offset_counts_ = 0, mirror_counts_ = 0;
};

struct PlantSettings {
    std::uint64_t seed = 1;
    AxisSettings translation{}, rotation = rotation_axis_settings;
    EncoderSettings translation_encoder{1e-6, 0.0}, rotation_encoder{6.283185307179586 / 65536.0, 0.0};
    double force_per_count_N = 1e-3; // of the force sensor
    double force_noise_N = 0.002;    // standard deviation
    double force_range_N = 20.0;     // beyond it the sensor saturates and reports it
    bool has_force_sensor = true;
};

class Plant
{
  public:
    struct Track {
        explicit Track(const PlantSettings &s)
            : translation(s.translation), rotation(s.rotation), translation_encoder(s.translation_encoder),
              rotation_encoder(s.rotation_encoder)
        {
        }
        Axis translation, rotation;
        Encoder translation_encoder, rotation_encoder;
        SensorFault force_fault = SensorFault::none;
        double force_jump_N = 0.0; // added by SensorFault::jump
        std::int32_t force_raw = 0;
        bool is_force_saturated = false;
        bool is_over_current = false; // set from outside; a driver at its limit also sets it
    };

    explicit Plant(const PlantSettings &settings);

    // Simulates one millisecond with the given outputs of the device; afterwards `inputs()` returns the
    // sensor values at the end of that millisecond.
    void step(const crn_port_outputs &outputs);
    const crn_port_inputs &inputs() const { return inputs_; }

    Track &track(int k) { return tracks_[static_cast<std::size_t>(k)]; }
    std::uint64_t milliseconds() const { return milliseconds_; }
    bool is_stage_on() const { return is_stage_on_; }
    // Returns the largest force of any motor within the last millisecond, as a meter at the actuator would
    // show it.
    double motor_peak_N() const;
    double motor_torque_peak_N_m() const;

    // The caller may set the following fields; their values appear in the next sensor values.
    bool emergency_stop = false, supply_good = true, local_unlock = false;
    std::uint32_t buttons = 0;
    std::int32_t syringe_counts = 0, inflator_raw = 0;
    std::uint8_t syringe_sensor = CRN_PORT_SENSOR_OK, inflator_sensor = CRN_PORT_SENSOR_OK;

  private:
    void run_stage(const crn_port_outputs &outputs);
    void sample_force(Track &track);
    std::uint8_t force_health(const Track &track) const;
    void sample();

    PlantSettings settings_;
    Random random_;
    std::array<Track, CRN_PORT_TOOL_MAX> tracks_;
    crn_port_inputs inputs_{};
    std::uint64_t milliseconds_ = 0;
    bool is_stage_on_ = false, last_drive_ = false;
    int hold_ms_ = 0;
};

} // namespace hil
