#include "host/patient/contrast.hpp"
#include "host/base/format.hpp"
#include "host/effects/lumen_pressure.hpp"
#include "host/model/units.hpp"
#include "host/patient/layering.hpp"
#include "host/patient/tool_balls.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace crn
{
namespace
{

using Eigen::Vector3d;
using Clock = std::chrono::steady_clock;

double seconds(Clock::duration duration)
{
    return std::chrono::duration<double>(duration).count();
}

constexpr double widening_step_m = 0.25e-3;
constexpr double invisible_mg_per_ml = 0.3; // 0.1 % of a 5 mm column: less than noise
constexpr double forgotten_mg = 0.01;       // mg in the whole lumen below which medium is ignored,
constexpr double invisible_distal_mg = 1.0; // and beyond the lumen; both stay where they are
constexpr double beats_per_min = 70.0;
constexpr std::uint32_t never = std::numeric_limits<std::uint32_t>::max();
constexpr double stream_radii =
    1.5; // radii of the vessel over which the stream from the tip spreads to fill it
constexpr double mixing_radii = 2.0;  // over which the medium's upstream end rises; assumed
constexpr double stream_fades = 0.01; // fading per ms, after the injection

// An artery of the heart does not end where its centreline ends. If no small vessel continues it, its column
// becomes narrower over the last radii.
double taper_at(double radii_before_end)
{
    constexpr double taper_radii = 8.0, narrowest = 0.35;
    return std::clamp(narrowest + (1.0 - narrowest) * radii_before_end / taper_radii, narrowest, 1.0);
}

// The X-ray draws every piece of a column of medium as a cylinder. A piece whose width changes is divided
// into shorter pieces, so that its edge has no visible steps.
void go_to(SweptCurve &curve, const SweptPoint &point)
{
    const SweptPoint from = curve.points.back();
    const double wider_m = std::fabs(point.radius_m - from.radius_m);
    const int pieces = std::clamp(static_cast<int>(wider_m / widening_step_m) + 1, 1, 10);
    for (int k = 1; k < pieces; ++k) {
        const double share = static_cast<double>(k) / pieces;
        curve.points.push_back({from.at_m + share * (point.at_m - from.at_m),
                                from.radius_m + share * (point.radius_m - from.radius_m),
                                from.share + share * (point.share - from.share)});
    }
    curve.points.push_back(point);
}

// The share of the full concentration at a place before (-1 to 0) or after the face where medium begins, in
// halves of the mixing length: a straight rise.
double mixed_share(double halves)
{
    return std::clamp(0.5 + 0.5 * halves, 0.0, 1.0);
}

constexpr double kPa_per_psi = 6.894757;

// Returns the reason why the stated flow of medium cannot pass through the tool, or an empty string if it
// can.
std::string flow_refusal(const Instrument &tool, std::span<const InnerTool> inside, double flow_ml_s,
                         double iodine_mg_per_ml)
{
    const double needed_kPa = injection_pressure_kPa(tool, inside, flow_ml_s, iodine_mg_per_ml);
    if (needed_kPa <= injection_pressure_max_kPa) return "";
    const double possible_ml_s = flow_ml_s * injection_pressure_max_kPa / needed_kPa;
    return formatted("%g ml/s THROUGH '%s'%s NEEDS %s - at most %.3g ml/s at %.0f psi; inject more slowly%s",
                     flow_ml_s, tool.name.c_str(), inside.empty() ? "" : " BESIDE THE DEVICES IN IT",
                     needed_kPa < 1e9 ? formatted("%.0f psi", needed_kPa / kPa_per_psi).c_str()
                                      : "AN OPEN LUMEN",
                     possible_ml_s, injection_pressure_max_kPa / kPa_per_psi,
                     inside.empty() ? " or through a wider device" : " or withdraw the inner device to 0 mm");
}

double end_hole_radius_m(const Instrument &tool)
{
    return tool.table.knots_count > 0 ? tool.table.knots[0].radius_inner_um * 1e-6 : 0.0;
}

} // namespace

std::vector<CatheterMouth> catheter_mouths(const Instrument &tool, const WireFrame &wire, double tip_arc_m)
{
    const double radius_m = end_hole_radius_m(tool);
    std::vector<CatheterMouth> mouths = {{place_at(wire, tip_arc_m), radius_m * radius_m}};
    double sum = mouths[0].share;
    for (const SideHoles &holes : tool.side_holes)
        for (std::uint32_t i = 0; i < holes.count; ++i) {
            const double along = holes.count > 1 ? static_cast<double>(i) / (holes.count - 1) : 0.0;
            const double arc_m =
                tip_arc_m + holes.arc_begin_m + along * (holes.arc_end_m - holes.arc_begin_m);
            mouths.push_back({place_at(wire, arc_m), 0.25 * holes.diameter_m * holes.diameter_m});
            sum += mouths.back().share;
        }
    for (CatheterMouth &mouth : mouths) mouth.share = sum > 0.0 ? mouth.share / sum : 1.0;
    return mouths;
}

std::optional<std::size_t> injecting_tool(const std::vector<Instrument> &tools, std::int32_t asked)
{
    for (std::size_t k = tools.size(); k-- > 0;)
        if ((asked == 0 || k + 1 == static_cast<std::size_t>(asked)) && has_lumen(tools[k])) return k;
    return {};
}

bool is_in_patient(const crn_wire_tool_state &tool)
{
    constexpr double taken_out_m = 1e-3;
    return units::metres(tool.inserted_m_q30) > taken_out_m;
}

std::string injection_refusal(const std::vector<Instrument> &tools, const RoomCommand &command,
                              double iodine_mg_per_ml)
{
    if (command.action != RoomAction::inject || command.values[0] == 0) return "";
    const std::int32_t asked = command.values[2];
    if (const auto tool = injecting_tool(tools, asked))
        return flow_refusal(tools[*tool], {}, command.values[1] * 1e-3, iodine_mg_per_ml);
    if (asked == 0) return "NO CATHETER - contrast medium needs a device with a lumen";
    if (static_cast<std::size_t>(asked) > tools.size())
        return "NO DEVICE " + std::to_string(asked) + " to inject through";
    return "'" + tools[static_cast<std::size_t>(asked) - 1].name + "' HAS NO LUMEN to inject through";
}

PatientContrast::PatientContrast(const VesselTree &vessels, const std::vector<Instrument> &tools,
                                 const Motion *motion, LesionOpening opening)
    : tools_(tools), vessels_(vessels), moved_(vessels, motion, opening), opening_(std::move(opening)),
      flow_(vessels), mean_flows_ml_s_(mean_flows_ml_s(flow_.cells()))
{
}

// The syringe was connected to the tool that was taken out, so the rest of its injection is lost; the medium
// in the vessels stays.
void PatientContrast::set_tools(const std::vector<Instrument> &tools, ChangedPositions changed,
                                std::uint32_t tick)
{
    tools_ = tools;
    if (!has_changed(changed, tool_) || state_ == State::idle) return;
    injector_.stop(tick);
    tool_ = injecting_tool(tools_, 0).value_or(tool_);
}

// Returns the tools that lie in the lumen of `tool`.
std::vector<InnerTool> PatientContrast::inside(std::size_t tool, const crn_wire_tick_state &state) const
{
    std::vector<InnerTool> inner;
    const auto inserted_m = [&](std::size_t k) { return units::metres(state.tools[k].inserted_m_q30); };
    for (std::size_t k = 0; k < tool && tool < state.tools_count; ++k)
        if (is_in_patient(state.tools[k])) inner.push_back({&tools_[k], inserted_m(tool) - inserted_m(k)});
    return inner;
}

// Returns the reason why the requested injection would need too high a pressure, or an empty string if it
// would not. The tools inside the injecting tool narrow its lumen over the length to which they are inserted.
std::string PatientContrast::pressure_refusal(const Asked &asked, const crn_wire_tick_state &state) const
{
    return flow_refusal(tools_[asked.tool], inside(asked.tool, state), asked.flow_ml_s,
                        asked.iodine_mg_per_ml);
}

std::optional<double> PatientContrast::injection_kPa_per_ml_s(const crn_wire_tick_state &state) const
{
    const std::optional<std::size_t> tool = injecting_tool(tools_, 0);
    if (!tool) return {};
    return injection_pressure_kPa(tools_[*tool], inside(*tool, state), 1.0, iodine_mg_per_ml_);
}

void PatientContrast::tick(const crn_wire_tick_state &state)
{
    last_ = state;
    judge_asked();
    if (state_ != State::flows) return;
    beats_.push_back({state.tick, core_beat(state.beat_ms, state.interval_ms,
                                            (state.rhythm_bits & CRN_WIRE_RHYTHM_IS_RESTING) != 0)});
}

// Checks the requested injections with the positions of the tools at the tick of each injection. Before the
// first tick the positions of the tools are not known.
void PatientContrast::judge_asked()
{
    while (!asked_.empty() && last_.tick > 0 && asked_.front().tick <= last_.tick) {
        const std::string why = pressure_refusal(asked_.front(), last_);
        if (!why.empty()) {
            injector_.cancel(asked_.front().number);
            refusals_.push_back({asked_.front().tick, why});
        }
        asked_.erase(asked_.begin());
    }
}

// `next` is the index of the next heartbeat; the index only increases, because the function is called with
// increasing ticks.
BeatPhase PatientContrast::beat_at(std::uint32_t tick, std::size_t &next) const
{
    while (next < beats_.size() && beats_[next].tick < tick) ++next;
    if (next < beats_.size() && beats_[next].tick == tick) return beats_[next].phase;
    return steady_beat(tick, beats_per_min);
}

// Moves the centrelines of the vessels to where heart and breath have moved the vessels in this frame.
void PatientContrast::place_vessels(const WireFrame &wire)
{
    curves_at_ = {wire.heart_phase32, wire.breath_phase32};
    if (moved_.can_move()) flow_.place(moved_.at(curves_at_, opening_, flow_open_));
}

VesselTree PatientContrast::opened_vessels() const
{
    VesselTree opened = vessels_;
    opening_.open(vessels_, seen_open_, opened);
    return opened;
}

// The simulated vessels widen only at the fixed ticks at which the tools' shape is read, so that the medium
// does not depend on which pictures were requested.
bool PatientContrast::open_vessels(const WireFrame &wire)
{
    if (opening_.is_empty() || wire.lesions_open == flow_open_) return false;
    const bool was_open = opening_.is_any_open(flow_open_);
    flow_open_ = wire.lesions_open;
    if (!was_open && !opening_.is_any_open(flow_open_)) return false;
    VesselTree opened = vessels_;
    opening_.open(vessels_, flow_open_, opened);
    flow_.reshape(opened, flow_.held_mg() > 0.0 ? static_cast<int>(look_every_ticks) : 0);
    return true;
}

std::string PatientContrast::refusal(const RoomCommand &command, double iodine_mg_per_ml) const
{
    const std::string why = injection_refusal(tools_, command, iodine_mg_per_ml);
    if (!why.empty() || command.action != RoomAction::inject || command.values[0] == 0) return why;
    return flow_.cells().size() == 0
               ? "NO VESSELS - this scene has no tree for contrast medium: bake it again"
               : "";
}

std::string PatientContrast::command(std::uint32_t tick, const RoomCommand &command)
{
    const std::string why = refusal(command, iodine_mg_per_ml_);
    if (!why.empty()) return why;
    if (command.action == RoomAction::contrast_strength) iodine_mg_per_ml_ = command.values[0];
    if (command.action != RoomAction::inject) return "";
    if (command.values[0] == 0) {
        injector_.stop(tick);
        return "";
    }
    tool_ = *injecting_tool(tools_, command.values[2]);
    const std::uint64_t number =
        injector_.inject(tick, command.values[0], command.values[1], iodine_mg_per_ml_);
    asked_.push_back({tick, number, tool_, command.values[1] * 1e-3, iodine_mg_per_ml_});
    judge_asked();
    if (state_ == State::idle) state_ = State::waits;
    return "";
}

std::uint32_t PatientContrast::next_tick() const
{
    if (look_due() == never) return never;
    return static_cast<std::uint32_t>(std::max<std::int64_t>(look_due(), seen_tick_ + 1));
}

// Returns the next tick at which the shape of the tools must be read: a multiple of look_every_ticks,
// whichever other frames are requested; never, if there is nothing to simulate.
std::uint32_t PatientContrast::look_due() const
{
    if (state_ == State::flows) return (look_tick_ / look_every_ticks + 1) * look_every_ticks;
    if (state_ == State::idle || injector_.is_empty()) return wake_tick_;
    return std::min(wake_tick_,
                    (injector_.first_tick() + look_every_ticks - 1) / look_every_ticks * look_every_ticks);
}

// Advances the medium to the frame's tick, with the tools at their last known positions. If the shape of the
// tools must be read at this tick, it is read from the frame after the medium has been advanced.
bool PatientContrast::advance(const WireFrame &wire)
{
    const std::uint32_t now = wire.tick;
    const Clock::time_point begin = Clock::now();
    std::size_t next = 0;
    if (state_ == State::flows)
        for (std::int64_t tick = seen_tick_ + 1; tick <= std::int64_t{now}; ++tick, ++cost_.steps) {
            const auto at = static_cast<std::uint32_t>(tick);
            fluid_ = injector_.take(at);
            note_given(at);
            FlowDrive drive = flow_drive(beat_at(at, next));
            if (pressure_share_ < 1.0) drive.pressure_mmHg *= pressure_share_;
            flow_.step(drive, fluid_);
            stream_.strength = fluid_.flow_ml_s > 0.0 ? 1.0 : std::max(stream_.strength - stream_fades, 0.0);
        }
    beats_.clear();
    if (state_ == State::flows || next_tick() <= now) place_vessels(wire);
    const bool is_look_due = next_tick() != never && now >= look_due();
    if (is_look_due) look(wire);
    seen_tick_ = now;
    seen_open_ = wire.lesions_open;
    const Clock::time_point stepped = Clock::now();
    cost_.step_s += seconds(stepped - begin);
    if (state_ != State::flows && curves_.empty()) return is_look_due;
    curves_mg_per_ml_ = iodine_mg_per_ml_;
    make_curves();
    cost_.frame_s += seconds(Clock::now() - stepped);
    ++cost_.frames;
    return is_look_due;
}

// Records the volume of medium that was injected during the tick that ends now.
void PatientContrast::note_given(std::uint32_t tick)
{
    if (fluid_.flow_ml_s <= 0.0) return;
    const bool goes_on = !given_.empty() && given_.back().tick_end + 1 == tick &&
                         given_.back().fluid.flow_ml_s == fluid_.flow_ml_s &&
                         given_.back().fluid.iodine_mg_per_ml == fluid_.iodine_mg_per_ml;
    if (goes_on)
        given_.back().tick_end = tick;
    else
        given_.push_back({tick - 1, tick, fluid_});
}

std::optional<RunContrast> PatientContrast::given(std::uint32_t from, std::uint32_t to) const
{
    RunContrast sum;
    sum.agent = "iohexol";
    for (const Given &part : given_) {
        const std::uint32_t begin = std::max(from, part.tick_begin), end = std::min(to, part.tick_end);
        if (begin >= end) continue;
        const double seconds = (end - begin) * 1e-3, volume_ml = seconds * part.fluid.flow_ml_s;
        if (sum.volume_ml == 0.0) sum.tick_begin = begin;
        sum.iodine_mg_ml += volume_ml * part.fluid.iodine_mg_per_ml;
        sum.volume_ml += volume_ml;
        sum.duration_s += seconds;
    }
    if (sum.volume_ml == 0.0) return {};
    sum.iodine_mg_ml /= sum.volume_ml;
    sum.flow_ml_s = sum.volume_ml / sum.duration_s;
    return sum;
}

bool PatientContrast::is_forgotten() const
{
    return injector_.is_empty() && flow_.held_mg() < forgotten_mg &&
           flow_.distal().visible_mg() < invisible_distal_mg && !flow_.wounds().is_bleeding();
}

void PatientContrast::look(const WireFrame &wire)
{
    look_tick_ = wire.tick;
    take_injuries();
    if (state_ != State::flows) {
        if (!injector_.is_empty() && wire.tick > injector_.first_tick() + look_every_ticks)
            injector_.skip_to(wire.tick);
        state_ = State::flows;
        wake_tick_ = never;
    }
    if (is_forgotten()) {
        state_ = State::idle;
        fluid_ = {};
        return;
    }
    if (open_vessels(wire)) place_vessels(wire);
    if (wire.nodes.empty()) return;
    flow_.set_tools(balls_of(wire));
    const double tip_arc_m = tool_ < wire.tip_arc_m.size() ? wire.tip_arc_m[tool_] : 0.0;
    if (tool_ >= tools_.size()) return;
    const std::vector<CatheterMouth> mouths = catheter_mouths(tools_[tool_], wire, tip_arc_m);
    flow_.set_mouths(mouths);
    stream_.cell = flow_.cells().nearest(mouths[0].place_m);
    stream_.tip_m = mouths[0].place_m;
    stream_.share = mouths[0].share;
}

// Returns how narrow the jet of medium from the tip is in a cell of the vessel: 1 at the tip, and 0 where the
// jet fills the vessel.
double PatientContrast::stream_at(std::size_t cell, double &behind_tip_mm) const
{
    const FlowCells &cells = flow_.cells();
    if (cell < stream_.cell || cells[cell].branch != cells[stream_.cell].branch) return 0.0;
    if (cell == stream_.cell) behind_tip_mm = 0.0;
    behind_tip_mm += cells[cell].length_mm;
    return stream_.strength * stream_.share *
           std::max(1.0 - behind_tip_mm / (stream_radii * cells[cell].radius_mm), 0.0);
}

// Draws the iodine of a cell as a column that is thinner than the vessel. The column of iodine lies beside
// the axis of the vessel, on the side of the catheter's tip. The column of iodine is just wide enough to hold
// all iodine of the cell as undiluted medium.
SweptPoint PatientContrast::stream_point(std::size_t cell, double narrowness) const
{
    const FlowCells &cells = flow_.cells();
    const double mean = flow_.iodine_mg_per_ml(cell), radius_m = cells[cell].radius_mm * 1e-3;
    const double width = std::max(std::sqrt(std::min(mean / curves_mg_per_ml_, 1.0)), 1.0 - narrowness);
    const Vector3d axis = (cells.last_face_m(stream_.cell) - cells.first_face_m(stream_.cell)).normalized();
    Vector3d beside_m = stream_.tip_m - cells.middle_m(stream_.cell);
    beside_m -= axis.dot(beside_m) * axis;
    const double room_m = radius_m * (1.0 - width), distance_m = beside_m.norm() * narrowness;
    const double share = distance_m > room_m ? room_m / distance_m : 1.0;
    return {cells.middle_m(cell) + share * narrowness * beside_m, width * radius_m,
            contrast_share(mean / (width * width))};
}

// Makes two columns per vessel. The first of a vessel's two columns has the vessel's width, and the
// concentration in the outer layer of blood. The second column of a vessel is narrower and lies on the
// vessel's axis. The second column of a vessel has the concentration in the inner layer of blood minus that
// in the outer layer. If the layer of blood along the wall has the higher concentration, both layers are
// drawn as if they were mixed. Near the tip, where the medium forms a jet, a vessel has only one column,
// which is thinner than the vessel.
void PatientContrast::make_curves()
{
    curves_.clear();
    if (state_ != State::flows) return;
    for (std::size_t branch = 0; branch < flow_.cells().branch_count(); ++branch)
        for (bool is_core : {false, true}) make_curves_of(branch, is_core);
    const VesselTree &now = moved_.can_move() ? moved_.last() : vessels_;
    make_small_curves(now);
    make_blush(now);
    make_sinuses();
    make_wounds();
}

// A column of medium begins at the upstream face of its first cell. Where a vessel divides, the first cells
// of its branches begin outside the parent vessel. The columns in the branches begin at the end of the parent
// vessel, because otherwise the picture would show a gap.
Vector3d PatientContrast::column_begin_m(std::size_t cell) const
{
    const FlowCells &cells = flow_.cells();
    const int upstream = cells[cell].upstream;
    if (upstream < 0 || cells[cell].branch == cells[static_cast<std::size_t>(upstream)].branch)
        return cells.first_face_m(cell);
    const auto from = static_cast<std::size_t>(upstream);
    const auto parent = static_cast<std::size_t>(cells[from].branch);
    return from + 1 == cells.branch_begin(parent + 1) ? cells.last_face_m(from) : cells.first_face_m(cell);
}

// In the wall of a much wider vessel, a column would begin with a flat face. It begins with a rounded one,
// which lies in the wider vessel.
void PatientContrast::add_mouth(SweptCurve &curve, const SweptPoint &first, std::size_t cell) const
{
    constexpr double wider = 2.0;
    const FlowCells &cells = flow_.cells();
    const int upstream = cells[cell].upstream;
    if (upstream < 0 || cells[static_cast<std::size_t>(upstream)].radius_mm < wider * cells[cell].radius_mm)
        return;
    const Vector3d way = (cells.last_face_m(cell) - cells.first_face_m(cell)).normalized();
    for (const auto &[back, width] : {std::pair{0.9, 0.3}, {0.7, 0.68}, {0.35, 0.92}})
        curve.points.push_back(
            {first.at_m - back * first.radius_m * way, width * first.radius_m, first.share});
}

// Upstream of the catheter's holes, medium ends within a vessel. The jets mix it with blood some way up, so
// its concentration rises along the vessel over mixing_radii, half of them on each side of the first cell's
// face. The column holds nearly as much iodine as with a sharp edge.
void PatientContrast::add_mixed_begin(SweptCurve &curve, const SweptPoint &first, std::size_t cell) const
{
    constexpr int pieces = 4;
    const FlowCells &cells = flow_.cells();
    const Vector3d way = (cells.last_face_m(cell) - cells.first_face_m(cell)).normalized();
    const double half_m = 0.5 * mixing_radii * cells[cell].radius_mm * 1e-3;
    for (int k = pieces; k > 0; --k) {
        const double back = static_cast<double>(k) / pieces; // 1: where the medium ends
        curve.points.push_back({first.at_m - back * half_m * way,
                                first.radius_m * std::sqrt(1.0 - 0.6 * back),
                                mixed_share(-back) * first.share});
    }
}

// The patient lies on the back, so medium settles towards the back. The core column, which has half of the
// vessel's area, then lies on the lower wall.
Vector3d PatientContrast::settle(std::size_t cell, double &core_mg_per_ml, double &wall_mg_per_ml) const
{
    const FlowCells &cells = flow_.cells();
    const double mean = 0.5 * (core_mg_per_ml + wall_mg_per_ml), wall = std::min(wall_mg_per_ml, mean);
    const double above = std::max(core_mg_per_ml - wall_mg_per_ml, 0.0);
    if (mean < invisible_mg_per_ml || wall <= 0.0) return Vector3d::Zero();
    // What leaves the whole width is twice as dense in half of it, and nothing is denser than undiluted
    // medium.
    const double room = (curves_mg_per_ml_ - above - wall) / wall;
    const Vector3d along = (cells.last_face_m(cell) - cells.first_face_m(cell)).normalized();
    const Vector3d down = -Vector3d::UnitZ() + along.z() * along; // short where the vessel is steep
    const double share =
        down.norm() * std::min(settled_share(mean, cells[cell].radius_mm, mean_flows_ml_s_[cell]), room);
    if (share <= 1e-6) return Vector3d::Zero();
    wall_mg_per_ml = (1.0 - share) * wall;
    core_mg_per_ml = wall_mg_per_ml + above + 2.0 * share * wall;
    return share * (1.0 - std::sqrt(0.5)) * cells[cell].radius_mm * 1e-3 * down.normalized();
}

void PatientContrast::make_curves_of(std::size_t branch, bool is_core)
{
    const FlowCells &cells = flow_.cells();
    SweptCurve curve{Material::iohexol_350, {}};
    const auto end_curve = [&] {
        if (curve.points.size() >= 2) curves_.push_back(curve);
        curve.points.clear();
    };
    double behind_tip_mm = 0.0;
    const std::size_t begin = cells.branch_begin(branch), end = cells.branch_begin(branch + 1);
    const bool has_blunt_end =
        cells[end - 1].end_ml_s > 0.0 && vessels_.branches[branch].bed != VesselBed::systemic;
    bool is_mixed = false;      // the column begins within the vessel
    double from_begin_mm = 0.0; // of the column
    double left_mm = 0.0;       // from the cell's last face to the end
    for (std::size_t i = begin; i < end; ++i) left_mm += cells[i].length_mm;
    for (std::size_t i = begin; i < end; ++i) {
        const double narrowness = stream_at(i, behind_tip_mm);
        left_mm -= cells[i].length_mm;
        double core = flow_.core_mg_per_ml(i), wall = flow_.wall_mg_per_ml(i);
        const double mean = 0.5 * (core + wall);
        const Vector3d down_m = settle(i, core, wall);
        double shown = is_core ? std::max(core - wall, 0.0) : std::min(wall, mean);
        if (narrowness > 0.0) shown = is_core ? 0.0 : mean;
        if (shown < invisible_mg_per_ml) {
            end_curve();
            continue;
        }
        const double taper = has_blunt_end ? taper_at(left_mm / cells[i].radius_mm) : 1.0;
        const double radius_m = taper * cells[i].radius_mm * 1e-3 * (is_core ? std::sqrt(0.5) : 1.0);
        SweptPoint point{cells.middle_m(i), radius_m, contrast_share(shown)};
        if (is_core) point.at_m += down_m;
        if (narrowness > 0.0) point = stream_point(i, narrowness);
        narrow(i, point);
        // A column begins and ends at the faces between cells, and not at the middle of a cell.
        if (curve.points.empty()) {
            is_mixed = i > begin && narrowness < 0.5;
            from_begin_mm = 0.0;
            SweptPoint first = point;
            first.at_m += column_begin_m(i) - cells.middle_m(i);
            if (i == begin) add_mouth(curve, first, i);
            if (is_mixed) {
                add_mixed_begin(curve, first, i);
                first.share *= mixed_share(0.0);
            }
            curve.points.push_back(first);
        }
        from_begin_mm += 0.5 * cells[i].length_mm;
        if (is_mixed) point.share *= mixed_share(2.0 * from_begin_mm / (mixing_radii * cells[i].radius_mm));
        from_begin_mm += 0.5 * cells[i].length_mm;
        go_to(curve, point);
        if (i + 1 == end) {
            const Vector3d to_end_m = cells.last_face_m(i) - cells.middle_m(i);
            curve.points.push_back({point.at_m + to_end_m, point.radius_m, point.share});
        }
    }
    end_curve();
}

void PatientContrast::colour(WireFrame &wire) const
{
    if (curves_.empty()) return;
    std::size_t cell = 0; // a guess
    for (WireNode &node : wire.nodes) {
        cell = flow_.cells().nearest(node.position_m, cell);
        node.contrast_mg_per_ml = flow_.iodine_mg_per_ml(cell);
    }
}

} // namespace crn
