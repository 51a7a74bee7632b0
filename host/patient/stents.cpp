#include "host/patient/stents.hpp"
#include "host/base/number_text.hpp"
#include "host/base/text.hpp"
#include "host/model/units.hpp"
#include "host/patient/balloon.hpp"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr double size_share = 0.1; // relative difference allowed between the diameters of balloon and stent
constexpr double length_spare_mm = 0.05; // clearance of a stent that fills the stretch between the bands
constexpr double band_mm = 1.0;          // docs/balloon.md
constexpr double wide_shares =
    2.0; // vessels wider than this many times a stent's largest diameter hold no stent
constexpr double inside_radii = 1.5; // the balloon is in a branch within this many radii of its centreline
constexpr std::uint32_t q15_per_256 = 32768 / 256;
constexpr double strut_moved_um = 100.0,
                 strut_widened_um = 20.0; // a ring that changed less needs no new order

std::string millimetres(double mm)
{
    return number_text(mm, 3) + " mm";
}

// Returns the diameter that the balloon has at its nominal pressure without a vessel around it. If the
// balloon has no label, the diameter is that in the first row of the balloon's table.
double nominal_diameter_mm(const Instrument &tool)
{
    const crn_wire_instrument &table = tool.table;
    const double kPa = tool.balloon ? tool.balloon->nominal_kPa : 0.0;
    for (std::uint16_t i = 1; i < table.balloon_count; ++i) {
        const crn_wire_balloon_point &a = table.balloon[i - 1], &b = table.balloon[i];
        if (kPa > b.pressure_kPa) continue;
        const double share = std::clamp((kPa - a.pressure_kPa) / (b.pressure_kPa - a.pressure_kPa), 0.0, 1.0);
        return (a.diameter_um + share * (double{1} * b.diameter_um - a.diameter_um)) * 1e-3;
    }
    return table.balloon[table.balloon_count - 1].diameter_um * 1e-3;
}

// Returns the distance between the inner edges of the balloon's marker bands. If the balloon has no marker
// bands, the function returns the working length.
double mount_length_mm(const Instrument &tool)
{
    const double working = (double{1} * tool.table.balloon_proximal_um - tool.table.balloon_distal_um) * 1e-3;
    if (!tool.balloon || tool.balloon->marker_arcs_m.size() < 2) return working;
    const auto [first, last] =
        std::minmax_element(tool.balloon->marker_arcs_m.begin(), tool.balloon->marker_arcs_m.end());
    return (*last - *first) * 1e3 - band_mm;
}

std::vector<std::vector<double>> opened_lists(const WireFrame &wire,
                                              const std::vector<LesionStations> &stations)
{
    std::vector<std::vector<double>> lists;
    std::size_t at = 0;
    for (const LesionStations &one : stations) {
        const std::size_t end = std::min<std::size_t>(at + one.count, wire.lesions_open.size());
        lists.emplace_back(wire.lesions_open.begin() + static_cast<std::ptrdiff_t>(at),
                           wire.lesions_open.begin() + static_cast<std::ptrdiff_t>(end));
        at = end;
    }
    return lists;
}

std::int32_t micrometres(double mm)
{
    return static_cast<std::int32_t>(std::lround(std::clamp(mm, -1900.0, 1900.0) * 1e3));
}

crn_wire_strut ring_of(const StentCircle &circle, std::uint8_t number, bool is_joined,
                       const StentDesign &design)
{
    return {number,
            static_cast<std::uint8_t>(is_joined),
            micrometres(circle.centre_mm.x()),
            micrometres(circle.centre_mm.y()),
            micrometres(circle.centre_mm.z()),
            static_cast<std::uint16_t>(std::clamp(micrometres(circle.inside_mm), 200, 20000)),
            static_cast<std::uint16_t>(std::clamp(micrometres(design.strut_thickness_mm), 10, 1000))};
}

// Returns true if a ring of a stent has changed so much that the core needs a new command for this ring.
bool has_changed(const crn_wire_strut &known, const crn_wire_strut &now)
{
    if (known.inside_um == 0 || now.inside_um == 0) return known.inside_um != now.inside_um;
    const double moved_um = std::hypot(double{1} * known.x_um - now.x_um, double{1} * known.y_um - now.y_um,
                                       double{1} * known.z_um - now.z_um);
    return moved_um > strut_moved_um || std::abs(known.inside_um - now.inside_um) > strut_widened_um ||
           known.joined != now.joined || known.thickness_um != now.thickness_um;
}

MotionMoment moment_of(const WireFrame &wire)
{
    return {wire.heart_phase32, wire.breath_phase32};
}

} // namespace

std::string mount_refusal(const StentDesign &stent, const std::vector<Instrument> &tools)
{
    const std::optional<std::size_t> tool = balloon_tool(tools);
    if (!tool) return "no tool has a balloon to mount it on: name a balloon catheter with --tool";
    const Instrument &balloon = tools[*tool];
    const double width = nominal_diameter_mm(balloon), length = mount_length_mm(balloon);
    if (std::abs(width - stent.diameter_mm) > size_share * stent.diameter_mm)
        return "its diameter of " + millimetres(stent.diameter_mm) + " does not go with '" + balloon.name +
               "', which has " + millimetres(width) + " at its nominal pressure: choose one of a size";
    if (stent.length_mm > length + length_spare_mm)
        return "its length of " + millimetres(stent.length_mm) + " does not go between the bands of '" +
               balloon.name + "', which leave " + millimetres(length) + ": choose a longer balloon";
    return "";
}

// Returns an empty text if the stent can be mounted on the balloon of any of these tools.
static std::string table_refusal(const StentDesign &stent, const std::vector<Instrument> &tools)
{
    std::string first;
    for (const Instrument &tool : tools) {
        if (tool.table.balloon_count == 0) continue;
        const std::string why = mount_refusal(stent, {tool});
        if (why.empty()) return "";
        if (first.empty()) first = why;
    }
    return first.empty() ? mount_refusal(stent, tools) : first;
}

std::vector<StentDesign> read_stents(const std::vector<std::string> &paths,
                                     const std::vector<Instrument> &tools)
{
    std::vector<StentDesign> stents;
    if (paths.size() > stents_max)
        throw FileError(paths[stents_max], 0, 0,
                        "is the stent number " + std::to_string(stents_max + 1) + ": a session has at most " +
                            std::to_string(stents_max));
    for (const std::string &path : paths) {
        stents.push_back(read_stent(path));
        const std::string why = table_refusal(stents.back(), tools);
        if (!why.empty()) throw FileError(path, 0, 0, why);
        if (!material_from_name(stents.back().material))
            throw FileError(path, 0, 0,
                            "unknown X-ray material '" + stents.back().material +
                                "'; known: " + material_names());
    }
    return stents;
}

PatientStents::PatientStents(std::vector<StentDesign> shelf, const VesselTree &vessels, const Motion *motion,
                             std::vector<LesionStations> stations, const std::vector<Instrument> &tools,
                             bool has_table)
    : shelf_(std::move(shelf)), vessels_(vessels),
      motion_(motion ? std::optional<Motion>(*motion) : std::nullopt), stations_(std::move(stations))
{
    take_tools(tools);
    if (!tool_ && !shelf_.empty() && !has_table)
        throw std::runtime_error("no tool has a balloon to mount '" + shelf_[0].name + "' on");
    for (const LesionStations &one : stations_) known_256_.emplace_back(one.count, 0);
}

void PatientStents::take_tools(const std::vector<Instrument> &tools)
{
    tool_ = balloon_tool(tools);
    balloon_ = tool_ ? tools[*tool_] : Instrument{};
    inserted_m_ = 0.0;
    if (!tool_) return;
    mount_mm_ = balloon_middle_mm(balloon_);
    folded_end_m_ = balloon_.table.balloon_distal_um * 1e-6;
}

void PatientStents::set_tools(const std::vector<Instrument> &tools, ChangedPositions changed)
{
    const std::optional<std::size_t> now = balloon_tool(tools);
    if (now == tool_ && (!now || !has_changed(changed, *now))) return;
    take_out();
    stents_.take_out();
    if (stents_.size() == 0) next_look_ = UINT32_MAX;
    take_tools(tools);
}

// --- mounting ---

void PatientStents::command(std::uint32_t tick, const RoomCommand &command)
{
    if (command.action == RoomAction::load_stent) load(tick);
}

// Before the first tick the balloon may be anywhere in the patient, because it was inserted together with its
// stent.
void PatientStents::load(std::uint32_t tick)
{
    const std::string at = " (at " + std::to_string(tick) + " ms)";
    if (loaded_ == shelf_.size()) {
        refusals_.push_back("NO STENT LEFT to load" + at);
        return;
    }
    if (!tool_) {
        refusals_.push_back(
            "NO STENT LOADED - no device on the line has a balloon: load the balloon catheter first" + at);
        return;
    }
    if (tick > 0 && inserted_m_ > folded_end_m_) {
        refusals_.push_back("NO STENT LOADED - the balloon is in the patient: withdraw it" + at);
        return;
    }
    const std::string why = mount_refusal(shelf_[loaded_], {balloon_});
    if (!why.empty()) {
        refusals_.push_back("NO STENT LOADED - " + why + at);
        return;
    }
    take_out();
    stents_.add(shelf_[loaded_], mount_mm_);
    stories_.push_back({loaded_, mount_mm_, tick, {}, {}, {}});
    loaded_++;
    const std::uint32_t due = (tick + look_every_ticks - 1) / look_every_ticks * look_every_ticks;
    next_look_ = std::min(next_look_, due);
}

// Records that a stent which is still on its balloon has left the patient.
void PatientStents::take_out()
{
    if (stents_.size() == 0 || !stents_[stents_.size() - 1].is_on_balloon()) return;
    const StentDesign &before = stents_[stents_.size() - 1].design();
    taken_out_.push_back({before.name, before.diameter_mm, before.length_mm, stories_.back().loaded_tick});
    stories_.pop_back();
}

void PatientStents::tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state)
{
    if (tool_ && *tool_ < state.tools_count) inserted_m_ = units::metres(state.tools[*tool_].inserted_m_q30);
    for (const crn_wire_order &order : orders_of(input)) {
        if (order.kind == CRN_WIRE_KIND_strut) note(order.strut);
        if (order.kind == CRN_WIRE_KIND_scaffold) note(order.scaffold);
    }
}

// Stores the state of a stent's ring after the core has carried out the command for this ring.
void PatientStents::note(const crn_wire_strut &ring)
{
    if (ring.number >= 1 && ring.number <= struts_max) known_struts_[ring.number - 1u] = ring;
}

void PatientStents::note(const crn_wire_scaffold &hold)
{
    if (hold.lesion == 0 || hold.lesion > known_256_.size()) return;
    std::vector<std::uint32_t> &known = known_256_[hold.lesion - 1u];
    for (std::size_t k = hold.first; k <= hold.last && k < known.size(); ++k)
        known[k] = std::max<std::uint32_t>(known[k], hold.open_q15 / q15_per_256);
}

// --- walls ---

// The model of a branch's wall is made when a stent first reaches that branch, because most branches never
// get a stent.
std::size_t PatientStents::vessel_of(std::size_t branch)
{
    for (std::size_t i = 0; i < walls_.size(); ++i)
        if (walls_[i].branch == branch) return i;
    constexpr double whole_mm = 1e4;
    walls_.push_back({branch, std::make_unique<VesselWall>(vessels_, branch, 0.0, whole_mm,
                                                           motion_ ? &*motion_ : nullptr)});
    for (std::size_t k = 0; k < stations_.size(); ++k)
        if (stations_[k].count > 1)
            walls_.back().wall->set_places(k, static_cast<double>(stations_[k].count - 1) *
                                                  stations_[k].spacing_m * 1e3);
    return walls_.size() - 1;
}

// Returns the branch around the middle of the balloon: the one for which the distance of this middle from the
// centreline, divided by the radius, is least. The function returns no value if no branch at the balloon
// could hold a stent of this size.
std::optional<std::size_t> PatientStents::vessel_at(const BalloonPose &pose, const MotionMoment &moment)
{
    if (pose.points.empty()) return {};
    const Vector3d now_m = pose.points[pose.points.size() / 2].centre_mm * 1e-3;
    const Vector3d place_m = motion_ ? motion_->pull(now_m, moment) : now_m;
    std::optional<std::size_t> best;
    VesselFoot least;
    least.radii = inside_radii;
    for (std::size_t i = 0; i < vessels_.branches.size(); ++i) {
        const VesselFoot foot = vessel_foot(vessels_.branches[i], place_m);
        if (foot.radii >= least.radii) continue;
        least = foot;
        best = i;
    }
    if (!best) return {};
    const double radius_m = vessels_.branches[*best].radii_m[least.point];
    const StentDesign &design = stents_[stents_.size() - 1].design();
    if (2e3 * radius_m > wide_shares * design.diameter_max_mm) return {};
    try {
        return vessel_of(*best);
    } catch (const std::invalid_argument &) {
        return {}; // a branch that ends before its own ostium
    }
}

// Limits the radius of each ball that models the balloon to the radius of the vessel's wall at that ball. The
// radius of a ball outside the vessel is not limited.
void PatientStents::give_room(BalloonPose &pose, std::optional<std::size_t> vessel) const
{
    if (!vessel) return;
    const VesselWall &wall = *walls_[*vessel].wall;
    for (BalloonPoint &point : pose.points) {
        const VesselWall::Foot foot = wall.foot_of(point.centre_mm);
        if (foot.off_mm <= wall.healthy_radius_mm(foot.along_mm))
            point.room_mm = wall.radius_at_mm(foot.along_mm);
    }
}

void PatientStents::move_walls(const WireFrame &wire)
{
    const std::vector<std::vector<double>> opened = opened_lists(wire, stations_);
    for (const Vessel &vessel : walls_) vessel.wall->move(moment_of(wire), opened);
}

std::vector<const StentWall *> PatientStents::walls() const
{
    std::vector<const StentWall *> walls;
    for (const Story &story : stories_)
        walls.push_back(story.vessel ? &walls_[*story.vessel].wall->wall() : nullptr);
    return walls;
}

// --- a look ---

void PatientStents::advance(const WireFrame &wire)
{
    if (wire.tick < next_look_) return;
    next_look_ = (wire.tick / look_every_ticks + 1) * look_every_ticks;
    BalloonPose pose = tool_ ? balloon_pose(wire, *tool_) : BalloonPose{};
    const Stent &last = stents_[stents_.size() - 1];
    // Once a ring of the stent has been opened, the stent stays in its vessel, even if another vessel comes
    // nearer.
    if (last.is_on_balloon() && !stories_.back().opened_tick && !pose.points.empty())
        stories_.back().vessel = vessel_at(pose, moment_of(wire));
    move_walls(wire);
    if (last.is_on_balloon()) give_room(pose, stories_.back().vessel);
    stents_.step(walls(), pose.points.empty() ? nullptr : &pose);
    note_stages(wire.tick);
    orders_.clear();
    ask_for_holds(wire);
    ask_for_struts(wire);
    seen_ = wire;
    seen_.nodes.clear();
}

void PatientStents::note_stages(std::uint32_t tick)
{
    for (std::size_t i = 0; i < stories_.size(); ++i) {
        const Stent &stent = stents_[i];
        for (int ring = 0; ring < stent.design().rings && !stories_[i].opened_tick; ++ring)
            if (stent.is_opened(ring)) stories_[i].opened_tick = tick;
        if (!stent.is_on_balloon() && !stories_[i].released_tick) stories_[i].released_tick = tick;
    }
}

// Queues the commands by which stents hold points of a lesion open, but only for the points that the core
// does not yet know. A queued command that no tick's input has contained is queued again.
void PatientStents::ask_for_holds(const WireFrame &wire)
{
    const std::vector<std::vector<double>> opened = opened_lists(wire, stations_);
    for (std::size_t lesion = 0; lesion < stations_.size() && lesion < vessels_.lesions.size(); ++lesion) {
        const auto vessel = std::find_if(walls_.begin(), walls_.end(), [&](const Vessel &one) {
            return one.branch == vessels_.lesions[lesion].branch;
        });
        if (vessel == walls_.end()) continue;
        for (const StentHold &hold :
             stents_.holds(*vessel->wall, lesion, static_cast<std::uint32_t>(stations_[lesion].count),
                           opened[lesion])) {
            const auto is_new = [&](std::uint32_t k) {
                return k <= hold.last && known_256_[lesion][k] < hold.open_256;
            };
            for (std::uint32_t k = hold.first; k <= hold.last; ++k) {
                if (!is_new(k)) continue;
                const std::uint32_t first = k;
                while (is_new(k)) ++k;
                orders_.add(crn_wire_order_of_scaffold(
                    {static_cast<std::uint8_t>(lesion + 1), static_cast<std::uint8_t>(first),
                     static_cast<std::uint8_t>(k - 1),
                     static_cast<std::uint16_t>(hold.open_256 * q15_per_256)}));
            }
        }
    }
}

// The numbers of the rings of different stents do not overlap. If a ring no longer exists, a command removes
// it from the core.
void PatientStents::ask_for_struts(const WireFrame &wire)
{
    const std::size_t share = struts_max / std::max<std::size_t>(shelf_.size(), 1);
    const auto to_reference = [&](const Vector3d &place_mm) -> Vector3d {
        return motion_ ? Vector3d(motion_->pull(place_mm * 1e-3, moment_of(wire)) * 1e3) : place_mm;
    };
    for (std::size_t i = 0; i < stents_.size() && (i + 1) * share <= struts_max; ++i) {
        const std::vector<StentCircle> circles = stent_circles(stents_[i], share, to_reference);
        for (std::size_t k = 0; k < share; ++k) {
            const auto number = static_cast<std::uint8_t>(i * share + k + 1);
            crn_wire_strut ring{};
            ring.number = number;
            if (k < circles.size())
                ring = ring_of(circles[k], number, k + 1 < circles.size(), stents_[i].design());
            if (has_changed(known_struts_[number - 1u], ring)) orders_.add(crn_wire_order_of_strut(ring));
        }
    }
}

// --- pictures and reports ---

std::vector<SweptCurve> PatientStents::curves_at(const WireFrame &wire)
{
    std::vector<SweptCurve> curves;
    if (stents_.size() == 0) return curves;
    BalloonPose pose = tool_ ? balloon_pose(wire, *tool_) : BalloonPose{};
    move_walls(wire);
    Stents shown = stents_; // the next look continues from the last one
    shown.step(walls(), pose.points.empty() ? nullptr : &pose);
    for (const Stent &stent : shown.all()) {
        if (stent.is_on_balloon() && pose.points.empty()) continue; // outside the patient
        const Material material = material_from_name(stent.design().material).value_or(Material::steel);
        for (const StentLine &line : stent_lines(stent)) {
            curves.push_back({material, {}});
            for (const Vector3d &point_mm : line.points_mm)
                curves.back().points.push_back({point_mm * 1e-3, line.radius_mm * 1e-3, 1.0});
        }
    }
    return curves;
}

std::string PatientStents::stage_text() const
{
    if (stents_.size() == 0) return "";
    const Stent &last = stents_[stents_.size() - 1];
    if (last.is_on_balloon()) return stories_.back().opened_tick ? "being opened" : "on its balloon";
    return std::string(stent_stage_text(last.stage()));
}

std::vector<StentResult> PatientStents::results()
{
    std::vector<StentResult> results;
    for (const Taken &taken : taken_out_) {
        StentResult result;
        result.name = taken.name;
        result.diameter_mm = taken.diameter_mm;
        result.length_mm = taken.length_mm;
        result.loaded_tick = taken.loaded_tick;
        result.was_taken_out = true;
        results.push_back(result);
    }
    move_walls(seen_); // the walls return to their places at the last look
    for (std::size_t i = 0; i < stories_.size(); ++i) {
        const Stent &stent = stents_[i];
        const Story &story = stories_[i];
        StentResult result;
        result.name = stent.design().name;
        result.diameter_mm = stent.design().diameter_mm;
        result.length_mm = stent.design().length_mm;
        result.stage = stent.stage();
        result.loaded_tick = story.loaded_tick;
        result.opened_tick = story.opened_tick;
        result.released_tick = story.released_tick;
        result.slip_mm = stent.slip_mm();
        const VesselWall *wall = story.vessel ? walls_[*story.vessel].wall.get() : nullptr;
        result.figures = stent_figures(stent, wall ? &wall->wall() : nullptr);
        for (std::size_t k = 0; k < i; ++k) result.overlap_mm += stent_overlap_mm(stent, stents_[k].sleeve());
        if (wall) {
            const std::size_t branch = walls_[*story.vessel].branch;
            result.branch = vessels_.branches[branch].name;
            result.stretch = stent_stretch(stent, wall->line_mm(), wall->healthy_radius_mm());
            for (std::size_t k = 0; k < vessels_.lesions.size(); ++k)
                if (vessels_.lesions[k].branch == branch)
                    result.lesions.push_back({k, vessels_.lesions[k].name, stent_coverage(stent, *wall, k)});
        }
        results.push_back(result);
    }
    return results;
}

} // namespace crn
