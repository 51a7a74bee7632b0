// These tests check the drawn aortas: every seed gives a tree that a person could have, and always the same
// tree.
#include "host/base/pending_file.hpp"
#include "host/base/tests/folder.hpp"
#include "tools/anatomy/varied/persons.hpp"
#include "tools/anatomy/varied/plausible.hpp"
#include "tools/anatomy/varied/variety.hpp"
#include "tools/anatomy/wall_calcium.hpp"
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <set>
extern "C" {
#include <cmocka.h>
}

using namespace anatomy;

namespace
{

constexpr std::uint64_t SEEDS = 60;

std::vector<Vessel> vessels_of(const TreeDraft &draft)
{
    std::vector<Vessel> vessels;
    for (const GivenVessel &given : draft.vessels) vessels.push_back(given.vessel);
    return vessels;
}

const std::vector<DrawnAorta> &drawn_ones()
{
    static const std::vector<DrawnAorta> all = [] {
        std::vector<DrawnAorta> drawn;
        for (std::uint64_t seed = 0; seed < SEEDS; ++seed) drawn.push_back(drawn_aorta(seed));
        return drawn;
    }();
    return all;
}

std::vector<Vessel> shipped_aorta()
{
    return shipped_vessels("aorta").vessels;
}

const Solid &bones()
{
    static const Solid shipped = trunk_bones();
    return shipped;
}

void a_seed_always_gives_the_same_file_and_seeds_differ(void **)
{
    std::set<std::string> texts;
    for (const DrawnAorta &drawn : drawn_ones()) texts.insert(vessel_file_text(drawn));
    assert_int_equal(texts.size(), SEEDS);
    assert_string_equal(vessel_file_text(drawn_aorta(7)).c_str(), vessel_file_text(drawn_ones()[7]).c_str());
}

void the_file_of_a_seed_has_the_drawn_vessels(void **)
{
    const crn::tests::Folder folder("variety");
    for (size_t i = 0; i < 10; ++i) {
        const std::string file = folder.file("vessels.toml");
        crn::write_whole_file(file, vessel_file_text(drawn_ones()[i]));
        const VesselTree read = read_vessels(file);
        const std::vector<Vessel> drawn = vessels_of(drawn_ones()[i].draft);
        assert_int_equal(read.vessels.size(), drawn.size());
        for (size_t k = 0; k < drawn.size(); ++k) {
            assert_string_equal(read.vessels[k].name.c_str(), drawn[k].name.c_str());
            assert_string_equal(read.vessels[k].parent.c_str(), drawn[k].parent.c_str());
            assert_int_equal(read.vessels[k].stations.size(), drawn[k].stations.size());
            for (size_t s = 0; s < drawn[k].stations.size(); ++s) {
                const Station &a = read.vessels[k].stations[s], &b = drawn[k].stations[s];
                assert_true((a.position_mm - b.position_mm).norm() < 1e-9);
                assert_true(std::abs(a.diameter_mm - b.diameter_mm) < 1e-9);
            }
        }
    }
}

void every_drawn_tree_keeps_the_rules(void **)
{
    const TreeSpaces usual = spaces_of(shipped_aorta(), bones());
    for (const DrawnAorta &drawn : drawn_ones())
        assert_string_equal(broken_rule(vessels_of(drawn.draft), usual, bones()).c_str(), "");
}

void the_rules_refuse_vessels_in_bones_in_each_other_and_with_sharp_bends(void **)
{
    const std::vector<Vessel> shipped = shipped_aorta();
    const TreeSpaces usual = spaces_of(shipped, bones());
    const auto index = [&](const std::string &name) {
        size_t i = 0;
        while (shipped.at(i).name != name) ++i;
        return i;
    };
    std::vector<Vessel> in_bone = shipped;
    for (Station &station : in_bone[index("aorta")].stations)
        if (station.position_mm.y() < 60) station.position_mm.z() -= 15; // towards the spine
    const std::string in_bone_text = broken_rule(in_bone, usual, bones());
    assert_true(in_bone_text.starts_with("aorta: ") && in_bone_text.ends_with("mm from a bone"));

    std::vector<Vessel> touching = shipped;
    for (Station &station : touching[index("left common carotid artery")].stations)
        if (station.position_mm.y() > 260)
            station.position_mm += Vec3(14, 0, -17); // into the left subclavian
    assert_non_null(
        std::strstr(broken_rule(touching, usual, bones()).c_str(), "mm from left common carotid artery"));

    std::vector<Vessel> bent = shipped;
    for (Station &station : bent[index("aorta")].stations)
        if (station.position_mm.y() > 225) station.position_mm.y() += 25; // two stations of the arch
    assert_true(broken_rule(bent, usual, bones()).starts_with("aorta: a bend of"));
}

void the_arch_of_a_drawn_tree_has_the_type_of_its_title(void **)
{
    for (const DrawnAorta &drawn : drawn_ones()) {
        const ArchFigures arch = arch_figures(vessels_of(drawn.draft));
        const std::string title = drawn.draft.title;
        assert_non_null(
            std::strstr(title.c_str(), (std::string("type ") + arch_type_name(arch.type)).c_str()));
        assert_int_equal(title.ends_with("common trunk"), arch.has_common_trunk);
        assert_true(arch.drop_widths == drawn.arch.drop_widths);
    }
}

// Of 60 trees with the probability p, 60 p are expected, with a standard deviation of sqrt(60 p (1 - p)): 3.9
// for 55 %, 3.5 for 30 %, and 2.8 for 15 %. The test allows deviations of three standard deviations.
void types_and_common_trunks_occur_as_often_as_stated(void **)
{
    std::array<double, 3> types = {};
    double trunks = 0;
    for (const DrawnAorta &drawn : drawn_ones()) {
        ++types[static_cast<size_t>(drawn.arch.type)];
        trunks += drawn.arch.has_common_trunk;
    }
    assert_true(std::abs(types[0] - 33) < 11.6 && std::abs(types[1] - 18) < 10.6 &&
                std::abs(types[2] - 9) < 8.3);
    assert_true(trunks > 0 && std::abs(trunks - 9.3) < 8.4);
}

// The ratio of length to straight distance exceeds 1 in each iliac artery by at least half as much as in the
// shipped one, and in some by much more.
void iliac_arteries_wind_differently(void **)
{
    double least = 1e9, most = 0;
    for (const DrawnAorta &drawn : drawn_ones())
        for (const double value : {drawn.right_tortuosity, drawn.left_tortuosity}) {
            least = std::min(least, value);
            most = std::max(most, value);
        }
    assert_true(least > 1.05 && least < 1.2);
    assert_true(most > least + 0.1);
}

// The wall of an iliac artery runs inside the aorta where both begin. A plaque there would lie in the blood.
void no_plaque_lies_inside_a_lumen(void **)
{
    constexpr std::uint64_t PERSONS = 12;
    constexpr std::size_t MOST = 46; // plaques of a person with calcium 1
    PersonWish wish;
    wish.calcium = 1.0;
    std::size_t plaques = 0;
    for (std::uint64_t seed = 0; seed < PERSONS; ++seed) {
        const DrawnPerson drawn = drawn_person(seed, wish);
        const VesselTree tree = drawn.tree();
        const Solid lumen = tree_solid(tree, 0.0);
        for (const Plaque &plaque : wall_plaques(tree, soft_shape(drawn.person))) {
            ++plaques;
            if (lumen.distance(plaque.centre_mm) <= 0)
                fail_msg("seed %d: a plaque lies %.1f mm inside a lumen", static_cast<int>(seed),
                         -lumen.distance(plaque.centre_mm));
        }
    }
    std::printf("# %zu of %zu plaques\n", plaques, PERSONS * MOST);
    assert_true(plaques > PERSONS * MOST * 9 / 10); // few are left out
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_seed_always_gives_the_same_file_and_seeds_differ),
        cmocka_unit_test(the_file_of_a_seed_has_the_drawn_vessels),
        cmocka_unit_test(every_drawn_tree_keeps_the_rules),
        cmocka_unit_test(the_rules_refuse_vessels_in_bones_in_each_other_and_with_sharp_bends),
        cmocka_unit_test(the_arch_of_a_drawn_tree_has_the_type_of_its_title),
        cmocka_unit_test(types_and_common_trunks_occur_as_often_as_stated),
        cmocka_unit_test(iliac_arteries_wind_differently),
        cmocka_unit_test(no_plaque_lies_inside_a_lumen),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
