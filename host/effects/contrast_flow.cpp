#include "host/effects/contrast_flow.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace seld
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double step_s = 1e-3;
constexpr double emptied_max = 0.95; // share of a layer that may leave its cell in one part of a step

} // namespace

ContrastFlow::ContrastFlow(const VesselTree &tree, const ContrastSettings &settings)
    : settings_(settings), cells_(tree), network_(cells_, settings.viscosity_mPa_s)
{
    const std::size_t count = cells_.size();
    for (std::size_t i = 0; i < count; ++i) {
        const FlowCell &cell = cells_[i];
        upstream_.push_back(cell.upstream);
        per_volume_.push_back(2.0 / cell.volume_ml);
        // Mean speed over the length on which layers mix: (Q / (pi r^2)) / (mixing_radii r).
        mixing_.push_back(1e3 /
                          (pi * cell.radius_mm * cell.radius_mm * cell.radius_mm * settings.mixing_radii));
    }
    tool_mm_.assign(count, 0.0);
    core_mg_.assign(count, 0.0);
    wall_mg_.assign(count, 0.0);
    core_change_.resize(count);
    wall_change_.resize(count);
}

void ContrastFlow::set_tools(std::span<const ToolBall> balls)
{
    std::fill(tool_mm_.begin(), tool_mm_.end(), 0.0);
    if (tool_mm_.empty()) return;
    for (const ToolBall &ball : balls) {
        double &thickest = tool_mm_[cells_.nearest(ball.place_m)];
        thickest = std::max(thickest, ball.radius_m * 1e3);
    }
    network_.set_tools(tool_mm_);
}

void ContrastFlow::set_mouths(std::span<const CatheterMouth> mouths)
{
    mouths_.clear();
    if (tool_mm_.empty()) return;
    for (const CatheterMouth &mouth : mouths) mouths_.push_back({cells_.nearest(mouth.place_m), mouth.share});
}

void ContrastFlow::step(const FlowDrive &drive, const InjectedFluid &fluid)
{
    sources_.clear();
    for (const CellSource &mouth : mouths_)
        if (fluid.flow_ml_s > 0.0) sources_.push_back({mouth.cell, mouth.flow_ml_s * fluid.flow_ml_s});
    network_.solve(drive, sources_);

    // The faster layer may not give away more than it holds: then the step is done in parts.
    const std::vector<double> &inflow = network_.inflow_ml_s(), &outflow = network_.outflow_ml_s();
    std::copy(outflow.begin(), outflow.end(), core_change_.begin()); // what leaves each cell, ml/s
    for (std::size_t i = 0; i < upstream_.size(); ++i) {
        if (inflow[i] < 0.0) core_change_[i] -= inflow[i];
        if (inflow[i] > 0.0 && upstream_[i] >= 0)
            core_change_[static_cast<std::size_t>(upstream_[i])] += inflow[i];
    }
    double emptied = 0.0;
    for (std::size_t i = 0; i < upstream_.size(); ++i)
        emptied = std::max(emptied, core_change_[i] * per_volume_[i]);
    const double faster = std::max(settings_.core_flow_share, 1.0 - settings_.core_flow_share);
    const double parts = std::max(std::ceil(emptied * faster * step_s / emptied_max), 1.0);
    for (int part = 0; part < static_cast<int>(parts); ++part) transport(step_s / parts, fluid);
    mix(step_s);
}

// Each layer by itself, upwind: a flow carries the concentration of the cell that it leaves. Both layers have half of the
// volume, and the same shares of every flow, injected fluid included, so that what enters a layer also leaves it.
void ContrastFlow::transport(double dt_s, const InjectedFluid &fluid)
{
    const std::vector<double> &inflow = network_.inflow_ml_s(), &outflow = network_.outflow_ml_s();
    const double core = settings_.core_flow_share * dt_s, wall = (1.0 - settings_.core_flow_share) * dt_s;
    std::fill(core_change_.begin(), core_change_.end(), 0.0);
    std::fill(wall_change_.begin(), wall_change_.end(), 0.0);
    for (std::size_t i = 0; i < upstream_.size(); ++i) {
        const int up = upstream_[i];
        const double q = inflow[i];
        const int from = q > 0.0 ? up : static_cast<int>(i);
        if (from >= 0) { // else fresh blood
            const auto donor = static_cast<std::size_t>(from);
            const double carried = q * per_volume_[donor];
            const double core_mg = core * carried * core_mg_[donor],
                         wall_mg = wall * carried * wall_mg_[donor];
            core_change_[i] += core_mg;
            wall_change_[i] += wall_mg;
            if (up >= 0) {
                core_change_[static_cast<std::size_t>(up)] -= core_mg;
                wall_change_[static_cast<std::size_t>(up)] -= wall_mg;
            } else {
                budget_.reflux_mg -= core_mg + wall_mg;
            }
        }
        if (outflow[i] > 0.0) {
            const double carried = outflow[i] * per_volume_[i];
            const double core_mg = core * carried * core_mg_[i], wall_mg = wall * carried * wall_mg_[i];
            core_change_[i] -= core_mg;
            wall_change_[i] -= wall_mg;
            budget_.out_mg += core_mg + wall_mg;
        }
    }
    for (const CellSource &source : sources_) {
        const double mg_per_s = source.flow_ml_s * fluid.iodine_mg_per_ml;
        core_change_[source.cell] += core * mg_per_s;
        wall_change_[source.cell] += wall * mg_per_s;
        budget_.injected_mg += mg_per_s * dt_s;
    }
    for (std::size_t i = 0; i < core_mg_.size(); ++i) {
        core_mg_[i] += core_change_[i];
        wall_mg_[i] += wall_change_[i];
    }
}

// The layers' difference falls as exp(-k t), k in proportion to the speed; implicit, so that it never overshoots.
void ContrastFlow::mix(double dt_s)
{
    const std::vector<double> &inflow = network_.inflow_ml_s();
    for (std::size_t i = 0; i < core_mg_.size(); ++i) {
        const double x = std::fabs(inflow[i]) * mixing_[i] * dt_s;
        const double moved = 0.5 * (core_mg_[i] - wall_mg_[i]) * x / (1.0 + x);
        core_mg_[i] -= moved;
        wall_mg_[i] += moved;
    }
}

double ContrastFlow::iodine_mg_per_ml(std::size_t cell) const
{
    return (core_mg_[cell] + wall_mg_[cell]) / cells_[cell].volume_ml;
}

double ContrastFlow::held_mg() const
{
    double sum = 0.0;
    for (std::size_t i = 0; i < core_mg_.size(); ++i) sum += core_mg_[i] + wall_mg_[i];
    return sum;
}

// --- snapshots: counts, then the arrays ---

std::vector<std::uint8_t> ContrastFlow::snapshot() const
{
    std::vector<std::uint8_t> bytes;
    const auto put = [&](const void *from, std::size_t size) {
        bytes.resize(bytes.size() + size);
        if (size > 0) std::memcpy(bytes.data() + bytes.size() - size, from, size);
    };
    const std::uint64_t counts[2] = {cells_.size(), mouths_.size()};
    put(counts, sizeof counts);
    put(&budget_, sizeof budget_);
    for (const std::vector<double> *values : {&core_mg_, &wall_mg_, &tool_mm_})
        put(values->data(), values->size() * sizeof(double));
    put(network_.throat_flows_ml_s().data(), network_.throat_flows_ml_s().size() * sizeof(double));
    for (const CellSource &mouth : mouths_) {
        const std::uint64_t cell = mouth.cell;
        put(&cell, sizeof cell);
        put(&mouth.flow_ml_s, sizeof mouth.flow_ml_s);
    }
    return bytes;
}

bool ContrastFlow::restore(std::span<const std::uint8_t> bytes)
{
    std::uint64_t counts[2];
    std::vector<double> throats(cells_.throats().size());
    const std::size_t fixed =
        sizeof counts + sizeof budget_ + 3 * sizeof(double) * cells_.size() + sizeof(double) * throats.size();
    if (bytes.size() < fixed) return false;
    const std::uint8_t *from = bytes.data();
    const auto get = [&](void *to, std::size_t size) {
        std::memcpy(to, from, size);
        from += size;
    };
    get(counts, sizeof counts);
    if (counts[0] != cells_.size() || counts[1] != (bytes.size() - fixed) / 16 ||
        (bytes.size() - fixed) % 16 != 0)
        return false;
    std::vector<CellSource> mouths(counts[1]);
    const std::uint8_t *of_mouths = bytes.data() + fixed;
    for (CellSource &mouth : mouths) {
        std::uint64_t cell;
        std::memcpy(&cell, of_mouths, 8);
        std::memcpy(&mouth.flow_ml_s, of_mouths + 8, 8);
        of_mouths += 16;
        if (cell >= cells_.size()) return false;
        mouth.cell = cell;
    }
    get(&budget_, sizeof budget_);
    for (std::vector<double> *values : {&core_mg_, &wall_mg_, &tool_mm_})
        get(values->data(), values->size() * sizeof(double));
    get(throats.data(), throats.size() * sizeof(double));
    network_.set_throat_flows(throats);
    mouths_ = std::move(mouths);
    network_.set_tools(tool_mm_);
    return true;
}

} // namespace seld
