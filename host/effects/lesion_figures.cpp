#include "host/effects/lesion_figures.hpp"

namespace crn
{
namespace
{

// Returns the cell that lies directly upstream of a lesion, so that blood flows from it into the first cell
// inside the lesion.
std::size_t before(const FlowCells &cells, const VesselLesion &lesion, const FlowThroat &throat)
{
    std::size_t first = cells.branch_begin(lesion.branch);
    while (first < throat.cell && cells[first].last.point < lesion.first_point) ++first;
    const int upstream = cells[first].upstream;
    return upstream < 0 ? first : static_cast<std::size_t>(upstream);
}

bool is_coronary(VesselBed bed)
{
    return bed == VesselBed::left_coronary || bed == VesselBed::right_coronary;
}

// Returns whether blood that passes a cell enters a bed of the heart. A cell comes after the one that feeds
// it.
bool feeds_the_heart(const FlowCells &cells, std::size_t from)
{
    std::vector<bool> is_behind(cells.size(), false);
    is_behind[from] = true;
    for (std::size_t i = from; i < cells.size(); ++i) {
        const int upstream = cells[i].upstream;
        if (upstream >= 0 && is_behind[static_cast<std::size_t>(upstream)]) is_behind[i] = true;
        if (is_behind[i] && cells[i].outlet_ml_s > 0.0 && is_coronary(cells[i].bed)) return true;
    }
    return false;
}

} // namespace

double LesionFigures::diameter_percent() const
{
    return 100.0 * (1.0 - minimum_diameter_mm / reference_diameter_mm);
}

double LesionFigures::area_percent() const
{
    const double left = minimum_diameter_mm / reference_diameter_mm;
    return 100.0 * (1.0 - left * left);
}

std::vector<LesionFigures> lesion_figures(const VesselTree &tree, double viscosity_mPa_s,
                                          const VesselTree *opened)
{
    std::vector<LesionFigures> all;
    if (tree.lesions.empty()) return all;
    FlowCells cells(tree);
    if (opened) cells.reshape(*opened);
    FlowNetwork rest(cells, viscosity_mPa_s), hyperaemia(cells, viscosity_mPa_s);
    const FlowDrive resting;
    FlowDrive open;
    for (const VesselBed bed : {VesselBed::left_coronary, VesselBed::right_coronary})
        open.openness[static_cast<std::size_t>(bed)] = hyperaemia_openness;
    rest.settle(resting);
    hyperaemia.settle(open);
    for (std::size_t k = 0; k < tree.lesions.size(); ++k) {
        const VesselLesion &lesion = tree.lesions[k];
        const FlowThroat &throat = cells.throats()[k];
        const std::size_t ahead = before(cells, lesion, throat);
        const auto drop = [&](const FlowNetwork &network) {
            return network.pressure_mmHg(ahead) - network.pressure_mmHg(throat.behind);
        };
        LesionFigures figures;
        figures.name = lesion.name;
        figures.branch = tree.branches[lesion.branch].name;
        figures.length_mm = lesion.length_m() * 1e3;
        figures.minimum_diameter_mm = 2.0 * throat.radius_mm;
        figures.reference_diameter_mm = 2.0 * throat.healthy_radius_mm;
        figures.rest_flow_ml_s = rest.inflow_ml_s(rest.run_of(throat.cell));
        figures.rest_drop_mmHg = drop(rest);
        figures.hyperaemic_flow_ml_s = hyperaemia.inflow_ml_s(hyperaemia.run_of(throat.cell));
        figures.hyperaemic_drop_mmHg = drop(hyperaemia);
        figures.ffr = hyperaemia.pressure_mmHg(throat.behind) / open.pressure_mmHg;
        figures.is_coronary = feeds_the_heart(cells, throat.cell);
        all.push_back(figures);
    }
    return all;
}

} // namespace crn
