// These tests check that the practice session takes the instruments that fit through the narrowest part of
// their way and stops its catheter before a vessel that it would fill, that thin side branches of a wide
// vessel do not count, that the choices say why, and that the vessels with medium lie in the middle of the
// picture. The trees are straight lines, so distances and places are known.
#include "host/base/format.hpp"
#include "tools/centreline/tests/shapes.hpp"
#include "tools/patient/practice.hpp"
#include "tools/patient/ways.hpp"

#include <cmath>

using namespace crn;
using namespace crn::patient;
using centreline::Branch;
using centreline::Tree;
using Eigen::Vector3d;

// All tests of this room are one unit, so these names have a namespace of their own.
namespace practice_tests
{

// A straight branch with a sphere at every millimetre.
static Branch line(const std::string &name, int parent, std::size_t parent_sphere, const Vector3d &from,
                   const Vector3d &to, double radius_mm)
{
    Branch branch{name, parent, parent_sphere, {}};
    const int length_mm = static_cast<int>(std::lround((to - from).norm()));
    for (int i = 0; i <= length_mm; ++i)
        branch.spheres.push_back({from + (to - from) * i / length_mm, radius_mm});
    return branch;
}

struct Said {
    std::string session, choices;
};

// The tree is entered at the first sphere of its root, and the sheath ends 15 mm behind it.
static Said practice(const Tree &tree)
{
    Choices choices;
    Said said;
    said.session = practice_session("patient.scene", tree, ends_of(tree).front(), 15.0, choices);
    said.choices = choices.text("");
    return said;
}

static void says(const std::string &text, const std::string &words)
{
    if (text.find(words) == text.npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), words.c_str());
}

static void a_wide_vessel_takes_the_usual_wire(void **)
{
    const Said said = practice({{line("iliac", -1, 0, {0, 0, 0}, {0, 215, 0}, 3.0)}});
    says(said.session, "needs tools j_wire, terumo_5f\n");
    says(said.session, "advance wire 100 mm");
    says(said.session, "advance catheter 80 mm");
    says(said.choices, "radius of 3.0 mm, 0 mm from the entry in iliac, and j_wire needs 2.0 mm");
}

// The entry is wide. From 80 mm behind it on, the vessel is narrower than a J wire needs, and from 100 mm on
// narrower than the thin catheter.
static void the_narrowest_part_of_the_way_decides(void **)
{
    Tree tree = {{line("trunk", -1, 0, {0, 0, 0}, {0, 315, 0}, 3.0)}};
    for (std::size_t i = 95; i <= 315; ++i) tree.branches[0].spheres[i].radius_mm = i < 115 ? 1.5 : 0.9;
    const Said said = practice(tree);
    says(said.session, "needs tools coronary_014, terumo_4f\n");
    says(said.session, "inject 5 ml at 3 ml/s\n");
    says(said.choices,
         "radius of 0.9 mm, 100 mm from the entry in trunk, and j_wire with terumo_5f would need "
         "2.0 mm; terumo_4f stops before a radius of 1.0 mm");
    // At the start, up to 20 mm of a tool lie in the vessel: 20 + 77 mm stay 3 mm before the narrow part.
    says(said.session, "advance catheter 77 mm");
    says(said.session, "advance wire 97 mm");
}

// Nobody turns the wire: of two vessels that are nearly as wide, it may take either.
static void every_wide_vessel_of_a_junction_counts_and_no_thin_one(void **)
{
    Tree tree = {{line("trunk", -1, 0, {0, 0, 0}, {0, 75, 0}, 3.0),
                  line("ahead", 0, 75, {0, 75, 0}, {0, 315, 0}, 2.5),
                  line("lumbar", 0, 60, {0, 60, 0}, {30, 60, 0}, 0.6)}};
    says(practice(tree).session, "needs tools j_wire, terumo_5f\n");
    tree.branches.push_back(line("aside", 0, 75, {0, 75, 0}, {90, 75, 0}, 1.9));
    const Said said = practice(tree);
    says(said.session, "needs tools coronary_014, terumo_4f\n");
    says(said.choices, "radius of 1.9 mm");
    says(said.choices, "in aside");
}

// From an end, the ways lead up to the parent and on in both of its directions.
static void ways_lead_up_and_down_the_tree(void **)
{
    const Tree tree = {{line("aorta", -1, 0, {0, 100, 0}, {0, 0, 0}, 3.0),
                        line("left", 0, 100, {0, 0, 0}, {60, 0, 0}, 2.0),
                        line("right", 0, 100, {0, 0, 0}, {-50, 0, 0}, 2.0)}};
    TreeEnd left;
    for (const TreeEnd &end : ends_of(tree))
        if (!end.is_root && end.branch == 1) left = end;
    double up_mm = 0, over_mm = 0;
    for (const WayPlace &one : ways_from(tree, left, 15.0)) {
        if (one.place_mm.y() > 99.5) up_mm = one.from_entry_mm;
        if (one.place_mm.x() < -49.5) over_mm = one.from_entry_mm;
    }
    assert_float_equal(up_mm, 45 + 100, 1e-9);
    assert_float_equal(over_mm, 45 + 50, 1e-9);
}

static Vector3d table_of(const std::string &session)
{
    const std::size_t at = session.find("table ");
    assert_true(at != session.npos);
    Vector3d place;
    assert_int_equal(std::sscanf(session.c_str() + at, "table x %lf mm y %lf mm z %lf mm", &place.x(),
                                 &place.y(), &place.z()),
                     3);
    return place;
}

// The catheter ends 60 mm behind the entry at most, in front of a fork whose arms go to the left.
static void the_vessels_with_medium_are_in_the_middle_of_the_picture(void **)
{
    const Tree tree = {{line("trunk", -1, 0, {0, 0, 0}, {0, 80, 0}, 3.0),
                        line("upper", 0, 80, {0, 80, 0}, {60, 140, 20}, 2.2),
                        line("lower", 0, 80, {0, 80, 0}, {60, 60, 0}, 2.2)}};
    const Said said = practice(tree);
    // Reach 65 + 87 mm, so the wire goes 70 mm and the catheter 50 mm: its end is at y = 85 at most.
    says(said.session, "advance catheter 50 mm");
    const Vector3d table = table_of(said.session);
    Eigen::AlignedBox3d box;
    for (const Branch &branch : {tree.branches[1], tree.branches[2]})
        for (const centreline::Sphere &sphere : branch.spheres) box.extend(sphere.centre_mm);
    assert_true((table - box.center()).norm() < 10);
    // The table moves there before the run, and the field holds the box, which is 1.4 times as large there.
    double field_cm = 0;
    assert_int_equal(
        std::sscanf(said.session.c_str() + said.session.find("field "), "field %lf cm", &field_cm), 1);
    assert_true(field_cm * 10 > 1.4 * box.sizes().maxCoeff());
    assert_true(said.session.find("table ") < said.session.find("dsa on"));
    says(said.choices, "picture");
}

// A tube of 3 mm ends flat, where the inscribed spheres become smaller with the distance to the end, and as a
// cone.
static void a_closed_end_is_as_wide_as_its_vessel(void **)
{
    Tree tree = {{line("tube", -1, 0, {0, 0, 0}, {0, 99, 0}, 3.0)}};
    std::vector<centreline::Sphere> &spheres = tree.branches[0].spheres;
    for (std::size_t i = 0; i < 100; ++i) {
        const auto mm = static_cast<double>(i);
        spheres[i].radius_mm = std::min({3.0, mm + 0.4, 0.5 * (99 - mm) + 0.2});
    }
    widen_closed_ends(tree);
    for (const centreline::Sphere &sphere : spheres) assert_float_equal(sphere.radius_mm, 3.0, 1e-12);
    // A vessel that becomes thinner over its length stays as it is.
    for (std::size_t i = 0; i < 100; ++i) spheres[i].radius_mm = 3.0 - 0.025 * static_cast<double>(i);
    const Tree taper = tree;
    widen_closed_ends(tree);
    for (std::size_t i = 0; i < 100; ++i)
        assert_float_equal(spheres[i].radius_mm, taper.branches[0].spheres[i].radius_mm, 1e-12);
}

} // namespace practice_tests

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(practice_tests::a_wide_vessel_takes_the_usual_wire),
        cmocka_unit_test(practice_tests::the_narrowest_part_of_the_way_decides),
        cmocka_unit_test(practice_tests::every_wide_vessel_of_a_junction_counts_and_no_thin_one),
        cmocka_unit_test(practice_tests::ways_lead_up_and_down_the_tree),
        cmocka_unit_test(practice_tests::the_vessels_with_medium_are_in_the_middle_of_the_picture),
        cmocka_unit_test(practice_tests::a_closed_end_is_as_wide_as_its_vessel)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
