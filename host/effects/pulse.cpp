#include "host/effects/pulse.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// The values of the pressure model are those of a resting adult; the model is a windkessel (Westerhof et al.,
// Med Biol Eng Comput 2009;47:131).
constexpr double resistance_mmHg_s_ml = 1.05, compliance_ml_mmHg = 1.35, impedance_mmHg_s_ml = 0.045;
constexpr double venous_mmHg = 6.0;
constexpr double stroke_ml = 72.0;          // after a diastole of 470 ms, as at 70 /min
constexpr double filling_constant_ms = 150; // time constant of ventricular filling
constexpr double tick_s = 1e-3;
constexpr double valve_opens_share = 0.24;   // of systole: 94 of 393 ms, the pre-ejection period at 70 /min
constexpr double valve_closes_share = 0.955; // then the flow reverses briefly, which makes the notch
constexpr double backflow_share = 0.02;      // of the stroke

double bell(double at_ms, double width_ms)
{
    const double z = at_ms / width_ms;
    return std::exp(-0.5 * z * z);
}

double filled_share(double filling_ms)
{
    constexpr double usual_ms = 470.0;
    return (1.0 - std::exp(-filling_ms / filling_constant_ms)) /
           (1.0 - std::exp(-usual_ms / filling_constant_ms));
}

} // namespace

double ecg_mV(double phase, double beat_ms, double interval_ms, std::uint8_t bits)
{
    const double to_next_ms = interval_ms - beat_ms;
    double mV = 0.0;
    if ((bits & (CRN_WIRE_RHYTHM_NEXT_PREMATURE | CRN_WIRE_RHYTHM_IS_RESTING)) == 0 &&
        (bits & CRN_WIRE_RHYTHM_WANTS_ASYSTOLE) == 0)
        mV += 0.14 * bell(to_next_ms - 118.0, 20.0); // P
    if ((bits & CRN_WIRE_RHYTHM_IS_RESTING) != 0) return mV;
    // The T wave peaks at four fifths of systole and ends soon after systole.
    const double t = bell(phase / phase_systole_end - 0.8, 0.105);
    if ((bits & CRN_WIRE_RHYTHM_IS_PREMATURE) != 0)
        return mV + 1.5 * bell(beat_ms - 62.0, 24.0) - 0.5 * bell(beat_ms - 128.0, 26.0) - 0.42 * t;
    return mV - 0.12 * bell(beat_ms - 12.0, 6.0) + 1.25 * bell(beat_ms - 36.0, 9.0) -
           0.28 * bell(beat_ms - 60.0, 8.0) + 0.30 * t;
}

// The flow out of the ventricle follows the curve s^a (1-s)^b of the fraction s of the ejection time, scaled
// to the area 1: it rises fast and falls slowly, like the flow in the aortic root.
double ejection_shape(double share)
{
    if (share <= valve_opens_share || share >= valve_closes_share) return 0.0;
    const double s = (share - valve_opens_share) / (valve_closes_share - valve_opens_share);
    return 20.0 * s * (1.0 - s) * (1.0 - s) * (1.0 - s); // beta function B(2,4) = 1/20
}

double PulseMonitor::ejection_ml_per_s(const crn_wire_tick_state &state) const
{
    const double phase = phase_of(state.heart_phase32);
    if ((state.rhythm_bits & CRN_WIRE_RHYTHM_IS_RESTING) != 0 || phase >= phase_systole_end) return 0.0;
    const double share = phase / phase_systole_end;
    const double stroke = stroke_ml * filled_share(filling_ms_);
    const double ejection_s = systole_ms_ * 1e-3 * (valve_closes_share - valve_opens_share);
    const double back_s = systole_ms_ * 1e-3 * (1.0 - valve_closes_share);
    if (share >= valve_closes_share) return -stroke * backflow_share / back_s;
    return stroke * (1.0 + backflow_share) * ejection_shape(share) / ejection_s;
}

void PulseMonitor::begin_beat(const crn_wire_tick_state &state)
{
    beats_++;
    premature_beats_ += (state.rhythm_bits & CRN_WIRE_RHYTHM_IS_PREMATURE) != 0;
    if (beat_ms_ < 1e6) {
        filling_ms_ = std::max(beat_ms_ - systole_ms_, 0.0);
        intervals_ms_[interval_count_++ % intervals_ms_.size()] = beat_ms_ + 1.0;
        systolic_mmHg_ = highest_mmHg_;
        diastolic_mmHg_ = lowest_mmHg_;
    }
    highest_mmHg_ = 0.0;
    lowest_mmHg_ = 1e9;
}

void PulseMonitor::tick(const crn_wire_tick_state &state)
{
    advance(state);
    show(aortic_mmHg_);
}

void PulseMonitor::advance(const crn_wire_tick_state &state)
{
    if (state.beat_ms < beat_ms_) begin_beat(state);
    beat_ms_ = state.beat_ms;
    bits_ = state.rhythm_bits;
    const double phase = phase_of(state.heart_phase32);
    if (state.beat_ms >= 1 && phase > 0.0 && phase < phase_systole_end)
        systole_ms_ = state.beat_ms * phase_systole_end / phase;
    const double flow = ejection_ml_per_s(state);
    const double run_off = (stored_mmHg_ - venous_mmHg) / resistance_mmHg_s_ml;
    stored_mmHg_ += (flow - run_off) / compliance_ml_mmHg * tick_s;
    aortic_mmHg_ = stored_mmHg_ + impedance_mmHg_s_ml * flow;
    if (ticks_ % sample_ticks == 0)
        ecg_mV_ = ecg_mV(phase, state.beat_ms, state.interval_ms, state.rhythm_bits);
}

void PulseMonitor::show(double measured_mmHg)
{
    highest_mmHg_ = std::max(highest_mmHg_, measured_mmHg);
    lowest_mmHg_ = std::min(lowest_mmHg_, measured_mmHg);
    if (ticks_++ % sample_ticks != 0) return;
    newest_ = (newest_ + 1) % sample_count;
    samples_[newest_] = {static_cast<float>(ecg_mV_), static_cast<float>(measured_mmHg)};
}

void PulseMonitor::archive(StateArchive &state)
{
    for (Sample &sample : samples_)
        for (float *value : {&sample.ecg_mV, &sample.pressure_mmHg}) state.real(*value, -1e6, 1e6);
    state.index(newest_, sample_count);
    for (std::uint32_t *count : {&ticks_, &beats_, &premature_beats_}) state.integer(*count);
    state.integer(bits_);
    for (double *value : {&ecg_mV_, &beat_ms_, &filling_ms_, &systole_ms_, &stored_mmHg_, &aortic_mmHg_,
                          &highest_mmHg_, &lowest_mmHg_, &systolic_mmHg_, &diastolic_mmHg_})
        state.real(*value);
    state.reals(intervals_ms_);
    state.index(interval_count_, std::size_t{1} << 40);
}

double PulseMonitor::rate_per_min() const
{
    const std::size_t count = std::min(interval_count_, intervals_ms_.size());
    if (count == 0 || beat_ms_ > 3000.0) return 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < count; i++) sum += intervals_ms_[i];
    return 60e3 * static_cast<double>(count) / sum;
}

} // namespace crn
