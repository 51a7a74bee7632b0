#include "host/stent/figures.hpp"
#include "host/stent/vessel_wall.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr int samples_per_strut = 5;
constexpr double far_mm = 99.0; // from any wall
constexpr double behind_mm =
    0.3; // a place farther behind the wall counts as outside the vessel, at this distance from the wall

// Returns the point at the fraction `share` (0 to 1) of a strut's length; the strut is bent at its middle.
Vector3d along_strut(const Vector3d &a, const Vector3d &middle, const Vector3d &b, double share)
{
    return share < 0.5 ? Vector3d(a + 2 * share * (middle - a))
                       : Vector3d(middle + (2 * share - 1) * (b - middle));
}

// Returns the distance from a point of a strut to the nearest wall; the search starts where the strut's two
// ends touch the wall.
double distance_mm(const StentWall &wall, const Vector3d &place, const StentPoint &a, const StentPoint &b)
{
    double least = far_mm;
    for (const StentPoint *end : {&a, &b}) {
        const WallFoot foot = wall.walk(place, end->foot.triangle);
        if (foot.is_known() && std::abs(foot.distance_mm) < std::abs(least)) least = foot.distance_mm;
    }
    return least < -behind_mm ? -least : least;
}

void appose(const Stent &stent, const StentWall *wall, StentFigures &figures)
{
    std::size_t apposed = 0, bedded = 0;
    const double half = stent.design().strut_thickness_mm / 2;
    for (std::size_t i = 0; i < stent.lattice().struts.size(); ++i) {
        const auto [a, b] = stent.lattice().struts[i];
        const StentPoint &from = stent.points()[a], &to = stent.points()[b];
        const Vector3d middle = stent.strut_middle_mm(i);
        StentGap worst{stent.lattice().ring_of(a), i, 0.0, middle};
        for (int k = 0; k < samples_per_strut; ++k) {
            const Vector3d place =
                along_strut(from.place_mm, middle, to.place_mm, (k + 0.5) / samples_per_strut);
            const double layer = std::max(from.layer_mm, to.layer_mm);
            const double gap = wall ? distance_mm(*wall, place, from, to) - half - layer : far_mm;
            ++figures.samples;
            if (gap <= apposed_mm) ++apposed;
            if (gap <= worst.gap_mm) continue;
            worst.gap_mm = gap;
            worst.place_mm = place;
        }
        if (worst.gap_mm > apposed_mm) figures.gaps.push_back(worst);
    }
    for (const StentPoint &point : stent.points()) bedded += point.is_bedded;
    figures.apposed_share = static_cast<double>(apposed) / static_cast<double>(figures.samples);
    figures.bedded_share = static_cast<double>(bedded) / static_cast<double>(stent.points().size());
}

// Measures a ring of struts as seen along its axis. The inner area of a ring is the area of the polygon
// through its points, times the ratio of a circle's area to that of the regular polygon in it.
StentRing ring_of(const Stent &stent, int index)
{
    const StentDesign &design = stent.design();
    const int around = 2 * design.crowns;
    StentRing ring{stent.ring_centre_mm(index), stent.ring_axis(index)};
    std::vector<Vector3d> out;
    for (int k = 0; k < around; ++k) {
        const Vector3d from = stent.points()[stent.lattice().point(index, k)].place_mm - ring.centre_mm;
        const Vector3d flat = from - from.dot(ring.axis) * ring.axis;
        // The inner side of a strut is nearer to the axis by half the strut's thickness.
        out.push_back(flat * std::max(0.0, 1 - design.strut_thickness_mm / 2 / std::max(flat.norm(), 1e-9)));
    }
    double doubled = 0.0;
    ring.diameter_min_mm = std::numeric_limits<double>::infinity();
    for (int k = 0; k < around; ++k) {
        const auto here = static_cast<std::size_t>(k), next = static_cast<std::size_t>((k + 1) % around);
        const auto across = static_cast<std::size_t>((k + design.crowns) % around);
        doubled += ring.axis.dot(out[here].cross(out[next]));
        ring.diameter_min_mm = std::min(ring.diameter_min_mm, out[here].norm() + out[across].norm());
    }
    const double step = std::numbers::pi / design.crowns;
    ring.area_mm2 = std::abs(doubled) / 2 * step / std::sin(step);
    ring.diameter_mm = 2 * std::sqrt(ring.area_mm2 / std::numbers::pi);
    ring.is_opened = stent.is_opened(index);
    return ring;
}

// Returns half of a ring's height, which is the mean distance of the ring's crowns from the ring's middle,
// measured along its axis.
double half_height_mm(const Stent &stent, const StentRing &ring, int index)
{
    double sum = 0.0;
    const int around = 2 * stent.design().crowns;
    for (int k = 0; k < around; ++k)
        sum += std::abs(
            (stent.points()[stent.lattice().point(index, k)].place_mm - ring.centre_mm).dot(ring.axis));
    return sum / around;
}

struct LinePlace {
    double along_mm = 0.0, share = 0.0;
    std::size_t piece = 0;
};

LinePlace nearest_on(std::span<const Vector3d> line, const Vector3d &place)
{
    LinePlace best;
    double least = std::numeric_limits<double>::infinity(), before = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vector3d way = line[i] - line[i - 1];
        const double length = way.norm();
        if (length < 1e-9) continue;
        const double share = std::clamp((place - line[i - 1]).dot(way) / (length * length), 0.0, 1.0);
        const double squared = (line[i - 1] + share * way - place).squaredNorm();
        if (squared < least) {
            least = squared;
            best = {before + share * length, share, i - 1};
        }
        before += length;
    }
    return best;
}

} // namespace

StentFigures stent_figures(const Stent &stent, const StentWall *wall)
{
    StentFigures figures;
    if (!stent.was_placed()) return figures;
    appose(stent, wall && wall->is_placed() ? wall : nullptr, figures);
    figures.diameter_min_mm = figures.area_min_mm2 = std::numeric_limits<double>::infinity();
    for (int ring = 0; ring < stent.design().rings; ++ring) {
        StentRing now = ring_of(stent, ring);
        if (!figures.rings.empty())
            now.along_mm =
                figures.rings.back().along_mm + (now.centre_mm - figures.rings.back().centre_mm).norm();
        figures.diameter_min_mm = std::min(figures.diameter_min_mm, now.diameter_min_mm);
        figures.area_min_mm2 = std::min(figures.area_min_mm2, now.area_mm2);
        figures.unopened_rings += !now.is_opened;
        figures.rings.push_back(now);
    }
    figures.length_mm = figures.rings.back().along_mm + half_height_mm(stent, figures.rings.front(), 0) +
                        half_height_mm(stent, figures.rings.back(), stent.design().rings - 1);
    figures.foreshortening = 1 - figures.length_mm / stent.design().length_mm;
    return figures;
}

namespace
{

// Returns the positions of a stent's two ends along a vessel. The position of an end is the mean position of
// the outer crowns of the first or last ring. The function `along` converts a point to its position along the
// vessel.
template <class Along>
StentCoverage coverage(const Stent &stent, const Along &along, double lesion_from_mm, double lesion_to_mm)
{
    StentCoverage coverage{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    const int rings[2] = {0, stent.design().rings - 1}, sides[2] = {-1, 1};
    for (int end = 0; end < 2; ++end) {
        double sum = 0.0;
        for (int k = 0; k < 2 * stent.design().crowns; ++k) {
            const std::uint32_t i = stent.lattice().point(rings[end], k);
            if (stent.lattice().side_of(i) == sides[end]) sum += along(stent.points()[i].place_mm);
        }
        const double at = sum / stent.design().crowns;
        coverage.from_mm = std::min(coverage.from_mm, at);
        coverage.to_mm = std::max(coverage.to_mm, at);
    }
    const double length = lesion_to_mm - lesion_from_mm;
    coverage.missed_before_mm = std::clamp(coverage.from_mm - lesion_from_mm, 0.0, length);
    coverage.missed_behind_mm = std::clamp(lesion_to_mm - coverage.to_mm, 0.0, length);
    return coverage;
}

} // namespace

StentCoverage stent_coverage(const Stent &stent, std::span<const Vector3d> centreline_mm,
                             double lesion_from_mm, double lesion_to_mm)
{
    return coverage(
        stent, [&](const Vector3d &place) { return nearest_on(centreline_mm, place).along_mm; },
        lesion_from_mm, lesion_to_mm);
}

StentCoverage stent_coverage(const Stent &stent, const VesselWall &vessel, std::size_t lesion)
{
    const VesselWall::Stretch stretch = vessel.lesion_mm(lesion);
    return coverage(
        stent, [&](const Vector3d &place) { return vessel.along_of(place); }, stretch.from_mm, stretch.to_mm);
}

double stent_stretch(const Stent &stent, std::span<const Vector3d> centreline_mm,
                     std::span<const double> healthy_radius_mm)
{
    double most = 0.0;
    if (centreline_mm.size() < 2 || healthy_radius_mm.size() != centreline_mm.size()) return most;
    for (int ring = 0; ring < stent.design().rings; ++ring) {
        if (!stent.is_opened(ring)) continue;
        double peak = 0.0;
        for (int k = 0; k < 2 * stent.design().crowns; ++k)
            peak += stent.points()[stent.lattice().point(ring, k)].peak_mm;
        peak = peak / (2 * stent.design().crowns) + stent.design().strut_thickness_mm / 2;
        const LinePlace at = nearest_on(centreline_mm, stent.ring_centre_mm(ring));
        const double healthy =
            (1 - at.share) * healthy_radius_mm[at.piece] + at.share * healthy_radius_mm[at.piece + 1];
        if (healthy > 0) most = std::max(most, peak / healthy - 1);
    }
    return most;
}

double stent_overlap_mm(const Stent &inner, const StentSleeve &outer)
{
    double overlap = 0.0;
    for (int ring = 1; ring < inner.design().rings; ++ring) {
        const Vector3d a = inner.ring_centre_mm(ring - 1), b = inner.ring_centre_mm(ring);
        constexpr int parts = 8;
        for (int k = 0; k < parts; ++k)
            if (outer.covers(a + (k + 0.5) / parts * (b - a))) overlap += (b - a).norm() / parts;
    }
    return overlap;
}

std::vector<StentLine> stent_lines(const Stent &stent)
{
    std::vector<StentLine> lines;
    if (!stent.was_placed()) return lines;
    const StentDesign &design = stent.design();
    const double radius = std::sqrt(design.strut_width_mm * design.strut_thickness_mm / std::numbers::pi);
    const auto around = static_cast<std::size_t>(2 * design.crowns);
    for (std::size_t strut = 0; strut < stent.lattice().struts.size(); ++strut) {
        if (strut % around == 0) {
            lines.push_back({{}, radius});
            lines.back().points_mm.push_back(stent.points()[stent.lattice().struts[strut][0]].place_mm);
        }
        lines.back().points_mm.push_back(stent.strut_middle_mm(strut));
        lines.back().points_mm.push_back(stent.points()[stent.lattice().struts[strut][1]].place_mm);
    }
    for (const auto &[a, b] : stent.lattice().links)
        lines.push_back({{stent.points()[a].place_mm, stent.points()[b].place_mm}, radius});
    return lines;
}

std::vector<StentLine> stent_markers(const StentDesign &design, double mount_arc_mm, const BalloonPose &pose)
{
    constexpr int pieces = 4;
    constexpr double shaft_share = 0.3; // share of the crimped diameter: the bands sit on the inner shaft
    std::vector<StentLine> lines;
    const BalloonAxis axis(pose, Vector3d::UnitX());
    if (!axis.is_known()) return lines;
    for (const double from : {mount_arc_mm - design.length_mm / 2 - design.marker_length_mm,
                              mount_arc_mm + design.length_mm / 2}) {
        lines.push_back({{}, shaft_share * design.crimped_diameter_mm});
        for (int k = 0; k <= pieces; ++k)
            lines.back().points_mm.push_back(axis.at(from + k * design.marker_length_mm / pieces).centre_mm);
    }
    return lines;
}

std::string_view stent_stage_text(StentStage stage)
{
    switch (stage) {
    case StentStage::on_balloon:
        return "on its balloon";
    case StentStage::deployed:
        return "deployed";
    case StentStage::stripped:
        return "lost: slid off its balloon before it was opened";
    case StentStage::adrift:
        return "lost: released where no wall holds it";
    }
    return "";
}

} // namespace crn
