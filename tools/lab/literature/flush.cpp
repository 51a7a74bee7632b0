// Injects medium through a pigtail catheter into the aorta, and measures how far it runs against the blood.
#include "host/effects/contrast_flow.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include "tools/lab/literature/experiments.hpp"
#include "tools/lab/literature/heart_flow.hpp"
#include "tools/timi/flow_tree.hpp"

#include <algorithm>

namespace crn::literature
{

namespace
{

constexpr double iodine_mg_per_ml = 350, seen_share = 0.1; // of undiluted medium
constexpr double end_hole_share = 0.23, holes = 10, first_hole_mm = 5, between_holes_mm = 2.7;

// The end of the shipped pigtail lies at the diaphragm, and its side holes below the loop (docs/contrast.md).
std::vector<CatheterMouth> pigtail(const FlowCells &cells, std::size_t aorta, double place_mm)
{
    const auto cell_at = [&](double mm) {
        std::size_t cell = cells.branch_begin(aorta);
        for (double behind = cells[cell].length_mm; behind < mm; behind += cells[++cell].length_mm) {
        }
        return cell;
    };
    std::vector<CatheterMouth> mouths{{cells.middle_m(cell_at(place_mm)), end_hole_share}};
    for (int k = 0; k < int(holes); k++)
        mouths.push_back({cells.middle_m(cell_at(place_mm + first_hole_mm + k * between_holes_mm)),
                          (1 - end_hole_share) / holes});
    return mouths;
}

// The largest distance above the catheter that medium reaches during two seconds, from injections that begin
// at four phases of the beat.
double reach_mm(const VesselTree &tree, double ml_s)
{
    constexpr double rate_per_min = 70, place_mm = 300; // from the valve along the aorta
    constexpr std::uint32_t injected_ms = 2000;
    const std::size_t aorta = branch_named(tree, "aorta");
    double farthest = 0;
    for (std::uint32_t phase = 0; phase < 4; phase++) {
        ContrastFlow flow(tree);
        const FlowCells &cells = flow.cells();
        flow.set_mouths(pigtail(cells, aorta, place_mm));
        const auto beat_ms = std::uint32_t(60000 / rate_per_min);
        for (std::uint32_t ms = 0; ms < injected_ms; ms++) {
            flow.step(flow_drive(steady_beat(ms + phase * beat_ms / 4, rate_per_min)),
                      {ml_s, iodine_mg_per_ml});
            double behind = 0;
            for (std::size_t cell = cells.branch_begin(aorta); behind < place_mm; cell++) {
                if (flow.iodine_mg_per_ml(cell) >= seen_share * iodine_mg_per_ml) {
                    farthest = std::max(farthest, place_mm - behind);
                    break;
                }
                behind += cells[cell].length_mm;
            }
        }
    }
    return farthest;
}

Figures upstream_reach()
{
    const VesselTree tree = anatomy::flow_tree(anatomy::shipped_vessels("aorta"));
    return {{{"at_10_ml_s", reach_mm(tree, 10)},
             {"at_15_ml_s", reach_mm(tree, 15)},
             {"at_20_ml_s", reach_mm(tree, 20)}},
            {}};
}

} // namespace

std::vector<Experiment> flush_experiments()
{
    return {{"flush_reach", upstream_reach}};
}

} // namespace crn::literature
