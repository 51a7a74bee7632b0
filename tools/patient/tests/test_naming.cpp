// Tests the names that are proposed for the branches of an arterial tree.
#include "tools/patient/naming.hpp"
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

// Adds a straight branch from the end of its parent. Returns its number.
int add(centreline::Tree &tree, int parent, const Vector3d &to_mm, double radius_mm,
        const Vector3d &from_mm = {0, 0, 0})
{
    centreline::Branch branch;
    branch.parent = parent;
    Vector3d from = from_mm;
    if (parent >= 0) {
        const auto &spheres = tree.branches[static_cast<std::size_t>(parent)].spheres;
        branch.parent_sphere = spheres.size() - 1;
        branch.spheres.push_back(spheres.back());
        from = spheres.back().centre_mm;
    }
    const int steps = std::max(2, static_cast<int>((to_mm - from).norm() / 2));
    for (int n = parent >= 0 ? 1 : 0; n <= steps; ++n)
        branch.spheres.push_back({from + (to_mm - from) * n / steps, radius_mm});
    tree.branches.push_back(branch);
    return static_cast<int>(tree.branches.size()) - 1;
}

const std::string &name_of(const centreline::Tree &tree, int branch)
{
    return tree.branches[static_cast<std::size_t>(branch)].name;
}

} // namespace

static void branches_of_a_usual_aorta_have_their_names(void **)
{
    // In the scene's axes: x to the left, y to the head, z to the front.
    centreline::Tree tree;
    const int root = add(tree, -1, {-5, 60, 25}, 14, {10, 10, 30});
    const int arch_1 = add(tree, root, {5, 70, 12}, 13);
    const int arch_2 = add(tree, arch_1, {12, 72, 0}, 13);
    const int arch_3 = add(tree, arch_2, {20, 62, -22}, 12);
    const int chest = add(tree, arch_3, {10, -150, -30}, 11);
    const int belly_1 = add(tree, chest, {8, -165, -28}, 9);
    const int belly_2 = add(tree, belly_1, {7, -180, -27}, 9);
    const int belly_3 = add(tree, belly_2, {5, -220, -22}, 8);
    const int belly_4 = add(tree, belly_3, {3, -270, -20}, 8);
    struct Wanted {
        int branch;
        const char *name;
    };
    const int trunk = add(tree, root, {-15, 95, 18}, 6), left_iliac = add(tree, belly_4, {35, -320, -15}, 5),
              right_iliac = add(tree, belly_4, {-30, -320, -15}, 5),
              coeliac = add(tree, chest, {8, -155, 5}, 3.5);
    // The right renal artery gives off a short, wide branch upwards at once.
    const int right_renal = add(tree, belly_2, {-3, -182, -22}, 2.9);
    add(tree, right_renal, {5, -172, -12}, 2.8);
    const Wanted wanted[] = {{root, "aorta"},
                             {belly_4, "aorta_9"},
                             {trunk, "brachiocephalic_trunk"},
                             {add(tree, trunk, {-60, 105, 10}, 4.5), "right_subclavian_artery"},
                             {add(tree, trunk, {-20, 150, 5}, 3.5), "right_common_carotid_artery"},
                             {add(tree, arch_1, {18, 150, 0}, 3.5), "left_common_carotid_artery"},
                             {add(tree, arch_2, {45, 110, -10}, 4.5), "left_subclavian_artery"},
                             {coeliac, "coeliac_trunk"},
                             {add(tree, coeliac, {70, -150, -10}, 2.8), "splenic_artery"},
                             {add(tree, coeliac, {-50, -150, 10}, 2.5), "common_hepatic_artery"},
                             {add(tree, belly_1, {5, -250, 20}, 3.3), "superior_mesenteric_artery"},
                             {add(tree, belly_2, {50, -185, -35}, 2.7), "left_renal_artery"},
                             {right_renal, "right_renal_artery"},
                             {add(tree, right_renal, {-45, -190, -35}, 2.5), "right_renal_artery_2"},
                             {add(tree, belly_3, {12, -270, 10}, 1.8), "inferior_mesenteric_artery"},
                             {left_iliac, "left_common_iliac_artery"},
                             {right_iliac, "right_common_iliac_artery"},
                             {add(tree, left_iliac, {50, -400, 20}, 4), "left_external_iliac_artery"},
                             {add(tree, left_iliac, {40, -370, -60}, 3), "left_internal_iliac_artery"},
                             {add(tree, belly_3, {4, -225, -45}, 1.3), "branch_2"}};
    patient::propose_names(tree);
    for (const Wanted &one : wanted) assert_string_equal(name_of(tree, one.branch).c_str(), one.name);
}

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(branches_of_a_usual_aorta_have_their_names)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
