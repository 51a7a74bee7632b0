#include "host/effects/wounds.hpp"
#include <algorithm>
#include <numbers>

namespace crn
{
namespace
{

// At less than this pressure above the veins a hole counts as stopped, and clots.
constexpr double stopped_mmHg = 4.0;

} // namespace

double pocket_ml(const FlowCells &cells, std::size_t begin, std::size_t end, double narrowing)
{
    const double left = 1.0 - narrowing;
    double sum_mm3 = 0.0;
    for (std::size_t i = begin; i < end; ++i)
        sum_mm3 += std::numbers::pi * cells[i].radius_mm * cells[i].radius_mm * cells[i].length_mm;
    return (1.0 - left * left) * sum_mm3 * 1e-3;
}

bool Wounds::is_bleeding() const
{
    return std::any_of(holes_.begin(), holes_.end(),
                       [](const WallHole &hole) { return hole.ml_s_per_mmHg > 0.0; });
}

double Wounds::leaked_ml() const
{
    double sum_ml = 0.0;
    for (const WallHole &hole : holes_) sum_ml += hole.leaked_ml;
    return sum_ml;
}

double Wounds::tissue_mg() const
{
    double sum_mg = 0.0;
    for (const WallHole &hole : holes_) sum_mg += hole.iodine_mg;
    return sum_mg;
}

double Wounds::pocket_mg() const
{
    double sum_mg = 0.0;
    for (const WallFlap &flap : flaps_) sum_mg += flap.iodine_mg;
    return sum_mg;
}

void Wounds::set_hole(std::size_t index, const WallHole &hole)
{
    if (index >= holes_.size()) {
        holes_.push_back(hole);
        return;
    }
    WallHole changed = hole; // torn open again
    changed.leaked_ml = holes_[index].leaked_ml;
    changed.iodine_mg = holes_[index].iodine_mg;
    holes_[index] = changed;
}

void Wounds::set_flap(std::size_t index, const WallFlap &flap)
{
    if (index >= flaps_.size()) {
        flaps_.push_back(flap);
        return;
    }
    const double iodine_mg = flaps_[index].iodine_mg;
    flaps_[index] = flap;
    flaps_[index].iodine_mg = iodine_mg;
}

std::vector<CellHole> Wounds::open_holes() const
{
    std::vector<CellHole> open;
    for (const WallHole &hole : holes_)
        if (hole.open_share() > 0.0) open.push_back({hole.cell, hole.ml_s_per_mmHg * hole.open_share()});
    return open;
}

std::vector<double> Wounds::open_shares(std::size_t cells) const
{
    if (flaps_.empty()) return {};
    std::vector<double> shares(cells, 1.0);
    for (const WallFlap &flap : flaps_)
        for (std::size_t i = flap.begin; i < flap.end; ++i)
            shares[i] = std::min(shares[i], 1.0 - flap.narrowing);
    return shares;
}

// Holes in one cell share its leak in proportion to their conductances.
void Wounds::leak(std::size_t cell, double ml, double mg)
{
    double sum = 0.0;
    for (const WallHole &hole : holes_)
        if (hole.cell == cell) sum += hole.ml_s_per_mmHg * hole.open_share();
    for (WallHole &hole : holes_) {
        if (hole.cell != cell || !(sum > 0.0)) continue;
        const double share = hole.ml_s_per_mmHg * hole.open_share() / sum;
        hole.leaked_ml += share * ml;
        hole.iodine_mg += share * mg;
    }
}

void Wounds::pass(const FlowNetwork &network, double dt_s)
{
    for (WallHole &hole : holes_) {
        const double pressure_mmHg = network.pressure_mmHg(hole.cell);
        hole.flow_ml_s = std::max(pressure_mmHg, 0.0) * hole.ml_s_per_mmHg * hole.open_share();
        if (pressure_mmHg < stopped_mmHg) hole.stopped_s += dt_s;
    }
}

// The step is implicit, so that no pocket takes more than its cells have, and none gives more than it has.
void Wounds::exchange(std::span<const double> volume_ml, std::span<double> core_mg, std::span<double> wall_mg,
                      double dt_s)
{
    for (WallFlap &flap : flaps_) {
        double lumen_ml = 0.0, lumen_mg = 0.0;
        for (std::size_t i = flap.begin; i < flap.end; ++i) {
            lumen_ml += volume_ml[i];
            lumen_mg += core_mg[i] + wall_mg[i];
        }
        const double both_ml = lumen_ml + flap.pocket_ml;
        if (!(lumen_mg > 0.0 || flap.iodine_mg > 0.0) || !(lumen_ml > 0.0 && flap.pocket_ml > 0.0)) continue;
        // The exchange ends at equal concentrations, with this amount in the pocket.
        const double even_mg = (lumen_mg + flap.iodine_mg) * flap.pocket_ml / both_ml;
        const double x = dt_s / (even_mg > flap.iodine_mg ? flap.fill_s : flap.empty_s) * both_ml / lumen_ml;
        const double moved_mg = (even_mg - flap.iodine_mg) * x / (1.0 + x); // out of the lumen
        flap.iodine_mg += moved_mg;
        for (std::size_t i = flap.begin; i < flap.end; ++i) {
            // What the lumen gives comes from where it is; what it receives spreads evenly.
            const double share =
                moved_mg > 0.0 ? (core_mg[i] + wall_mg[i]) / lumen_mg : volume_ml[i] / lumen_ml;
            const double cell_mg = core_mg[i] + wall_mg[i];
            const double core_share = moved_mg > 0.0 && cell_mg > 0.0 ? core_mg[i] / cell_mg : 0.5;
            core_mg[i] -= share * core_share * moved_mg;
            wall_mg[i] -= share * (1.0 - core_share) * moved_mg;
        }
    }
}

void archive_hole(StateArchive &state, WallHole &hole, std::size_t cells)
{
    constexpr double most = 1e6;
    state.index(hole.cell, cells);
    for (double *value : {&hole.ml_s_per_mmHg, &hole.seal_s, &hole.stopped_s, &hole.flow_ml_s,
                          &hole.leaked_ml, &hole.iodine_mg})
        state.real(*value, -most, most);
    state.reals({hole.outward.data(), 3}, -2.0, 2.0);
    state.real(hole.diameter_mm, 0.0, 100.0);
    state.real(hole.blush_mg_per_ml, 0.1, 1000.0);
    state.flag(hole.is_jet);
    if (state.restores()) state.require(hole.seal_s > 0.0 && hole.ml_s_per_mmHg >= 0.0);
}

void archive_flap(StateArchive &state, WallFlap &flap, std::size_t cells)
{
    constexpr double most = 1e6;
    state.index(flap.begin, cells);
    state.index(flap.end, cells + 1);
    if (state.restores()) state.require(flap.begin < flap.end);
    state.real(flap.narrowing, 0.0, 1.0);
    state.real(flap.pocket_ml, 0.0, most);
    state.real(flap.fill_s, 1e-6, most);
    state.real(flap.empty_s, 1e-6, most);
    state.reals({flap.side.data(), 3}, -2.0, 2.0);
    state.real(flap.iodine_mg, -most, most);
}

void Wounds::archive(StateArchive &state, std::size_t cells)
{
    state.list(holes_, [&](WallHole &hole) { archive_hole(state, hole, cells); });
    state.list(flaps_, [&](WallFlap &flap) { archive_flap(state, flap, cells); });
}

} // namespace crn
