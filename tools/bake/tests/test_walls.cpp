// These tests check the WALLS section that `bake` makes: the numbers of the laws, which brick gets which law,
// and the messages about a text that cannot be meant.
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"
#include "tools/bake/plaque.hpp"
#include "tools/bake/tests/shapes.hpp"
#include "tools/bake/tests/texts.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;
using namespace crn::bake::tests;

namespace
{

std::uint32_t word(const std::vector<std::uint8_t> &bytes, std::size_t at)
{
    return std::uint32_t{bytes[at]} | std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at + 2]} << 16 |
           std::uint32_t{bytes[at + 3]} << 24;
}

// A row of eight bricks along x from 0 to 62.5 mm; the lumen lies in the first six.
Field row_of_bricks()
{
    Field field;
    field.lumen.brick_count_xyz[0] = 8;
    field.lumen.brick_count_xyz[1] = field.lumen.brick_count_xyz[2] = 1;
    field.index.assign(8, CRN_LUMEN_ENTRY_INSIDE);
    field.index[6] = field.index[7] = CRN_LUMEN_ENTRY_OUTSIDE;
    return field;
}

crn::VesselBranch branch_of(const std::string &name, double from_mm, double to_mm, double wide_mm)
{
    crn::VesselBranch branch;
    branch.name = name;
    for (int i = 0; i <= 20; ++i) {
        branch.points_m.emplace_back((from_mm + (to_mm - from_mm) * i / 20) * 1e-3, 4e-3, 4e-3);
        branch.radii_m.push_back(wide_mm * 1e-3);
    }
    return branch;
}

// The wide trunk ends at 20 mm; the wall of the narrow branch begins where the trunk's ends, at 24 mm.
crn::VesselTree two_vessels()
{
    crn::VesselTree tree;
    tree.branches = {branch_of("trunk", 0, 20, 6), branch_of("left_side", 28, 46, 2)};
    return tree;
}

WallsText soft_side()
{
    WallsText text;
    text.is_given = true;
    WallBranchText side;
    side.place = "scene.toml:9: [[walls.branch]]: ";
    side.names = {"left_*"};
    side.law.bed_kPa = 0;
    side.law.distensibility_per_kPa = 0.02;
    text.branches = {side};
    return text;
}

// k_w = 8 / D: 0.02 / kPa are 400 kPa.
void laws_are_written_in_the_units_of_the_section(void **)
{
    const crn::VesselTree tree = two_vessels();
    const auto bytes = walls_section(soft_side(), row_of_bricks(), &tree);
    assert_int_equal(bytes.size(), 16 + 2 * 32 + 8);
    assert_int_equal(word(bytes, 0), 2);
    const std::uint32_t everywhere[] = {30000, 666667, 150, 10000, 12000, 500, 0, 0};
    const std::uint32_t side[] = {0, 400000, 150, 10000, 12000, 500, 0, 0};
    for (std::size_t i = 0; i < 8; ++i) {
        assert_int_equal(word(bytes, 16 + 4 * i), everywhere[i]);
        assert_int_equal(word(bytes, 48 + 4 * i), side[i]);
    }
}

// Brick middles lie at 3.9, 11.7, 19.5, 27.3 ... mm. At 27.3 mm, the trunk's wall is 1.3 mm away, and the
// side's wall is nearer: the place is within it. Bricks beyond the lumen and its neighbours keep the usual
// law.
void a_brick_has_the_law_of_the_vessel_with_the_nearest_wall(void **)
{
    const crn::VesselTree tree = two_vessels();
    const auto bytes = walls_section(soft_side(), row_of_bricks(), &tree);
    const std::uint8_t expected[] = {1, 1, 1, 2, 2, 2, 2, 1};
    assert_memory_equal(bytes.data() + 16 + 64, expected, sizeof expected);
}

void without_branches_one_law_holds_everywhere(void **)
{
    WallsText text;
    text.is_given = true;
    const auto bytes = walls_section(text, row_of_bricks(), nullptr);
    assert_int_equal(word(bytes, 0), 1);
    for (std::size_t i = 48; i < bytes.size(); ++i) assert_int_equal(bytes[i], 1);
}

std::string fault_of(const WallsText &text, const crn::VesselTree *tree)
{
    try {
        walls_section(text, row_of_bricks(), tree);
    } catch (const Fault &fault) {
        return fault.what();
    }
    return "accepted";
}

void a_branch_that_the_tree_lacks_is_named(void **)
{
    const crn::VesselTree tree = two_vessels();
    WallsText text = soft_side();
    text.branches[0].names = {"left_side", "right_*"};
    contains(fault_of(text, &tree), {"scene.toml:9:", "'right_*'", "[tree]"});
    contains(fault_of(text, nullptr), {"scene.toml:9:", "'left_side'"});
    text.branches.assign(16, soft_side().branches[0]);
    contains(fault_of(text, &tree), {"at most 15"});
}

void faults_of_the_text_of_walls_name_key_and_range(void **)
{
    const Folder folder;
    write_ply(torus(50, 6, 60, 20), folder.path / "lumen.ply");
    const auto says = [&](const char *walls) -> std::string {
        Progress progress;
        try {
            crn::bake::bake(options_in(folder, folder.write("scene.toml", scene_text_of("lumen.ply") +
                                                                              "[walls]\n" + walls)),
                            progress);
        } catch (const std::exception &fault) {
            return fault.what();
        }
        return "accepted";
    };
    contains(says("bed_kPa = 0.5\n"), {"scene.toml:", "[walls]", "'bed_kPa' = 0.5", "1 .. 10000"});
    contains(says("bed_kP = 3\n"), {"[walls]", "unknown key 'bed_kP'", "did you mean 'bed_kPa'"});
    contains(says("distensibility_per_kPa = 2\n"), {"distensibility_per_kPa", "0.0004 .. 0.4"});
    contains(says("relax_ms = 5\n"), {"relax_ms", "20 .. 10000"});
    contains(says("carry_mm = 30\n"), {"carry_mm", "0 .. 20"});
    contains(says("way_max_mm = 21\n"), {"way_max_mm", "0 .. 20"});
    contains(says("widen_max_mm = 5\n"), {"widen_max_mm", "0 .. 4"});
    // Beyond `outside_mm` and beyond the band of the finest level, the field knows no wall.
    contains(says("widen_max_mm = 1.2\n"), {"widen_max_mm", "1.2", "at most 1.1", "outside_mm"});
    contains(says("[[walls.branch]]\nbed_kPa = 3\n"), {"[[walls.branch]]", "names"});
    contains(says("[[walls.branch]]\nnames = [\"lad\"]\n"), {"[[walls.branch]]", "'lad'"});
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(laws_are_written_in_the_units_of_the_section),
        cmocka_unit_test(a_brick_has_the_law_of_the_vessel_with_the_nearest_wall),
        cmocka_unit_test(without_branches_one_law_holds_everywhere),
        cmocka_unit_test(a_branch_that_the_tree_lacks_is_named),
        cmocka_unit_test(faults_of_the_text_of_walls_name_key_and_range),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
