// Tests balloon and stents in a session; this file makes the shapes of the nested tools. The tests check
// which stents may be mounted and when the stents are updated. The tests of this file also check which
// commands the core gets, and when a command is repeated. The tests of this file also check the X-ray of a
// filled balloon, the contents of a recording, and that making pictures does not change the session.
#include "host/base/tests/folder.hpp"
#include "host/base/text.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/stents.hpp"
#include "host/script/session.hpp"
#include "host/session/balloon_figures.hpp"
#include "host/session/recording.hpp"
#include "host/session/recording_format.hpp"
#include "host/stent/tests/stent_heart.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

using std::numbers::pi;
constexpr std::uint32_t stations = 24; // from one end of the artery's lesion to the other
const char *const stent_file = "shared/examples/stents/coronary_3_0x18.toml";

std::vector<Instrument> wire_and_balloon()
{
    return {read_instrument("shared/examples/instruments/coronary_014.toml"),
            read_instrument("shared/examples/instruments/balloon_3x20.toml")};
}

// The nested tools lie in the middle of an artery with a lesion and have a node every millimetre. The middle
// of the balloon is at the middle of the lesion. The tip of the guidewire is 20 mm ahead of the tip of the
// catheter. The balloon has the radius `radius_mm` along its whole length.
WireFrame line_at(std::uint32_t tick, double radius_mm, double open)
{
    static const VesselTree tree = beating_artery(false);
    const std::vector<Vector3d> &line_m = tree.branches[0].points_m; // every 0.5 mm
    WireFrame wire;
    wire.tick = tick;
    wire.tip_arc_m = {0.0, 0.01};
    for (int i = 0; i <= 50; ++i) {
        WireNode node;
        node.position_m = line_m[static_cast<std::size_t>(100 - 2 * i)];
        if (i > 0)
            node.arc_m = wire.nodes.back().arc_m + (node.position_m - wire.nodes.back().position_m).norm();
        wire.nodes.push_back(node);
    }
    wire.balloon_arc_m = 0.015;
    wire.balloon_spacing_m = 1e-3;
    wire.balloon_radii_m.assign(21, radius_mm * 1e-3);
    wire.lesions_open.assign(stations, open);
    return wire;
}

PatientStents session_stents(std::size_t count = 1)
{
    const std::vector<Instrument> tools = wire_and_balloon();
    return PatientStents(read_stents(std::vector<std::string>(count, stent_file), tools),
                         beating_artery(true), nullptr, {{stations, 12e-3 / (stations - 1)}}, tools);
}

constexpr RoomCommand load{RoomAction::load_stent, {}};

// The test lasts 800 ms: the stent is crimped until 200 ms, the balloon is under pressure until 500 ms, and
// then the balloon folds. Some of the frames are at ticks at which the stents are updated; other frames lie
// between two updates.
void carry_out(PatientStents &stents, std::uint32_t frame_ticks)
{
    stents.command(0, load);
    for (std::uint32_t tick = 0; tick <= 800;) {
        const bool is_up = tick > 200 && tick <= 500;
        stents.advance(line_at(tick, is_up ? 1.55 : 0.45, tick > 200 ? 1.0 : 0.0));
        tick = std::min(stents.next_tick(), (tick / frame_ticks + 1) * frame_ticks);
    }
}

void a_stent_is_refused_on_what_cannot_carry_it(void **)
{
    const StentDesign good = read_stent(stent_file);
    StentDesign wide = good, lengthy = good;
    wide.diameter_mm = 3.5;
    lengthy.length_mm = 19.0;
    const std::vector<Instrument> tools = wire_and_balloon(), bare = {tools[0]};
    assert_string_equal(mount_refusal(good, tools).c_str(), "");
    assert_non_null(std::strstr(mount_refusal(good, bare).c_str(), "no tool has a balloon"));
    assert_non_null(std::strstr(mount_refusal(wide, tools).c_str(), "diameter of 3.5 mm"));
    assert_non_null(std::strstr(mount_refusal(lengthy, tools).c_str(), "leave 18 mm"));
    try {
        read_stents({stent_file}, bare);
        fail_msg("accepted without a balloon");
    } catch (const FileError &error) {
        assert_non_null(std::strstr(error.what(), stent_file));
    }
    try {
        read_stents(std::vector<std::string>(stents_max + 1, stent_file), tools);
        fail_msg("more stents than the limit were accepted");
    } catch (const FileError &error) {
        assert_non_null(std::strstr(error.what(), "at most 8"));
    }
}

void nothing_is_looked_at_before_a_stent_is_loaded(void **)
{
    PatientStents stents = session_stents();
    assert_true(stents.next_tick() == UINT32_MAX && stents.stage_text().empty());
    stents.command(41, load);
    assert_true(stents.next_tick() == 80);
}

// Making frames between two updates, or making pictures, must not change any bit of the stents' state.
void other_pictures_do_not_change_the_stents(void **)
{
    PatientStents often = session_stents(), seldom = session_stents(), seen = session_stents();
    carry_out(often, 7);
    carry_out(seldom, 1000);
    seen.command(0, load);
    for (std::uint32_t tick = 0; tick <= 800; tick += 40) {
        seen.advance(line_at(tick, tick > 200 && tick <= 500 ? 1.55 : 0.45, tick > 200 ? 1.0 : 0.0));
        assert_false(seen.curves_at(line_at(tick + 13, 0.5, 0.3)).empty());
    }
    assert_true(often.stents()[0].stage() == StentStage::deployed);
    assert_true(often.stents().snapshot() == seldom.stents().snapshot());
    assert_true(often.stents().snapshot() == seen.stents().snapshot());
}

// A stent is saved while its balloon opens it in an artery with a lesion, and again after it was deployed.
void a_saved_stent_continues_bit_for_bit(void **)
{
    const auto run = [](PatientStents &stents, std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t tick = from; tick < to; tick += 40) {
            const bool is_up = tick > 200 && tick <= 500;
            stents.advance(line_at(tick, is_up ? 1.55 : 0.45, tick > 200 ? 1.0 : 0.0));
        }
    };
    const auto bytes_of = [](PatientStents &stents) {
        std::vector<std::uint8_t> bytes;
        StateArchive saved = StateArchive::saving(bytes);
        stents.archive(saved, wire_and_balloon());
        return bytes;
    };
    for (const std::uint32_t moment : {320u, 720u}) {
        PatientStents first = session_stents(2), fresh = session_stents(2), later = session_stents(2);
        first.command(0, load);
        run(first, 0, moment);
        carry_out(later, 40);
        later.command(801, load);
        const std::vector<std::uint8_t> bytes = bytes_of(first);
        run(first, moment, 900);
        for (PatientStents *stents : {&fresh, &later}) {
            StateArchive restored = StateArchive::restoring(bytes);
            stents->archive(restored, wire_and_balloon());
            assert_true(!restored.is_refused() && restored.is_at_end());
            assert_true(bytes_of(*stents) == bytes);
            run(*stents, moment, 900);
            assert_true(bytes_of(*stents) == bytes_of(first));
            assert_true(stents->results()[0].branch == first.results()[0].branch);
        }
        assert_true(first.stents()[0].stage() == StentStage::deployed);
    }
}

// A saved state that names a triangle, a vessel or a stent design that does not exist must be refused.
void damaged_stents_are_refused_or_can_continue(void **)
{
    PatientStents healthy = session_stents();
    carry_out(healthy, 40);
    std::vector<std::uint8_t> bytes;
    StateArchive saved = StateArchive::saving(bytes);
    healthy.archive(saved, wire_and_balloon());
    std::size_t refused = 0, accepted = 0;
    std::uint64_t random = 5;
    for (std::size_t round = 0; round < 200; round++) {
        random = random * 6364136223846793005ull + 1442695040888963407ull;
        std::vector<std::uint8_t> bad = bytes;
        bad[(random >> 20) % bad.size()] = static_cast<std::uint8_t>(random >> 56);
        if (round % 8 == 0) bad.resize((random >> 20) % bad.size());
        PatientStents tried = session_stents();
        StateArchive restored = StateArchive::restoring(bad);
        tried.archive(restored, wire_and_balloon());
        if (restored.is_refused()) {
            refused++;
            continue;
        }
        accepted++;
        tried.advance(line_at(840, 0.45, 1.0));
        assert_false(tried.curves_at(line_at(850, 0.5, 0.3)).empty());
    }
    print_message("%zu refused, %zu accepted\n", refused, accepted);
    assert_true(refused > 20 && accepted > 20);
}

crn_wire_order_list next_orders(PatientStents &stents)
{
    crn_wire_order_list orders{};
    stents.give_orders(orders);
    return orders;
}

// Returns the command of the next tick by which a stent holds a lesion open (scaffold), or no value if the
// tick has none.
std::optional<crn_wire_scaffold> next_hold(PatientStents &stents)
{
    const crn_wire_order_list orders = next_orders(stents);
    const crn_wire_order *order = order_of(orders, CRN_WIRE_KIND_scaffold);
    return order ? std::optional(order->scaffold) : std::nullopt;
}

std::optional<crn_wire_strut> next_ring(PatientStents &stents)
{
    const crn_wire_order_list orders = next_orders(stents);
    const crn_wire_order *order = order_of(orders, CRN_WIRE_KIND_strut);
    return order ? std::optional(order->strut) : std::nullopt;
}

// In this test the whole lesion lies inside the stent and has been opened. The commands to the core must
// cover every point of the lesion except two at each end, and must hold the middle point more than 90 % open.
// After the core has carried out the commands about this lesion, the stents must not send any further command
// about it.
void the_core_is_asked_once_for_what_it_does_not_know(void **)
{
    PatientStents stents = session_stents();
    carry_out(stents, 1000);
    std::vector<int> asked(stations, 0);
    crn_wire_tick_state state{};
    std::size_t orders = 0;
    for (auto list = next_orders(stents); list.items_count > 0; list = next_orders(stents)) {
        crn_wire_tick_input input{};
        input.orders = list;
        stents.tick(input, state);
        const crn_wire_order *item = order_of(list, CRN_WIRE_KIND_scaffold);
        if (!item) continue;
        const crn_wire_scaffold *order = &item->scaffold;
        assert_true(order->lesion == 1 && order->first <= order->last && order->last < stations);
        assert_true(order->open_q15 >= 1 && order->open_q15 <= 32768 && order->open_q15 % 128 == 0);
        for (std::size_t k = order->first; k <= order->last; ++k) asked[k] = order->open_q15;
        ++orders;
    }
    assert_true(orders > 0 && asked[stations / 2] > 32768 * 9 / 10);
    for (std::size_t k = 2; k + 2 < stations; ++k) assert_true(asked[k] > 0);
    for (std::uint32_t tick = 840; tick < 1000; tick += 40) {
        stents.advance(line_at(tick, 0.45, 1.0));
        assert_false(next_hold(stents).has_value());
    }
}

// Lets the core carry out all commands about struts, and returns the rings of these commands.
std::vector<crn_wire_strut> take_struts(PatientStents &stents)
{
    std::vector<crn_wire_strut> rings;
    for (auto list = next_orders(stents); list.items_count > 0; list = next_orders(stents)) {
        crn_wire_tick_input input{};
        input.orders = list;
        stents.tick(input, {});
        if (const crn_wire_order *order = order_of(list, CRN_WIRE_KIND_strut)) rings.push_back(order->strut);
    }
    return rings;
}

// While the stent is on the balloon, no command about struts may reach the core. After the stent has been
// deployed, every ring from end to end must become one circle in the core, with the ring's own width. After
// the core has carried out the commands about the rings, the stents must not send any further command about
// them.
void struts_are_told_once_the_stent_is_deployed(void **)
{
    PatientStents stents = session_stents();
    stents.command(0, load);
    for (std::uint32_t tick = 0; tick <= 400; tick += 40) stents.advance(line_at(tick, 1.55, 1.0));
    assert_false(next_ring(stents).has_value());
    for (std::uint32_t tick = 440; tick <= 800; tick += 40) stents.advance(line_at(tick, 0.45, 1.0));
    const std::vector<crn_wire_strut> rings = take_struts(stents);
    const StentFigures figures = stent_figures(stents.stents()[0], nullptr);
    assert_int_equal(rings.size(), figures.rings.size());
    double length_mm = 0.0;
    for (std::size_t i = 0; i < rings.size(); ++i) {
        assert_int_equal(rings[i].number, i + 1);
        assert_int_equal(rings[i].joined, i + 1 < rings.size());
        assert_int_equal(rings[i].thickness_um, 81);
        const double wide_mm = figures.rings[i].diameter_mm / 2;
        assert_true(std::abs(rings[i].inside_um * 1e-3 - wide_mm) < 0.05);
        const Vector3d place(rings[i].x_um * 1e-3, rings[i].y_um * 1e-3, rings[i].z_um * 1e-3);
        const bool is_end = i == 0 || i + 1 == rings.size();
        assert_true((place - figures.rings[i].centre_mm).norm() < (is_end ? 0.7 : 0.01));
        if (i == 0) continue;
        const Vector3d before(rings[i - 1].x_um * 1e-3, rings[i - 1].y_um * 1e-3, rings[i - 1].z_um * 1e-3);
        length_mm += (place - before).norm();
    }
    std::printf("# struts from end to end %.2f mm, along the rings' middles %.2f mm\n", length_mm,
                figures.length_mm);
    assert_true(std::abs(length_mm - figures.length_mm) < 1.5);
    for (std::uint32_t tick = 840; tick < 1000; tick += 40) {
        stents.advance(line_at(tick, 0.45, 1.0));
        assert_false(next_ring(stents).has_value());
    }
}

// The balloon of a second stent widens the first stent from inside. The widened rings must be sent to the
// core again. If the core does not confirm the commands about the widened rings, the commands must be sent
// once more at the next update.
void struts_that_are_widened_are_told_again(void **)
{
    PatientStents stents = session_stents(2);
    stents.command(0, load);
    for (std::uint32_t tick = 0; tick <= 800; tick += 40)
        stents.advance(line_at(tick, tick > 200 && tick <= 500 ? 1.38 : 0.45, 1.0));
    const std::vector<crn_wire_strut> rings = take_struts(stents);
    stents.command(801, load);
    for (std::uint32_t tick = 840; tick <= 1000; tick += 40) stents.advance(line_at(tick, 1.35, 1.0));
    const auto first = next_ring(stents);
    stents.advance(line_at(1040, 1.35, 1.0));
    const auto again = next_ring(stents);
    assert_true(first && again && first->number == again->number && first->number <= rings.size());
    std::printf("# ring %d from %d to %d um\n", first->number, rings.at(first->number - 1u).inside_um,
                first->inside_um);
    assert_true(first->inside_um > rings.at(first->number - 1u).inside_um + 20);
    stents.advance(line_at(1080, 1.35, 1.0));
    assert_true(take_struts(stents).size() <= rings.size());
    for (std::uint32_t tick = 1120; tick <= 1200; tick += 40) {
        stents.advance(line_at(tick, 1.35, 1.0));
        take_struts(stents);
    }
    stents.advance(line_at(1240, 1.35, 1.0));
    assert_true(take_struts(stents).empty());
}

// The core can hold a limited number of rings, and every stent of a session gets an equal part of this
// number. If a stent has more rings than its part of the core's limit, the rings for the core are chosen
// evenly from end to end of the stent.
void stents_share_the_rings_of_the_core(void **)
{
    PatientStents stents = session_stents(8);
    carry_out(stents, 1000);
    const std::vector<crn_wire_strut> rings = take_struts(stents);
    assert_int_equal(rings.size(), struts_max / 8);
    assert_true(rings.back().number == struts_max / 8 && rings.back().joined == 0);
    PatientStents alone = session_stents();
    carry_out(alone, 1000);
    const std::vector<crn_wire_strut> all = take_struts(alone);
    assert_true(all.front().x_um == rings.front().x_um && all.back().y_um == rings.back().y_um);
}

// If a device did not carry out a command, the command must be sent again.
void what_the_core_did_not_confirm_is_asked_for_again(void **)
{
    PatientStents stents = session_stents();
    carry_out(stents, 1000);
    const auto first = next_hold(stents);
    stents.advance(line_at(840, 0.45, 1.0));
    const auto again = next_hold(stents);
    assert_true(first && again && first->first == again->first && first->open_q15 == again->open_q15);
}

// A stent does not open a lesion by itself: the lesion stays open only as far as the balloon has opened it.
void a_stent_holds_no_more_than_is_open(void **)
{
    PatientStents stents = session_stents();
    stents.command(0, load);
    for (std::uint32_t tick = 0; tick <= 400; tick += 40) stents.advance(line_at(tick, 1.55, 0.25));
    const auto order = next_hold(stents);
    assert_true(order && order->first == 0 && order->last == stations - 1);
    assert_int_equal(order->open_q15, 32768 / 4);
    assert_false(next_hold(stents).has_value());
}

// The tools in use at the start may include no balloon; the message of the refusal must then tell what a
// trainee can do, not how to call the program.
void without_a_balloon_on_the_line_the_refusal_says_what_to_do(void **)
{
    const std::vector<Instrument> tools = wire_and_balloon();
    PatientStents stents(read_stents({stent_file}, tools), beating_artery(true), nullptr,
                         {{stations, 12e-3 / (stations - 1)}}, {tools[0]}, true);
    stents.command(50, load);
    assert_int_equal(stents.loaded(), 0);
    assert_string_equal(stents.refusals().at(0).c_str(),
                        "NO STENT LOADED - no device on the line has a balloon: "
                        "load the balloon catheter first (at 50 ms)");
}

void another_one_is_loaded_outside_only(void **)
{
    PatientStents stents = session_stents(2);
    crn_wire_tick_state state{};
    state.tools_count = 2;
    state.tools[1].inserted_m_q30 = 1 << 24; // 15.6 mm: the balloon begins 5 mm proximal to the tip
    stents.command(0, load);
    stents.advance(line_at(0, 0.45, 0.0));
    stents.tick({}, state);
    stents.command(50, load);
    assert_int_equal(stents.loaded(), 1);
    assert_non_null(std::strstr(stents.refusals().at(0).c_str(), "in the patient"));
    state.tools[1].inserted_m_q30 = 1 << 22; // 3.9 mm
    stents.tick({}, state);
    stents.command(60, load);
    assert_int_equal(stents.loaded(), 2);
    stents.command(70, load);
    assert_non_null(std::strstr(stents.refusals().at(1).c_str(), "NO STENT LEFT"));
    const std::vector<StentResult> results = stents.results();
    assert_int_equal(results.size(), 2);
    assert_true(results[0].was_taken_out && !results[1].was_taken_out);
}

// The test compares the iodine in the column of medium with that in the parts of the balloon. The parts of
// the balloon in this test are the cylinder, the cones and the waist. A conical end of the balloon with the
// radii R and r and the length h has the volume pi h / 3 (R^2 + R r + r^2), less that of the shaft.
void the_filling_holds_as_much_as_the_balloon(void **)
{
    const std::vector<Instrument> tools = wire_and_balloon();
    const auto iodine = [&](const WireFrame &wire) {
        double sum = 0.0;
        for (const SweptCurve &curve : balloon_filling(wire, tools, 175.0))
            for (std::size_t i = 1; i < curve.points.size(); ++i) {
                const SweptPoint &a = curve.points[i - 1], &b = curve.points[i];
                const double r = (a.radius_m + b.radius_m) / 2e-3, share = (a.share + b.share) / 2;
                sum += pi * r * r * share * (b.at_m - a.at_m).norm() * 1e3;
            }
        return sum / contrast_share(175.0); // mm^3 of medium
    };
    const double R = 1.5, r = 0.45, h = (R - r) / 0.5;
    const double cone = pi * h / 3 * (R * R + R * r + r * r) - pi * h * r * r;
    const double whole = pi * 20 * (R * R - r * r) + 2 * cone;
    const double filled = iodine(line_at(0, R, 0.0));
    std::printf("# %.1f mm3 of medium, expected %.1f\n", filled, whole);
    assert_true(std::abs(filled - whole) < 0.03 * whole);
    assert_true(balloon_filling(line_at(0, r, 0.0), tools, 175.0).empty());
    WireFrame waist = line_at(0, R, 0.0);
    waist.balloon_radii_m[10] = 0.8e-3; // linear to the neighbouring balls, a millimetre on either side
    const double lost = 2 * (pi * R * R - pi / 3 * (R * R + R * 0.8 + 0.8 * 0.8));
    assert_true(std::abs(filled - iodine(waist) - lost) < 0.1 * lost);
}

void a_balloon_outside_of_the_patient_is_not_seen(void **)
{
    WireFrame wire = line_at(0, 1.5, 0.0);
    wire.balloon_arc_m = wire.nodes.back().arc_m + 0.05;
    assert_true(balloon_filling(wire, wire_and_balloon(), 175.0).empty());
    assert_true(balloon_pose(wire, 1).points.empty());
    wire.balloon_arc_m =
        wire.nodes.back().arc_m - 0.005; // most of it is in the introducer, where the line continues straight
    const BalloonPose pose = balloon_pose(wire, 1);
    assert_int_equal(pose.points.size(), 21);
    for (std::size_t i = 1; i < pose.points.size(); ++i)
        assert_true(std::abs((pose.points[i].centre_mm - pose.points[i - 1].centre_mm).norm() - 1.0) < 0.01);
}

void balloon_figures_say_how_far_how_hard_and_how_long(void **)
{
    BalloonFigures figures;
    for (std::uint32_t tick = 1; tick <= 400; ++tick) {
        crn_wire_tick_state state{};
        const bool is_up = (tick > 100 && tick <= 150) || (tick > 200 && tick <= 300);
        state.tick = tick;
        state.balloon_kPa = is_up ? (tick == 250 ? 1200 : 800) : 0;
        state.balloon_diameter_max_um = is_up ? 3000 : 900;
        state.balloon_diameter_min_um = is_up ? 2500 : 900;
        state.balloon_wall_mN = tick == 220 ? 60500 : 0;
        state.balloon_bits = tick >= 301 ? 1 : 0;
        figures.take(state);
    }
    assert_true(figures.is_there && figures.peaks.size() == 1 && figures.peaks[0].pressure_kPa == 1200 &&
                figures.peaks[0].tick == 250);
    assert_true(figures.inflations == 2 && figures.ticks_up == 150 && figures.ticks_up_longest == 100);
    assert_true(figures.burst_tick == 301u && figures.diameter_max_mm == 3.0 && figures.wall_max_N == 60.5);
    assert_int_equal(figures.series.size(), 10);
    assert_true(figures.series[2].tick == 120 && figures.series[2].pressure_kPa == 800.0f &&
                figures.series[2].diameter_min_mm == 2.5f);
}

void scripts_load_stents(void **)
{
    const Session session = parse_session("load stent\nwait 1 s\n", "s");
    assert_true(session.statements.at(0).room.at(0) == load);
    try {
        parse_session("load stint\n", "s"); // no "load NAME as TOOL"
        fail_msg("'load stint' was accepted");
    } catch (const FileError &error) {
        assert_non_null(std::strstr(error.what(), "s:1:6: unknown word 'stint', did you mean 'stent'?"));
    }
}

std::vector<std::uint8_t> recorded(const std::string &path, const StentDesign &stent)
{
    RecordingHeader header;
    header.schema_hash = crn_wire_schema_hash();
    header.tools = wire_and_balloon();
    header.entry.inserted_um_count = 2;
    header.stents = {stent};
    Recorder(path, header).finish(0, 1);
    const std::vector<unsigned char> bytes = read_binary_file(path);
    return {bytes.begin(), bytes.end()};
}

// A recording must contain a stent exactly, to the last bit. The reader must refuse a recorded stent that no
// stent file could describe.
void a_recording_keeps_its_stents(void **)
{
    const tests::Folder folder("stents");
    const StentDesign design = read_stent(stent_file);
    const Recording read = parse_recording(recorded(folder.file("a.rec"), design), "a");
    assert_int_equal(read.header.stents.size(), 1);
    const StentDesign &kept = read.header.stents[0];
    assert_true(kept.name == design.name && kept.material == design.material &&
                kept.connection == design.connection);
    for (const StentNumber &row : stent_numbers()) assert_true(kept.*row.value == design.*row.value);
    for (const StentCount &row : stent_counts()) assert_true(kept.*row.value == design.*row.value);
    StentDesign nonsense[3] = {design, design, design};
    nonsense[0].strut_length_mm = std::nan("");
    nonsense[1].crowns = 1 << 30;
    nonsense[2].strut_length_mm = 0.5; // too short to reach from crown to crown
    for (const StentDesign &bad : nonsense) {
        try {
            parse_recording(recorded(folder.file("b.rec"), bad), "b");
            fail_msg("a design out of range was accepted");
        } catch (const RecordingError &error) {
            assert_true(error.fault == RecordingFault::inconsistent);
        }
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_stent_is_refused_on_what_cannot_carry_it),
        cmocka_unit_test(nothing_is_looked_at_before_a_stent_is_loaded),
        cmocka_unit_test(other_pictures_do_not_change_the_stents),
        cmocka_unit_test(a_saved_stent_continues_bit_for_bit),
        cmocka_unit_test(damaged_stents_are_refused_or_can_continue),
        cmocka_unit_test(the_core_is_asked_once_for_what_it_does_not_know),
        cmocka_unit_test(struts_are_told_once_the_stent_is_deployed),
        cmocka_unit_test(struts_that_are_widened_are_told_again),
        cmocka_unit_test(stents_share_the_rings_of_the_core),
        cmocka_unit_test(what_the_core_did_not_confirm_is_asked_for_again),
        cmocka_unit_test(a_stent_holds_no_more_than_is_open),
        cmocka_unit_test(without_a_balloon_on_the_line_the_refusal_says_what_to_do),
        cmocka_unit_test(another_one_is_loaded_outside_only),
        cmocka_unit_test(the_filling_holds_as_much_as_the_balloon),
        cmocka_unit_test(a_balloon_outside_of_the_patient_is_not_seen),
        cmocka_unit_test(balloon_figures_say_how_far_how_hard_and_how_long),
        cmocka_unit_test(scripts_load_stents),
        cmocka_unit_test(a_recording_keeps_its_stents),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
