#include "tools/centreline/end_width.hpp"
#include "tools/mesh/median.hpp"

#include <algorithm>

namespace crn::centreline
{
namespace
{

// The largest sphere within `reach_mm` behind the sphere `from`, or the next one if all are farther.
std::size_t largest_behind(const std::vector<Sphere> &inwards, std::size_t from, double reach_mm)
{
    std::size_t best = std::min(from + 1, inwards.size() - 1);
    double passed_mm = 0;
    for (std::size_t i = from + 1; i < inwards.size(); ++i) {
        passed_mm += (inwards[i].centre_mm - inwards[i - 1].centre_mm).norm();
        if (passed_mm > reach_mm) break;
        if (inwards[i].radius_mm > inwards[best].radius_mm) best = i;
    }
    return best;
}

} // namespace

EndWidth width_inside(const std::vector<Sphere> &inwards)
{
    constexpr double taper = 0.1, least_mm = 0.5, over_radii = 2.0;
    if (inwards.empty()) return {};
    std::size_t at = 0;
    for (;;) {
        const double radius_mm = inwards[at].radius_mm;
        const std::size_t next = largest_behind(inwards, at, radius_mm + least_mm);
        if (!(inwards[next].radius_mm > (1 + taper) * radius_mm)) break;
        at = next;
    }
    std::vector<double> radii_mm = {inwards[at].radius_mm};
    double passed_mm = 0;
    for (std::size_t i = at + 1; i < inwards.size(); ++i) {
        passed_mm += (inwards[i].centre_mm - inwards[i - 1].centre_mm).norm();
        if (passed_mm > over_radii * inwards[at].radius_mm) break;
        radii_mm.push_back(inwards[i].radius_mm);
    }
    const double radius_mm = mesh::median(radii_mm);
    // The rest of the taper is flatter than a tenth.
    for (std::size_t i = at; at > 0 && i < at + radii_mm.size(); ++i)
        if (inwards[i].radius_mm >= radius_mm) return {radius_mm, i};
    return {radius_mm, at};
}

EndWidth open_end(std::vector<Sphere> &inwards)
{
    const EndWidth width = width_inside(inwards);
    std::vector<double> radii_mm;
    for (std::size_t i = 0; i < width.index; ++i) {
        const double behind_mm = inwards[largest_behind(inwards, i, width.radius_mm)].radius_mm;
        radii_mm.push_back(std::max(inwards[i].radius_mm, std::min(behind_mm, width.radius_mm)));
    }
    for (std::size_t i = 0; i < radii_mm.size(); ++i) inwards[i].radius_mm = radii_mm[i];
    return width;
}

} // namespace crn::centreline
