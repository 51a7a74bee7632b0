#include "host/patient/complications.hpp"
#include "host/model/units.hpp"
#include "host/model/vessel_map.hpp"
#include "host/model/wire_place.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/tool_balls.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{
namespace
{

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double tip_reach_m = 1.5e-3;     // nodes so far behind a tip push with it
constexpr double tip_direction_m = 2.0e-3; // over which its direction is measured
// The shaft's direction is that of the line so far behind the tip. A tip that turns more than 60 degrees away
// from it, such as that of a J wire, does not lead: the wire's bow does, which is blunt.
constexpr double shaft_behind_m = 6.0e-3, leading_cosine = 0.5;
constexpr double same_place_mm = 5.0;   // injuries of one kind so near to each other are one
constexpr double touching_share = 0.85; // of the healthy radius: a narrower ball stretches no wall
constexpr double unfolded_kPa = 50.0, folds_share = 0.03; // docs/balloon.md
constexpr double newton_per_q22 = 1.0 / (1 << 22);

double tip_radius_um(const Instrument &tool)
{
    return tool.table.knots_count > 0 ? tool.table.knots[0].radius_outer_um : 0.0;
}

Vector3d force_N(const crn_wire_contact &contact)
{
    return newton_per_q22 * Vector3d(contact.force_x_N_q22, contact.force_y_N_q22, contact.force_z_N_q22);
}

double healthy_radius_mm(const FlowCell &cell)
{
    return std::sqrt(std::sqrt(cell.length_mm / cell.healthy_per_r4_mm3));
}

Vector3d axis_of(const FlowCells &cells, std::size_t cell)
{
    return (cells.last_face_m(cell) - cells.first_face_m(cell)).normalized();
}

// Returns the way out of the vessel: across its axis, on the side of the place; a place on the axis gives the
// direction `ahead`, or the front of the patient.
Vector3d outward_of(const FlowCells &cells, std::size_t cell, const Vector3d &place_m, const Vector3d &ahead)
{
    const Vector3d axis = axis_of(cells, cell);
    for (Vector3d way : {Vector3d(place_m - cells.middle_m(cell)), ahead, Vector3d(Vector3d::UnitZ()),
                         Vector3d(Vector3d::UnitX())}) {
        const double length = way.norm();
        way -= axis.dot(way) * axis;
        if (way.norm() > 0.1 * length && way.norm() > 1e-9) return way.normalized();
    }
    return Vector3d::UnitX();
}

} // namespace

double free_balloon_mm(const crn_wire_instrument &tool, double pressure_kPa)
{
    if (tool.balloon_count < 2 || pressure_kPa < unfolded_kPa) return 0.0;
    const auto *rows = tool.balloon;
    const double first_kPa = rows[0].pressure_kPa, first_mm = rows[0].diameter_um * 1e-3;
    if (pressure_kPa <= first_kPa)
        return first_mm *
               (1.0 - folds_share * (first_kPa - pressure_kPa) / std::max(first_kPa - unfolded_kPa, 1.0));
    std::size_t next = 1;
    while (next + 1 < tool.balloon_count && rows[next].pressure_kPa < pressure_kPa) ++next;
    const double low_kPa = rows[next - 1].pressure_kPa, high_kPa = rows[next].pressure_kPa;
    const double low_mm = rows[next - 1].diameter_um * 1e-3, high_mm = rows[next].diameter_um * 1e-3;
    return low_mm + (pressure_kPa - low_kPa) / (high_kPa - low_kPa) * (high_mm - low_mm);
}

double tip_area_mm2(const Instrument &tool)
{
    const double radius_mm = tip_radius_um(tool) * 1e-3;
    return pi * radius_mm * radius_mm;
}

// The wall's force on the nodes at the tip, friction included, has a part along the tip. This part pushes the
// tip back, and the tip pushes the wall in front of it with the same force. The sides of a tip that slides
// along a wall press across the tip, and do not count.
TipPush tip_push(const WireFrame &wire, const crn_wire_contacts &contacts, std::size_t tool)
{
    TipPush push;
    if (wire.nodes.size() < 2 || tool >= std::max<std::size_t>(wire.tip_arc_m.size(), 1)) return push;
    const double tip_arc_m = wire.tip_arc_m.empty() ? 0.0 : wire.tip_arc_m[tool];
    if (tip_arc_m + tip_direction_m > wire.nodes.back().arc_m) return push; // still in the sheath
    for (std::size_t other = tool + 1; other < wire.tip_arc_m.size(); ++other)
        if (wire.tip_arc_m[other] <= tip_arc_m + tip_reach_m) return push; // inside another tool
    push.is_known = true;
    push.place_m = line_place_m(wire, tip_arc_m);
    push.ahead = (push.place_m - line_place_m(wire, tip_arc_m + tip_direction_m)).normalized();
    const Vector3d shaft = (line_place_m(wire, tip_arc_m + shaft_behind_m) -
                            line_place_m(wire, tip_arc_m + shaft_behind_m + tip_direction_m))
                               .normalized();
    if (push.ahead.dot(shaft) < leading_cosine) return push;
    Vector3d sum_N = Vector3d::Zero();
    for (std::uint16_t i = 0; i < contacts.contacts_count; ++i) {
        const std::size_t node = contacts.contacts[i].node;
        if (node >= wire.nodes.size()) continue;
        const double behind_m = wire.nodes[node].arc_m - tip_arc_m;
        if (behind_m > -1e-6 && behind_m <= tip_reach_m) sum_N += force_N(contacts.contacts[i]);
    }
    push.force_N = std::max(-sum_N.dot(push.ahead), 0.0);
    return push;
}

PatientComplications::PatientComplications(const VesselTree &vessels, const std::vector<Instrument> &tools)
    : vessels_(vessels), tools_(tools)
{
}

void PatientComplications::set_tools(const std::vector<Instrument> &tools, ChangedPositions changed)
{
    tools_ = tools;
    for (std::size_t k = 0; k < tips_.size(); ++k)
        if (has_changed(changed, k)) tips_[k] = {};
    balloon_perforation_.reset();
    balloon_dissection_.reset();
}

// Most contacts are far weaker than any limit; then the shape of the tools is not needed.
bool PatientComplications::feel(const crn_wire_contacts &contacts)
{
    double least_N = 1e9;
    for (const Instrument &tool : tools_)
        if (tool.table.knots_count > 0)
            least_N =
                std::min(least_N, limits_.dissection_tip_kPa * 1e-3 * tip_area_mm2(tool)); // kPa mm2: mN
    bool is_strong = false;
    for (std::uint16_t i = 0; limits_.is_on && i < contacts.contacts_count && !is_strong; ++i)
        is_strong = force_N(contacts.contacts[i]).norm() > 0.5 * least_N; // two nodes may share a tip's force
    if (!is_strong || vessels_.branches.empty()) {
        tips_.fill({});
        return false;
    }
    contacts_ = contacts;
    return true;
}

bool PatientComplications::locate(const WireFrame &wire, PatientContrast &contrast)
{
    if (wire.tick != contacts_.tick) return false;
    const FlowCells &cells = contrast.cells_at(wire);
    bool has_changed_any = false;
    for (std::size_t k = 0; k < std::min(tools_.size(), tips_.size()); ++k) {
        const TipPush push = tip_push(wire, contacts_, k);
        const double area_mm2 = tools_[k].table.knots_count > 0 ? tip_area_mm2(tools_[k]) : 0.0;
        if (!push.is_known || !(area_mm2 > 0.0)) {
            tips_[k] = {};
            continue;
        }
        Found found;
        found.tool = tools_[k].name;
        found.place_m = push.place_m;
        found.ahead = push.ahead;
        found.force_N = push.force_N;
        found.value = push.force_N / area_mm2 * 1e3;
        found.front_mm = 2e-3 * tip_radius_um(tools_[k]);
        found.cell = cells.nearest(push.place_m);
        for (const InjuryKind kind : {InjuryKind::dissection, InjuryKind::perforation})
            has_changed_any |=
                watch(kind == InjuryKind::dissection ? tips_[k].dissection : tips_[k].perforation, kind,
                      found, wire.tick, cells, contrast);
    }
    return has_changed_any;
}

void PatientComplications::tick(const crn_wire_tick_state &state)
{
    const bool is_up = state.balloon_bits == 0 && state.balloon_kPa >= unfolded_kPa;
    if (is_up && balloon_kPa_ == 0) look_tick_ = state.tick;
    balloon_kPa_ = is_up ? state.balloon_kPa : 0;
    if (is_up) return;
    balloon_perforation_.reset();
    balloon_dissection_.reset();
}

std::uint32_t PatientComplications::next_tick() const
{
    if (balloon_kPa_ == 0 || !limits_.is_on || vessels_.branches.empty()) return UINT32_MAX;
    return (look_tick_ / look_every_ticks + 1) * look_every_ticks;
}

// Returns the place at which the balloon is largest for its vessel, and the stretch of vessel around it that
// it stretches beyond the limit of a dissection.
std::optional<PatientComplications::Found> PatientComplications::stretched(const WireFrame &wire,
                                                                           const FlowCells &cells) const
{
    const std::optional<std::size_t> tool = balloon_tool(tools_);
    if (!tool) return {};
    const double free_mm = free_balloon_mm(tools_[*tool].table, balloon_kPa_);
    Found found;
    found.cause = InjuryCause::balloon;
    found.tool = tools_[*tool].name;
    std::vector<std::size_t> beyond; // cells
    std::size_t guess = 0;
    for (const BalloonPoint &ball : balloon_pose(wire, *tool).points) {
        const std::size_t cell = guess = cells.nearest(1e-3 * ball.centre_mm, guess);
        const double healthy_mm = healthy_radius_mm(cells[cell]);
        if (ball.radius_mm < touching_share * healthy_mm) continue;
        const double ratio = free_mm / (2.0 * healthy_mm);
        if (ratio > limits_.dissection_balloon_ratio) beyond.push_back(cell);
        if (ratio <= found.value) continue;
        found.value = ratio;
        found.cell = cell;
        found.place_m = 1e-3 * ball.centre_mm;
    }
    if (!(found.value > 0.0)) return {};
    found.begin = found.cell;
    found.end = found.cell + 1;
    for (const std::size_t cell : beyond) {
        if (cells[cell].branch != cells[found.cell].branch) continue;
        found.begin = std::min(found.begin, cell);
        found.end = std::max(found.end, cell + 1);
    }
    return found;
}

bool PatientComplications::advance(const WireFrame &wire, PatientContrast &contrast)
{
    if (wire.tick < next_tick() || wire.nodes.size() < 2) return false;
    look_tick_ = wire.tick;
    const FlowCells &cells = contrast.cells_at(wire);
    const std::optional<Found> found = stretched(wire, cells);
    if (!found) {
        balloon_perforation_.reset();
        balloon_dissection_.reset();
        return false;
    }
    const bool is_torn =
        watch(balloon_dissection_, InjuryKind::dissection, *found, wire.tick, cells, contrast);
    return watch(balloon_perforation_, InjuryKind::perforation, *found, wire.tick, cells, contrast) ||
           is_torn;
}

double PatientComplications::limit_of(InjuryKind kind, InjuryCause cause) const
{
    const bool is_hole = kind == InjuryKind::perforation;
    if (cause == InjuryCause::tip) return is_hole ? limits_.perforation_tip_kPa : limits_.dissection_tip_kPa;
    return is_hole ? limits_.perforation_balloon_ratio : limits_.dissection_balloon_ratio;
}

// The same push, or the same inflation, injures once. While it lasts, the injury grows with it.
bool PatientComplications::watch(Watch &watched, InjuryKind kind, const Found &found, std::uint32_t tick,
                                 const FlowCells &cells, PatientContrast &contrast)
{
    const double hold_ms = found.cause == InjuryCause::tip ? limits_.tip_hold_ms : limits_.balloon_hold_ms;
    const bool is_held = watched.limit.take(tick, found.value, limit_of(kind, found.cause), hold_ms);
    if (!watched.limit.is_above()) watched.injury.reset();
    if (!is_held) return false;
    if (!watched.injury) watched.injury = near(kind, found.cell, cells);
    const bool is_new = !watched.injury;
    if (is_new) {
        watched.injury = injuries_.size();
        injuries_.push_back(make(kind, found, tick, cells));
    }
    Injury &injury = injuries_[*watched.injury];
    const bool has_grown = injury.cause == found.cause && found.value > injury.value;
    if (!is_new && !has_grown) return false;
    if (has_grown) {
        injury.value = found.value;
        injury.force_N = std::max(injury.force_N, found.force_N);
        size(injury, found, cells);
    }
    wound(injury, tick, cells, contrast);
    return true;
}

std::optional<std::size_t> PatientComplications::near(InjuryKind kind, std::size_t cell,
                                                      const FlowCells &cells) const
{
    for (std::size_t i = 0; i < injuries_.size(); ++i) {
        const Injury &one = injuries_[i];
        if (one.kind != kind || cells[one.cell].branch != cells[cell].branch) continue;
        if (cell >= one.cell && cell < one.cell + one.cells) return i;
        const std::size_t first = std::min(cell, one.cell), last = std::max(cell, one.cell);
        double apart_mm = 0.0;
        for (std::size_t k = first; k < last; ++k) apart_mm += cells[k].length_mm;
        if (apart_mm < same_place_mm) return i;
    }
    return {};
}

std::string PatientComplications::vessel_name(std::size_t cell, const FlowCells &cells) const
{
    const auto branch = static_cast<std::size_t>(cells[cell].branch);
    const std::vector<Vector3d> &points_m = vessels_.branches[branch].points_m;
    double arc_m = 0.0;
    for (std::size_t i = 0; i < cells[cell].middle.point && i + 1 < points_m.size(); ++i)
        arc_m += (points_m[i + 1] - points_m[i]).norm();
    const VesselMap map(vessels_);
    return map.vessels()[map.vessel_of(branch, arc_m)].name;
}

Injury PatientComplications::make(InjuryKind kind, const Found &found, std::uint32_t tick,
                                  const FlowCells &cells) const
{
    Injury injury;
    injury.kind = kind;
    injury.cause = found.cause;
    injury.tick = tick;
    injury.tool = found.tool;
    injury.vessel = vessel_name(found.cell, cells);
    injury.place_m = found.place_m;
    injury.outward = outward_of(cells, found.cell, found.place_m, found.ahead);
    injury.value = found.value;
    injury.limit = limit_of(kind, found.cause);
    injury.force_N = found.force_N;
    injury.cell = found.cell;
    std::size_t of_kind = 0;
    for (const Injury &one : injuries_) of_kind += one.kind == kind;
    injury.wound = of_kind;
    size(injury, found, cells);
    return injury;
}

// Sets how large the wound is. The flap of a tip lies downstream of the tip's cell, as the blood opens it.
void PatientComplications::size(Injury &injury, const Found &found, const FlowCells &cells) const
{
    if (injury.kind == InjuryKind::perforation) {
        const bool is_tip = found.cause == InjuryCause::tip;
        const double hole_mm = is_tip ? found.front_mm : balloon_hole_mm(limits_, found.value);
        injury.size_mm = std::max(injury.size_mm, hole_mm);
        injury.bleeds = injury.size_mm >= limits_.crater_below_mm;
        injury.cells = 1;
        return;
    }
    const bool is_tip = injury.cause == InjuryCause::tip;
    injury.narrowing = flap_narrowing(limits_, injury.cause, injury.value, injury.limit);
    const auto branch = static_cast<std::size_t>(cells[injury.cell].branch);
    const std::size_t branch_end = cells.branch_begin(branch + 1);
    std::size_t end = found.end;
    if (!is_tip) {
        injury.cell = found.begin;
    } else if (injury.cells == 0) {
        injury.cell = std::min(injury.cell + 1, branch_end - 1);
        double length_mm = 0.0;
        for (end = injury.cell; end < branch_end && length_mm < limits_.flap_mm; ++end)
            length_mm += cells[end].length_mm;
    } else {
        end = injury.cell + injury.cells;
    }
    injury.cells = end - injury.cell;
    injury.size_mm = 0.0;
    for (std::size_t i = injury.cell; i < end; ++i) injury.size_mm += cells[i].length_mm;
}

void PatientComplications::wound(const Injury &injury, std::uint32_t tick, const FlowCells &cells,
                                 PatientContrast &contrast) const
{
    if (injury.kind == InjuryKind::dissection) {
        WallFlap flap;
        flap.begin = injury.cell;
        flap.end = injury.cell + injury.cells;
        flap.narrowing = injury.narrowing;
        flap.pocket_ml = pocket_ml(cells, flap.begin, flap.end, flap.narrowing);
        flap.fill_s = limits_.pocket_fill_s;
        flap.empty_s = injury_class(injury, limits_) == "B" ? limits_.pocket_fill_s : limits_.pocket_empty_s;
        flap.side = injury.outward;
        contrast.set_flap(injury.wound, flap, tick);
        return;
    }
    WallHole hole;
    hole.cell = injury.cell;
    hole.ml_s_per_mmHg = injury.bleeds ? hole_ml_s_per_mmHg(limits_, injury.size_mm) : 0.0;
    hole.seal_s = limits_.seal_s;
    hole.outward = injury.outward;
    hole.diameter_mm = injury.size_mm;
    hole.blush_mg_per_ml = limits_.blush_mg_per_ml;
    hole.is_jet = injury.size_mm >= limits_.jet_mm;
    contrast.set_hole(injury.wound, hole, tick);
}

std::size_t PatientComplications::count(InjuryKind kind) const
{
    return static_cast<std::size_t>(std::count_if(injuries_.begin(), injuries_.end(),
                                                  [=](const Injury &one) { return one.kind == kind; }));
}

double PatientComplications::lost_around_heart_ml(const ContrastFlow &flow) const
{
    double sum_ml = 0.0;
    for (const WallHole &hole : flow.wounds().holes()) {
        const VesselBed bed = vessels_.branches[static_cast<std::size_t>(flow.cells()[hole.cell].branch)].bed;
        if (bed == VesselBed::left_coronary || bed == VesselBed::right_coronary) sum_ml += hole.leaked_ml;
    }
    return sum_ml;
}

double PatientComplications::pressure_left(const ContrastFlow &flow) const
{
    if (flow.wounds().holes().empty()) return 1.0;
    return crn::pressure_left(limits_, lost_around_heart_ml(flow), flow.wounds().leaked_ml());
}

std::string PatientComplications::notice() const
{
    return injuries_.empty() ? "" : injury_notice(injuries_.back(), limits_);
}

void PatientComplications::archive(StateArchive &state, std::uint32_t now,
                                   const std::vector<Instrument> &tools)
{
    if (state.restores()) tools_ = tools;
    state.flag(limits_.is_on);
    for (const ComplicationLimit &limit : complication_limits())
        state.real(limits_.*limit.value, limit.low, limit.high);
    state.list(injuries_, [&](Injury &one) { archive_injury(state, one); });
    const auto archive_watch = [&](Watch &watched) {
        watched.limit.archive(state);
        state.optional(watched.injury, [&](std::size_t &index) { state.index(index, injuries_.size()); });
    };
    for (Tip &tip : tips_) {
        archive_watch(tip.perforation);
        archive_watch(tip.dissection);
    }
    archive_watch(balloon_perforation_);
    archive_watch(balloon_dissection_);
    state.integer(balloon_kPa_);
    state.integer<std::uint32_t>(look_tick_, 0, now);
}

} // namespace crn
