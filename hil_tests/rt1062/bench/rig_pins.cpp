#include "hil_tests/rt1062/bench/rig_pins.hpp"
#include <algorithm>
#include <cmath>

namespace hil
{

namespace
{

// The following values are those of firmware/port/imxrt1062/board.h and docs/porting.md.
constexpr double axial_full_mN = 12000, torque_full_uN_m = 30000;
constexpr std::int32_t force_zero_raw = 2048, current_good_raw = 1000, current_over_raw = 3200,
                       supply_good_raw = 3000, pressure_least_raw = 100;
constexpr double volts_per_count = 3.3 / 4095;
// At most one edge per 250 ns, which the input filters let pass.
constexpr std::int32_t edges_max_per_ms = 4000;
constexpr std::uint32_t syringe = 6;
// Encoders in the order of the pins: translation 1, 2, 3, rotation 1, 2, 3, syringe.
constexpr std::array<std::uint8_t, 3> rotation_encoder = {3, 4, 5};

struct Motor {
    std::uint32_t module, submodule;
    bool is_b;
};
constexpr std::array<Motor, 6> motors = {
    {{0, 2, false}, {0, 2, true}, {0, 3, false}, {0, 3, true}, {1, 1, false}, {1, 1, true}}};

rt_pin pin(int first, std::uint32_t more)
{
    return static_cast<rt_pin>(static_cast<std::uint32_t>(first) + more);
}

} // namespace

void RigPins::put_analog(rt_pin at, std::int32_t raw)
{
    rt_pin_volts(&chip_, at, raw * volts_per_count);
}

void RigPins::put_level(rt_pin at, bool level)
{
    rt_pin_drive(&chip_, at, level ? RT_HIGH : RT_LOW, chip_.now);
}

void RigPins::drive_phases(std::uint32_t encoder, std::int32_t counts, std::uint64_t instant)
{
    const auto phase = static_cast<std::uint32_t>(counts) & 3u;
    const bool a = phase == 1 || phase == 2, b = phase >= 2;
    rt_pin_drive(&chip_, pin(RT_PIN_ENCODER_A0, encoder), a ? RT_HIGH : RT_LOW, instant);
    rt_pin_drive(&chip_, pin(RT_PIN_ENCODER_B0, encoder), b ? RT_HIGH : RT_LOW, instant);
}

// An encoder whose electronics fail makes illegal steps: both phases change at once.
void RigPins::turn(std::uint32_t encoder, std::int32_t counts, bool is_healthy)
{
    Encoder &state = encoders_[encoder];
    if (!state.is_known) state = {counts, counts, true};
    const std::uint64_t ms = RT_INSTANTS_PER_us * 1000, begin = chip_.now > ms ? chip_.now - ms : 0;
    if (!is_healthy) {
        drive_phases(encoder, state.counts + 2, begin);
        state.counts += 2;
        return;
    }
    // The counts wrap, so their difference is the shortest way.
    const auto difference = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) -
                                                      static_cast<std::uint32_t>(state.counts));
    const std::int32_t steps = std::clamp(difference, -edges_max_per_ms, edges_max_per_ms);
    const std::int32_t sign = steps < 0 ? -1 : 1, count = std::abs(steps);
    for (std::int32_t i = 1; i <= count; i++) {
        state.counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(state.counts) +
                                                 static_cast<std::uint32_t>(sign));
        drive_phases(encoder, state.counts,
                     begin + ms * static_cast<std::uint64_t>(i) / static_cast<std::uint64_t>(count + 1));
    }
    if (count == 0) drive_phases(encoder, state.counts, chip_.now);
}

void RigPins::put(const crn_port_inputs &inputs)
{
    bool any_over_current = false;
    for (std::uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        const crn_port_track &track = inputs.tracks[k];
        turn(k, inputs.hands[k].translation_counts, track.translation_sensor == CRN_PORT_SENSOR_OK);
        turn(rotation_encoder[k], inputs.hands[k].rotation_counts,
             track.rotation_sensor == CRN_PORT_SENSOR_OK);
        const bool has_force = track.force_sensor == CRN_PORT_SENSOR_OK;
        put_analog(pin(RT_PIN_FORCE0, k), has_force ? force_zero_raw + track.force_raw : 0);
        put_analog(pin(RT_PIN_CURRENT0, k), track.over_current ? current_over_raw : current_good_raw);
        any_over_current = any_over_current || track.over_current;
    }
    turn(syringe, inputs.syringe_counts, inputs.syringe_sensor == CRN_PORT_SENSOR_OK);
    const rt_level fault_line = is_fault_line_cut_ ? RT_OPEN : any_over_current ? RT_LOW : RT_HIGH;
    rt_pin_drive(&chip_, RT_PIN_FAULT, fault_line, chip_.now);
    const bool has_pressure = inputs.inflator_sensor == CRN_PORT_SENSOR_OK;
    put_analog(RT_PIN_PRESSURE, has_pressure ? std::max(inputs.inflator_raw, pressure_least_raw) : 0);
    put_analog(RT_PIN_SUPPLY, inputs.supply_good ? supply_good_raw : 0);
    rt_pin_drive(&chip_, RT_PIN_STOP, inputs.emergency_stop ? RT_OPEN : RT_LOW, chip_.now);
    rt_pin_drive(&chip_, RT_PIN_PEDAL_XRAY, (inputs.buttons & 1u) != 0 ? RT_LOW : RT_OPEN, chip_.now);
    rt_pin_drive(&chip_, RT_PIN_PEDAL_CINE, (inputs.buttons & 2u) != 0 ? RT_LOW : RT_OPEN, chip_.now);
    rt_pin_drive(&chip_, RT_PIN_UNLOCK, inputs.local_unlock ? RT_LOW : RT_OPEN, chip_.now);
    put_level(RT_PIN_STAGE, inputs.stage_on);
}

void RigPins::cut_fault_line()
{
    is_fault_line_cut_ = true;
    rt_pin_drive(&chip_, RT_PIN_FAULT, RT_OPEN, chip_.now);
}

crn_port_outputs RigPins::outputs()
{
    crn_port_outputs outputs{};
    for (std::uint32_t i = 0; i < motors.size(); i++) {
        const Motor &motor = motors[i];
        const bool is_routed = rt_pin_is_routed(&chip_, pin(RT_PIN_PWM0, i));
        double duty = is_routed ? rt_pwm_duty(&chip_, motor.module, motor.submodule, motor.is_b) : 0;
        const rt_fault &fault = chip_.fault;
        if (rt_fault_is(&fault, RT_FAULT_DUTY) && fault.address == i) duty = fault.set;
        if (rt_pin_level(&chip_, pin(RT_PIN_DIRECTION0, i))) duty = -duty;
        crn_port_motor &track = outputs.motors[i / 2];
        if (motor.is_b)
            track.torque_uN_m = static_cast<std::int32_t>(std::lround(duty * torque_full_uN_m));
        else
            track.axial_mN = static_cast<std::int32_t>(std::lround(duty * axial_full_mN));
    }
    if (chip_.pins.drive_edges != drive_edges_) has_flipped_ = !has_flipped_;
    drive_edges_ = chip_.pins.drive_edges;
    outputs.drive = has_flipped_;
    outputs.enable = rt_pin_level(&chip_, RT_PIN_ENABLE);
    return outputs;
}

} // namespace hil
