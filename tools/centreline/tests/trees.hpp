// Provides a small vessel tree and assertions for the tests of trees.
#pragma once
#include "tools/centreline/formats.hpp"

#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <functional>
extern "C" {
#include <cmocka.h>
}

namespace crn::centreline::tests
{

inline Branch straight(const std::string &name, const Eigen::Vector3d &from, const Eigen::Vector3d &to,
                       int spheres, double radius_from_mm, double radius_to_mm)
{
    Branch branch;
    branch.name = name;
    for (int i = 0; i < spheres; ++i) {
        const double t = static_cast<double>(i) / (spheres - 1);
        branch.spheres.push_back(
            {from + t * (to - from), radius_from_mm + t * (radius_to_mm - radius_from_mm)});
    }
    return branch;
}

// Makes a trunk of six spheres that forks into a left and a right branch.
inline Tree y_tree()
{
    Tree tree;
    tree.branches.push_back(straight("trunk", {0, 0, 0}, {0, 5, 0}, 6, 2.0, 1.5));
    for (double side : {1.0, -1.0}) {
        Branch branch = straight(side > 0 ? "left" : "right", {0, 5, 0}, {4 * side, 9, 0.5}, 7, 1.5, 0.75);
        branch.parent = 0;
        branch.parent_sphere = 5;
        tree.branches.push_back(branch);
    }
    tree.branches[1].spheres[4].is_manual = true;
    tree.branches[1].spheres[3].speed_mm_s = 123.5;
    return tree;
}

inline void assert_same_tree(const Tree &a, const Tree &b, bool with_speed = true)
{
    assert_int_equal(a.branches.size(), b.branches.size());
    for (std::size_t n = 0; n < a.branches.size(); ++n) {
        const Branch &one = a.branches[n], &other = b.branches[n];
        assert_string_equal(one.name.c_str(), other.name.c_str());
        assert_int_equal(one.parent, other.parent);
        assert_int_equal(one.parent_sphere, other.parent_sphere);
        assert_int_equal(one.spheres.size(), other.spheres.size());
        for (std::size_t i = 0; i < one.spheres.size(); ++i) {
            assert_true((one.spheres[i].centre_mm - other.spheres[i].centre_mm).norm() < 2e-6);
            assert_true(std::abs(one.spheres[i].radius_mm - other.spheres[i].radius_mm) < 2e-6);
            assert_int_equal(one.spheres[i].is_manual, other.spheres[i].is_manual);
            if (with_speed)
                assert_true(std::abs(one.spheres[i].speed_mm_s - other.spheres[i].speed_mm_s) < 2e-6);
        }
    }
}

// Asserts that the function `work` throws a Fault whose message contains all the given parts.
inline void says(const std::function<void()> &work, std::initializer_list<const char *> parts)
{
    std::string text;
    try {
        work();
    } catch (const Fault &fault) {
        text = fault.what();
    }
    if (text.empty()) fail_msg("it was accepted, but should say \"%s\"", *parts.begin());
    for (const char *part : parts)
        if (text.find(part) == text.npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), part);
}

} // namespace crn::centreline::tests
