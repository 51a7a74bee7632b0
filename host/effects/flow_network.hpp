// Computes the blood flow in the cells of a tree of vessels at one moment. The inputs are the pressure at the
// inlet, the conductances behind the outlets, the injected fluid, and the resistance of every cell by
// Poiseuille's law. A tool that lies in a cell raises the cell's flow resistance. The equations are linear:
// an elimination from the outlets to the inlet, and a pass back to the outlets, solve them exactly.
// Consecutive cells form one resistance, so that the cost depends only on the number of points where flow
// divides.
#pragma once
#include "host/effects/beat.hpp"
#include "host/effects/flow_cells.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// Returns the conductance of a round tube with a concentric round rod in it, divided by that of the empty
// tube; k is the rod's radius divided by the tube's radius. If a guidewire of radius k times the lumen's
// radius lies in the lumen, the remaining fraction of the conductance is 1 - k^4 - (1 - k^2)^2 / ln(1/k), and
// 0 from k = 0.98 on (Bird, Stewart, Lightfoot, Transport Phenomena, flow through an annulus).
double annulus_share(double share);

struct CellSource {
    std::size_t cell = 0;
    double flow_ml_s = 0.0;
};

// Describes a hole in the wall of a cell through which blood leaves the vessels: its flow is the conductance
// times the pressure above the veins, because the tissue around the vessel has the veins' pressure.
struct CellHole {
    std::size_t cell = 0;
    double ml_s_per_mmHg = 0.0;

    bool operator==(const CellHole &) const = default;
};

// Describes consecutive cells of a vessel with no source or outlet between them, so that the same flow passes
// through all of them.
struct FlowRun {
    std::size_t begin = 0, end = 0; // cells
    int upstream = -1;              // the run whose last cell feeds the first cell of this one; -1: the inlet
    double smallest_ml = 0.0;       // of its cells
};

class FlowNetwork
{
  public:
    FlowNetwork() = default;
    FlowNetwork(const FlowCells &cells, double viscosity_mPa_s);

    // Adopts the shape of the vessels after a balloon has widened lesions: the cells stay the same, but their
    // radii change. `tool_radius_mm` is as in set_tools.
    void reshape(const FlowCells &cells, std::span<const double> tool_radius_mm);
    void set_volumes(std::span<const double> volume_ml); // of the cells
    // Sets the radius of the thickest tool in each cell, in mm; 0 means that the cell contains no tool.
    void set_tools(std::span<const double> tool_radius_mm);
    // Sets the holes in the wall, and the share of each cell's radius that flaps leave open; an empty list of
    // shares means that no cell is narrowed. `tool_radius_mm` is as in set_tools.
    void set_wounds(std::span<const CellHole> holes, std::span<const double> open_share,
                    std::span<const double> tool_radius_mm);
    // If `is_inlet_shut`, no blood passes the inlet, and the sources alone drive the flow.
    void solve(const FlowDrive &drive, std::span<const CellSource> sources, bool is_inlet_shut = false);
    // Repeats the solution until the flows through the stenoses agree with the stenoses' resistances, which
    // depend on these flows.
    void settle(const FlowDrive &drive);

    // Returns the runs (rows of consecutive cells) of the last solution. Every cell is in one run of cells.
    // In the list, a run of cells comes after the run from which it receives its blood. The last cell of a
    // run has an outlet, receives injected fluid, or supplies a cell other than the next one in the list.
    const std::vector<FlowRun> &runs() const { return runs_; }
    std::size_t run_of(std::size_t cell) const { return run_of_[cell]; }
    // The next functions return flows in ml/s: the flow from upstream into the run (negative: out of the
    // run), the flow from its last cell out of the vessels, and the parts of it that leave through holes in
    // the wall and into the vascular bed.
    double inflow_ml_s(std::size_t run) const { return flows_[run].in_ml_s; }
    double outflow_ml_s(std::size_t run) const { return flows_[run].out_ml_s; }
    double leak_ml_s(std::size_t run) const { return flows_[run].leak_ml_s; }
    double bed_ml_s(std::size_t run) const { return flows_[run].out_ml_s - flows_[run].leak_ml_s; }

    double pressure_mmHg(std::size_t cell) const; // above the veins

    // Returns the flows through the stenoses, in ml/s, which determine the stenoses' resistance. The flows
    // through the stenoses are the only stored state on which the next solution depends; all other inputs are
    // arguments.
    const std::vector<double> &throat_flows_ml_s() const { return throat_flows_; }
    void set_throat_flows(std::span<const double> flows_ml_s); // as many as there are stenoses

  private:
    struct Flow {
        double in_ml_s = 0.0, out_ml_s = 0.0, leak_ml_s = 0.0;
    };
    struct Row {                  // of the elimination, at a run's last cell
        double conductance = 0.0; // of everything behind it, seen from the cell
        double source = 0.0;
        double open_way = 0.0,
               way = 0.0; // conductance from the last cell of the run upstream, without and with stenoses
        double pressure_mmHg = 0.0, injected_ml_s = 0.0;
    };
    double poiseuille(double per_r4_mm3) const;
    void open_beds(const FlowCells &cells);
    void take_shape(const FlowCells &cells);
    double smallest_ml(std::size_t begin, std::size_t end) const;
    void divide(std::span<const CellSource> sources);
    void set_ways();
    void add_throats();

    double viscosity_mPa_s_ = 0.0;
    std::vector<FlowThroat> throats_;
    std::vector<double> throat_loss_,
        throat_flows_; // mmHg per (ml/s)^2 with the tools in it; ml/s
    std::vector<int> upstream_;
    std::vector<double> open_,
        resistance_; // of the path into each cell: conductance without tools, resistance with tools
    std::vector<double> outlet_; // mean conductance behind it
    std::vector<VesselBed> bed_;
    std::vector<double> leak_;       // conductance of the holes in each cell; empty: there are none
    std::vector<double> open_share_; // of each cell's radius; empty: no flap narrows a cell
    std::vector<double> radius_mm_, volume_ml_;
    std::vector<std::uint8_t> ends_run_;    // without sources
    std::vector<std::size_t> source_cells_; // cells at which the runs were divided
    std::vector<FlowRun> runs_;
    std::vector<std::size_t> run_of_; // of each cell
    std::vector<Row> rows_;
    std::vector<Flow> flows_;
};

} // namespace crn
