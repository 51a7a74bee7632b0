// Repeats the compression experiment of section 5.4.2 of the thesis. The hand pushes a rod into the phantom
// until its tip is at the closed end and further pushing has compressed it. At the end, the length of the
// compressed rod is compared with its unloaded length. All solvers (the modes of the thesis' rod, and our
// direct solver) simulate the same rod, vessel and motion of the hand.
#pragma once
#include "tools/lab/vcsim3/direct.hpp"
#include "tools/lab/vcsim3/preset.hpp"
#include "tools/lab/vcsim3/simulation.hpp"
#include <functional>
#include <memory>
#include <string>

namespace vcsim3
{

struct Protocol {
    int element_count = 256; // all of them in the vessel at the end
    double element_m = preset_element_m;
    double start_m = 0.02;   // inserted when the hand begins to move
    double speed_m_s = 0.05; // of the hand
    double hold_s = 0.5;     // time after that with the hand at rest
    double average_s = 0.1;  // figures are means over this time

    double goal_m() const { return element_count * element_m; }
    int push_ticks() const;
    int hold_ticks() const;
};

struct ShapeNode {
    Vector position_m;
    bool is_touching; // true if it touched at some tick of the last average_s of the hold
};

// Positive percentages are compression. If a rod has become unstable, is_sound is false and the other values
// of the result are meaningless. A rod counts as unstable if a coordinate is not finite or is more than half
// a metre away from the first node that the hand holds. A rod also counts as unstable if the error of its
// length exceeds 50 % of its length.
struct CompressionResult {
    std::string name, token; // "25 Local", "local25"; "Direct", "direct"
    bool is_sound = true;
    double pushing_pct = 0.0;        // at the end of the push: Figure 5.11
    double holding_pct = 0.0;        // at the end of the hold
    double largest_pct = 0.0;        // at any tick
    double handle_N = 0.0;           // pushing, at the end
    double depth_max_mm = 0.0;       // of any node in the wall, at the end of any tick
    int contacts = 0;                // touching nodes of the shape
    std::vector<ShapeNode> shape;    // tip first, at the end of the hold
    std::vector<std::uint8_t> state; // state at the same moment, for timing: begin_at() or DirectRod::restore
};

// The program calls a Watch after each tick, with the completed fraction of the run. If the Watch returns
// false, the run stops and throws Interrupted.
using Watch = std::function<bool(double)>;
struct Interrupted : std::exception {
    const char *what() const noexcept override { return "interrupted"; }
};

// Returns the rod's properties for our solver: stiffness, radius and friction of the preset, the mass of a
// real wire, and zero weight as in the baseline.
DirectProperties direct_of(const Preset &preset, const Protocol &protocol);
inline constexpr double direct_mass_kg_per_m = 0.005;

Simulation make_simulation(const Preset &preset, const Mode &mode, const Vessel &vessel,
                           const Protocol &protocol);
DirectRod make_direct(const Preset &preset, const Vessel &vessel, const Protocol &protocol);

CompressionResult compress_baseline(const Preset &preset, const Mode &mode, const Vessel &vessel,
                                    const Protocol &protocol, const Watch &watch);
CompressionResult compress_direct(const Preset &preset, const Vessel &vessel, const Protocol &protocol,
                                  const Watch &watch);

// Converts the state of a simulation, which is a list of numbers, to bytes and back, for
// CompressionResult::state.
std::vector<std::uint8_t> to_bytes(const std::vector<double> &numbers);
std::vector<double> to_numbers(const std::vector<std::uint8_t> &bytes);

} // namespace vcsim3
