// Carries contrast medium beyond the lumen: through small vessels, capillary beds and veins
// (docs/contrast.md).
//
//   DistalFlow distal(tree, cells);
//   distal.take(cell, mg);            // medium that has left the lumen at this cell, in this millisecond
//   distal.pass(cell, ml);            // and the blood
//   distal.step();                    // once a millisecond
//   distal.piece_mg_per_ml(vessel, piece);
//
// The resistance of small vessels counts as part of their bed's, so that the flow divides among them in fixed
// proportions. An artery that joins another one, as in the circle of Willis, passes on its stated share.
// Each piece of a small vessel is one well-mixed volume, and a bed is a few of them in series.
// All volumes are advanced together every few milliseconds, by an implicit step that never makes iodine
// negative.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/flow_cells.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// Describes a kind of tissue: how long blood stays in its capillaries and small veins on average, and how
// many well-mixed volumes in series represent them.
struct BedTransit {
    double mean_s;
    int volumes;
};
BedTransit bed_transit(VesselBed bed);

// Iodine beyond the lumen, mg.
struct DistalIodine {
    double entered_mg = 0.0; // since the beginning
    double small_mg = 0.0, beds_mg = 0.0, veins_mg = 0.0;
    double gone_mg = 0.0; // out of the veins since the beginning
};

class DistalFlow
{
  public:
    static constexpr int step_ms = 8; // milliseconds that are advanced together

    DistalFlow() = default;
    DistalFlow(const VesselTree &tree, const FlowCells &cells);

    void take(std::size_t cell, double mg) { waiting_mg_[outlet_of_cell_[cell]] += mg; }
    void pass(std::size_t cell, double ml) { waiting_ml_[outlet_of_cell_[cell]] += ml; }
    void step();

    // Concentration in the piece of a small vessel between its points `piece` and piece + 1, in mg/ml.
    double piece_mg_per_ml(std::size_t vessel, std::size_t piece) const;
    // The beds behind the ends of the vessels.
    struct Bed {
        int vessel = 0; // numbered as parents in VesselTree; the bed lies behind its last point
        VesselBed kind = VesselBed::systemic;
    };
    const std::vector<Bed> &beds() const { return beds_; }
    double bed_mg(std::size_t bed) const;

    double visible_mg() const; // in vessels, and in the beds of organs; not in systemic beds
    DistalIodine iodine() const;
    double held_mg() const;

    void archive(StateArchive &state);

  private:
    struct Outlet {
        double mean_ml_s = 0.0;         // out of the lumen at this cell
        std::size_t first = 0, end = 0; // volumes of the small arteries and beds behind it
    };
    // A well-mixed volume that is fed by another one, or by the outlet.
    struct Volume {
        int from = -1;       // -1: the outlet
        double split = 1.0;  // its share of what leaves `from`
        double per_ml = 0.0; // 1 / volume
        int vein = -1;       // of the last volume of a bed: vein piece into which it drains; -1: gone
        bool is_last = false;
    };
    struct VeinPiece {
        int to = -1; // piece towards the heart; -1: blood leaves there
        double volume_ml = 0.0;
    };
    // The last volume of an artery that joins another one, and the volume that its blood enters. The blood
    // enters with the next advance, so that volumes need no other order than by their outlets.
    struct Joint {
        std::size_t from = 0, to = 0;
        double ml = 0.0, mg = 0.0; // on the way
    };
    class Builder;

    void advance_arteries();
    void advance_veins();

    std::vector<std::uint32_t> outlet_of_cell_;
    std::vector<Outlet> outlets_;
    std::vector<Volume> volumes_;
    std::vector<Joint> joints_;
    std::vector<double> piece_ml_; // volumes of the pieces of small arteries
    std::vector<Bed> beds_;
    std::vector<std::size_t> bed_first_, bed_end_;
    std::vector<int> first_piece_; // of each small vessel, in volumes_ or, for a vein, in veins_
    std::vector<std::uint8_t> is_vein_;
    std::vector<VeinPiece> veins_;
    std::vector<double> waiting_mg_, waiting_ml_; // of outlets, since the last advance
    std::vector<double> mg_, vein_mg_;
    int waited_ms_ = 0;
    double entered_mg_ = 0.0, gone_mg_ = 0.0;
    // Working memory: what leaves a volume, and what comes into it through joints; what comes into veins.
    std::vector<double> out_mg_, out_ml_, joined_mg_, joined_ml_, vein_in_mg_, vein_in_ml_;
};

} // namespace crn
