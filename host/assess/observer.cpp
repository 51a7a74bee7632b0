#include "host/assess/observer.hpp"
#include "host/model/wall_way.hpp"
#include "host/model/wire_place.hpp"
#include "host/session/contact_figures.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

constexpr double inflated_mm = 0.5; // a ball of the balloon this much wider than the folded one is inflated

} // namespace

AssessObserver::AssessObserver(Patient &patient, const std::vector<Instrument> &tools, const TipPlaces &tips)
    : patient_(patient), tips_(tips)
{
    static_assert(SessionLog::every_ticks == ContactFigures::look_every_ticks); // contacts come then
    log_.map = tips.map();
    for (const Instrument &tool : tools) {
        table_.push_back({tool.name, tool.kind == InstrumentKind::wire});
        if (!tool.balloon) continue;
        log_.has_balloon = true;
        if (tool.balloon->rated_burst_kPa > 0.0) log_.rated_burst_bar = tool.balloon->rated_burst_kPa * 1e-2;
    }
    log_.has_transducer = !patient.catheter_pressure().tool_name().empty();
    log_.has_stents = patient.stents() != nullptr;
    log_.has_lesions = !patient.contrast().vessels().lesions.empty();
    follow_line();
}

// For each position on the line (the nested tools), the log names all tools that have been there, such as "J
// wire, then Coronary wire".
void AssessObserver::follow_line()
{
    const LineNumbers &now = patient_.line();
    if (now == line_) return;
    log_.tools.resize(now.size());
    for (std::size_t k = 0; k < now.size(); ++k) {
        const bool is_new = k >= line_.size() || line_[k] != now[k];
        if (!is_new || now[k] == 0 || now[k] > table_.size()) continue;
        log_.tools[k] += (log_.tools[k].empty() ? "" : ", then ") + table_[now[k] - 1u].name;
    }
    line_ = now;
}

void AssessObserver::tick(const crn_wire_tick_input &, const crn_wire_tick_state &state)
{
    log_.ticks = state.tick;
}

void AssessObserver::contacts(const crn_wire_contacts &contacts)
{
    log_.has_contacts = true;
    wall_N_ = contact_sum_N(contacts);
}

void AssessObserver::frame(const SessionFrame &frame)
{
    if (frame.wire.tick % SessionLog::every_ticks != 0 || frame.wire.tick < next_tick_) return;
    next_tick_ = frame.wire.tick + SessionLog::every_ticks;
    SessionMoment moment;
    moment.tick = frame.wire.tick;
    moment.wall_N = wall_N_;
    look_at_room(moment);
    look_at_tools(frame, moment);
    look_at_vessels(frame.wire, moment);
    log_.moments.push_back(moment);
}

void AssessObserver::look_at_room(SessionMoment &moment)
{
    const Room &room = patient_.room();
    const DoseMeter &dose = room.dose();
    moment.is_xray_on = room.is_beam_on();
    moment.is_acquiring = moment.is_xray_on && !dose.irradiations().empty() &&
                          dose.irradiations().back().kind != RunKind::fluoro;
    moment.is_gantry_moving = room.gantry().is_moving();
    moment.fluoroscopy_s = dose.fluoro_ticks() * 1e-3;
    moment.kap_Gy_cm2 = dose.total().kap_Gy_cm2;
    moment.injected_ml = patient_.contrast().injected_ml();
    const SessionMoment before = log_.moments.empty() ? SessionMoment() : log_.moments.back();
    moment.is_injecting = moment.injected_ml > before.injected_ml;
    moment.is_pressure_damped = patient_.catheter_pressure().is_damped();
    moment.unaspirated_injections = static_cast<int>(patient_.catheter_air().injections().size());
    moment.runs = before.runs;
    moment.filled_runs = before.filled_runs;
    moment.empty_runs = before.empty_runs;
    if (moment.is_acquiring && !was_acquiring_) injected_at_run_ml_ = before.injected_ml;
    if (!moment.is_acquiring && was_acquiring_) {
        moment.runs++;
        (moment.injected_ml > injected_at_run_ml_ ? moment.filled_runs : moment.empty_runs)++;
    }
    was_acquiring_ = moment.is_acquiring;
}

void AssessObserver::look_at_tools(const SessionFrame &frame, SessionMoment &moment)
{
    const WireFrame &wire = frame.wire;
    follow_line();
    moment.has_wire = std::any_of(line_.begin(), line_.end(), [&](std::uint8_t number) {
        return number > 0 && number <= table_.size() && table_[number - 1u].is_wire;
    });
    const bool has_shape = wire.nodes.size() >= 2 && !wire.tip_arc_m.empty();
    const std::vector<TipPlace> places = tips_.at(wire);
    for (std::size_t k = 0; k < std::min(frame.tools.size(), moment.tools.size()); ++k) {
        ToolMoment &tool = moment.tools[k];
        tool.inserted_mm = frame.tools[k].inserted_m * 1e3;
        tool.turned_deg = frame.tools[k].turned_deg;
        tool.hand_force_N = frame.tools[k].axial_N;
        if (!has_shape || k >= wire.tip_arc_m.size()) continue;
        const Eigen::Vector3d at_m = line_place_m(wire, wire.tip_arc_m[k]);
        tool.has_tip = true;
        tool.tip_mm = at_m * 1e3;
        tool.ahead_mm = (wire.tip_arc_m[0] - wire.tip_arc_m[k]) * 1e3;
        look_at_picture(tool, at_m);
        if (k >= places.size() || !places[k].is_known) continue;
        tool.tip_mm = places[k].reference_m * 1e3;
        tool.has_place = true;
        tool.vessel = places[k].place.vessel;
        tool.inside_mm = places[k].inside_m * 1e3;
        const auto node = std::find_if(wire.nodes.begin(), wire.nodes.end(), [&](const WireNode &one) {
            return one.arc_m >= wire.tip_arc_m[k] + 1e-3;
        });
        if (node != wire.nodes.end()) tool.lumen_share = 2e3 * node->radius_m / lumen_mm(places[k]);
    }
}

// Returns the diameter of the untreated lumen at a tip, in mm, with all lesions as in the scene file.
double AssessObserver::lumen_mm(const TipPlace &tip) const
{
    const VesselBranch &branch =
        patient_.contrast().vessels().branches[log_.map.vessels()[tip.place.vessel].branch];
    const VesselFoot foot = vessel_foot(branch, tip.reference_m);
    const std::size_t next = std::min(foot.point + 1, branch.radii_m.size() - 1);
    return 2e3 *
           (branch.radii_m[foot.point] + foot.share * (branch.radii_m[next] - branch.radii_m[foot.point]));
}

void AssessObserver::look_at_picture(ToolMoment &tool, const Eigen::Vector3d &tip_m) const
{
    const Room &room = patient_.room();
    const View view = make_view(room.gantry().carm(room.field_m()), SessionLog::picture_px);
    Eigen::Vector2d pixel;
    if (!project(view, tip_m, pixel)) return;
    tool.right_px = pixel.x();
    tool.down_px = pixel.y();
    const RoomState state = room.state();
    const double half = 0.5 * SessionLog::picture_px, right = (pixel.x() - half) / half,
                 down = (pixel.y() - half) / half;
    const double width = state.open_width_share, height = state.open_height_share;
    tool.is_in_picture = state.is_round ? std::hypot(right, down) <= std::min(width, height)
                                        : std::fabs(right) <= width && std::fabs(down) <= height;
}

void AssessObserver::look_at_vessels(const WireFrame &wire, SessionMoment &moment)
{
    const crn_wire_tick_state &state = patient_.state();
    moment.balloon_bar = state.balloon_kPa * 1e-2;
    moment.balloon_mm = state.balloon_diameter_max_um * 1e-3;
    moment.is_balloon_burst = state.balloon_bits != 0;
    if (!wire.lesions_open.empty())
        moment.lesion_open_pct =
            100.0 * *std::max_element(wire.lesions_open.begin(), wire.lesions_open.end());
    if (patient_.stents()) look_at_stents(wire, moment);
    moment.perforations = static_cast<int>(patient_.complications().count(InjuryKind::perforation));
    moment.dissections = static_cast<int>(patient_.complications().count(InjuryKind::dissection));
    moment.blood_loss_ml = patient_.contrast().flow().wounds().leaked_ml();
}

void AssessObserver::look_at_stents(const WireFrame &wire, SessionMoment &moment)
{
    const PatientStents &stents = *patient_.stents();
    moment.stents_loaded = static_cast<int>(stents.loaded());
    std::vector<Eigen::Vector3d> rings_mm;
    double ring_mm = 0.0; // half the distance between rings: a ring covers the line up to there
    for (const Stent &stent : stents.stents().all()) {
        moment.stents_deployed += stent.stage() == StentStage::deployed;
        moment.stents_lost += stent.stage() == StentStage::stripped || stent.stage() == StentStage::adrift;
        if (stent.stage() != StentStage::deployed) continue;
        for (int ring = 0; ring < stent.design().rings; ++ring) {
            rings_mm.push_back(stent.ring_centre_mm(ring));
            if (ring > 0)
                ring_mm = std::max(ring_mm, 0.5 * (rings_mm.back() - rings_mm[rings_mm.size() - 2]).norm());
        }
    }
    if (rings_mm.empty() || wire.balloon_radii_m.empty() || wire.nodes.size() < 2) return;
    const WireFrame rest = at_rest(wire); // as the rings are
    const double folded_m = *std::min_element(wire.balloon_radii_m.begin(), wire.balloon_radii_m.end());
    for (std::size_t i = 0; i < wire.balloon_radii_m.size(); ++i) {
        if (wire.balloon_radii_m[i] < folded_m + 0.5e-3 * inflated_mm) continue;
        const Eigen::Vector3d ball_mm =
            1e3 * line_place_m(rest, wire.balloon_arc_m + static_cast<double>(i) * wire.balloon_spacing_m);
        double nearest_mm = 1e9;
        for (const Eigen::Vector3d &ring : rings_mm)
            nearest_mm = std::min(nearest_mm, (ring - ball_mm).norm());
        moment.balloon_beyond_stent_mm = std::max(moment.balloon_beyond_stent_mm, nearest_mm - ring_mm);
    }
}

} // namespace crn
