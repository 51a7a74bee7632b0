#include "tools/lab/ct/arteries/ascending.hpp"
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/measures.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

std::size_t middle_voxel(const Volume &scan, const Disc &disc)
{
    return scan.at(static_cast<int>(std::lround(disc.middle.x())),
                   static_cast<int>(std::lround(disc.middle.y())), disc.slice);
}

// Whether blood reaches the stack from above, as it does in the ascending aorta. The left atrium is as round
// and as bright, but its path from the aorta comes up through the left ventricle.
bool is_reached_from_above(const Volume &scan, const Growth &growth, const Stack &stack, double neck_mm)
{
    const std::size_t middle = middle_voxel(scan, stack[stack.size() / 2]);
    if (!growth.is_artery(middle) || growth.neck[middle] * width_unit_mm < neck_mm) return false;
    const std::vector<std::size_t> path = path_to(scan, growth, middle); // backwards, to the descending aorta
    const auto highest = std::max_element(path.begin(), path.end(), [&](std::size_t a, std::size_t b) {
        return slice_of(scan, a) < slice_of(scan, b);
    });
    return std::all_of(path.begin(), highest,
                       [&](std::size_t at) { return slice_of(scan, at) >= stack.front().slice; });
}

// Takes away the lowest discs if they are much narrower than the others: the outflow tract of the ventricle.
Stack without_neck(Stack stack)
{
    std::vector<double> radii;
    for (const Disc &disc : stack) radii.push_back(disc.radius_mm);
    const double least_mm = 0.75 * median(radii);
    while (stack.size() > 2 && stack.front().radius_mm < least_mm) stack.erase(stack.begin());
    return stack;
}

} // namespace

// The stack of the ascending aorta and, below it, of the root.
Stack ascending_aorta(const Volume &scan, const Growth &growth, const std::vector<Stack> &stacks,
                      const Stack &descending)
{
    const double radius_mm = descending[descending.size() / 2].radius_mm;
    std::vector<Stack> others;
    for (const Stack &one : stacks)
        if (&one != &stacks.front()) others.push_back(without_neck(one));
    // The tallest first: a short one may be a second reading of the arch's end.
    std::stable_sort(others.begin(), others.end(), [](const Stack &a, const Stack &b) {
        return a.back().slice - a.front().slice > b.back().slice - b.front().slice;
    });
    Stack found;
    for (const Stack &stack : others) {
        const Disc &top = stack.back(), &bottom = stack.front();
        if (top.slice > descending.back().slice + 3) continue;
        if (bottom.radius_mm < 0.9 * radius_mm || bottom.radius_mm > 2.5 * radius_mm) continue;
        if (!is_reached_from_above(scan, growth, stack, 0.6 * radius_mm)) continue;
        if (found.empty()) {
            found = stack;
        } else if (bottom.slice < found.front().slice && top.slice + 4 > found.front().slice &&
                   (place_of(scan, top) - place_of(scan, found.front())).norm() < found.front().radius_mm) {
            Stack both;
            for (const Disc &disc : stack)
                if (disc.slice < found.front().slice) both.push_back(disc);
            both.insert(both.end(), found.begin(), found.end());
            found = both;
        }
    }
    return found;
}

// The plane below the aortic root, which closes the way into the ventricle.
std::vector<std::size_t> gate_below(const Volume &scan, const Stack &ascending)
{
    std::vector<std::size_t> gate;
    if (ascending.empty()) return gate;
    const Disc &lowest = ascending.front();
    for (int k = lowest.slice - 1; k >= std::max(lowest.slice - 2, 0); --k) {
        const Ball ball{scan.scene({lowest.middle.x(), lowest.middle.y(), 1.0 * k}), 1.8 * lowest.radius_mm};
        for_ball(scan, ball, [&](std::size_t at) {
            if (slice_of(scan, at) == k) gate.push_back(at);
        });
    }
    return gate;
}

} // namespace crn::ct
