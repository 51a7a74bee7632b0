#include "host/xray/paths/tube_outline.hpp"
#include "host/xray/paths/tube_painter.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace
{

constexpr double margin_pixels = 0.25; // far more than the rounding of single precision
constexpr double nearest_mm = 1.0;     // from the source
constexpr double everywhere = 1e9;     // pixels

double length(double x, double y)
{
    return std::sqrt(x * x + y * y);
}

} // namespace

// The rim of an end is the ellipse a + r (u cos s + v sin s) for all angles s, with the middle a of the end
// and the radius r of the cylinder. The vectors u and v lie in the cutting plane, and their parts
// perpendicular to the axis have the length 1 and are perpendicular to each other.
struct TubeOutline::End {
    Vector3d middle_mm, u, v;
    Vector2d pixel;
    double pixels_per_mm; // at the point of the rim that is nearest to the source
};

struct TubeOutline::Strip {
    Vector2d direction;
    double low, high;

    Strip(const Vector2d &along, const std::array<End, 2> &ends, double outer_mm)
        : direction(along), low(everywhere), high(-everywhere)
    {
        for (const End &end : ends) {
            // A point q mm beside the middle of the end lies (q gradient) (focal length)/depth pixels farther
            // along the direction than the image of the middle; rows count downwards.
            const Vector3d &a = end.middle_mm;
            const Vector3d gradient(along.x(), -along.y(), (along.y() * a.y() - along.x() * a.x()) / a.z());
            const double reach =
                length(end.u.dot(gradient), end.v.dot(gradient)) * outer_mm * end.pixels_per_mm +
                margin_pixels;
            low = std::min(low, along.dot(end.pixel) - reach);
            high = std::max(high, along.dot(end.pixel) + reach);
        }
    }
};

TubeOutline::TubeOutline(const TubePiece &piece, double outer_mm, double focal_pixels, double half)
    : left_{Edge{-everywhere, 0.0}, Edge{-everywhere, 0.0}}, right_{Edge{everywhere, 0.0},
                                                                    Edge{everywhere, 0.0}},
      top_(-everywhere), bottom_(everywhere)
{
    const Vector3d axis = (piece.b_mm - piece.a_mm).normalized();
    const Vector3d e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    std::array<End, 2> ends;
    for (int k = 0; k < 2; ++k) {
        const Vector3d &at = k == 0 ? piece.a_mm : piece.b_mm,
                       &normal = k == 0 ? piece.normal_a : piece.normal_b;
        const Vector3d shear = axis / axis.dot(normal);
        End &end = ends[k];
        end.middle_mm = at;
        end.u = e1 - shear * e1.dot(normal);
        end.v = e2 - shear * e2.dot(normal);
        const double nearest = at.z() - outer_mm * length(end.u.z(), end.v.z());
        if (!(nearest > nearest_mm)) return; // the image has no bounds
        end.pixels_per_mm = focal_pixels / nearest;
        end.pixel = {half + focal_pixels * at.x() / at.z(), half - focal_pixels * at.y() / at.z()};
    }
    const Vector2d apart = ends[1].pixel - ends[0].pixel;
    const double distance = apart.norm();
    const Vector2d along = distance > 1e-6 ? Vector2d(apart / distance) : Vector2d(1.0, 0.0);
    add(Strip(along, ends, outer_mm), 0);
    add(Strip({-along.y(), along.x()}, ends, outer_mm), 1);
    const Strip vertical({0.0, 1.0}, ends, outer_mm);
    top_ = vertical.low;
    bottom_ = vertical.high;
}

// The edge of a strip in the row [y, y + 1] is where the strip reaches farthest to the left or to the right.
void TubeOutline::add(const Strip &strip, std::size_t place)
{
    const double across = strip.direction.x(), down = strip.direction.y();
    if (std::fabs(across) < 1e-9) return; // bounds no columns
    const double first = (strip.low - std::max(down, 0.0)) / across,
                 last = (strip.high - std::min(down, 0.0)) / across;
    left_[place] = {std::min(first, last), -down / across};
    right_[place] = {std::max(first, last), -down / across};
}

std::pair<double, double> TubeOutline::columns(int y) const
{
    const double row = y;
    return {
        std::max(left_[0].at_row_0 + left_[0].per_row * row, left_[1].at_row_0 + left_[1].per_row * row),
        std::min(right_[0].at_row_0 + right_[0].per_row * row, right_[1].at_row_0 + right_[1].per_row * row)};
}

} // namespace crn
