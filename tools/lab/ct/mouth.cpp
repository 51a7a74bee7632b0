#include "tools/lab/ct/mouth.hpp"
#include "host/base/format.hpp"
#include "tools/lab/ct/measures.hpp"
#include "tools/mesh/fault.hpp"
#include <Eigen/SVD>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double beside_mm = 10; // distance at which a line may pass mouth_mm
constexpr double length_share =
    0.04;                       // permitted difference between a line's length and the inserted length ...
constexpr double length_mm = 6; // ... or this, whichever is larger
constexpr double depths_mm = 6; // permitted difference between the places of mouth_mm from different depths
constexpr double straight_mm = 12; // length of the line at the mouth whose direction is the introducer's

// Returns the point at a given distance back along the centreline from its last point; the centreline must be
// at least that long.
Vector3d before_tip(const std::vector<Vector3d> &line, double arc_mm)
{
    for (std::size_t i = line.size() - 1; i > 0; --i) {
        const double piece = (line[i] - line[i - 1]).norm();
        if (arc_mm <= piece && piece > 0) return line[i] + (line[i - 1] - line[i]) * (arc_mm / piece);
        arc_mm -= piece;
    }
    return line.front();
}

// Returns the direction of the straight line that fits the points best; the direction leads from the first to
// the last point.
Vector3d direction_of(const std::vector<Vector3d> &places)
{
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d &place : places) middle += place / static_cast<double>(places.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vector3d &place : places) spread += (place - middle) * (place - middle).transpose();
    const Vector3d axis = Eigen::JacobiSVD<Eigen::Matrix3d>(spread, Eigen::ComputeFullU).matrixU().col(0);
    return axis.dot(places.back() - places.front()) < 0 ? Vector3d(-axis) : axis;
}

// Returns the direction of the introducer, which is straight. The function measures the direction of the
// instrument in that part of the introducer which the scan shows. If the scan shows too little of the
// introducer, the function uses the first millimetres of the centreline in the vessel instead.
Vector3d direction_at(const InsertedLine &line)
{
    const double end = length_of(line.places), mouth = end - line.inserted_mm;
    const bool shows_inserter = mouth >= 0.5 * straight_mm;
    const double from = shows_inserter ? std::max(0.0, mouth - straight_mm) : mouth,
                 to = shows_inserter ? mouth : std::min(end, mouth + 0.5 * straight_mm);
    std::vector<Vector3d> places;
    for (double arc = from; arc <= to; arc += 0.5) places.push_back(before_tip(line.places, end - arc));
    return direction_of(places);
}

} // namespace

bool begin_at_mouth(InstrumentLine &line, const Mouth &mouth, const std::string &name)
{
    std::vector<LinePoint> &points = line.points;
    const auto ahead = [&](std::size_t i) {
        return (points[i].place_mm - mouth.place_mm).dot(mouth.direction);
    };
    std::size_t first = 0; // the point after the crossing that is nearest to mouth_mm
    Vector3d begin = points.front().place_mm;
    for (std::size_t i = 1; i < points.size(); ++i) {
        const double a = ahead(i - 1), b = ahead(i);
        if (a >= 0 || b < 0) continue;
        const Vector3d crossing =
            points[i - 1].place_mm + (points[i].place_mm - points[i - 1].place_mm) * (-a / (b - a));
        if (first > 0 && (crossing - mouth.place_mm).norm() > (begin - mouth.place_mm).norm()) continue;
        first = i;
        begin = crossing;
    }
    if (first == 0 && ahead(0) < 0)
        throw Fault(name + ": the instrument lies behind the mouth: are mouth_mm and direction in the "
                           "scene's axes, and the scan's axes not mirrored?");
    if (first == 0) {
        line.notes.push_back(
            "the scan shows the instrument only in front of the mouth: the line begins where it does");
        return false;
    }
    const double beside = (begin - mouth.place_mm).norm();
    if (beside > beside_mm)
        throw Fault(name +
                    formatted(": the instrument passes %.0f mm beside the mouth at (%.0f, %.0f, %.0f) mm: "
                              "mouth_mm is not in the scene's axes, or the scan's axes are mirrored",
                              beside, mouth.place_mm.x(), mouth.place_mm.y(), mouth.place_mm.z()));
    LinePoint start = points[first];
    start.place_mm = begin;
    points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(first));
    if ((points.front().place_mm - begin).norm() < 0.1)
        points.front() = start;
    else
        points.insert(points.begin(), start);
    return true;
}

Mouth find_mouth(const std::vector<InsertedLine> &lines)
{
    std::vector<Vector3d> places;
    Mouth mouth{Vector3d::Zero(), Vector3d::Zero()};
    for (const InsertedLine &line : lines) {
        const double shown = length_of(line.places);
        if (shown < line.inserted_mm)
            throw Fault(line.name +
                        formatted(": shows %.1f mm of the instrument, and %.1f mm are inserted, so "
                                  "that the mouth is not in it: write mouth_mm and direction into "
                                  "case.toml, or mend inserted_mm",
                                  shown, line.inserted_mm));
        places.push_back(before_tip(line.places, line.inserted_mm));
        mouth.place_mm += places.back() / static_cast<double>(lines.size());
        mouth.direction += direction_at(line);
    }
    mouth.direction.normalize();
    for (std::size_t i = 0; i < places.size(); ++i)
        if (const double apart = (places[i] - places.front()).norm(); apart > depths_mm)
            throw Fault(lines[i].name +
                        formatted(": by inserted_mm the mouth is %.0f mm away from where %s has "
                                  "it: inserted_mm, the scan's spacing or its place is wrong, "
                                  "or its axes are mirrored; mend it, or write mouth_mm and "
                                  "direction into case.toml",
                                  apart, lines.front().name.c_str()));
    return mouth;
}

void check_length(const InsertedLine &line)
{
    const double shown = length_of(line.places), apart = std::abs(shown - line.inserted_mm);
    if (apart > std::max(length_mm, length_share * line.inserted_mm))
        throw Fault(line.name +
                    formatted(": the line from the mouth to the tip is %.1f mm long, the case says "
                              "that %.1f mm are inserted: the scan's spacing, inserted_mm or the mouth "
                              "is wrong, or it is another depth's scan",
                              shown, line.inserted_mm));
}

std::vector<Vector3d> behind_mouth(const LineOptions &options, const Vector3d &begin_mm)
{
    constexpr double behind_mm = 300;
    if (!options.mouth_mm) return {};
    return {begin_mm, begin_mm - behind_mm * options.direction};
}

} // namespace crn::ct
