// Computes what drives the blood flow at a moment of the heartbeat: the pressure at the inlet, and the
// openness of the vascular beds behind the outlets. The part of the program that controls the heart rhythm
// supplies the phase of the beat; steady_beat() supplies the phase of a heart that beats regularly. The
// computation uses no libm, so that every machine gives results that are equal bit for bit. See
// docs/contrast.md.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <array>
#include <cstddef>
#include <cstdint>

namespace crn
{

inline constexpr double mean_pressure_mmHg = 88.0; // aorta less veins

// Describes a moment within a heartbeat, which begins when the aortic valve opens.
struct BeatPhase {
    double since_opening_s = 0.0; // 0 .. beat_s
    double systole_s = 0.294;     // valve open
    double beat_s = 60.0 / 70.0;
    bool is_beating = true; // false: asystole, no flow
};

struct FlowDrive {
    double pressure_mmHg = mean_pressure_mmHg; // at the inlet above the veins
    // Of an aorta that begins at the heart: the pressure that stretches it, divided by its mean, and whether
    // the heart ejects.
    double aortic_pressure = 1.0;
    bool is_valve_open = true;
    // Holds the conductances of the vascular beds behind the outlets, divided by their means over the beat;
    // the index is the kind of vascular bed (VesselBed).
    std::array<double, vessel_bed_count> openness = {1.0, 1.0, 1.0, 1.0, 1.0};

    double of(VesselBed bed) const { return openness[static_cast<std::size_t>(bed)]; }
};

FlowDrive flow_drive(const BeatPhase &phase);

// The arteries as a windkessel: 1.05 mmHg s/ml times 1.35 ml/mmHg, as in the trace of the aortic pressure
// (pulse.hpp). The small arteries behind the outlets store a part of it themselves; this part is assumed.
inline constexpr double windkessel_s = 1.05 * 1.35, windkessel_beyond_s = 0.4;

// Returns the pressure in a windkessel of a regular heartbeat, divided by its mean, and its change per
// second.
struct WindkesselPressure {
    double pressure = 1.0, per_s = 0.0;
};
WindkesselPressure windkessel_pressure(double since_opening_s, double systole_s, double beat_s);

// Returns the phase of the core's own heartbeat (docs/heart.md) from the state of a tick. Systole begins with
// the QRS and lasts 540 ms - 2.1 ms x heart rate (in beats per minute). The aortic valve opens after 24 % of
// systole and closes at its end. During asystole (`is_resting`) there is no flow.
BeatPhase core_beat(double beat_ms, double interval_ms, bool is_resting);

// Returns the phase of a regular heartbeat that starts at tick 0 and has 20 .. 250 beats per minute. The
// heart model assumes that ejection lasts 413 ms - 1.7 ms x heart rate (in beats per minute), as in men
// (Weissler et al., Circulation 37 (1968) 149).
BeatPhase steady_beat(std::uint32_t tick, double beats_per_min);

} // namespace crn
