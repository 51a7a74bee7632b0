// The picture shows the vessel from the front (from +z), so the patient's left is on the right of the
// picture, as in a radiograph.
#include "tools/lab/figures/vessel_picture.hpp"
#include <algorithm>
#include <cmath>

namespace vcsim3
{
namespace
{

constexpr Colour wall_colour{120, 150, 190}, touching_colour{20, 160, 60}, free_colour{215, 40, 40};
constexpr double depth_step_mm = 0.5, rim_mm = 4.0;

Colour shaded(Colour colour, double light)
{
    const auto scale = [light](std::uint8_t c) {
        return static_cast<std::uint8_t>(std::clamp(c * light, 0.0, 255.0));
    };
    return {scale(colour.red), scale(colour.green), scale(colour.blue)};
}

void draw_sphere(Canvas &canvas, double x, double y, double radius, Colour colour)
{
    canvas.disc(x, y, radius, shaded(colour, 0.55));
    canvas.disc(x, y, radius * 0.85, colour);
    canvas.disc(x - radius * 0.3, y - radius * 0.3, radius * 0.3, shaded(colour, 1.6));
}

} // namespace

VesselPicture::VesselPicture(const Vessel &vessel, double pixels_per_mm) : pixels_per_mm_(pixels_per_mm)
{
    const Vector low_mm = vessel.low_m() * 1e3, high_mm = vessel.high_m() * 1e3;
    left_mm_ = low_mm.x();
    top_mm_ = high_mm.y();
    width_ = static_cast<int>((high_mm.x() - low_mm.x()) * pixels_per_mm);
    height_ = static_cast<int>((high_mm.y() - low_mm.y()) * pixels_per_mm);
    glass_.assign(static_cast<std::size_t>(width_) * height_, 0.0);
    for (int row = 0; row < height_; row++) {
        for (int column = 0; column < width_; column++) {
            const double x = left_mm_ + (column + 0.5) / pixels_per_mm,
                         y = top_mm_ - (row + 0.5) / pixels_per_mm;
            double deepest_mm = 0.0; // depth of the lumen along the line of sight
            for (double z = low_mm.z(); z < high_mm.z(); z += depth_step_mm)
                deepest_mm = std::max(deepest_mm, -1e3 * vessel.sample(Vector(x, y, z) * 1e-3).distance_m);
            // The glass of the vessel looks darkest where its wall is seen edge-on.
            const double edge = std::max(0.0, 1.0 - deepest_mm / rim_mm);
            glass_[static_cast<std::size_t>(row) * width_ + column] =
                deepest_mm > 0.0 ? 0.18 + 0.55 * edge * edge : 0.0;
        }
    }
}

Eigen::Vector2d VesselPicture::place_of(const Vector &position_m) const
{
    return {(position_m.x() * 1e3 - left_mm_) * pixels_per_mm_,
            (top_mm_ - position_m.y() * 1e3) * pixels_per_mm_};
}

void VesselPicture::draw(Canvas &canvas, double left, double top, const std::vector<ShapeNode> &shape,
                         double free_radius_mm, double touching_radius_mm) const
{
    for (int row = 0; row < height_; row++)
        for (int column = 0; column < width_; column++)
            canvas.blend(static_cast<int>(left) + column, static_cast<int>(top) + row, wall_colour,
                         glass_[static_cast<std::size_t>(row) * width_ + column]);
    std::vector<ShapeNode> nodes = shape;
    std::stable_sort(nodes.begin(), nodes.end(), [](const ShapeNode &a, const ShapeNode &b) {
        return a.is_touching != b.is_touching ? b.is_touching : a.position_m.z() < b.position_m.z();
    });
    for (const ShapeNode &node : nodes) {
        const Eigen::Vector2d place = place_of(node.position_m);
        const double radius_mm = node.is_touching ? touching_radius_mm : free_radius_mm;
        draw_sphere(canvas, left + place.x(), top + place.y(), radius_mm * pixels_per_mm_,
                    node.is_touching ? touching_colour : free_colour);
    }
}

} // namespace vcsim3
