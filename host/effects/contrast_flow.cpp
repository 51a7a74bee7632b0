#include "host/effects/contrast_flow.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace crn
{
namespace
{

using std::numbers::pi;
constexpr double step_s = 1e-3;
constexpr double sinus_s = 0.35;     // mean time that refluxed medium stays in the sinus: assumed
constexpr double emptied_max = 0.95; // share of a layer that may leave its cell in one substep
// An aorta that begins at the heart is so wide there, and rises by so much of its first length.
constexpr double root_radius_min_m = 11e-3, root_length_m = 40e-3, root_rise = 0.3;
constexpr double stretch_max = 0.6;
constexpr double stretch_step_max = 2.5e-3; // of a volume in a step; a regular beat needs 1.4e-3
constexpr double lowest_pressure = 0.5;     // of the mean
constexpr double empty_mg = 0.02;           // so little in the lumen counts as none

// The root of the tree begins at the heart if it is as wide there as an ascending aorta, and rises like one.
// A scan may begin in a descending aorta that is as wide.
bool begins_at_heart(const VesselTree &tree)
{
    if (tree.branches.empty()) return false;
    const VesselBranch &root = tree.branches[0];
    double arc_m = 0.0, widest_m = root.radii_m[0], rise_m = 0.0;
    for (std::size_t i = 1; i < root.points_m.size() && arc_m < root_length_m; ++i) {
        arc_m += (root.points_m[i] - root.points_m[i - 1]).norm();
        rise_m = root.points_m[i].y() - root.points_m[0].y();
        if (arc_m <= root_length_m) widest_m = std::max(widest_m, root.radii_m[i]);
    }
    return widest_m >= root_radius_min_m && rise_m >= root_rise * arc_m;
}

double leaving_in_diastole_ml(const FlowCells &cells, BeatPhase beat)
{
    std::array<double, vessel_bed_count> flow_ml_s{};
    for (std::size_t i = 0; i < cells.size(); ++i)
        flow_ml_s[static_cast<std::size_t>(cells[i].bed)] += cells[i].outlet_ml_s;
    double sum_ml = 0.0;
    for (beat.since_opening_s = beat.systole_s; beat.since_opening_s < beat.beat_s;
         beat.since_opening_s += step_s) {
        const FlowDrive drive = flow_drive(beat);
        for (std::size_t bed = 0; bed < vessel_bed_count; ++bed)
            sum_ml += flow_ml_s[bed] * drive.openness[bed] * step_s;
    }
    return sum_ml;
}

} // namespace

ContrastFlow::ContrastFlow(const VesselTree &tree, const ContrastSettings &settings)
    : settings_(settings), cells_(tree), network_(cells_, settings.viscosity_mPa_s), distal_(tree, cells_)
{
    const std::size_t count = cells_.size();
    for (std::size_t i = 0; i < count; ++i) volume_ml_.push_back(cells_[i].volume_ml);
    find_stretch(tree);
    take_volumes();
    tool_mm_.assign(count, 0.0);
    core_mg_.assign(count, 0.0);
    wall_mg_.assign(count, 0.0);
    in_mg_.assign(count, 0.0);
    branch_injected_mg_.assign(tree.branches.size(), 0.0);
    branch_out_mg_ = branch_injected_mg_;
    sinus_mg_ = branch_injected_mg_;
    for (const VesselBranch &branch : tree.branches)
        has_sinus_.push_back(branch.bed != VesselBed::systemic && branch.parent >= 0 &&
                             tree.branches[static_cast<std::size_t>(branch.parent)].bed ==
                                 VesselBed::systemic);
}

// The wall's compliance per length is in proportion to the cube of the radius, as measured
// (docs/contrast.md), so that a volume grows in proportion to its radius. At 70 beats per minute, the aorta
// stores in systole what leaves the vessels in diastole.
void ContrastFlow::find_stretch(const VesselTree &tree)
{
    if (!begins_at_heart(tree)) return;
    const BeatPhase beat = steady_beat(0, 70.0);
    const double closing = windkessel_pressure(beat.systole_s, beat.systole_s, beat.beat_s).pressure,
                 opening = windkessel_pressure(0.0, beat.systole_s, beat.beat_s).pressure;
    const std::size_t aorta = cells_.branch_begin(1);
    double weight = 0.0, widest_mm = 0.0;
    for (std::size_t i = 0; i < cells_.size(); ++i) mean_ml_s_ += cells_[i].outlet_ml_s;
    for (std::size_t i = 0; i < aorta; ++i) {
        weight += cells_[i].radius_mm * cells_[i].volume_ml;
        widest_mm = std::max(widest_mm, cells_[i].radius_mm);
    }
    const double per_mm = std::min(leaving_in_diastole_ml(cells_, beat) / (weight * (closing - opening)),
                                   stretch_max / widest_mm);
    for (std::size_t i = 0; i < aorta; ++i) stretch_.push_back(per_mm * cells_[i].radius_mm);
}

// Returns the volume that a cell has at the present pressure.
double ContrastFlow::wanted_ml(std::size_t cell) const
{
    const double stretch = cell < stretch_.size() ? stretch_[cell] * (aortic_pressure_ - 1.0) : 0.0;
    return cells_[cell].volume_ml * (1.0 + stretch);
}

void ContrastFlow::take_volumes()
{
    per_volume_.resize(cells_.size());
    mixing_.resize(cells_.size());
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        const double radius_mm = cells_[i].radius_mm;
        per_volume_[i] = 2.0 / volume_ml_[i];
        // The mixing rate of the two layers of blood is the mean speed Q / (pi r^2) of the blood (flow Q in a
        // vessel of radius r) divided by the mixing length. The mixing length is mixing_radii times the
        // radius r.
        mixing_[i] = 1e3 / (pi * radius_mm * radius_mm * radius_mm * settings_.mixing_radii);
    }
    least_ml_ = volume_ml_;
    for (std::size_t i = 0; i < stretch_.size(); ++i)
        least_ml_[i] = cells_[i].volume_ml * (1.0 - (1.0 - lowest_pressure) * stretch_[i]);
    network_.set_volumes(least_ml_);
}

void ContrastFlow::reshape(const VesselTree &opened, int steps)
{
    cells_.reshape(opened);
    widening_steps_ = std::max(steps, 0);
    for (std::size_t i = 0; i < cells_.size() && widening_steps_ == 0; ++i)
        volume_ml_[i] = cells_[i].volume_ml;
    take_volumes();
    network_.reshape(cells_, tool_mm_);
}

void ContrastFlow::set_hole(std::size_t index, const WallHole &hole)
{
    wounds_.set_hole(index, hole);
    take_wounds();
}

void ContrastFlow::set_flap(std::size_t index, const WallFlap &flap)
{
    wounds_.set_flap(index, flap);
    take_wounds();
}

void ContrastFlow::take_wounds()
{
    network_.set_wounds(wounds_.open_holes(), wounds_.open_shares(cells_.size()), tool_mm_);
}

void find_thickest(const FlowCells &cells, std::span<const ToolBall> balls, std::vector<double> &tool_mm)
{
    tool_mm.assign(cells.size(), 0.0);
    if (tool_mm.empty()) return;
    std::size_t cell = 0; // a guess
    for (const ToolBall &ball : balls) {
        cell = cells.nearest(ball.place_m, cell);
        double &thickest = tool_mm[cell];
        thickest = std::max(thickest, ball.radius_m * 1e3);
    }
}

void ContrastFlow::set_tools(std::span<const ToolBall> balls)
{
    find_thickest(cells_, balls, tool_mm_);
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
    injecting_ = sources_.size();
    aortic_pressure_ = drive.aortic_pressure;
    find_widening();
    const bool has_valve = !stretch_.empty(), is_shut = has_valve && !drive.is_valve_open;
    network_.solve(drive, sources_, is_shut);
    // The aortic valve lets no blood back.
    if (has_valve && !is_shut && network_.inflow_ml_s(0) < 0.0) network_.solve(drive, sources_, true);
    out_mg_.resize(network_.runs().size());
    const double parts = parts_of_step();
    for (int part = 0; part < static_cast<int>(parts); ++part) {
        transport(step_s / parts, fluid);
        widen(step_s / parts);
    }
    if (widening_steps_ > 0) end_widening();
    mix(step_s);
    empty_sinuses(step_s);
    if (!wounds_.is_empty()) {
        wounds_.pass(network_, step_s);
        wounds_.exchange(volume_ml_, core_mg_, wall_mg_, step_s);
    }
    const std::vector<FlowRun> &runs = network_.runs();
    for (std::size_t r = 0; r < runs.size(); ++r)
        if (network_.bed_ml_s(r) > 0.0) distal_.pass(runs[r].end - 1, network_.bed_ml_s(r) * step_s);
    distal_.step();
}

// A cell (short segment of a vessel) that widens takes blood from its neighbours, and a cell that narrows
// gives blood to them. This exchange of blood is an added flow that carries no iodine of its own; the flow is
// spread evenly over the remaining time steps.
void ContrastFlow::find_widening()
{
    const double lumen_mg =
        budget_.injected_mg - budget_.out_mg - budget_.reflux_mg - budget_.leaked_mg - wounds_.pocket_mg();
    for (std::size_t i = 0; i < stretch_.size() && widening_steps_ == 0; ++i) {
        // After a pause of the simulation the volumes are those of another moment of the beat.
        const double most_ml = stretch_step_max * volume_ml_[i];
        if (lumen_mg < empty_mg && std::fabs(wanted_ml(i) - volume_ml_[i]) > most_ml) {
            volume_ml_[i] = wanted_ml(i);
            per_volume_[i] = 2.0 / volume_ml_[i];
        }
        sources_.push_back({i, -std::clamp(wanted_ml(i) - volume_ml_[i], -most_ml, most_ml) / step_s});
    }
    if (widening_steps_ == 0) return;
    least_ml_.resize(cells_.size());
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        const double missing_ml = wanted_ml(i) - volume_ml_[i];
        least_ml_[i] = volume_ml_[i] + std::min(missing_ml, 0.0) / widening_steps_;
        if (missing_ml != 0.0) sources_.push_back({i, -missing_ml / (widening_steps_ * step_s)});
    }
    network_.set_volumes(least_ml_);
}

void ContrastFlow::end_widening()
{
    if (--widening_steps_ > 0) return;
    for (const CellSource &source : std::span(sources_).subspan(injecting_)) {
        volume_ml_[source.cell] = wanted_ml(source.cell);
        per_volume_[source.cell] = 2.0 / volume_ml_[source.cell];
    }
    take_volumes();
}

// Each layer of blood has received its fraction of the flows, but must grow by half of the cell's growth.
// Because the fraction of the flows that a layer carries is not one half, one layer passes its excess volume
// to the other layer.
void ContrastFlow::widen(double dt_s)
{
    const double core_share = settings_.core_flow_share;
    for (std::size_t i = injecting_; i < sources_.size(); ++i) {
        const std::size_t cell = sources_[i].cell;
        const double half_ml = 0.5 * volume_ml_[cell], growth_ml = -sources_[i].flow_ml_s * dt_s;
        const double handed_ml = (core_share - 0.5) * growth_ml; // from the core to the wall
        const double moved_mg = handed_ml > 0.0
                                    ? handed_ml * core_mg_[cell] / (half_ml + core_share * growth_ml)
                                    : handed_ml * wall_mg_[cell] / (half_ml + (1.0 - core_share) * growth_ml);
        core_mg_[cell] -= moved_mg;
        wall_mg_[cell] += moved_mg;
        volume_ml_[cell] += growth_ml;
        per_volume_[cell] = 2.0 / volume_ml_[cell];
    }
}

// In one time step the faster layer must not lose more fluid than it holds; if it would, the time step is
// divided.
double ContrastFlow::parts_of_step()
{
    const std::vector<FlowRun> &runs = network_.runs();
    leaving_.assign(runs.size(), 0.0); // flow out of each run's last cell, ml/s
    double emptied = 0.0;
    for (std::size_t r = runs.size(); r-- > 0;) {
        const double q = network_.inflow_ml_s(r);
        if (q > 0.0 && runs[r].upstream >= 0) leaving_[static_cast<std::size_t>(runs[r].upstream)] += q;
        const double last = leaving_[r] + network_.outflow_ml_s(r) + std::max(-q, 0.0);
        emptied = std::max(
            {emptied, last * per_volume_[runs[r].end - 1], std::fabs(q) * 2.0 / runs[r].smallest_ml});
    }
    const double faster = std::max(settings_.core_flow_share, 1.0 - settings_.core_flow_share);
    return std::max(std::ceil(emptied * faster * step_s / emptied_max), 1.0);
}

// The iodine of each layer is transported separately by the upwind rule: a flow has the concentration of the
// cell that it leaves. Each of the two layers of blood has half of the cell's volume and a fixed fraction of
// every flow, including injected fluid. The flow into a layer of blood equals the flow out of it.
void ContrastFlow::transport(double dt_s, const InjectedFluid &fluid)
{
    const double core = settings_.core_flow_share * dt_s, wall = (1.0 - settings_.core_flow_share) * dt_s;
    carry(core, core_mg_);
    carry(wall, wall_mg_);
    for (const CellSource &source : std::span(sources_).first(injecting_)) {
        const double mg_per_s = source.flow_ml_s * fluid.iodine_mg_per_ml;
        core_mg_[source.cell] += core * mg_per_s;
        wall_mg_[source.cell] += wall * mg_per_s;
        budget_.injected_mg += mg_per_s * dt_s;
        branch_injected_mg_[static_cast<std::size_t>(cells_[source.cell].branch)] += mg_per_s * dt_s;
    }
}

// Transports the iodine of one layer, whose contents are given; `share_s` is the time step in seconds times
// the layer's fraction of the flows. All flows carry the concentrations that the cells had at the beginning
// of the time step.
void ContrastFlow::carry(double share_s, std::vector<double> &layer_mg)
{
    const std::vector<FlowRun> &runs = network_.runs();
    double *mg = layer_mg.data(), *in = in_mg_.data();
    const double *per_volume = per_volume_.data();
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const std::size_t begin = runs[r].begin, end = runs[r].end;
        const double k = share_s * network_.inflow_ml_s(r);
        const int up = runs[r].upstream;
        if (k > 0.0) {
            const std::size_t from = up < 0 ? 0 : runs[static_cast<std::size_t>(up)].end - 1;
            in[begin] = up < 0 ? 0.0 : k * per_volume[from] * mg[from]; // otherwise fresh blood
            for (std::size_t i = begin + 1; i < end; ++i) in[i] = k * per_volume[i - 1] * mg[i - 1];
        } else {
            for (std::size_t i = begin; i < end; ++i) in[i] = k * per_volume[i] * mg[i];
        }
        // When a vessel widens, blood without contrast medium flows back into the vessel from its vascular
        // bed.
        out_mg_[r] = share_s * std::max(network_.outflow_ml_s(r), 0.0) * per_volume[end - 1] * mg[end - 1];
    }
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const std::size_t begin = runs[r].begin, last = runs[r].end - 1;
        for (std::size_t i = begin; i < last; ++i) mg[i] += in[i] - in[i + 1];
        mg[last] += in[last] - out_mg_[r];
        double bed_mg = out_mg_[r];
        if (network_.leak_ml_s(r) > 0.0) { // a part of it leaves through holes
            const double share =
                network_.bed_ml_s(r) > 0.0 ? network_.leak_ml_s(r) / network_.outflow_ml_s(r) : 1.0;
            const double leaked_mg = share * out_mg_[r];
            wounds_.leak(last, network_.leak_ml_s(r) * share_s, leaked_mg);
            budget_.leaked_mg += leaked_mg;
            bed_mg -= leaked_mg;
        }
        budget_.out_mg += bed_mg;
        if (bed_mg != 0.0) distal_.take(runs[r].end - 1, bed_mg);
        branch_out_mg_[static_cast<std::size_t>(cells_[last].branch)] += out_mg_[r];
        const auto branch = static_cast<std::size_t>(cells_[begin].branch);
        if (in[begin] < 0.0 && has_sinus_[branch] && begin == cells_.branch_begin(branch))
            sinus_mg_[branch] -= in[begin];
        else if (runs[r].upstream >= 0)
            mg[runs[static_cast<std::size_t>(runs[r].upstream)].end - 1] -= in[begin];
        else
            budget_.reflux_mg -= in[begin];
    }
}

// The aorta's blood washes refluxed medium out of the sinuses, the faster it flows the sooner: in diastole
// the medium stays.
void ContrastFlow::empty_sinuses(double dt_s)
{
    for (std::size_t branch = 0; branch < sinus_mg_.size(); ++branch) {
        if (!(sinus_mg_[branch] > 0.0)) continue;
        const auto aorta = static_cast<std::size_t>(cells_[cells_.branch_begin(branch)].upstream);
        const double flow_ml_s = std::fabs(network_.inflow_ml_s(network_.run_of(aorta)));
        const double washing = stretch_.empty() ? 1.0 : flow_ml_s / mean_ml_s_;
        const double leaving_mg = sinus_mg_[branch] * std::min(dt_s / sinus_s * washing, 1.0);
        sinus_mg_[branch] -= leaving_mg;
        core_mg_[aorta] += 0.5 * leaving_mg;
        wall_mg_[aorta] += 0.5 * leaving_mg;
    }
}

// The difference of concentration between the two layers falls as exp(-k t), where k is proportional to the
// speed of the blood. The time step is implicit, so that the difference of concentration between the two
// layers never changes sign.
void ContrastFlow::mix(double dt_s)
{
    double *core = core_mg_.data(), *wall = wall_mg_.data();
    const double *mixing = mixing_.data();
    const std::vector<FlowRun> &runs = network_.runs();
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const double flow_ml = std::fabs(network_.inflow_ml_s(r)) * dt_s;
        for (std::size_t i = runs[r].begin; i < runs[r].end; ++i) {
            const double x = flow_ml * mixing[i];
            const double moved = 0.5 * (core[i] - wall[i]) * x / (1.0 + x);
            core[i] -= moved;
            wall[i] += moved;
        }
    }
}

double ContrastFlow::iodine_mg_per_ml(std::size_t cell) const
{
    return (core_mg_[cell] + wall_mg_[cell]) / volume_ml_[cell];
}

double ContrastFlow::held_mg() const
{
    double sum = 0.0;
    for (std::size_t i = 0; i < core_mg_.size(); ++i) sum += core_mg_[i] + wall_mg_[i];
    for (double mg : sinus_mg_) sum += mg;
    return sum + wounds_.pocket_mg();
}

// Sums two amounts of contrast medium for each branch: what entered at the branch's beginning, and what was
// injected in the branch or downstream of it. Branches come after their parents.
std::vector<double> ContrastFlow::received_mg() const
{
    const std::size_t count = cells_.branch_count();
    std::vector<double> behind_mg = branch_out_mg_, injected_mg = branch_injected_mg_, received_mg(count);
    std::vector<int> parents(count, -1);
    for (std::size_t b = 0; b < count; ++b) {
        const std::size_t begin = cells_.branch_begin(b), end = cells_.branch_begin(b + 1);
        for (std::size_t i = begin; i < end; ++i) behind_mg[b] += core_mg_[i] + wall_mg_[i];
        for (const WallFlap &flap : wounds_.flaps())
            if (flap.begin >= begin && flap.begin < end) behind_mg[b] += flap.iodine_mg;
        if (begin < end && cells_[begin].upstream >= 0)
            parents[b] = cells_[static_cast<std::size_t>(cells_[begin].upstream)].branch;
        if (parents[b] >= 0) behind_mg[static_cast<std::size_t>(parents[b])] += sinus_mg_[b];
    }
    for (std::size_t b = count; b-- > 0;) {
        const double came_in_mg =
            behind_mg[b] - injected_mg[b]; // through its beginning; below 0: flowed back
        received_mg[b] += std::max(branch_injected_mg_[b] + came_in_mg, 0.0);
        if (parents[b] < 0) continue;
        const auto parent = static_cast<std::size_t>(parents[b]);
        behind_mg[parent] += behind_mg[b];
        injected_mg[parent] += injected_mg[b];
        received_mg[parent] += std::max(-came_in_mg, 0.0);
    }
    return received_mg;
}

// --- snapshots ---

void ContrastFlow::archive(StateArchive &state)
{
    constexpr double mg_per_ml_max = 1000.0, flow_max_ml_s = 1e6; // no medium has as much iodine
    std::size_t cells = cells_.size();
    state.index(cells, SIZE_MAX);
    state.require(cells == cells_.size());
    distal_.archive(state);
    for (double *sum : {&budget_.injected_mg, &budget_.out_mg, &budget_.reflux_mg, &budget_.leaked_mg})
        state.real(*sum);
    wounds_.archive(state, cells_.size());
    for (std::vector<double> *sums : {&branch_injected_mg_, &branch_out_mg_}) state.reals(*sums);
    state.reals(sinus_mg_);
    state.integer(widening_steps_, 0, 1000);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        // A cell that is not being widened has the volume that follows from its shape, and from the pressure.
        const double shape_ml = cells_[i].volume_ml;
        const double widest = widening_steps_ > 0 ? 1e4 : i < stretch_.size() ? 10.0 : 1.0;
        state.real(volume_ml_[i], shape_ml / widest, shape_ml * widest);
        const double most_mg = 0.5 * mg_per_ml_max * shape_ml * widest;
        state.real(core_mg_[i], -most_mg, most_mg);
        state.real(wall_mg_[i], -most_mg, most_mg);
        state.real(tool_mm_[i], 0.0, 100.0);
    }
    std::vector<double> throats = network_.throat_flows_ml_s();
    state.reals(throats, 0.0, flow_max_ml_s);
    state.list(mouths_, [&](CellSource &mouth) {
        state.index(mouth.cell, cells_.size());
        state.real(mouth.flow_ml_s, 0.0, 1.0);
    });
    if (!state.restores() || state.is_refused()) return;
    network_.set_throat_flows(throats);
    take_volumes();
    take_wounds(); // and the tools
}

std::vector<std::uint8_t> ContrastFlow::snapshot() const
{
    std::vector<std::uint8_t> bytes;
    StateArchive state = StateArchive::saving(bytes);
    ContrastFlow(*this).archive(state);
    return bytes;
}

bool ContrastFlow::restore(std::span<const std::uint8_t> bytes)
{
    ContrastFlow restored = *this;
    StateArchive state = StateArchive::restoring(bytes);
    restored.archive(state);
    if (state.is_refused() || !state.is_at_end()) return false;
    *this = std::move(restored);
    return true;
}

} // namespace crn
