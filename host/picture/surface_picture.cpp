#include "host/picture/surface_picture.hpp"
#include "host/base/format.hpp"
#include "host/picture/canvas.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace crn
{
namespace
{

using Eigen::Vector3d;

constexpr int finer = 2; // samples along each edge of a pixel
constexpr double margin_share = 0.04;
constexpr double edge_samples = 0.9;  // half of the width of a triangle's edge
constexpr double edged_samples = 7.0; // smaller triangles are drawn without edges
constexpr double touching_mm = 0.25;  // a wall would hide a balloon that fills it

const Vector3d paper(255, 255, 255), edge_colour(96, 24, 24);
const Vector3d light = Vector3d(-0.4, 0.5, 0.8).normalized(); // in the view: right, up, towards the eye

// Describes how a kind of surface looks, by its colour and its transparency.
struct Look {
    Vector3d colour;
    double glass;
};

Look look_of(SurfaceKind kind)
{
    switch (kind) {
    case SurfaceKind::calcium:
        return {{236, 214, 150}, 0.0};
    case SurfaceKind::balloon:
        return {{96, 150, 214}, 0.0};
    case SurfaceKind::wall:
        break;
    }
    return {{222, 120, 108}, 0.62};
}

// Describes the part of space that every panel shows, in mm along the axes of the view.
struct Frame {
    Vector3d middle_mm;
    double pixels_per_mm = 1.0;
};

class Panel
{
  public:
    Panel(const SurfaceView &view, const Frame &frame, int samples)
        : samples_(samples), frame_(frame), colours_(static_cast<std::size_t>(samples) * samples, paper),
          depths_(colours_.size(), -std::numeric_limits<double>::infinity())
    {
        axes_ << view.right.transpose(), view.up.transpose(), view.right.cross(view.up).transpose();
    }

    // Draws opaque meshes and the far sides of walls first, and then the near sides of walls as glass over
    // them.
    void draw(const SurfacePanel &panel)
    {
        for (const SurfaceMesh &mesh : panel.meshes)
            draw(mesh, mesh.kind == SurfaceKind::wall ? Side::far : Side::near);
        for (const SurfaceMesh &mesh : panel.meshes)
            if (mesh.kind == SurfaceKind::wall) draw(mesh, Side::near);
    }

    Ink at(int x, int y) const
    {
        Vector3d sum = Vector3d::Zero();
        for (int b = 0; b < finer; ++b)
            for (int a = 0; a < finer; ++a)
                sum += colours_[static_cast<std::size_t>(y * finer + b) * samples_ + x * finer + a];
        sum /= finer * finer;
        return {static_cast<std::uint8_t>(sum[0]), static_cast<std::uint8_t>(sum[1]),
                static_cast<std::uint8_t>(sum[2])};
    }

  private:
    enum class Side { near, far };

    Vector3d seen(const Vector3d &place_mm) const
    {
        Vector3d at = (axes_ * place_mm - frame_.middle_mm) * frame_.pixels_per_mm;
        return {at.x() + 0.5 * samples_, 0.5 * samples_ - at.y(), at.z()};
    }

    void draw(const SurfaceMesh &mesh, Side side)
    {
        std::vector<Vector3d> corners;
        for (const Vector3d &vertex : mesh.vertices_mm) corners.push_back(seen(vertex));
        for (const auto &triangle : mesh.triangles) {
            const Vector3d &a = corners[triangle[0]], &b = corners[triangle[1]], &c = corners[triangle[2]];
            Vector3d normal = (b - a).cross(c - a); // y grows downwards: a normal towards the eye is below 0
            const double length = normal.norm();
            if (!(length > 0.0) || (normal.z() < 0.0) != (side == Side::near)) continue;
            normal /= length;
            const double lit = std::fabs(Vector3d(-normal.x(), normal.y(), -normal.z()).dot(light));
            fill(a, b, c, mesh.kind, side, 0.45 + 0.55 * lit);
        }
    }

    void fill(const Vector3d &a, const Vector3d &b, const Vector3d &c, SurfaceKind kind, Side side,
              double shade)
    {
        const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
        const auto first = [this](double value) {
            return std::clamp(static_cast<int>(value), 0, samples_ - 1);
        };
        const Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
        if (high.x() < 0 || high.y() < 0 || low.x() >= samples_ || low.y() >= samples_) return;
        const double to_edge[3] = {std::fabs(area) / (c - b).head<2>().norm(),
                                   std::fabs(area) / (c - a).head<2>().norm(),
                                   std::fabs(area) / (b - a).head<2>().norm()};
        const double smallest = *std::min_element(to_edge, to_edge + 3);
        for (int y = first(low.y()); y <= first(high.y()); ++y)
            for (int x = first(low.x()); x <= first(high.x()); ++x) {
                const double px = x + 0.5, py = y + 0.5;
                const double u = ((b.x() - px) * (c.y() - py) - (b.y() - py) * (c.x() - px)) / area,
                             v = ((c.x() - px) * (a.y() - py) - (c.y() - py) * (a.x() - px)) / area,
                             w = 1 - u - v;
                if (u < 0 || v < 0 || w < 0) continue;
                const bool is_edge =
                    kind == SurfaceKind::wall && side == Side::near && smallest > edged_samples &&
                    std::min({u * to_edge[0], v * to_edge[1], w * to_edge[2]}) < edge_samples;
                paint(x, y, u * a.z() + v * b.z() + w * c.z(), kind, side, shade, is_edge);
            }
    }

    // The far side of a wall also fills the depth buffer, so that objects inside the vessel are drawn in
    // front of it. The near side of a wall tints only the objects behind it.
    void paint(int x, int y, double depth, SurfaceKind kind, Side side, double shade, bool is_edge)
    {
        const std::size_t i = static_cast<std::size_t>(y) * samples_ + x;
        const bool is_glass = kind == SurfaceKind::wall && side == Side::near;
        if (depth < depths_[i] - (is_glass ? touching_mm * frame_.pixels_per_mm : 0.0)) return;
        const Look look = look_of(kind);
        if (!is_glass) {
            depths_[i] = depth;
            colours_[i] = shade * look.colour;
            return;
        }
        colours_[i] = look.glass * colours_[i] + (1 - look.glass) * shade * look.colour;
        if (is_edge) colours_[i] = 0.6 * colours_[i] + 0.4 * edge_colour;
    }

    int samples_;
    Frame frame_;
    Eigen::Matrix3d axes_;
    std::vector<Vector3d> colours_;
    std::vector<double> depths_; // larger is nearer to the eye
};

Frame frame_of(const std::vector<SurfacePanel> &panels, const SurfaceView &view, int samples)
{
    Eigen::AlignedBox2d box;
    for (const SurfacePanel &panel : panels)
        for (const SurfaceMesh &mesh : panel.meshes)
            for (const Vector3d &vertex : mesh.vertices_mm)
                if (mesh.kind != SurfaceKind::balloon)
                    box.extend(Eigen::Vector2d(view.right.dot(vertex), view.up.dot(vertex)));
    if (box.isEmpty()) box.extend(Eigen::Vector2d(-1, -1)).extend(Eigen::Vector2d(1, 1));
    const double widest_mm = std::max(box.sizes().maxCoeff(), 1.0);
    return {{box.center().x(), box.center().y(), 0.0}, samples * (1 - 2 * margin_share) / widest_mm};
}

void draw_scale(Sheet &sheet, int size, double pixels_per_mm)
{
    constexpr double bar_mm = 5.0;
    const int length = static_cast<int>(bar_mm * pixels_per_mm), y = size - 14;
    sheet.box(12, y, 12 + length, y + 3, {});
    sheet.text(12, y - 20, "5 mm", 2, {});
}

} // namespace

Image draw_surfaces(const std::vector<SurfacePanel> &panels, const SurfaceView &view, int size)
{
    const int count = static_cast<int>(std::max<std::size_t>(panels.size(), 1));
    Sheet sheet(count * size, size);
    const Frame frame = frame_of(panels, view, size * finer);
    for (std::size_t k = 0; k < panels.size(); ++k) {
        Panel panel(view, frame, size * finer);
        panel.draw(panels[k]);
        const int left = static_cast<int>(k) * size;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) sheet.blend(left + x, y, panel.at(x, y), 1.0);
        const std::string text = formatted("%.1f s", panels[k].time_s);
        sheet.text(left + 12, 12, text, 2, {});
    }
    draw_scale(sheet, size, frame.pixels_per_mm / finer);
    return sheet.image();
}

} // namespace crn
