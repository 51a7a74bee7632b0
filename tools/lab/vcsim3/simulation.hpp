// Simulates one rod of the thesis' kind, which the hand pushes into a vessel. The class defines the order of
// the phases within a time step, and measures the time of each phase.
//   Cosserat     elastic forces and torques
//   Integrator   velocities, later positions and orientations
//   Collisions   depth of every point in the wall
//   Constraints  N times: distances, then contact and friction
#pragma once
#include "tools/lab/vcsim3/collision.hpp"
#include "tools/lab/vcsim3/constraints.hpp"
#include "tools/lab/vcsim3/inserter.hpp"
#include <string>

namespace vcsim3
{

// The method that keeps lengths.
struct Mode {
    enum class Kind { global, penalty, local };
    Kind kind = Kind::global;
    int iterations = 1; // of the local method

    std::string name() const;  // as in the thesis' figures: "1 Global", "25 Local"
    std::string token() const; // for command lines and files: "global", "local25"
};
bool operator==(const Mode &a, const Mode &b);

// Parses the short name of a mode; returns false for an unknown name. For the mode "local", the number of
// iterations in the name must be 1 .. 10000.
bool parse_mode(const std::string &token, Mode &mode);

// Returns the nine modes that Figures 5.11 to 5.14 show, in the order of the thesis.
const std::vector<Mode> &thesis_modes();

struct PhaseTimes {
    double integrator_s = 0.0, constraints_s = 0.0, cosserat_s = 0.0, collisions_s = 0.0;
    double total_s() const { return integrator_s + constraints_s + cosserat_s + collisions_s; }
};

struct SimulationSettings {
    Mode mode;
    DistanceSettings distance;
    int substeps = 1; // steps per millisecond tick
};

class Simulation
{
  public:
    Simulation(const RodProperties &properties, const Inserter &inserter, const Wall &wall,
               const SimulationSettings &settings, double inserted_m);

    // Simulates one millisecond at constant speed, in which the hand pushes the rod in by `feed_m` and turns
    // it by `turn_rad` (right-handed about the direction of insertion).
    void tick(double feed_m, double turn_rad = 0.0);

    // Simulates one step of 1 ms / substeps while the hand stands still; unless `times` is null, adds the
    // durations of the phases to it.
    void step(PhaseTimes *times);

    const Rod &rod() const { return rod_; }
    double inserted_m() const { return inserted_m_; }
    double turn_rad() const { return turn_rad_; }
    double step_s() const { return step_s_; }
    double handle_axial_N() const; // of the last step, + pushes the hand back out; noisy, so take a mean
    double handle_axial_mean_N() const { return handle_mean_N_; } // over the steps of the last tick

    // The following functions convert the state of the rod to numbers and back. The function restore()
    // returns false when the numbers belong to a rod with another number of elements.
    std::vector<double> save() const;
    bool restore(const std::vector<double> &numbers);
    const std::vector<Contact> &contacts() const { return contacts_; } // of the last step
    const SimulationSettings &settings() const { return settings_; }

  private:
    void hold_lengths();

    SimulationSettings settings_;
    Inserter inserter_;
    Wall wall_;
    Rod rod_;
    DistanceConstraints distances_;
    std::vector<Contact> contacts_;
    double inserted_m_, step_s_;
    double turn_rad_ = 0.0, handle_mean_N_ = 0.0;
};

} // namespace vcsim3
