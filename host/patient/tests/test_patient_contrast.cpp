// Tests contrast medium in a session: the medium must leave only through the openings of the catheter. The
// medium must depend only on the commands and on the shapes of the tools at fixed ticks, whatever pictures
// were requested. The columns that the X-ray shows must contain as much iodine as the vessels.
#include "host/base/text.hpp"
#include "host/patient/contrast.hpp"
#include "host/patient/layering.hpp"
#include "host/rig/pedals.hpp"
#include "host/script/session.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
extern "C" {
#include <cmocka.h>

#include "shared/scene/tests/scene_sample.h"
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

constexpr std::uint32_t never = std::numeric_limits<std::uint32_t>::max();
using std::numbers::pi;
const RoomCommand inject_6_ml{RoomAction::inject, {6000, 4000, 0}};

// Makes an aorta of 300 mm length down the y axis, with a radius of 8 mm and a flow of 30 ml/s.
VesselTree aorta()
{
    VesselBranch branch;
    branch.name = "aorta";
    branch.flow_ml_s = 30.0;
    for (int i = 0; i <= 30; ++i) {
        branch.points_m.push_back({0.0, -0.01 * i, 0.0});
        branch.radii_m.push_back(0.008);
    }
    return {{branch}};
}

Instrument tool(const char *name, std::uint32_t inner_um)
{
    Instrument made;
    made.name = name;
    made.table.knots_count = 1;
    made.table.knots[0].radius_outer_um = 800;
    made.table.knots[0].radius_inner_um = inner_um;
    return made;
}

// The nested tools go up the aorta from its lower end. The tip of the catheter is at y = -150 mm, and the tip
// of the guidewire is 50 mm ahead of it.
WireFrame line_at(std::uint32_t tick)
{
    WireFrame wire;
    wire.tick = tick;
    wire.tip_arc_m = {0.0, 0.05};
    for (int i = 0; i <= 20; ++i) {
        WireNode node;
        node.position_m = {0.0, -0.1 - 0.01 * i, 0.0};
        node.arc_m = 0.01 * i;
        node.radius_m = 0.0008;
        wire.nodes.push_back(node);
    }
    return wire;
}

const std::vector<Instrument> wire_and_catheter = {tool("wire", 0), tool("catheter", 485)};

// Advances to tick `end`, and stops at every multiple of `frame_ticks` and at every tick at which the tools'
// shape must be read.
void go_on(PatientContrast &contrast, std::uint32_t from, std::uint32_t end, std::uint32_t frame_ticks)
{
    for (std::uint32_t tick = from; tick < end;) {
        tick = std::min({end, contrast.next_tick(), (tick / frame_ticks + 1) * frame_ticks});
        contrast.advance(line_at(tick));
    }
}

void medium_comes_out_of_the_catheter_and_not_of_the_wire(void **)
{
    PatientContrast contrast(aorta(), wire_and_catheter);
    contrast.advance(line_at(0));
    assert_string_equal(contrast.command(1, inject_6_ml).c_str(), "");
    go_on(contrast, 0, 100, 20);
    const FlowCells &cells = contrast.flow().cells();
    assert_true(contrast.flow().held_mg() > 10.0);
    for (std::size_t i = 0; i < cells.size(); ++i)
        if (cells.middle_m(i).y() > -0.148) assert_true(contrast.flow().iodine_mg_per_ml(i) == 0.0);
}

void without_a_catheter_or_vessels_it_says_so(void **)
{
    PatientContrast bare(aorta(), {tool("wire", 0)}), no_tree({}, wire_and_catheter),
        good(aorta(), wire_and_catheter);
    assert_non_null(std::strstr(bare.command(0, inject_6_ml).c_str(), "NO CATHETER"));
    assert_non_null(std::strstr(no_tree.command(0, inject_6_ml).c_str(), "NO VESSELS"));
    assert_non_null(std::strstr(good.refusal({RoomAction::inject, {1000, 1000, 1}}, 350.0).c_str(),
                                "'wire' HAS NO LUMEN"));
    assert_non_null(
        std::strstr(good.refusal({RoomAction::inject, {1000, 1000, 3}}, 350.0).c_str(), "NO DEVICE 3"));
    assert_true(bare.next_tick() == never && no_tree.next_tick() == never && good.next_tick() == never);
}

// Additional frames, such as those of a film, must not change any bit of the simulated contrast medium.
void other_pictures_do_not_change_the_medium(void **)
{
    PatientContrast often(aorta(), wire_and_catheter), seldom(aorta(), wire_and_catheter);
    for (PatientContrast *contrast : {&often, &seldom}) {
        const std::uint32_t frame_ticks = contrast == &often ? 7 : 1000;
        contrast->advance(line_at(0));
        go_on(*contrast, 0, 333, frame_ticks);
        contrast->command(334, inject_6_ml);
        go_on(*contrast, 333, 1200, frame_ticks);
    }
    assert_true(often.flow().held_mg() > 100.0);
    assert_true(often.flow().snapshot() == seldom.flow().snapshot());
}

void after_washing_out_no_look_is_wanted(void **)
{
    PatientContrast contrast(aorta(), wire_and_catheter);
    contrast.command(0, inject_6_ml);
    go_on(contrast, 0, 2000, 1000);
    assert_true(contrast.next_tick() == 2040);
    go_on(contrast, 2000, 60000, 1000);
    assert_true(contrast.next_tick() == never && contrast.curves().empty());
    assert_true(std::fabs(contrast.injected_ml() - 6.0) < 1e-9);
    assert_true(std::fabs(contrast.flow().budget().injected_mg - 6.0 * 350.0) < 1e-6);
}

// In this test an artery divides into two branches. In both branches a column of medium must begin where the
// artery ends.
void columns_have_no_gap_where_a_vessel_divides(void **)
{
    VesselTree tree = aorta();
    const Vector3d fork_m = tree.branches[0].points_m.back();
    for (double side : {-1.0, 1.0}) {
        VesselBranch branch;
        branch.name = side < 0 ? "right" : "left";
        branch.parent = 0;
        branch.parent_point = 30;
        branch.flow_ml_s = 15.0;
        for (int i = 0; i <= 20; ++i) {
            branch.points_m.push_back(fork_m + 0.005 * i * Vector3d(0.7 * side, -0.7, 0.0));
            branch.radii_m.push_back(0.005);
        }
        tree.branches.push_back(branch);
    }
    PatientContrast contrast(tree, wire_and_catheter);
    contrast.command(0, {RoomAction::inject, {60000, 30000, 0}});
    go_on(contrast, 0, 2000, 1000);
    int begin = 0, end = 0;
    for (const SweptCurve &curve : contrast.curves()) {
        begin += (curve.points.front().at_m - fork_m).norm() < 1e-6;
        end += (curve.points.back().at_m - fork_m).norm() < 1e-6;
    }
    assert_true(begin >= 2 && end >= 1);
}

// The test compares the iodine in the columns with the iodine in the cells. The iodine of a column is the
// volume of its cones times the fraction of iohexol 350 in them. The tolerance of 2 % is needed because the
// ends of columns fade out, and because the concentration changes linearly along a column.
void columns_hold_the_iodine_of_the_vessels(void **)
{
    PatientContrast contrast(aorta(), wire_and_catheter);
    contrast.command(0, inject_6_ml);
    go_on(contrast, 0, 1000, 1000);
    double mg = 0.0;
    for (const SweptCurve &curve : contrast.curves())
        for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
            const SweptPoint &a = curve.points[i], &b = curve.points[i + 1];
            const double square =
                (a.radius_m * a.radius_m + a.radius_m * b.radius_m + b.radius_m * b.radius_m) / 3;
            mg += pi * square * (b.at_m - a.at_m).norm() * 1e6 * 0.5 * (a.share + b.share) * 350.0;
        }
    if (std::fabs(mg - contrast.flow().held_mg()) > 0.02 * mg)
        fail_msg("curves %.1f mg, vessels %.1f mg", mg, contrast.flow().held_mg());
}

// After the injection, blood without medium follows from upstream. The column does not begin with a flat face
// at full strength: over two radii of the vessel, its concentration rises from nothing.
void the_upstream_end_of_medium_is_soft(void **)
{
    PatientContrast contrast(aorta(), wire_and_catheter);
    contrast.command(0, inject_6_ml);
    go_on(contrast, 0, 1620, 20);
    assert_false(contrast.curves().empty());
    const std::vector<SweptPoint> &points = contrast.curves().front().points; // of the vessel's whole width
    double largest_step = 0.0, most = 0.0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        most = std::max(most, points[i].share);
        if ((points[i].at_m - points.front().at_m).norm() < 0.016)
            largest_step = std::max(largest_step, points[i + 1].share - points[i].share);
    }
    assert_true(points.front().share == 0.0 && most > 0.05);
    assert_true(largest_step < 0.4 * most);
}

// Undiluted iohexol 350 in an aorta of 20 mm width at 0.2 m/s: Ri = 9.81 * 0.3175 * 0.02 / 0.04 = 1.56, so it
// settles as far as it can. A tenth of it has Ri = 0.16, and stays mixed; so does a fast vessel.
void medium_settles_where_buoyancy_beats_the_flow(void **)
{
    const double flow_ml_s = 0.2 * pi * 0.01 * 0.01 * 1e6;
    assert_true(settled_share(350.0, 10.0, flow_ml_s) == 0.9);
    assert_true(settled_share(35.0, 10.0, flow_ml_s) == 0.0);
    assert_true(settled_share(350.0, 10.0, 3.0 * flow_ml_s) == 0.0);
    // Half of it: Ri = 0.778, so (0.778 - 0.25) / 1.25.
    assert_true(std::fabs(settled_share(175.0, 10.0, flow_ml_s) - 0.423) < 1e-3);
}

// In a wide and slow aorta, the middle of all iodine lies behind the axis, and its amount is unchanged.
void settled_medium_lies_at_the_back_of_the_vessel(void **)
{
    VesselTree tree = aorta();
    tree.branches[0].flow_ml_s = 15.0; // 0.075 m/s
    PatientContrast contrast(tree, wire_and_catheter);
    contrast.command(0, inject_6_ml);
    go_on(contrast, 0, 2200, 1000);
    double mg = 0.0, back_m_mg = 0.0;
    for (const SweptCurve &curve : contrast.curves())
        for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
            const SweptPoint &a = curve.points[i], &b = curve.points[i + 1];
            const double square =
                (a.radius_m * a.radius_m + a.radius_m * b.radius_m + b.radius_m * b.radius_m) / 3;
            const double piece_mg =
                pi * square * (b.at_m - a.at_m).norm() * 1e6 * 0.5 * (a.share + b.share) * 350.0;
            mg += piece_mg;
            back_m_mg -= piece_mg * 0.5 * (a.at_m.z() + b.at_m.z());
        }
    // The middle of a lower half disc lies 0.42 radii below the axis; the core column is 0.29 radii below it.
    const double back_radii = back_m_mg / mg / 0.008;
    if (!(back_radii > 0.05 && back_radii < 0.29)) fail_msg("%.3f radii behind the axis", back_radii);
    if (std::fabs(mg - contrast.flow().held_mg()) > 0.03 * mg)
        fail_msg("curves %.1f mg, vessels %.1f mg", mg, contrast.flow().held_mg());
}

// The session injects 6 ml of 350 mg/ml at 4 ml/s. The injection starts at tick 1001, because the command
// comes after the frame of tick 1000. Then the session injects 2 ml of 150 mg/ml at 2 ml/s.
void what_was_given_between_two_ticks_is_known(void **)
{
    PatientContrast contrast(aorta(), wire_and_catheter);
    contrast.advance(line_at(0));
    go_on(contrast, 0, 1000, 100);
    contrast.command(1000, inject_6_ml);
    go_on(contrast, 1000, 4000, 100);
    contrast.command(4000, {RoomAction::contrast_strength, {150, 0, 0}});
    contrast.command(4000, {RoomAction::inject, {2000, 2000, 0}});
    go_on(contrast, 4000, 6000, 100);
    assert_false(contrast.given(0, 1000).has_value());
    assert_false(contrast.given(2501, 4000).has_value());
    const RunContrast whole = contrast.given(0, 4000).value(), half = contrast.given(1751, 3000).value(),
                      both = contrast.given(0, 6000).value();
    const auto assert_given = [](const RunContrast &given, double ml, double ml_s, double s, double mg_ml) {
        if (std::fabs(given.volume_ml - ml) > 1e-9 || std::fabs(given.flow_ml_s - ml_s) > 1e-9 ||
            std::fabs(given.duration_s - s) > 1e-9 || std::fabs(given.iodine_mg_ml - mg_ml) > 1e-9)
            fail_msg("%g ml at %g ml/s in %g s, %g mg/ml", given.volume_ml, given.flow_ml_s, given.duration_s,
                     given.iodine_mg_ml);
    };
    assert_given(whole, 6.0, 4.0, 1.5, 350.0);
    assert_int_equal(whole.tick_begin, 1001);
    assert_given(half, 3.0, 4.0, 0.75, 350.0);
    assert_given(both, 8.0, 8.0 / 2.5, 2.5, (6.0 * 350.0 + 2.0 * 150.0) / 8.0);
}

void blood_around_the_line_takes_its_colour(void **)
{
    PatientContrast contrast(aorta(), wire_and_catheter);
    contrast.command(0, inject_6_ml);
    go_on(contrast, 0, 1000, 1000);
    WireFrame wire = line_at(1000);
    contrast.colour(wire);
    assert_true(wire.nodes[0].contrast_mg_per_ml == 0.0);  // upstream
    assert_true(wire.nodes[15].contrast_mg_per_ml > 10.0); // downstream of the catheter's tip
}

// Every one of the catheter's 20 side holes has a fifth of the end hole's area. A fifth of the medium leaves
// at the tip, and the remainder leaves between 20 and 58 mm behind the tip.
void a_pigtail_gives_medium_through_its_side_holes(void **)
{
    Instrument pigtail = tool("pigtail", 500);
    pigtail.side_holes = {{0.020, 0.058, 20, 2 * 0.0005 * std::sqrt(0.2)}};
    const std::vector<CatheterMouth> mouths = catheter_mouths(pigtail, line_at(0), 0.05);
    assert_int_equal(mouths.size(), 21);
    assert_true(std::fabs(mouths[0].share - 0.2) < 1e-12);
    assert_true((mouths[0].place_m - Vector3d(0, -0.15, 0)).norm() < 1e-12);
    assert_true((mouths[20].place_m - Vector3d(0, -0.208, 0)).norm() < 1e-12);
    PatientContrast contrast(aorta(), {tool("wire", 0), pigtail});
    contrast.command(400, inject_6_ml); // in diastole, when blood is slow
    go_on(contrast, 400, 441, 20);      // one look, then 1 ms: the injected medium is still where it entered
    const FlowCells &cells = contrast.flow().cells();
    double ahead_mg = 0.0, all_mg = 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const double mg = contrast.flow().iodine_mg_per_ml(i) * cells[i].volume_ml;
        all_mg += mg;
        if (cells.middle_m(i).y() > -0.16) ahead_mg += mg;
    }
    if (std::fabs(ahead_mg / all_mg - 0.2) > 0.03) fail_msg("%.3f of it at the tip", ahead_mg / all_mg);
}

// The core's heartbeats determine the blood flow. During asystole the medium stays where it was injected;
// when the heart beats, the blood moves 6 ml of medium away.
void blood_flows_with_the_cores_heart(void **)
{
    double carried_mg[2] = {};
    for (bool is_resting : {false, true}) {
        PatientContrast contrast(aorta(), wire_and_catheter);
        contrast.command(0, {RoomAction::inject, {200, 4000, 0}});
        go_on(contrast, 0, 40, 40);
        for (std::uint32_t tick = 41; tick <= 4000; ++tick) {
            crn_wire_tick_state state{};
            state.tick = tick;
            state.beat_ms = tick % 857;
            state.interval_ms = 857;
            state.rhythm_bits = is_resting ? CRN_WIRE_RHYTHM_IS_RESTING : 0;
            contrast.tick(state);
            if (tick % 40 == 0) contrast.advance(line_at(tick));
        }
        carried_mg[is_resting] = contrast.flow().budget().out_mg;
    }
    assert_true(carried_mg[0] > 60.0 && carried_mg[1] == 0.0);
}

// In this test a vessel passes through the lattice of the sample scene, which heart and breath move. The
// cells of the vessel must be where the lattice moves them, to within 0.1 mm; the vessel has a point every
// millimetre.
void medium_moves_with_the_vessels(void **)
{
    alignas(16) static std::uint8_t file[SAMPLE_BYTES_MAX];
    crn_scene scene{};
    if (crn_scene_open(file, sample_moving_scene(file, sizeof file), &scene, nullptr) != CRN_SCENE_OK)
        fail_msg("the sample does not open");
    const Motion motion(scene);
    VesselTree vessel = aorta();
    VesselBranch &branch = vessel.branches[0];
    for (std::size_t i = 0; i < branch.points_m.size(); ++i) {
        branch.points_m[i] = {0.001 * (static_cast<double>(i) - 15.0), 0.0078, 0.0078};
        branch.radii_m[i] = 0.002;
    }
    const PatientContrast still(vessel, wire_and_catheter);
    PatientContrast contrast(vessel, wire_and_catheter, &motion);
    contrast.command(0, inject_6_ml);
    WireFrame wire = line_at(40);
    wire.heart_phase32 = 1u << 31;
    contrast.advance(wire);
    const FlowCells &cells = contrast.flow().cells();
    double largest_m = 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const Vector3d rest_m = still.flow().cells().middle_m(i);
        const Vector3d pushed_m = motion.push(rest_m, MotionMoment{wire.heart_phase32, 0});
        largest_m = std::max(largest_m, (pushed_m - rest_m).norm());
        if ((cells.middle_m(i) - pushed_m).norm() > 1e-4) fail_msg("cell %zu is elsewhere", i);
    }
    assert_true(largest_m > 0.5e-3);
}

// --- lesions that yield ---

// The last 60 mm of the aorta, from y = -160 to -220 mm, lie beyond the catheter's tip. The narrowed part of
// the aorta has a radius of 2 mm instead of 8 mm, and is shifted 3 mm to the left.
VesselTree narrowed_aorta()
{
    VesselTree tree = aorta();
    VesselLesion lesion;
    lesion.name = "plaque";
    lesion.first_point = 16;
    for (std::size_t i = 16; i <= 22; ++i) {
        lesion.healthy_points_m.push_back(tree.branches[0].points_m[i]);
        lesion.healthy_radii_m.push_back(0.008);
        if (i == 16 || i == 22) continue;
        tree.branches[0].points_m[i].x() = 0.003;
        tree.branches[0].radii_m[i] = 0.002;
    }
    tree.lesions.push_back(lesion);
    return tree;
}

const LesionStations stations_of_aorta{7, 0.01};

// The opening of the lesion (1 means fully open) rises to 0.7 within a second from 1 s on, and is 0.5 from 2
// s on. Medium fills the lesion meanwhile.
WireFrame giving_way_at(std::uint32_t tick)
{
    WireFrame wire = line_at(tick);
    const double share = tick < 1000 ? 0.0 : tick < 2000 ? 0.7e-3 * (tick - 1000) : 0.5;
    wire.lesions_open.assign(7, share);
    return wire;
}

void a_lesion_that_gives_way_widens_cells_and_columns(void **)
{
    PatientContrast often(narrowed_aorta(), wire_and_catheter, nullptr,
                          {narrowed_aorta(), {&stations_of_aorta, 1}}),
        seldom(often);
    for (PatientContrast *contrast : {&often, &seldom}) {
        const std::uint32_t frame_ticks = contrast == &often ? 7 : 1000;
        contrast->advance(giving_way_at(0));
        contrast->command(1, {RoomAction::inject, {60000, 20000, 0}});
        for (std::uint32_t tick = 0; tick < 3000;) {
            tick = std::min({3000u, contrast->next_tick(), (tick / frame_ticks + 1) * frame_ticks});
            contrast->advance(giving_way_at(tick));
        }
    }
    assert_true(often.flow().snapshot() == seldom.flow().snapshot());
    const IodineBudget &budget = often.flow().budget();
    const double lost_mg = budget.injected_mg - often.flow().held_mg() - budget.out_mg - budget.reflux_mg;
    assert_true(budget.injected_mg > 10000 && std::fabs(lost_mg) < 1e-9 * budget.injected_mg);
    const FlowCells &cells = often.flow().cells(); // half open: 5 mm, 1.5 mm to the left
    const Vector3d middle_m(0.0015, -0.19, 0);
    const std::size_t cell = cells.nearest(middle_m);
    assert_true(std::fabs(cells[cell].radius_mm - 5) < 1e-9 &&
                std::fabs(cells.middle_m(cell).x() - 0.0015) < 1e-9);
    double widest_m = 0;
    for (const SweptCurve &curve : often.curves())
        for (const SweptPoint &point : curve.points)
            if (std::fabs(point.at_m.y() + 0.19) < 0.005) widest_m = std::max(widest_m, point.radius_m);
    assert_true(std::fabs(widest_m - 0.005) < 1e-6);
    const VesselTree opened = often.opened_vessels();
    assert_true(std::fabs(opened.branches[0].radii_m[19] - 0.005) < 1e-12);
    assert_true(often.vessels().branches[0].radii_m[19] == 0.002);
}

// In this test a lesion yields at 1500 ms, and its cells widen; in the object that restores the saved state,
// the lesion was half open before.
void a_saved_lesion_continues_bit_for_bit(void **)
{
    const LesionOpening opening(narrowed_aorta(), {&stations_of_aorta, 1});
    PatientContrast first(narrowed_aorta(), wire_and_catheter, nullptr, opening), other(first), fresh(first);
    const auto run = [](PatientContrast &contrast, std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t tick = from; tick < to;) {
            tick = std::min(to, contrast.next_tick());
            contrast.advance(giving_way_at(tick));
        }
    };
    for (PatientContrast *contrast : {&first, &other}) {
        contrast->advance(giving_way_at(0));
        contrast->command(1, {RoomAction::inject, {60000, 20000, 0}});
    }
    run(other, 0, 2600);
    run(first, 0, 1507);
    std::vector<std::uint8_t> bytes;
    StateArchive saved = StateArchive::saving(bytes);
    first.archive(saved, 1507, wire_and_catheter, {});
    const std::vector<SweptCurve> curves = first.curves();
    run(first, 1507, 2300);
    for (PatientContrast *contrast : {&other, &fresh}) {
        StateArchive restored = StateArchive::restoring(bytes);
        contrast->archive(restored, 1507, wire_and_catheter, {});
        assert_true(!restored.is_refused() && restored.is_at_end());
        assert_true(contrast->curves().size() == curves.size() && curves.size() > 1);
        for (std::size_t i = 0; i < curves.size(); ++i)
            assert_true(contrast->curves()[i].points.back().at_m == curves[i].points.back().at_m);
        run(*contrast, 1507, 2300);
        assert_true(contrast->flow().snapshot() == first.flow().snapshot());
    }
}

// The lesion in the sample's moving scene is fully open, so its cells must be where the heart moves the
// healthy vessel.
void an_open_lesion_moves_with_the_heart(void **)
{
    alignas(16) static std::uint8_t file[SAMPLE_BYTES_MAX];
    crn_scene scene{};
    if (crn_scene_open(file, sample_moving_scene(file, sizeof file), &scene, nullptr) != CRN_SCENE_OK)
        fail_msg("the sample does not open");
    const Motion motion(scene);
    VesselTree narrow = aorta();
    for (std::size_t i = 0; i < narrow.branches[0].points_m.size(); ++i) {
        narrow.branches[0].points_m[i] = {0.001 * (static_cast<double>(i) - 15.0), 0.0078, 0.0078};
        narrow.branches[0].radii_m[i] = 0.002;
    }
    VesselLesion lesion;
    lesion.name = "plaque";
    lesion.first_point = 10;
    for (std::size_t i = 10; i <= 20; ++i) {
        lesion.healthy_points_m.push_back(narrow.branches[0].points_m[i]);
        lesion.healthy_radii_m.push_back(0.002);
        narrow.branches[0].points_m[i].z() += 0.0008;
        narrow.branches[0].radii_m[i] = 0.0008;
    }
    narrow.lesions.push_back(lesion);
    const LesionStations stations{11, 0.001};
    PatientContrast contrast(narrow, wire_and_catheter, &motion, {narrow, {&stations, 1}});
    contrast.command(0, inject_6_ml);
    WireFrame wire = line_at(40);
    wire.heart_phase32 = 1u << 31;
    wire.lesions_open.assign(11, 1.0);
    contrast.advance(wire);
    const FlowCells &cells = contrast.flow().cells();
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (std::fabs(cells[i].radius_mm - 2) > 1e-9) fail_msg("cell %zu: %.6f mm", i, cells[i].radius_mm);
        const Vector3d rest_m = motion.pull(cells.middle_m(i), MotionMoment{wire.heart_phase32, 0});
        if (std::hypot(rest_m.y() - 0.0078, rest_m.z() - 0.0078) > 1e-4) fail_msg("cell %zu is elsewhere", i);
    }
}

// --- ways to order an injection ---

void scripts_ask_for_it_in_millilitres(void **)
{
    const Session session = parse_session(
        "contrast 300 mg/ml\ninject 8 ml at 4 ml/s\ninject 30 ml at 15 ml/s through catheter\ninject stop\n",
        "s");
    const auto command = [&](std::size_t i) { return session.statements[i].room.at(0); };
    assert_true(command(0) == (RoomCommand{RoomAction::contrast_strength, {300, 0, 0}}));
    assert_true(command(1) == (RoomCommand{RoomAction::inject, {8000, 4000, 0}}));
    assert_true(command(2) == (RoomCommand{RoomAction::inject, {30000, 15000, 2}}));
    assert_true(command(3) == (RoomCommand{RoomAction::inject, {0, 0, 0}}));
    for (const char *wrong :
         {"inject 8 at 4 ml/s", "inject 8 ml", "inject 8 ml at 4 mm/s", "inject 900 ml at 4 ml/s",
          "inject 8 ml at 4 ml/s through wire", "contrast 3 kg"}) {
        bool is_refused = false;
        try {
            parse_session(wrong, "s");
        } catch (const FileError &error) {
            is_refused = std::string(error.what()).find("s:1:") == 0;
        }
        if (!is_refused) fail_msg("accepted: %s", wrong);
    }
}

// When the syringe's plunger moves by 5,000 counts in 1 s, while its counter wraps round, 5 ml are injected.
// When the plunger is drawn back, or its sensor jumps, nothing is injected.
void a_rigs_syringe_injects_what_its_plunger_gives(void **)
{
    RigSyringe syringe;
    std::int32_t counts = std::numeric_limits<std::int32_t>::max() - 1000;
    std::int64_t volume_ul = 0;
    const auto move = [&](std::uint32_t tick, std::int32_t by) {
        counts =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) + static_cast<std::uint32_t>(by));
        if (const auto command = syringe.change(tick, counts)) {
            assert_string_equal(refusal(*command).c_str(), "");
            volume_ul += command->values[0];
        }
    };
    for (std::uint32_t tick = 1; tick <= 1001; ++tick) move(tick, tick <= 1 ? 0 : 5);
    for (std::uint32_t tick = 1002; tick <= 2000; ++tick)
        move(tick, tick == 1500 ? 10'000'000 : tick > 1100 ? -4 : 0);
    assert_int_equal(volume_ul, 5000);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(medium_comes_out_of_the_catheter_and_not_of_the_wire),
        cmocka_unit_test(without_a_catheter_or_vessels_it_says_so),
        cmocka_unit_test(other_pictures_do_not_change_the_medium),
        cmocka_unit_test(after_washing_out_no_look_is_wanted),
        cmocka_unit_test(columns_have_no_gap_where_a_vessel_divides),
        cmocka_unit_test(columns_hold_the_iodine_of_the_vessels),
        cmocka_unit_test(the_upstream_end_of_medium_is_soft),
        cmocka_unit_test(medium_settles_where_buoyancy_beats_the_flow),
        cmocka_unit_test(settled_medium_lies_at_the_back_of_the_vessel),
        cmocka_unit_test(what_was_given_between_two_ticks_is_known),
        cmocka_unit_test(blood_around_the_line_takes_its_colour),
        cmocka_unit_test(a_pigtail_gives_medium_through_its_side_holes),
        cmocka_unit_test(blood_flows_with_the_cores_heart),
        cmocka_unit_test(medium_moves_with_the_vessels),
        cmocka_unit_test(a_lesion_that_gives_way_widens_cells_and_columns),
        cmocka_unit_test(a_saved_lesion_continues_bit_for_bit),
        cmocka_unit_test(an_open_lesion_moves_with_the_heart),
        cmocka_unit_test(scripts_ask_for_it_in_millilitres),
        cmocka_unit_test(a_rigs_syringe_injects_what_its_plunger_gives),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
