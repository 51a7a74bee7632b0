// Computes the traces of a heart monitor, electrocardiogram and aortic pressure, from the beats that the core
// reports tick by tick.
//
// The electrocardiogram is a sum of bell curves at given phases of the beat: the P wave before the QRS, the T
// wave at the end of systole. In the electrocardiogram, a premature beat is wide, has no P wave, and has an
// inverted T wave. A two-element windkessel with a characteristic impedance, into which each systole ejects,
// gives the pressure. A ventricle that is less filled ejects less blood (docs/heart.md, "traces").
#pragma once
#include "host/base/state_archive.hpp"
#include "shared/wire/wire.h"
#include <array>
#include <cstdint>

namespace crn
{

// The aortic valve closes when 10 / 24 of the heart's cycle have passed.
inline constexpr double phase_systole_end = 10.0 / 24.0;

inline double phase_of(std::uint32_t phase32)
{
    return phase32 * 0x1p-32;
}

// Lead II, mV. `beat_ms` counts since the QRS, `interval_ms` is the time between it and the next one, `bits`
// are CRN_WIRE_RHYTHM_*.
double ecg_mV(double phase, double beat_ms, double interval_ms, std::uint8_t bits);

// Returns the flow out of the ventricle at the fraction `share`, 0 .. 1, of systole. The curve of this flow
// has area 1 over the ejection, and is 0 while the valve is shut.
double ejection_shape(double share);

class PulseMonitor
{
  public:
    static constexpr std::uint32_t sample_ticks = 5;
    static constexpr std::size_t sample_count = 800; // 4 s
    struct Sample {
        float ecg_mV = 0.0f, pressure_mmHg = 0.0f;
    };

    // Receives every tick. After a call of tick(), the curve shows the aortic pressure.
    void tick(const crn_wire_tick_state &state);
    // The next two functions together do the same as tick(), for a curve that shows the pressure of another
    // transducer. The function advance() computes the aortic pressure, and show() receives the measured
    // pressure of the same tick.
    void advance(const crn_wire_tick_state &state);
    void show(double measured_mmHg);

    double pressure_mmHg() const { return aortic_mmHg_; } // in the aorta
    // The next functions return figures of the last complete beat. The systolic and diastolic pressures are
    // those of the displayed curve.
    double systolic_mmHg() const { return systolic_mmHg_; }
    double diastolic_mmHg() const { return diastolic_mmHg_; }
    // Returns the heart rate per minute: 60 000 divided by the mean of the last four intervals in ms; 0 after
    // 3 s without a beat.
    double rate_per_min() const;
    std::uint32_t beats() const { return beats_; }
    std::uint32_t premature_beats() const { return premature_beats_; }
    bool holds_breath() const { return (bits_ & CRN_WIRE_RHYTHM_HOLDS_BREATH) != 0; }

    // Returns the last 4 s of both curves as a monitor draws them: new samples overwrite old ones from left
    // to right. `newest` is the index of the newest sample.
    const std::array<Sample, sample_count> &samples() const { return samples_; }
    std::size_t newest() const { return newest_; }
    bool has_samples() const { return ticks_ > 0; }
    bool is_full() const { return ticks_ >= sample_ticks * sample_count; }

    void archive(StateArchive &state);

  private:
    void begin_beat(const crn_wire_tick_state &state);
    double ejection_ml_per_s(const crn_wire_tick_state &state) const;

    std::array<Sample, sample_count> samples_{};
    std::size_t newest_ = sample_count - 1; // so that the first sample is written to the left edge
    std::uint32_t ticks_ = 0, beats_ = 0, premature_beats_ = 0;
    double ecg_mV_ = 0.0;
    std::uint8_t bits_ = 0;
    double beat_ms_ = 1e9, filling_ms_ = 500.0; // length of the diastole before this beat
    double systole_ms_ = 390.0;
    std::array<double, 4> intervals_ms_{};
    std::size_t interval_count_ = 0;
    double stored_mmHg_ = 84.0,
           aortic_mmHg_ = 84.0; // in the windkessel alone, and with the part of the impedance
    double highest_mmHg_ = 0.0, lowest_mmHg_ = 1e9, systolic_mmHg_ = 0.0, diastolic_mmHg_ = 0.0;
};

} // namespace crn
