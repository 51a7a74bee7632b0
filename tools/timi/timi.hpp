// Counts cine frames in a coronary tree as Gibson et al. did (Circulation 1996;93:879): from the frame in
// which medium touches both borders of the artery's beginning to the frame in which it first reaches a
// landmark at the end.
#pragma once
#include "host/effects/contrast_flow.hpp"
#include <string>
#include <vector>

namespace anatomy
{

struct TimiArtery {
    std::string name;       // as Gibson calls it
    std::string ostium;     // branch in which the catheter's tip lies, tip_mm behind its beginning
    std::string landmark;   // branch of the last mark
    double landmark_share;  // of the branch's length
    double ml, ml_s;        // the hand's injection (Dodge 1998)
    double mean, deviation; // published frames at 30 frames/s, of 78 normal arteries
};
const std::vector<TimiArtery> &timi_arteries();

struct TimiCase {
    double rate_per_min = 70.0;
    double start_share = 0.0; // of the beat, at which the injection begins; 0: the valve opens
    double speed = 1.0;       // of the injection, times the artery's usual one
    double flow = 1.0;        // of the beds' openness: above 1 with hyperaemia
};

// Returns the frames between the marks at 30 frames/s, to a hundredth; -1 if the medium does not come within
// 6 s.
double timi_frames(const crn::VesselTree &tree, const TimiArtery &artery, const TimiCase &circumstances);

// Returns the mean over injections that begin at four phases of the beat, as in a series of patients; the
// entry `start_share` is not used.
double timi_mean_frames(const crn::VesselTree &tree, const TimiArtery &artery, TimiCase circumstances);

// Returns the seconds from the frame in which medium touches both borders of the left main artery to the
// moment at which the middle of the coronary sinus has a tenth of undiluted medium; -1 if this takes over 10
// s.
double coronary_sinus_s(const crn::VesselTree &tree);

} // namespace anatomy
