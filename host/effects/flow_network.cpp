#include "host/effects/flow_network.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double mmHg_per_Pa = 1.0 / 133.322;
constexpr double wedged_share = 0.98; // of the lumen's radius; beyond it nothing passes
constexpr double blood_kg_m3 = 1060.0;
constexpr double expansion_loss = 1.5; // K_t, about (Young and Tsai 1973)
constexpr int settle_rounds = 60;      // each halves what is missing, at least

// Pressure lost behind a throat, K_t rho/2 (A0/As - 1)^2 v0^2, per square of the flow. Format: mm and ml/s -> mmHg s^2/ml^2
// (1 ml/s through 1 mm^2 is 1 m/s). 0 where the throat is no narrower than the vessel.
double loss_of(const FlowThroat &throat, double tool_radius_mm)
{
    const double area = throat.healthy_radius_mm * throat.healthy_radius_mm;
    const double left = throat.radius_mm * throat.radius_mm - tool_radius_mm * tool_radius_mm;
    if (!(left < area)) return 0.0;
    const double least = 1e-4 * area; // less lets nothing pass: the cell's conductance is 0 there
    const double widening = area / std::max(left, least) - 1.0, area_mm2 = pi * area;
    return expansion_loss * 0.5 * blood_kg_m3 * widening * widening / (area_mm2 * area_mm2) * mmHg_per_Pa;
}

// Logarithm of x >= 1 by square roots and a series, the same bits on every machine.
double logarithm(double x)
{
    double scale = 2.0;
    for (int i = 0; i < 5; ++i, scale *= 2.0) x = std::sqrt(x);
    const double z = (x - 1.0) / (x + 1.0), square = z * z;
    return scale * z * (1.0 + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square / 7.0)));
}

} // namespace

double annulus_share(double share)
{
    if (!(share > 1e-6)) return 1.0;
    if (share >= wedged_share) return 0.0;
    const double square = share * share, open = 1.0 - square;
    return std::max(1.0 - square * square - open * open / logarithm(1.0 / share), 0.0);
}

FlowNetwork::FlowNetwork(const FlowCells &cells, double viscosity_mPa_s)
{
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const FlowCell &cell = cells[i];
        // Hagen-Poiseuille, 8 mu/pi times the integral of ds/r^4, from Pa s/m^3 to mmHg s/ml.
        const double resistance = 8.0 * viscosity_mPa_s * cell.per_r4_mm3 / pi * mmHg_per_Pa;
        upstream_.push_back(cell.upstream);
        open_.push_back(1.0 / resistance);
        outlet_.push_back(cell.outlet_ml_s / mean_pressure_mmHg);
        bed_.push_back(cell.bed);
        radius_mm_.push_back(cell.radius_mm);
    }
    throats_ = cells.throats();
    for (const FlowThroat &throat : throats_) throat_loss_.push_back(loss_of(throat, 0.0));
    throat_flows_.assign(throats_.size(), 0.0);
    conductance_ = open_;
    rows_.resize(cells.size());
    injected_.assign(cells.size(), 0.0);
    pressure_.assign(cells.size(), 0.0);
    inflow_.assign(cells.size(), 0.0);
    outflow_.assign(cells.size(), 0.0);
}

void FlowNetwork::set_tools(std::span<const double> tool_radius_mm)
{
    for (std::size_t i = 0; i < open_.size(); ++i) {
        const double radius_mm = i < tool_radius_mm.size() ? tool_radius_mm[i] : 0.0;
        conductance_[i] = open_[i] * (radius_mm > 0.0 ? annulus_share(radius_mm / radius_mm_[i]) : 1.0);
    }
    for (std::size_t k = 0; k < throats_.size(); ++k) {
        const std::size_t cell = throats_[k].cell;
        throat_loss_[k] = loss_of(throats_[k], cell < tool_radius_mm.size() ? tool_radius_mm[cell] : 0.0);
    }
}

void FlowNetwork::set_throat_flows(std::span<const double> flows_ml_s)
{
    if (flows_ml_s.size() == throat_flows_.size())
        std::copy(flows_ml_s.begin(), flows_ml_s.end(), throat_flows_.begin());
}

void FlowNetwork::settle(const FlowDrive &drive)
{
    for (int round = 0; round < settle_rounds; ++round) solve(drive, {});
}

// Of the way into a cell: Poiseuille's, and behind it what its throats lose at the flows seen last.
void FlowNetwork::add_throats()
{
    way_ = conductance_;
    for (std::size_t k = 0; k < throats_.size(); ++k) {
        double &way = way_[throats_[k].cell];
        if (way > 0.0) way = 1.0 / (1.0 / way + throat_loss_[k] * throat_flows_[k]);
    }
}

// Behind a cell lie conductances c to the veins and sources s. Its pressure is p, the way into it from pressure u has
// conductance g: g (u - p) + s = c p. Seen from upstream the cell is g c / (g + c) with the source g s / (g + c).
void FlowNetwork::solve(const FlowDrive &drive, std::span<const CellSource> sources)
{
    add_throats();
    const std::size_t count = open_.size();
    for (std::size_t i = 0; i < count; ++i) {
        outflow_[i] = outlet_[i] > 0.0 ? outlet_[i] * drive.of(bed_[i]) : 0.0;
        rows_[i] = {outflow_[i], 0.0};
        injected_[i] = 0.0;
    }
    for (const CellSource &source : sources) {
        injected_[source.cell] += source.flow_ml_s;
        rows_[source.cell].source += source.flow_ml_s;
    }
    for (std::size_t i = count; i-- > 0;) {
        const double g = way_[i], sum = g + rows_[i].conductance;
        if (upstream_[i] < 0 || !(sum > 0.0)) continue;
        const double share = g / sum;
        Row &up = rows_[static_cast<std::size_t>(upstream_[i])];
        up.conductance += share * rows_[i].conductance;
        up.source += share * rows_[i].source;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const double g = way_[i], sum = g + rows_[i].conductance;
        const double before =
            upstream_[i] < 0 ? drive.pressure_mmHg : pressure_[static_cast<std::size_t>(upstream_[i])];
        pressure_[i] = sum > 0.0 ? (g * before + rows_[i].source) / sum : 0.0;
        outflow_[i] *= pressure_[i];
        inflow_[i] = outflow_[i] - injected_[i];
    }
    // What goes into a cell is what leaves it: exact, where differences of nearly equal pressures are not.
    for (std::size_t i = count; i-- > 0;) {
        if (!(way_[i] > 0.0)) inflow_[i] = 0.0; // nothing passes, not even a rounding error
        if (upstream_[i] >= 0) inflow_[static_cast<std::size_t>(upstream_[i])] += inflow_[i];
    }
    // Halfway to the new flow: the whole way would swing about it for ever.
    for (std::size_t k = 0; k < throats_.size(); ++k)
        throat_flows_[k] += 0.5 * (std::fabs(inflow_[throats_[k].cell]) - throat_flows_[k]);
}

} // namespace seld
