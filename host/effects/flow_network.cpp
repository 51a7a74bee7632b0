#include "host/effects/flow_network.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace crn
{
namespace
{

using std::numbers::pi;
constexpr double mmHg_per_Pa = 1.0 / 133.322;
constexpr double wedged_share = 0.98; // of the lumen's radius; beyond it there is no flow
constexpr double least_share = 0.25;  // of the pressure before a bed at the stated flow
constexpr double blood_kg_m3 = 1060.0;
constexpr double expansion_loss = 1.5; // K_t, approximately (Young and Tsai 1973)
constexpr int settle_rounds = 60;      // each round at least halves the remaining error

// Returns a stenosis's pressure loss K_t rho/2 (A0/As - 1)^2 v0^2 (K_t: loss coefficient, rho: density, A0
// and As: areas of the healthy vessel and of the stenosis, v0: speed in the healthy vessel), divided by the
// square of the flow through the stenosis. Format: mm and ml/s -> mmHg s^2/ml^2 (1 ml/s through 1 mm^2 is 1
// m/s). The loss is 0 where the lesion's narrowest point is no narrower than the vessel.
double loss_of(const FlowThroat &throat, double tool_radius_mm)
{
    const double area = throat.healthy_radius_mm * throat.healthy_radius_mm;
    const double left = throat.radius_mm * throat.radius_mm - tool_radius_mm * tool_radius_mm;
    if (!(left < area)) return 0.0;
    const double least = 1e-4 * area; // below it nothing flows: the cell's conductance is 0 there
    const double widening = area / std::max(left, least) - 1.0, area_mm2 = pi * area;
    return expansion_loss * 0.5 * blood_kg_m3 * widening * widening / (area_mm2 * area_mm2) * mmHg_per_Pa;
}

// Returns the natural logarithm of a number x >= 1. The logarithm is computed by square roots and a series,
// so that every machine gives results that are equal bit for bit.
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

FlowNetwork::FlowNetwork(const FlowCells &cells, double viscosity_mPa_s) : viscosity_mPa_s_(viscosity_mPa_s)
{
    const std::size_t count = cells.size();
    ends_run_.assign(count, 1);
    for (std::size_t i = 0; i < count; ++i) {
        const FlowCell &cell = cells[i];
        upstream_.push_back(cell.upstream);
        bed_.push_back(cell.bed);
        volume_ml_.push_back(cell.volume_ml);
    }
    std::vector<int> fed(count, 0); // number of cells that each cell feeds
    for (int up : upstream_)
        if (up >= 0) ++fed[static_cast<std::size_t>(up)];
    for (std::size_t i = 0; i + 1 < count; ++i)
        if (upstream_[i + 1] == static_cast<int>(i) && fed[i] == 1 && !(cells[i].outlet_ml_s > 0.0))
            ends_run_[i] = 0;
    open_beds(cells);
    take_shape(cells);
    throat_loss_.resize(throats_.size());
    throat_flows_.assign(throats_.size(), 0.0);
    set_tools({});
    divide({});
}

// Returns the flow resistance of a cell by Hagen-Poiseuille: 8 mu/pi times the integral of ds/r^4 (mu:
// viscosity, r: radius, s: arc length), converted from Pa s/m^3 to mmHg s/ml.
double FlowNetwork::poiseuille(double per_r4_mm3) const
{
    return 8.0 * viscosity_mPa_s_ * per_r4_mm3 / pi * mmHg_per_Pa;
}

// Opens every bed so far that its stated flow leaves the healthy vessels without tools at the mean pressure:
// the bed takes the flow at the pressure that the arteries before it leave of the inlet's. A bed behind
// arteries that would lose nearly all of the pressure at the stated flows is no more open than at the least
// pressure; there the arteries limit the flow.
void FlowNetwork::open_beds(const FlowCells &cells)
{
    const std::size_t count = cells.size();
    std::vector<double> flow_ml_s(count, 0.0), end_mmHg(count, mean_pressure_mmHg);
    for (std::size_t i = count; i-- > 0;) { // a cell comes after the one that feeds it
        flow_ml_s[i] += cells[i].outlet_ml_s;
        if (upstream_[i] >= 0) flow_ml_s[static_cast<std::size_t>(upstream_[i])] += flow_ml_s[i];
    }
    for (std::size_t i = 0; i < count; ++i) {
        const double before_mmHg =
            upstream_[i] < 0 ? mean_pressure_mmHg : end_mmHg[static_cast<std::size_t>(upstream_[i])];
        end_mmHg[i] = before_mmHg - flow_ml_s[i] * poiseuille(cells[i].healthy_per_r4_mm3);
        outlet_.push_back(cells[i].outlet_ml_s / std::max(end_mmHg[i], least_share * mean_pressure_mmHg));
    }
}

void FlowNetwork::take_shape(const FlowCells &cells)
{
    open_.resize(cells.size());
    radius_mm_.resize(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        open_[i] = 1.0 / poiseuille(cells[i].per_r4_mm3);
        radius_mm_[i] = cells[i].radius_mm;
    }
    throats_ = cells.throats();
}

void FlowNetwork::reshape(const FlowCells &cells, std::span<const double> tool_radius_mm)
{
    if (cells.size() != open_.size()) return;
    take_shape(cells);
    set_tools(tool_radius_mm);
}

void FlowNetwork::set_volumes(std::span<const double> volume_ml)
{
    if (volume_ml.size() != volume_ml_.size()) return;
    std::copy(volume_ml.begin(), volume_ml.end(), volume_ml_.begin());
    for (FlowRun &run : runs_) run.smallest_ml = smallest_ml(run.begin, run.end);
}

double FlowNetwork::smallest_ml(std::size_t begin, std::size_t end) const
{
    const auto first = volume_ml_.begin();
    return *std::min_element(first + static_cast<std::ptrdiff_t>(begin),
                             first + static_cast<std::ptrdiff_t>(end));
}

void FlowNetwork::set_tools(std::span<const double> tool_radius_mm)
{
    resistance_.resize(open_.size());
    for (std::size_t i = 0; i < open_.size(); ++i) {
        const double radius_mm = i < tool_radius_mm.size() ? tool_radius_mm[i] : 0.0;
        double lumen_mm = radius_mm_[i], open = open_[i];
        if (!open_share_.empty()) { // by Poiseuille's law, as the fourth power of the radius
            const double square = open_share_[i] * open_share_[i];
            lumen_mm *= open_share_[i];
            open *= square * square;
        }
        const double left = open * (radius_mm > 0.0 ? annulus_share(radius_mm / lumen_mm) : 1.0);
        resistance_[i] = left > 0.0 ? 1.0 / left : std::numeric_limits<double>::infinity();
    }
    for (std::size_t k = 0; k < throats_.size(); ++k) {
        const std::size_t cell = throats_[k].cell;
        throat_loss_[k] = loss_of(throats_[k], cell < tool_radius_mm.size() ? tool_radius_mm[cell] : 0.0);
    }
    set_ways();
}

void FlowNetwork::set_wounds(std::span<const CellHole> holes, std::span<const double> open_share,
                             std::span<const double> tool_radius_mm)
{
    leak_.assign(holes.empty() ? 0 : open_.size(), 0.0);
    for (const CellHole &hole : holes) leak_[hole.cell] += hole.ml_s_per_mmHg;
    open_share_.assign(open_share.begin(), open_share.end());
    set_tools(tool_radius_mm);
    divide({});
}

void FlowNetwork::set_throat_flows(std::span<const double> flows_ml_s)
{
    if (flows_ml_s.size() == throat_flows_.size())
        std::copy(flows_ml_s.begin(), flows_ml_s.end(), throat_flows_.begin());
}

void FlowNetwork::settle(const FlowDrive &drive)
{
    std::vector<double> before;
    for (int round = 0; round < settle_rounds; ++round) {
        before = throat_flows_;
        solve(drive, {});
        if (throat_flows_ == before) return; // every further round would give the same flows
    }
}

// Divides the cells into runs, which are rows of consecutive cells: a run ends where the flow divides,
// where fluid is injected, and where blood leaves through a hole in the wall.
void FlowNetwork::divide(std::span<const CellSource> sources)
{
    source_cells_.clear();
    std::vector<std::uint8_t> ends = ends_run_;
    for (std::size_t i = 0; i < leak_.size(); ++i)
        if (leak_[i] > 0.0) ends[i] = 1;
    for (const CellSource &source : sources) {
        source_cells_.push_back(source.cell);
        ends[source.cell] = 1;
    }
    runs_.clear();
    run_of_.resize(open_.size());
    for (std::size_t i = 0, begin = 0; i < open_.size(); ++i) {
        run_of_[i] = runs_.size();
        if (!ends[i]) continue;
        const int up = upstream_[begin];
        runs_.push_back({begin, i + 1, up < 0 ? -1 : static_cast<int>(run_of_[static_cast<std::size_t>(up)]),
                         smallest_ml(begin, i + 1)});
        begin = i + 1;
    }
    rows_.assign(runs_.size(), {});
    flows_.assign(runs_.size(), {});
    set_ways();
}

void FlowNetwork::set_ways()
{
    for (std::size_t r = 0; r < runs_.size(); ++r) {
        double resistance = 0.0;
        for (std::size_t i = runs_[r].begin; i < runs_[r].end; ++i) resistance += resistance_[i];
        rows_[r].open_way = std::isfinite(resistance) ? 1.0 / resistance : 0.0;
    }
}

// Adds the losses of a run's stenoses, at the flows of the last solution, to the run's resistance by
// Poiseuille's law.
void FlowNetwork::add_throats()
{
    for (Row &row : rows_) row.way = row.open_way;
    for (std::size_t k = 0; k < throats_.size(); ++k) {
        double &way = rows_[run_of_[throats_[k].cell]].way;
        if (way > 0.0) way = 1.0 / (1.0 / way + throat_loss_[k] * throat_flows_[k]);
    }
}

double FlowNetwork::pressure_mmHg(std::size_t cell) const
{
    const std::size_t run = run_of_[cell], end = runs_[run].end;
    double resistance = 0.0; // from there to the run's last cell
    for (std::size_t i = cell + 1; i < end; ++i) resistance += resistance_[i];
    for (std::size_t k = 0; k < throats_.size(); ++k)
        if (throats_[k].cell > cell && throats_[k].cell < end)
            resistance += throat_loss_[k] * throat_flows_[k];
    const double flow_ml_s = flows_[run].in_ml_s;
    return rows_[run].pressure_mmHg + (flow_ml_s == 0.0 ? 0.0 : flow_ml_s * resistance);
}

// In the following equations, c is the conductance from a run's last cell to the veins, and s is the flow
// that is injected into this cell. Let p be the pressure in the last cell, u the pressure upstream, and g the
// conductance of the path between them. With the pressures u upstream and p in the run's last cell, the
// conductance g between them, the flow s into this cell, and the conductance c from this cell to the veins,
// the balance of flows is g (u - p) + s = c p. Seen from upstream, the run therefore acts as a conductance of
// g c / (g + c) with an injected flow of g s / (g + c).
void FlowNetwork::solve(const FlowDrive &drive, std::span<const CellSource> sources, bool is_inlet_shut)
{
    const bool is_divided =
        std::equal(sources.begin(), sources.end(), source_cells_.begin(), source_cells_.end(),
                   [](const CellSource &source, std::size_t cell) { return source.cell == cell; });
    if (!is_divided) divide(sources);
    add_throats();
    if (is_inlet_shut && !rows_.empty()) rows_[0].way = 0.0;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
        const std::size_t last = runs_[r].end - 1;
        const double outlet = outlet_[last] > 0.0 ? outlet_[last] * drive.of(bed_[last]) : 0.0;
        const double leak = leak_.empty() ? 0.0 : leak_[last];
        flows_[r].leak_ml_s = leak;
        flows_[r].out_ml_s = outlet + leak;
        rows_[r].conductance = outlet + leak;
        rows_[r].source = rows_[r].injected_ml_s = 0.0;
    }
    for (const CellSource &source : sources) {
        Row &row = rows_[run_of_[source.cell]];
        row.injected_ml_s += source.flow_ml_s;
        row.source += source.flow_ml_s;
    }
    for (std::size_t r = runs_.size(); r-- > 0;) {
        const Row &row = rows_[r];
        const double sum = row.way + row.conductance;
        if (runs_[r].upstream < 0 || !(sum > 0.0)) continue;
        const double share = row.way / sum;
        Row &up = rows_[static_cast<std::size_t>(runs_[r].upstream)];
        up.conductance += share * row.conductance;
        up.source += share * row.source;
    }
    for (std::size_t r = 0; r < runs_.size(); ++r) {
        Row &row = rows_[r];
        const double sum = row.way + row.conductance;
        const int up = runs_[r].upstream;
        const double before =
            up < 0 ? drive.pressure_mmHg : rows_[static_cast<std::size_t>(up)].pressure_mmHg;
        row.pressure_mmHg = sum > 0.0 ? (row.way * before + row.source) / sum : 0.0;
        flows_[r].out_ml_s *= row.pressure_mmHg;
        flows_[r].leak_ml_s *= row.pressure_mmHg;
        flows_[r].in_ml_s = flows_[r].out_ml_s - row.injected_ml_s;
    }
    // The flow into a run of cells is computed from the flows out of it. A sum of flows is numerically exact,
    // whereas a difference of nearly equal pressures is not.
    for (std::size_t r = runs_.size(); r-- > 0;) {
        if (!(rows_[r].way > 0.0)) flows_[r].in_ml_s = 0.0; // no flow passes, not even a rounding error
        if (runs_[r].upstream >= 0)
            flows_[static_cast<std::size_t>(runs_[r].upstream)].in_ml_s += flows_[r].in_ml_s;
    }
    // Each iteration changes the flow only halfway towards the new solution, since full steps would oscillate
    // about the solution for ever.
    for (std::size_t k = 0; k < throats_.size(); ++k)
        throat_flows_[k] += 0.5 * (std::fabs(flows_[run_of_[throats_[k].cell]].in_ml_s) - throat_flows_[k]);
}

} // namespace crn
