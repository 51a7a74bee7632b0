#include "hil_tests/plant/plant.hpp"
#include <algorithm>
#include <cmath>

namespace hil
{

namespace
{

std::uint8_t health_of(SensorFault fault)
{
    if (fault == SensorFault::range) return CRN_PORT_SENSOR_RANGE;
    if (fault == SensorFault::silent) return CRN_PORT_SENSOR_ERROR;
    return CRN_PORT_SENSOR_OK;
}

} // namespace

void Encoder::sample(double place, Random &random)
{
    const double jitter = settings_.jitter_counts * (2.0 * random.uniform() - 1.0);
    if (fault_ == SensorFault::stuck || fault_ == SensorFault::silent) return;
    counts_ = static_cast<std::int64_t>(std::floor(place / settings_.per_count + jitter + 0.5));
}

void Encoder::set_fault(SensorFault fault, std::int64_t jump_counts)
{
    if (fault == SensorFault::jump) offset_counts_ += jump_counts;
    mirror_counts_ = counts_;
    fault_ = fault;
}

std::int32_t Encoder::counts() const
{
    const std::int64_t seen = fault_ == SensorFault::reversed ? 2 * mirror_counts_ - counts_ : counts_;
    return static_cast<std::int32_t>(
        static_cast<std::uint32_t>(seen + offset_counts_)); // the hardware's counter wraps
}

std::uint8_t Encoder::health() const
{
    return health_of(fault_);
}

Plant::Plant(const PlantSettings &settings)
    : settings_(settings), random_(settings.seed), tracks_{Track(settings), Track(settings), Track(settings)}
{
    sample();
}

void Plant::run_stage(const crn_port_outputs &outputs)
{
    if (outputs.drive != last_drive_) {
        hold_ms_ = CRN_PORT_DRIVE_HOLD_ms;
    } else if (hold_ms_ > 0) {
        hold_ms_--;
    }
    last_drive_ = outputs.drive;
    if (!outputs.enable || !supply_good || emergency_stop) hold_ms_ = 0;
    is_stage_on_ = hold_ms_ > 0;
}

void Plant::step(const crn_port_outputs &outputs)
{
    run_stage(outputs);
    for (std::size_t k = 0; k < tracks_.size(); k++) {
        tracks_[k].translation.step(outputs.motors[k].axial_mN * 1e-3, is_stage_on_);
        tracks_[k].rotation.step(outputs.motors[k].torque_uN_m * 1e-6, is_stage_on_);
    }
    milliseconds_++;
    sample();
}

void Plant::sample_force(Track &track)
{
    double force_N = track.translation.force_on_hand() + settings_.force_noise_N * random_.normal();
    if (track.force_fault == SensorFault::jump) force_N += track.force_jump_N;
    if (track.force_fault == SensorFault::reversed) force_N = -force_N;
    if (track.force_fault == SensorFault::stuck || track.force_fault == SensorFault::silent) return;
    track.force_raw = static_cast<std::int32_t>(
        std::lround(std::clamp(force_N, -settings_.force_range_N, settings_.force_range_N) /
                    settings_.force_per_count_N));
    track.is_force_saturated = std::abs(force_N) >= settings_.force_range_N;
}

std::uint8_t Plant::force_health(const Track &track) const
{
    if (!settings_.has_force_sensor) return CRN_PORT_SENSOR_ABSENT;
    return track.is_force_saturated ? std::uint8_t{CRN_PORT_SENSOR_RANGE} : health_of(track.force_fault);
}

void Plant::sample()
{
    for (std::size_t k = 0; k < tracks_.size(); k++) {
        Track &track = tracks_[k];
        track.translation_encoder.sample(track.translation.roller(), random_);
        track.rotation_encoder.sample(track.rotation.roller(), random_);
        sample_force(track);
        inputs_.hands[k] = {track.translation_encoder.counts(), track.rotation_encoder.counts()};
        inputs_.tracks[k].force_raw = track.force_raw;
        inputs_.tracks[k].translation_sensor = track.translation_encoder.health();
        inputs_.tracks[k].rotation_sensor = track.rotation_encoder.health();
        inputs_.tracks[k].force_sensor = force_health(track);
        inputs_.tracks[k].over_current =
            track.is_over_current || track.translation.is_limited() || track.rotation.is_limited();
    }
    inputs_.syringe_counts = syringe_counts;
    inputs_.syringe_sensor = syringe_sensor;
    inputs_.inflator_raw = inflator_raw;
    inputs_.inflator_sensor = inflator_sensor;
    inputs_.buttons = buttons;
    inputs_.emergency_stop = emergency_stop;
    inputs_.supply_good = supply_good;
    inputs_.stage_on = is_stage_on_;
    inputs_.local_unlock = local_unlock;
}

double Plant::motor_peak_N() const
{
    double most = 0.0;
    for (const Track &track : tracks_) most = std::max(most, track.translation.motor_peak());
    return most;
}

double Plant::motor_torque_peak_N_m() const
{
    double most = 0.0;
    for (const Track &track : tracks_) most = std::max(most, track.rotation.motor_peak());
    return most;
}

} // namespace hil
