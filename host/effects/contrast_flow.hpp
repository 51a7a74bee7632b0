// Simulates contrast medium in a tree of vessels, one millisecond per step: docs/contrast.md has the
// equations.
//
//   ContrastFlow contrast(tree);
//   contrast.set_tools(balls);              // tools in the lumen
//   contrast.set_mouths(mouths);            // where fluid leaves the catheter
//   contrast.step(flow_drive(phase), {4.0, 350.0});
//   contrast.iodine_mg_per_ml(cell);
//
// Iodine is conserved: the injected amount equals the amount in the lumen plus the amount that has left it,
// into small vessels and beds (distal()) or back out of the inlet. The result depends only on the inputs of
// the simulation. The computation has a fixed order and uses no libm, so that every machine gives results
// that are equal bit for bit.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/distal_flow.hpp"
#include "host/effects/flow_network.hpp"
#include "host/effects/wounds.hpp"
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crn
{

struct ContrastSettings {
    double viscosity_mPa_s = 3.5; // of blood
    // Blood moves in two layers of equal area, and core_flow_share is the fraction of the flow in the layer
    // around the axis. A core_flow_share of 0.75 means laminar flow (Poiseuille's parabola), and 0.5 means
    // plug flow.
    double core_flow_share = 0.75;
    double mixing_radii = 30.0; // over a distance of so many radii the layers' difference falls to 1/e
};

// Describes an opening through which fluid leaves the catheter, and the fraction of the flow through it; the
// fractions of all openings add up to 1.
struct CatheterMouth {
    Eigen::Vector3d place_m;
    double share = 1.0;
};

// Describes a sphere that represents a tool at one point along its length.
struct ToolBall {
    Eigen::Vector3d place_m;
    double radius_m = 0.0;
};

// Sets the radius of the thickest tool in each cell, in mm; 0 means that the cell contains no tool.
void find_thickest(const FlowCells &cells, std::span<const ToolBall> balls, std::vector<double> &tool_mm);

struct InjectedFluid {
    double flow_ml_s = 0.0;
    double iodine_mg_per_ml = 0.0;
};

// Iodine since the beginning, mg.
struct IodineBudget {
    double injected_mg = 0.0;
    double out_mg = 0.0;    // into the small vessels and beds behind the outlets
    double reflux_mg = 0.0; // back through the inlet
    double leaked_mg = 0.0; // through holes in the wall, into the tissue
};

class ContrastFlow
{
  public:
    explicit ContrastFlow(const VesselTree &tree, const ContrastSettings &settings = {});

    const FlowCells &cells() const { return cells_; }
    void place(const VesselTree &moved) { cells_.place(moved); }
    // Adopts the new shape of the vessels after a balloon has widened lesions (FlowCells::reshape).
    // Resistances change at once. The volumes of cells change within `steps` time steps. A cell that becomes
    // larger takes blood from its neighbours, and a cell that becomes smaller gives blood to them. The
    // exchanged blood has the concentration of the cell that it leaves. If `steps` is 0, every cell gets its
    // new volume at once and keeps its amount of iodine.
    void reshape(const VesselTree &opened, int steps);

    void set_tools(std::span<const ToolBall> balls);
    void set_mouths(std::span<const CatheterMouth> mouths);

    // Advances by one millisecond. Fluid is injected only after set_mouths() has given the catheter's
    // openings.
    void step(const FlowDrive &drive, const InjectedFluid &fluid);

    // The next three functions return concentrations in a cell in mg/ml: the mean, that in the layer around
    // the axis, and that in the layer along the wall.
    double iodine_mg_per_ml(std::size_t cell) const;
    double core_mg_per_ml(std::size_t cell) const { return 2.0 * core_mg_[cell] / volume_ml_[cell]; }
    double wall_mg_per_ml(std::size_t cell) const { return 2.0 * wall_mg_[cell] / volume_ml_[cell]; }
    const FlowNetwork &network() const { return network_; }
    const DistalFlow &distal() const { return distal_; } // small vessels, beds and veins
    // Iodine that has flowed back out of a coronary artery and still lies in the sinus of the aorta before
    // its ostium, mg.
    double sinus_mg(std::size_t branch) const { return sinus_mg_[branch]; }

    // Injures the vessels: adds a hole or a flap, or changes the one with this index. From then on, blood
    // leaves through the holes, and flaps narrow the lumen and hold medium.
    void set_hole(std::size_t index, const WallHole &hole);
    void set_flap(std::size_t index, const WallFlap &flap);
    const Wounds &wounds() const { return wounds_; }
    // Lets the resistances follow holes that close; the caller decides at which ticks.
    void take_wounds();

    double held_mg() const; // in the lumen, with the sinuses and the pockets behind flaps
    const IodineBudget &budget() const { return budget_; }
    // Returns for each branch the amount of contrast medium that entered the branch and did not flow back.
    // Contrast medium may be injected into the branch, or come from the vessel upstream or from a branch
    // downstream. If a branch passes contrast medium on to its side branches, this medium counts
    // both for the branch and for the side branches.
    std::vector<double> received_mg() const;

    // Saves or restores the whole state, except the shape of the vessels. If lesions are open, the caller
    // must give the vessels their saved shape before it restores the state. An archive that belongs to other
    // vessels is refused. snapshot() returns the same state as bytes; restore() changes nothing if it refuses
    // the bytes.
    void archive(StateArchive &state);
    std::vector<std::uint8_t> snapshot() const;
    bool restore(std::span<const std::uint8_t> bytes);

  private:
    void take_volumes();
    void find_stretch(const VesselTree &tree);
    double wanted_ml(std::size_t cell) const;
    void find_widening();
    void widen(double dt_s);
    void end_widening();
    double parts_of_step();
    void transport(double dt_s, const InjectedFluid &fluid);
    void carry(double share_s, std::vector<double> &layer_mg);
    void mix(double dt_s);
    void empty_sinuses(double dt_s);

    ContrastSettings settings_;
    FlowCells cells_;
    FlowNetwork network_;
    DistalFlow distal_;
    std::vector<double> volume_ml_; // present volumes of the cells
    int widening_steps_ = 0;        // steps until they equal those of cells_
    // Of the aorta's cells, if it begins at the heart: growth of the volume, in shares of it, while the
    // pressure grows by its mean. The aorta's cells are the first ones.
    std::vector<double> stretch_;
    double aortic_pressure_ = 1.0;   // of this step, divided by its mean
    double mean_ml_s_ = 0.0;         // into such an aorta
    std::vector<double> per_volume_; // 1 / (volume of a layer), 1/ml
    std::vector<double> mixing_;     // mixing rate per flow, 1/ml
    std::vector<double> tool_mm_;    // thickest tool in the cell
    std::vector<CellSource> mouths_; // shares
    std::vector<double> core_mg_, wall_mg_;
    Wounds wounds_;
    std::vector<double> sinus_mg_;        // of each branch
    std::vector<std::uint8_t> has_sinus_; // of each branch: it is a coronary artery that leaves the aorta
    IodineBudget budget_;
    std::vector<double> branch_injected_mg_, branch_out_mg_; // of each branch: into it, and from it into beds
    // The following members are working memory for one time step; the object keeps them so that it does not
    // allocate memory in every step.
    std::vector<CellSource>
        sources_; // cells of `injecting_` that give fluid, then cells that widen or narrow
    std::size_t injecting_ = 0;
    std::vector<double> leaving_, in_mg_, out_mg_; // of runs, into cells, out of runs
    std::vector<double> least_ml_;                 // of cells, while they change
};

} // namespace crn
