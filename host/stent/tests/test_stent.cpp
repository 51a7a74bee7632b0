// These tests check the following. A stent file is either read completely, or refused with the position of
// the error in the file. A stent opens to the width of its balloon, and its shortening and recoil agree with
// the formulas. The rings of a stent have the stiffness that the stent's file states, and the struts touch
// walls as capsules touch planes. Every sequence of actions on a stent has a defined result.
#include "firmware/tests/reference/long_run.h"
#include "host/base/tests/folder.hpp"
#include "host/base/text.hpp"
#include "host/stent/tests/stent_vessel.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

using std::numbers::pi;
constexpr double mount_mm = 20.0;
const std::string coronary_file = "shared/examples/stents/coronary_3_0x18.toml";
const std::string renal_file = "shared/examples/stents/renal_6_0x18.toml";

// Prints the expected and the actual value if they differ.
void near(const char *what, double got, double wanted, double allowed)
{
    if (!(std::abs(got - wanted) <= allowed))
        std::printf("# %s = %.9g, expected %.9g (allowed %g)\n", what, got, wanted, allowed);
    assert_true(std::abs(got - wanted) <= allowed);
}

StentDesign facing()
{
    StentDesign design = read_stent(coronary_file);
    design.connection = StentConnection::facing;
    return design;
}

TestVessel tube(double radius_mm, double curvature_per_mm = 0.0, double eccentricity = 0.0)
{
    TestVessel vessel;
    vessel.radius_mm = radius_mm;
    vessel.curvature_per_mm = curvature_per_mm;
    vessel.eccentricity = eccentricity;
    vessel.make();
    return vessel;
}

StentWall wall_of(const TestVessel &vessel)
{
    StentWall wall(vessel.triangles, vessel.vertices_mm.size());
    wall.move(vessel.vertices_um(TestVessel::still));
    return wall;
}

// Inflates the balloon to `radius_mm` in ten steps, and deflates it again in ten more steps.
void inflate(Stent &stent, const StentWall *wall, const TestVessel &vessel, double radius_mm,
             double length_mm = 20.0)
{
    for (int i = 0; i <= 20; ++i) {
        const double r = 0.4 + (radius_mm - 0.4) * (1 - std::abs(i - 10) / 10.0);
        const BalloonPose pose = balloon_in(vessel, mount_mm, length_mm, r);
        stent.step({wall, &pose});
    }
}

void rest(Stent &stent, const StentWall *wall, int pictures)
{
    for (int i = 0; i < pictures; ++i) stent.step({wall});
}

double mean_inside_mm(const StentFigures &figures)
{
    double sum = 0.0;
    for (const StentRing &ring : figures.rings) sum += ring.diameter_mm;
    return sum / static_cast<double>(figures.rings.size());
}

} // namespace

// --- files ---

static void shipped_stents_are_what_their_labels_say(void **)
{
    const StentDesign coronary = read_stent(coronary_file), renal = read_stent(renal_file);
    near("diameter", coronary.diameter_mm, 3.0, 0);
    near("length", coronary.length_mm, 18.0, 0);
    near("diameter", renal.diameter_mm, 6.0, 0);
    near("length", renal.length_mm, 18.0, 0);
    for (const StentDesign &design : {coronary, renal})
        near("crimped length", design.length_at_mm(design.crimped_radius_mm()), design.length_mm, 1e-12);
}

static void faulty_stent_files_are_refused_with_line_and_remedy(void **)
{
    const struct {
        const char *from, *to, *says;
    } faults[] = {
        {"crowns = 6", "crowns = 3", "'crowns' = 3 is outside 4 .. 24"},
        {"crowns = 6", "crowns = 6.5", "'crowns' is not a whole number"},
        {"crowns = 6", "crown = 6", "unknown key 'crown', did you mean 'crowns'?"},
        {"rings = 12", "rings = 14", "do not fit into 'length_mm' = 18"},
        {"links = 2", "links = 7", "more than the 6 'crowns' of a ring"},
        {"\"offset\"", "\"spiral\"", "'connection' is 'spiral'; known: offset, facing"},
        {"value = 3.75", "value = 2.75", "'diameter_max_mm' is below 'diameter_mm' = 3"},
        {"strut_length_mm = { value = 1.3", "strut_length_mm = { value = 0.9",
         "does not reach from crown to crown"},
        {"recoil_percent = { value = 3", "recoil_percent = { value = 30",
         "'recoil_percent' = 30 is outside 0 .. 20"},
        {"@drawn", "@dawn", "there is no 'dawn' in [sources]"},
        {"format = 1", "format = 2", "'format' must be 1"},
        {"rings = 12", "rings 12", ":"},
    };
    const tests::Folder folder("stent");
    const std::string text = read_text_file(coronary_file), path = folder.file("bad.toml");
    for (const auto &fault : faults) {
        std::string bad = text;
        bad.replace(bad.find(fault.from), std::strlen(fault.from), fault.to);
        std::ofstream(path) << bad;
        std::string message;
        try {
            read_stent(path);
        } catch (const FileError &error) {
            message = error.what();
        }
        if (message.find(fault.says) == std::string::npos || message.find(path + ":") != 0)
            std::printf("# '%s' gave: %s\n", fault.to, message.c_str());
        assert_true(message.find(path + ":") == 0); // file and line
        assert_true(message.find(fault.says) != std::string::npos);
    }
}

// --- closed forms ---

static void stent_opens_to_its_balloon(void **)
{
    const TestVessel straight = tube(5.0);
    for (const std::string &file : {coronary_file, renal_file}) {
        const StentDesign design = read_stent(file);
        for (double share : {0.8, 1.0, 1.1}) {
            Stent stent(design, mount_mm);
            const BalloonPose pose = balloon_in(straight, mount_mm, 20, share * design.diameter_mm / 2);
            stent.step({nullptr, &pose});
            const StentFigures figures = stent_figures(stent, nullptr);
            near("inner diameter", mean_inside_mm(figures), share * design.diameter_mm, 1e-9);
            near("narrowest", figures.diameter_min_mm, share * design.diameter_mm, 1e-9);
            assert_int_equal(figures.unopened_rings, 0);
            assert_true(stent.is_on_balloon());
        }
    }
}

// A diamond cell of a ring with the radius r and 2N points consists of struts of length s with a chord c = 2
// r sin(pi/2N), so its height per strut is sqrt(s^2 - c^2). The test computes the expected length of the
// stent by a separate formula, and compares it with the distance between the stent's outermost points.
static void cells_shorten_as_diamonds_do(void **)
{
    const TestVessel straight = tube(5.0);
    for (double balloon : {0.6, 1.0, 1.5, 1.8}) {
        const StentDesign design = facing();
        Stent stent(design, mount_mm);
        const BalloonPose pose = balloon_in(straight, mount_mm, 24, balloon);
        stent.step({nullptr, &pose});
        const auto height = [&](double r) {
            return std::sqrt(1.3 * 1.3 - std::pow(2 * r * std::sin(pi / 12), 2));
        };
        const double r0 = (1.05 - 0.081) / 2, r1 = balloon + 0.081 / 2;
        const double gap = (18 - 12 * height(r0)) / 11;
        near("length", stent_figures(stent, nullptr).length_mm, 12 * height(r1) + 11 * gap, 1e-9);
        // A stent with open cells, whose links join crowns of the same side, shortens only by the change in
        // height of one ring.
        Stent open(read_stent(coronary_file), mount_mm);
        open.step({nullptr, &pose});
        near("length, open cells", stent_figures(open, nullptr).length_mm, 18 - height(r0) + height(r1),
             1e-9);
    }
}

static void free_stent_recoils_by_its_share(void **)
{
    const TestVessel straight = tube(5.0);
    for (double recoil : {0.0, 0.03, 0.1}) {
        StentDesign design = read_stent(coronary_file);
        design.recoil = recoil;
        Stent stent(design, mount_mm);
        inflate(stent, nullptr, straight, 1.5);
        rest(stent, nullptr, 50);
        const double on_balloon = 1.5 + 0.081 / 2;
        near("radius", mean_inside_mm(stent_figures(stent, nullptr)) / 2,
             on_balloon * (1 - recoil) - 0.081 / 2, 1e-6);
    }
}

// The test changes the radius of one ring in small steps. From differences of the springs' energy E the
// test computes the force dE/dR and the stiffness d2E/dR2, and compares both with the file. Only the chords
// between crowns change: the height of a ring changes without force, because the struts only turn.
static void ring_is_as_stiff_as_stated(void **)
{
    for (const std::string &file : {coronary_file, renal_file}) {
        const StentDesign design = read_stent(file);
        const StentLattice lattice(design);
        const auto energy = [&](double radius, double free) {
            double sum = 0.0;
            for (const StentSpring &spring : lattice.springs) {
                if (spring.kind != StentSpringKind::hinge || lattice.ring_of(spring.ends[0]) != 0) continue;
                const double turn = (lattice.angle(spring.ends[1]) - lattice.angle(spring.ends[0])) / 2;
                const double chord = 2 * std::abs(std::sin(turn));
                sum += spring.stiffness_N_per_mm / 2 * std::pow(chord * (radius - free), 2);
            }
            return sum;
        };
        const double h = 1e-3, r = 1.5;
        const double stiffness = (energy(r + h, r) - 2 * energy(r, r) + energy(r - h, r)) / (h * h);
        near("ring stiffness", stiffness, design.ring_stiffness_N_per_mm, 1e-9 * stiffness);
    }
}

// A ring of stiffness K that a wall holds at a radius R below its free radius R0 stores the energy K/2 (R0 -
// R)^2 in its springs. The radius R of a ring is that of a circle with the same area as the ring. The flat
// facets of the wall, and the braces between rings, make the ring uneven, which adds 10 % to its energy.
static void pressed_ring_stores_what_its_stiffness_says(void **)
{
    const TestVessel vessel = tube(1.5);
    const StentWall wall = wall_of(vessel);
    StentDesign design = read_stent(coronary_file);
    design.recoil = 0.1; // elastic over the full range
    for (double stiffness : {4.0, 8.0, 16.0}) {
        design.ring_stiffness_N_per_mm = stiffness;
        Stent stent(design, mount_mm);
        inflate(stent, &wall, vessel, 1.70);
        rest(stent, &wall, 100);
        const double free = (1.70 + 0.081 / 2) * 0.9;
        const double way = free - mean_inside_mm(stent_figures(stent, &wall)) / 2 - 0.081 / 2;
        const double stored = 12 * stiffness / 2 * way * way;
        std::printf("# %g N/mm: stored %.4f, by the way %.4f N mm\n", stiffness, stent.energy_N_mm(), stored);
        near("energy", stent.energy_N_mm(), stored, 0.1 * stored);
    }
}

// --- the wall ---

// The end of a capsule (half a strut) reaches through the middle of a triangle. The expected depth of the
// contact, computed by hand, is the radius minus the distance of the capsule's end in front of the plane.
static void contact_of_a_strut_is_that_of_its_plane(void **)
{
    const std::array<Vector3d, 3> corners = {Vector3d(-1, -1, 0), Vector3d(2, -1, 0), Vector3d(-1, 2, 0)};
    const Vector3d out(0, 0, 1);
    for (double height : {0.05, 0.03, 0.0, -0.05, -0.2}) {
        const StrutCapsule strut{{-0.2, 0, -0.4}, {0.1, 0.1, -height}, 0.04};
        const StrutContact contact = strut_contact(strut, corners, out);
        near("depth", contact.depth_mm, std::max(0.04 - height, 0.0), 2e-3); // libccd's own tolerance
        if (contact.depth_mm > 0) near("direction", contact.direction.dot(-out), 1.0, 1e-3);
    }
}

// The test walks over the tube's triangles from one that is two millimetres away to the nearest point. The
// test compares this point with the result of a search over all triangles. The points from the walk and from
// the full search agree only to a micrometre, because beyond an edge between two faces either face may be
// nearest.
static void walk_over_the_wall_ends_at_the_nearest_place(void **)
{
    const TestVessel vessel = tube(1.5, 0.04, 0.1);
    const StentWall wall = wall_of(vessel);
    std::vector<std::uint32_t> all(wall.triangle_count());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    for (int i = 0; i < 60; ++i) {
        const double s = 8 + 0.4 * i, angle = 0.7 * i, r = 1.2 + 0.01 * (i % 40);
        const Vector3d place =
            vessel.middle(s) + r * (std::cos(angle) * vessel.across(s) + std::sin(angle) * Vector3d::UnitZ());
        const WallFoot sought = wall.nearest(place, all, 10.0);
        const Vector3d start = vessel.middle(s + 2);
        const WallFoot beside = wall.nearest(start + (place - vessel.middle(s)), all, 10.0);
        near("distance", wall.walk(place, beside.triangle).distance_mm, sought.distance_mm, 1e-3);
        near("place", (wall.place(sought) - place).norm(), 0.0, 1e-9);
    }
}

// --- deployment ---

// The test places a stent with the radius of the vessel in bends and in an oval tube. More than 95 % of the
// struts must lie on the wall, and no part of the stent may pass through the wall.
static void stent_of_the_right_size_lies_on_the_wall(void **)
{
    const struct {
        double curvature, eccentricity;
    } cases[] = {{0.0, 0.0}, {0.03, 0.0}, {0.06, 0.0}, {0.03, 0.03}};
    for (const auto &one : cases) {
        const TestVessel vessel = tube(1.5, one.curvature, one.eccentricity);
        const StentWall wall = wall_of(vessel);
        Stent stent(read_stent(coronary_file), mount_mm);
        inflate(stent, &wall, vessel, 1.5 * (1 + one.eccentricity));
        rest(stent, &wall, 30);
        const StentFigures figures = stent_figures(stent, &wall);
        const double deepest = deepest_strut_mm(stent, wall);
        std::printf("# curvature %.2f, oval %.2f: apposed %.3f, deepest %.4f mm, narrowest %.3f mm\n",
                    one.curvature, one.eccentricity, figures.apposed_share, deepest, figures.diameter_min_mm);
        assert_int_equal(stent.stage(), StentStage::deployed);
        assert_true(figures.apposed_share >= 0.95);
        assert_true(deepest <= 0.05);
        near("foreshortening", figures.foreshortening, 1 - stent.design().length_at_mm(1.5) / 18, 0.01);
    }
}

static void stent_a_size_too_small_is_found_out(void **)
{
    const TestVessel vessel = tube(1.5, 0.03);
    const StentWall wall = wall_of(vessel);
    StentDesign design = read_stent(coronary_file);
    Stent stent(design, mount_mm);
    inflate(stent, &wall, vessel, 1.25);
    rest(stent, &wall, 30);
    const StentFigures figures = stent_figures(stent, &wall);
    assert_true(figures.apposed_share < 0.8);
    assert_true(!figures.gaps.empty());
    // The gap between strut and wall is 0.21 mm on all sides: the vessel's radius of 1.5 mm minus 1.25 mm for
    // the balloon and 0.081 mm for the strut, plus the recoil. The gap varies around the stent, because the
    // balloon does not lie exactly in the middle.
    for (const StentGap &gap : figures.gaps) assert_true(gap.gap_mm > apposed_mm && gap.gap_mm < 0.4);
}

// A second, wider balloon opens the stent again. The stent must end with the diameter of the second balloon
// minus the recoil.
static void post_dilation_brings_a_small_stent_to_the_wall(void **)
{
    const TestVessel vessel = tube(1.5, 0.03);
    const StentWall wall = wall_of(vessel);
    Stent stent(read_stent(coronary_file), mount_mm);
    inflate(stent, &wall, vessel, 1.30);
    rest(stent, &wall, 10);
    const StentFigures before = stent_figures(stent, &wall);
    assert_int_equal(stent.stage(), StentStage::adrift); // still
    for (int i = 0; i <= 60; ++i) {                      // up, held for 20 pictures, down
        const double up = std::clamp(1.5 - std::abs(i - 30) / 20.0, 0.0, 1.0);
        const BalloonPose pose = balloon_in(vessel, mount_mm, 22, 0.4 + 1.06 * up);
        const StentBalloon second{&pose, 0.0};
        stent.step({&wall, nullptr, {&second, 1}});
    }
    rest(stent, &wall, 10);
    const StentFigures after = stent_figures(stent, &wall);
    std::printf("# apposed %.3f -> %.3f, inside %.3f -> %.3f mm, deepest %.4f\n", before.apposed_share,
                after.apposed_share, mean_inside_mm(before), mean_inside_mm(after),
                deepest_strut_mm(stent, wall));
    near("inside before", mean_inside_mm(before), 2 * (1.3405 * 0.97 - 0.0405), 0.01);
    near("inside after", mean_inside_mm(after), 2 * (1.5005 * 0.97 - 0.0405), 0.02);
    assert_int_equal(stent.stage(), StentStage::deployed);
    assert_true(before.apposed_share < 0.8 && after.apposed_share >= 0.95);
    assert_true(after.foreshortening > before.foreshortening);
    assert_true(stent_stretch(stent, std::vector<Vector3d>{vessel.middle(0), vessel.middle(40)},
                              std::vector<double>{1.5, 1.5}) > 0.02);
}

// In this test the second stent lies inside the first. Where the two stents overlap, the crowns of the inner
// stent must be nearer to the axis by a strut's thickness; this also shows how long the overlap is.
static void second_stent_lies_on_the_first_where_they_overlap(void **)
{
    const TestVessel vessel = tube(1.5);
    const StentWall wall = wall_of(vessel);
    Stent first(read_stent(coronary_file), 14.0), second(read_stent(coronary_file), 26.0);
    for (Stent *stent : {&first, &second}) {
        const StentSleeve sleeve = first.sleeve();
        const bool is_second = stent == &second;
        for (int i = 0; i <= 20; ++i) {
            const double r = 0.4 + 1.1 * (1 - std::abs(i - 10) / 10.0);
            const BalloonPose pose = balloon_in(vessel, stent->mount_arc_mm(), 20, r);
            const StentBalloon inside{&pose, second.design().strut_thickness_mm};
            if (is_second) first.step({&wall, nullptr, {&inside, 1}});
            stent->step({&wall, &pose, {}, std::span(&sleeve, is_second ? 1 : 0)});
        }
        rest(*stent, &wall, 10);
    }
    rest(first, &wall, 5);
    const double length = first.design().length_at_mm(1.5);
    near("overlap", stent_overlap_mm(second, first.sleeve()), length - 12, 1.0);
    double inner = 0.0, alone = 0.0;
    int inner_count = 0, alone_count = 0;
    for (const StentPoint &point : second.points()) {
        const double radius = std::hypot(point.place_mm.y(), point.place_mm.z());
        (point.layer_mm > 0 ? inner : alone) += radius;
        ++(point.layer_mm > 0 ? inner_count : alone_count);
    }
    std::printf("# %d crowns on the first stent, %d on the wall\n", inner_count, alone_count);
    assert_true(inner_count > 40 && alone_count > 60);
    near("step between the layers", alone / alone_count - inner / inner_count, 0.081, 0.06);
    assert_true(stent_figures(second, &wall).apposed_share >= 0.95);
    assert_true(deepest_strut_mm(first, wall) <= 0.05 && deepest_strut_mm(second, wall) <= 0.05);
}

// --- failures ---

static void stent_pulled_through_a_narrow_place_slides_off(void **)
{
    const TestVessel straight = tube(5.0);
    const auto pull = [&](double room_mm, double to_mm) {
        Stent stent(read_stent(coronary_file), mount_mm);
        for (double at = 20; at <= to_mm; at += 0.25) {
            BalloonPose pose = balloon_in(straight, at, 20, 0.4);
            // While the tool is pulled along the vessel, each ball of the balloon keeps its arc length along
            // the tool. The narrow part of the vessel is 30 mm from the vessel's beginning.
            for (BalloonPoint &ball : pose.points) {
                if (std::abs(ball.arc_mm - 30) < 1.0) ball.room_mm = room_mm;
                ball.arc_mm += mount_mm - at;
            }
            stent.step({nullptr, &pose});
        }
        return stent;
    };
    const Stent through = pull(0.50, 60), stuck = pull(0.20, 60), begun = pull(0.20, 25);
    assert_int_equal(through.stage(), StentStage::on_balloon);
    near("slip", through.slip_mm(), 0.0, 1e-12);
    assert_int_equal(begun.stage(), StentStage::on_balloon);
    assert_true(begun.slip_mm() < -1.0);
    assert_int_equal(stuck.stage(), StentStage::stripped);
    // The crimped stent must stay where it was stripped off the balloon.
    assert_true(stuck.ring_centre_mm(6).x() < 40);
    near("crimped", mean_inside_mm(stent_figures(stuck, nullptr)), 1.05 - 2 * 0.081, 1e-6);
}

static void stent_deployed_outside_a_vessel_is_adrift(void **)
{
    const TestVessel wide = tube(5.0);
    const StentWall wall = wall_of(wide);
    for (const StentWall *around : {static_cast<const StentWall *>(nullptr), &wall}) {
        Stent stent(read_stent(coronary_file), mount_mm);
        inflate(stent, around, wide, 1.5);
        rest(stent, around, 20);
        assert_int_equal(stent.stage(), StentStage::adrift);
        near("apposed", stent_figures(stent, around).apposed_share, 0.0, 0.0);
        assert_string_equal(std::string(stent_stage_text(stent.stage())).c_str(),
                            "lost: released where no wall holds it");
    }
}

// Half of the stent lies beyond the end of the vessel, as at an ostium. The half of the stent inside the
// vessel must be held by the vessel, and the report must name the crowns outside.
static void half_a_stent_in_the_ostium_is_held_and_reported(void **)
{
    TestVessel vessel = tube(1.5);
    const std::size_t open = vessel.triangles.size() - static_cast<std::size_t>(2 * vessel.around);
    vessel.triangles.resize(open); // no lids
    const StentWall wall = wall_of(vessel);
    Stent stent(read_stent(coronary_file), mount_mm);
    for (int i = 0; i <= 20; ++i) {
        BalloonPose pose = balloon_in(vessel, 2.0, 20, 0.4 + 1.1 * (1 - std::abs(i - 10) / 10.0));
        for (BalloonPoint &ball : pose.points) ball.arc_mm += mount_mm - 2.0;
        stent.step({&wall, &pose});
    }
    rest(stent, &wall, 20);
    const StentFigures figures = stent_figures(stent, &wall);
    std::printf("# apposed %.3f, bedded %.3f\n", figures.apposed_share, figures.bedded_share);
    assert_int_equal(stent.stage(), StentStage::deployed);
    assert_true(figures.apposed_share > 0.5 && figures.apposed_share < 0.75);
    for (const StentGap &gap : figures.gaps) assert_true(gap.place_mm.x() < 0.3);
    const std::vector<Vector3d> line = {vessel.middle(0), vessel.middle(40)};
    const StentCoverage coverage = stent_coverage(stent, line, 0.0, 12.0);
    near("covered to", coverage.to_mm, 2.0 + stent.design().length_at_mm(1.5) / 2, 0.2);
    near("missed behind", coverage.missed_behind_mm, 12.0 - coverage.to_mm, 1e-9);
    near("missed before", coverage.missed_before_mm, 0.0, 1e-9);
}

// If the balloon is inflated too little, the stent is not deployed and can be taken out of the patient.
static void stent_that_was_not_opened_stays_on_its_balloon(void **)
{
    const TestVessel straight = tube(5.0);
    Stent stent(read_stent(coronary_file), mount_mm);
    inflate(stent, nullptr, straight, 0.50);
    rest(stent, nullptr, 5);
    assert_int_equal(stent.stage(), StentStage::on_balloon);
    assert_int_equal(stent_figures(stent, nullptr).unopened_rings, 12);
}

// In random steps, balloons jump in position and width, lose balls and shrink to a point, and walls jump by
// millimetres. The stent may be displaced, but its points must stay finite and near the vessel, and no strut
// may become more than a few times longer.
static void nothing_that_balloon_and_wall_do_tears_it_apart(void **)
{
    std::uint32_t random = 2463534242u;
    const auto uniform = [&](double from, double to) {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        return from + (to - from) * random * 0x1p-32;
    };
    for (int round = 0; round < 1 + REFERENCE_RUN(10) / 2; ++round) {
        const TestVessel vessel = tube(uniform(0.7, 2.5), uniform(0, 0.08), uniform(0, 0.3));
        StentWall wall = wall_of(vessel);
        Stent stent(read_stent(round % 2 == 0 ? coronary_file : renal_file), mount_mm);
        double radius = 0.4, longest = 0.0, farthest = 0.0;
        for (int i = 0; i < 40; ++i) {
            const Vector3d leap(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
            const double scale = uniform(0.8, 1.2);
            const auto map = [&](const Vector3d &x) -> Vector3d { return x * scale + leap; };
            wall.move(vessel.vertices_um(map));
            if (i % 4 == 0) radius = uniform(0, 4);
            BalloonPose pose = balloon_in(vessel, mount_mm, i % 9 == 0 ? 3 : 22, radius, map);
            pose.points[pose.points.size() / 2].centre_mm.x() = NAN;
            pose.points.back().radius_mm = -1;
            stent.step({i % 7 == 0 ? nullptr : &wall, i % 5 == 0 ? nullptr : &pose});
            for (const auto &[a, b] : stent.lattice().struts)
                longest = std::max(longest, (stent.points()[a].place_mm - stent.points()[b].place_mm).norm());
            for (const StentPoint &point : stent.points()) {
                assert_true(point.place_mm.allFinite());
                farthest = std::max(farthest, point.place_mm.norm());
            }
        }
        std::printf("# %s: longest strut %.2f mm\n", std::string(stent_stage_text(stent.stage())).c_str(),
                    longest);
        assert_true(longest < 4 * stent.design().strut_length_mm && farthest < 80);
    }
}

// --- replay ---

static void snapshot_goes_on_with_the_same_bits(void **)
{
    const TestVessel vessel = tube(1.5, 0.03);
    const StentWall wall = wall_of(vessel);
    const auto at = [&](Stent &stent, int picture) {
        const double r = picture <= 20 ? 0.4 + 1.1 * (1 - std::abs(picture - 10) / 10.0) : 0.4;
        const BalloonPose pose = balloon_in(vessel, mount_mm, 20, r);
        stent.step({&wall, &pose});
    };
    Stent whole(read_stent(coronary_file), mount_mm);
    for (int stop : {5, 19, 25}) {
        Stent first(read_stent(coronary_file), mount_mm), second(read_stent(coronary_file), mount_mm);
        for (int i = 0; i <= 40; ++i) {
            at(first, i);
            if (i == stop) assert_true(second.restore(first.snapshot()));
            if (i > stop) at(second, i);
        }
        assert_true(first.snapshot() == second.snapshot());
    }
    std::vector<std::uint8_t> bytes = whole.snapshot();
    Stent other(read_stent(renal_file), mount_mm);
    assert_false(other.restore(bytes));
    bytes.pop_back();
    assert_false(whole.restore(bytes));
    assert_false(whole.restore({}));
}

static void struts_and_bands_are_drawn_where_they_are(void **)
{
    const TestVessel straight = tube(5.0);
    const StentDesign design = read_stent(coronary_file);
    Stent stent(design, mount_mm);
    assert_true(stent_lines(stent).empty()); // not placed yet
    const BalloonPose pose = balloon_in(straight, mount_mm, 24, 1.5);
    stent.step({nullptr, &pose});
    const std::vector<StentLine> lines = stent_lines(stent);
    assert_int_equal(lines.size(), 12 + 11 * 2);
    double metal = 0.0;
    for (const StentLine &line : lines)
        for (std::size_t i = 1; i < line.points_mm.size(); ++i)
            metal +=
                pi * line.radius_mm * line.radius_mm * (line.points_mm[i] - line.points_mm[i - 1]).norm();
    // The expected volume of metal is that of 22 links and of 144 struts of 1.3 mm, which are a little longer
    // because they are bent around the axis.
    near("metal mm^3", metal, (144 * 1.31 + 22 * design.link_length_mm()) * 0.09 * 0.081, 0.02 * metal);
    for (const Vector3d &point : lines.front().points_mm)
        near("radius", std::hypot(point.y(), point.z()), 1.5405, 1e-9);
    const std::vector<StentLine> bands = stent_markers(design, mount_mm, pose);
    assert_int_equal(bands.size(), 2);
    near("inner edge of a band", bands[0].points_mm.back().x(), 20 - 9, 1e-9);
    near("inner edge of the other", bands[1].points_mm.front().x(), 20 + 9, 1e-9);
}

int main(void)
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(shipped_stents_are_what_their_labels_say),
        cmocka_unit_test(faulty_stent_files_are_refused_with_line_and_remedy),
        cmocka_unit_test(stent_opens_to_its_balloon),
        cmocka_unit_test(cells_shorten_as_diamonds_do),
        cmocka_unit_test(free_stent_recoils_by_its_share),
        cmocka_unit_test(ring_is_as_stiff_as_stated),
        cmocka_unit_test(pressed_ring_stores_what_its_stiffness_says),
        cmocka_unit_test(contact_of_a_strut_is_that_of_its_plane),
        cmocka_unit_test(walk_over_the_wall_ends_at_the_nearest_place),
        cmocka_unit_test(stent_of_the_right_size_lies_on_the_wall),
        cmocka_unit_test(stent_a_size_too_small_is_found_out),
        cmocka_unit_test(post_dilation_brings_a_small_stent_to_the_wall),
        cmocka_unit_test(second_stent_lies_on_the_first_where_they_overlap),
        cmocka_unit_test(stent_pulled_through_a_narrow_place_slides_off),
        cmocka_unit_test(stent_deployed_outside_a_vessel_is_adrift),
        cmocka_unit_test(half_a_stent_in_the_ostium_is_held_and_reported),
        cmocka_unit_test(stent_that_was_not_opened_stays_on_its_balloon),
        cmocka_unit_test(nothing_that_balloon_and_wall_do_tears_it_apart),
        cmocka_unit_test(snapshot_goes_on_with_the_same_bits),
        cmocka_unit_test(struts_and_bands_are_drawn_where_they_are),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
