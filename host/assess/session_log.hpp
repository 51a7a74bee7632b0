// Holds the data from which a session is assessed. Every 16 ticks there is one entry (a moment) with the
// places of tips and hands, the X-ray, the syringe, the balloon, the stents and the wall forces. A moment
// depends only on the session's inputs and on its tick, so a replay of a recording gives equal moments.
#pragma once
#include "host/model/vessel_map.hpp"
#include "host/xray/run.hpp"
#include "shared/wire/wire.h"
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Holds the state of one tool at one moment. Lengths are in millimetres.
struct ToolMoment {
    double inserted_mm = 0.0;  // beyond the introducer sheath
    double turned_deg = 0.0;   // by the hand, since the start
    double hand_force_N = 0.0; // on the hand, + pushes back out
    double ahead_mm = 0.0;     // of the innermost tool's tip, along the line; negative: behind it
    bool has_place = false;    // whether the place in the vessels is known
    std::size_t vessel = 0;    // of the map
    double inside_mm = 0.0;    // depth inside that vessel, from where the tools enter it
    double lumen_share = 0.0;  // diameter of the tool over the diameter of the lumen, at the tip
    bool has_tip = false;      // whether the shape of the tools is known
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero(); // without the motion of heart and breath
    double right_px = 0.0, down_px = 0.0; // place in a picture of picture_px pixels, from its upper left
    bool is_in_picture = false;           // inside the part of the detector that the blades leave open
};

struct SessionMoment {
    std::uint32_t tick = 0;
    std::array<ToolMoment, CRN_WIRE_TOOL_MAX> tools{};
    bool has_wire = true;                          // a wire is on the line
    bool is_xray_on = false, is_acquiring = false; // fluoroscopy or a run; a run (cine or DSA)
    bool is_gantry_moving = false;
    double fluoroscopy_s = 0.0, kap_Gy_cm2 = 0.0; // since the start
    double injected_ml = 0.0;                     // since the start
    bool is_injecting = false;
    bool is_pressure_damped = false; // at the tip of the catheter (CatheterPressure)
    int unaspirated_injections = 0;  // through a lumen that might hold air (CatheterAir), since the start
    int runs = 0, filled_runs = 0, empty_runs = 0; // that have ended; with and without contrast medium
    double balloon_bar = 0.0, balloon_mm = 0.0;    // pressure and largest diameter
    bool is_balloon_burst = false;
    double balloon_beyond_stent_mm = 0.0; // by which the balloon reaches beyond every deployed stent
    int stents_loaded = 0, stents_deployed = 0, stents_lost = 0;
    double lesion_open_pct =
        0.0;             // of the lesions that yield, where they opened most: 0 as baked, 100 healthy
    double wall_N = 0.0; // sum of all contact forces
    int perforations = 0, dissections = 0; // of vessels, since the start
    double blood_loss_ml = 0.0;            // through their walls
};

struct SessionLog {
    static constexpr std::uint32_t every_ticks = 16;
    static constexpr double seconds_per_moment = every_ticks * 1e-3;
    static constexpr int picture_px = 512; // pixels along the edge of the picture in which tips are tracked

    VesselMap map;
    std::vector<std::string> tools;        // names at each position, from the innermost: "A", or "A, then B"
    std::optional<double> rated_burst_bar; // empty: no tool has a balloon, or its label does not state it
    bool has_balloon = false, has_stents = false, has_lesions = false;
    bool has_transducer = false; // a tool has a lumen in which the pressure is measured
    bool has_contacts = false;   // the forces of the walls are known
    std::vector<SessionMoment> moments;
    std::uint32_t ticks = 0; // of the whole session
};

} // namespace crn
