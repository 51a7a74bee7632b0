// Blood flow in the cells of a tree at one moment: Poiseuille's resistance of every cell, narrowed by the tools in it, a
// pressure at the inlet, conductances behind the outlets, and fluid that is injected. Linear, so one elimination from the
// outlets to the inlet and one walk back solve it exactly. Behind the throat of a lesion the jet loses pressure with the square of
// the flow (docs/contrast.md): that resistance is taken from the flows of the solutions before.
// May include: flow_cells, beat. Called by: contrast_flow.
#pragma once
#include "host/effects/beat.hpp"
#include "host/effects/flow_cells.hpp"
#include <span>
#include <vector>

namespace seld
{

// Share of its conductance that a round tube keeps with a round rod of `share` of its radius in its middle, 0 from 0.98 on:
// 1 - k^4 - (1 - k^2)^2 / ln(1/k) (Bird, Stewart, Lightfoot, Transport Phenomena, flow through an annulus).
double annulus_share(double share);

struct CellSource {
    std::size_t cell = 0;
    double flow_ml_s = 0.0;
};

class FlowNetwork
{
  public:
    FlowNetwork() = default;
    FlowNetwork(const FlowCells &cells, double viscosity_mPa_s);

    // Radius of the thickest tool in each cell, mm; 0: none.
    void set_tools(std::span<const double> tool_radius_mm);
    void solve(const FlowDrive &drive, std::span<const CellSource> sources);
    // Solves until the flows through the throats agree with their resistance.
    void settle(const FlowDrive &drive);

    // ml/s: into cell i from the one upstream of it (below 0: out of it), and out of it into the bed behind it.
    const std::vector<double> &inflow_ml_s() const { return inflow_; }
    const std::vector<double> &outflow_ml_s() const { return outflow_; }
    const std::vector<double> &pressure_mmHg() const { return pressure_; } // above the veins

    // The flows on which the throats' resistance rests, ml/s: what the next solution depends on besides its arguments.
    const std::vector<double> &throat_flows_ml_s() const { return throat_flows_; }
    void set_throat_flows(std::span<const double> flows_ml_s); // as many as there are throats

  private:
    void add_throats();

    struct Row {                  // of the elimination
        double conductance = 0.0; // of all behind it, seen from the cell
        double source = 0.0;
    };
    std::vector<FlowThroat> throats_;
    std::vector<double> throat_loss_,
        throat_flows_; // mmHg per (ml/s)^2 with the tools that stand in it; ml/s
    std::vector<int> upstream_;
    std::vector<double> open_, conductance_,
        way_; // of the way into each cell: without tools, with them, with the throats too; ml/s per mmHg
    std::vector<double> outlet_; // mean conductance behind it
    std::vector<VesselBed> bed_;
    std::vector<double> radius_mm_;
    std::vector<Row> rows_;
    std::vector<double> injected_, pressure_, inflow_, outflow_;
};

} // namespace seld
