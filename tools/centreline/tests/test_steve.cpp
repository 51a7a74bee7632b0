// These tests check the following. The tool must recover the centrelines of stEVE_bench from a surface that
// was made from these centrelines. The recovered centrelines keep their position (mean distance <= 0.5 mm)
// and their radius (mean error <= 5 %). From the imperfect surface of stEVE_bench, the tool makes a tree, or
// prints which part of the mesh must be repaired. The anatomy of stEVE_bench does not ship with Cournand;
// where it is missing, the test is skipped and prints the reason. The test with the whole anatomy takes half
// a minute. Without the variable CRN_WHOLE, the test therefore covers only the path from the iliac arteries
// to the arch; `make validate-centreline` covers the whole anatomy.
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/join.hpp"
#include "tools/centreline/tests/shapes.hpp"

#include <algorithm>

using namespace crn;
using namespace crn::centreline;
using namespace crn::centreline::tests;

namespace
{

bake::Progress recovery_progress;

std::filesystem::path data()
{
    const char *folder = std::getenv("CRN_ANATOMY");
    return std::filesystem::path(folder ? folder : "../shared/anatomy") / "steve_bench";
}

void skip_without_anatomy()
{
    if (std::filesystem::exists(data() / "centrelines")) return;
    print_message("skipped: no steve_bench in $CRN_ANATOMY or ../shared/anatomy\n");
    skip();
}

bool is_whole()
{
    return std::getenv("CRN_WHOLE") != nullptr;
}

Tree curves()
{
    std::vector<std::filesystem::path> files;
    for (const auto &entry : std::filesystem::directory_iterator(data() / "centrelines"))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    Tree all;
    for (const std::filesystem::path &file : files)
        for (Branch &branch : read_tree(file).branches) {
            branch.name = file.stem().stem().string();
            all.branches.push_back(std::move(branch));
        }
    return all;
}

void all_curves_join_into_one_tree(void **)
{
    skip_without_anatomy();
    const Tree tree = joined(curves());
    check_tree(tree, "joined");
    assert_int_equal(tree.branches.size(), 25);
    int roots = 0;
    for (const Branch &branch : tree.branches) roots += branch.parent < 0;
    assert_int_equal(roots, 1);
}

void curves_are_recovered_from_their_surface(void **)
{
    skip_without_anatomy();
    Tree truth = curves();
    if (!is_whole())
        std::erase_if(truth.branches, [](const Branch &branch) {
            const std::string number = branch.name.substr(branch.name.find_last_of('_') + 1);
            return number != "(0)" && number != "(2)" && number != "(3)" && number != "(5)";
        });
    LumenWish wish_of_lumen;
    if (!is_whole()) wish_of_lumen.voxel_mm = 1.5;
    const Lumen lumen(bake::surface_of(truth.branches, is_whole() ? 0.6 : 1.0, recovery_progress),
                      wish_of_lumen, recovery_progress);
    std::vector<std::string> notes;
    AutoWish wish;
    wish.inlet_mm = truth.branches[0].spheres[0].centre_mm; // curve 0 begins in the arch
    const Tree tree = fit_automatic(lumen, wish, notes, recovery_progress);
    // The test compares each sphere of the recovered tree with the nearest original curve. The mean weights
    // each sphere by the length of vessel that it represents; otherwise thin vessels, which have more
    // spheres, would count too much.
    double off = 0, radius = 0, weight = 0, found = 0, whole = 0;
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        for (std::size_t i = first_own_sphere(tree, b); i < tree.branches[b].spheres.size(); ++i) {
            const Sphere &sphere = tree.branches[b].spheres[i];
            LinePlace best{INFINITY, 0, 0};
            for (const Branch &curve : truth.branches) {
                const LinePlace place = line_place(curve, sphere.centre_mm);
                if (place.distance_mm < best.distance_mm) best = place;
            }
            const double length =
                i > 0 ? (sphere.centre_mm - tree.branches[b].spheres[i - 1].centre_mm).norm() : 0;
            off += length * best.distance_mm;
            radius += length * std::abs(sphere.radius_mm / best.radius_mm - 1);
            weight += length;
        }
    // The test also measures how much of the original curves' length has a recovered centreline nearby,
    // because no curve may be lost.
    for (const Branch &curve : truth.branches)
        for (const Sphere &sphere : curve.spheres) {
            ++whole;
            for (const Branch &branch : tree.branches)
                if (line_place(branch, sphere.centre_mm).distance_mm < sphere.radius_mm) {
                    ++found;
                    break;
                }
        }
    std::printf("# stEVE_bench recovered: mean distance %.3f mm, mean radius error %.2f %%, %.1f %% of the "
                "curves' points "
                "within a radius of the tree (%zu branches, %zu spheres)\n",
                off / weight, 100 * radius / weight, 100 * found / whole, tree.branches.size(),
                sphere_count(tree));
    assert_true(off / weight <= 0.5);
    assert_true(radius / weight <= 0.05);
    assert_true(found / whole >= 0.97);
}

void the_dirty_surface_gives_a_tree_or_says_what_to_mend(void **)
{
    skip_without_anatomy();
    if (!is_whole()) {
        print_message("skipped: CRN_WHOLE is not set, as make validate-centreline does\n");
        skip();
    }
    bake::MeshText text;
    text.file = data() / "mechanical_thrombectomy_collision_FIX_REMESH.obj";
    text.placement.unit = "mm";
    std::string outcome;
    try {
        const Lumen lumen(bake::load_mesh(text), {}, recovery_progress);
        std::vector<std::string> notes;
        const Tree tree = fit_automatic(lumen, {}, notes, recovery_progress);
        check_tree(tree, "dirty");
        double length = 0;
        for (const Branch &branch : tree.branches) length += length_mm(branch);
        // The surface extends from the iliac arteries to the head, so the recovered tree must have several
        // branches and a length similar to that of the surface.
        assert_true(tree.branches.size() > 5 && length > 500);
        assert_true(!lumen.notes().empty());
        outcome = "a tree of " + std::to_string(tree.branches.size()) + " branches and " +
                  std::to_string(length) + " mm; " + lumen.notes()[0];
    } catch (const Fault &fault) {
        outcome = fault.what();
        assert_true(outcome.find("edge") != outcome.npos || outcome.find("opening") != outcome.npos);
    }
    std::printf("# the dirty surface: %s\n", outcome.c_str());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(all_curves_join_into_one_tree),
                                cmocka_unit_test(curves_are_recovered_from_their_surface),
                                cmocka_unit_test(the_dirty_surface_gives_a_tree_or_says_what_to_mend)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
