#include "tools/lab/ct/pictures.hpp"
#include "host/base/pending_file.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

constexpr int caption_height = 14;

std::size_t at_axis(int axis)
{
    return static_cast<std::size_t>(axis);
}

// Projects the volume along the axis: the value of a pixel is the largest or the smallest value in its column
// of voxels.
std::vector<float> extreme_along(const Volume &volume, int axis, bool wants_largest)
{
    const int right = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
    const int columns = volume.size[at_axis(right)], rows = volume.size[at_axis(down)];
    std::vector<float> result(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows),
                              wants_largest ? -1e30f : 1e30f);
    for (int k = 0; k < volume.size[2]; ++k)
        for (int j = 0; j < volume.size[1]; ++j)
            for (int i = 0; i < volume.size[0]; ++i) {
                const int index[3] = {i, j, k};
                float &here =
                    result[static_cast<std::size_t>(index[down]) * static_cast<std::size_t>(columns) +
                           static_cast<std::size_t>(index[right])];
                const float value = volume.hu[volume.at(i, j, k)];
                here = wants_largest ? std::max(here, value) : std::min(here, value);
            }
    return result;
}

// Returns a two-dimensional picture of a volume, which is either one slice or the projection of the largest
// or smallest values.
struct Flat {
    int columns, rows;
    std::vector<float> values;

    double value(double x, double y) const
    {
        x = std::clamp(x, 0.0, columns - 1.0);
        y = std::clamp(y, 0.0, rows - 1.0);
        const int i = std::min(static_cast<int>(x), columns - 2), j = std::min(static_cast<int>(y), rows - 2);
        const double u = x - i, v = y - j;
        const auto at = [&](int a, int b) {
            return static_cast<double>(
                values[static_cast<std::size_t>(b) * static_cast<std::size_t>(columns) +
                       static_cast<std::size_t>(a)]);
        };
        return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) +
               v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
    }
};

Flat flat(const Volume &volume, int axis, int index, bool wants_largest)
{
    const int right = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
    Flat result{volume.size[at_axis(right)], volume.size[at_axis(down)], {}};
    if (index < 0) {
        result.values = extreme_along(volume, axis, wants_largest);
        return result;
    }
    for (int row = 0; row < result.rows; ++row)
        for (int column = 0; column < result.columns; ++column) {
            int at[3];
            at[right] = column;
            at[down] = row;
            at[axis] = index;
            result.values.push_back(volume.hu[volume.at(at[0], at[1], at[2])]);
        }
    return result;
}

int pixels(double voxels, double spacing_mm, double pixel_mm)
{
    return std::clamp(static_cast<int>(std::lround(voxels * spacing_mm / pixel_mm)), 8, 4000);
}

} // namespace

Picture::Picture(const Volume &volume, int axis, int index, double low_HU, double high_HU, double pixel_mm)
    : axis_(axis), index_(index), right_(axis == 0 ? 1 : 0), down_(axis == 2 ? 1 : 2),
      down_is_turned_(down_ == 2), pixel_mm_(pixel_mm),
      width_(pixels(volume.size[at_axis(right_)], volume.spacing_mm[right_], pixel_mm)),
      height_(pixels(volume.size[at_axis(down_)], volume.spacing_mm[down_], pixel_mm)),
      sheet_(width_, height_ + caption_height)
{
    grid_.size = volume.size;
    grid_.spacing_mm = volume.spacing_mm;
    grid_.origin_mm = volume.origin_mm;
    grid_.direction = volume.direction;
    const Flat values = flat(volume, axis, index, true);
    sheet_.box(0, height_, width_, height_ + caption_height, {0, 0, 0});
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const Eigen::Vector3d v = voxel(x, y);
            const double share = (values.value(v[right_], v[down_]) - low_HU) / (high_HU - low_HU);
            const auto grey = static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
            sheet_.blend(x, y, {grey, grey, grey}, 1);
        }
}

Eigen::Vector3d Picture::voxel(int x, int y) const
{
    Eigen::Vector3d v = Eigen::Vector3d::Constant(std::max(index_, 0));
    v[right_] = (x + 0.5) * pixel_mm_ / grid_.spacing_mm[right_] - 0.5;
    const double rows = (down_is_turned_ ? height_ - y - 0.5 : y + 0.5);
    v[down_] = rows * pixel_mm_ / grid_.spacing_mm[down_] - 0.5;
    return v;
}

SheetPoint Picture::place(const Eigen::Vector3d &voxel) const
{
    const double y = (voxel[down_] + 0.5) * grid_.spacing_mm[down_] / pixel_mm_;
    return {(voxel[right_] + 0.5) * grid_.spacing_mm[right_] / pixel_mm_, down_is_turned_ ? height_ - y : y};
}

void Picture::outline(const Volume &level, Ink ink)
{
    const Flat values = flat(level, axis_, index_, false);
    const auto inside = [&](int x, int y) {
        const Eigen::Vector3d v = voxel(x, y);
        return values.value(v[right_], v[down_]) < 0;
    };
    for (int y = 0; y + 1 < height_; ++y)
        for (int x = 0; x + 1 < width_; ++x)
            if (const bool here = inside(x, y); here != inside(x + 1, y) || here != inside(x, y + 1))
                sheet_.blend(x, y, ink, 1);
}

void Picture::line(const std::vector<Eigen::Vector3d> &scene_mm, Ink ink, double width)
{
    std::vector<SheetPoint> points;
    for (const Eigen::Vector3d &point : scene_mm) points.push_back(place(grid_.voxel(point)));
    sheet_.clip(0, 0, width_, height_);
    if (points.size() > 1) sheet_.stroke(points, width, ink);
    sheet_.unclip();
}

void Picture::dot(const Eigen::Vector3d &scene_mm, Ink ink, double width)
{
    const SheetPoint p = place(grid_.voxel(scene_mm));
    sheet_.stroke({p, {p.x + 0.01, p.y}}, width, ink);
}

void Picture::caption(const std::string &text, int row)
{
    const int y = row == 0 ? height_ + 4 : height_ - 10 * row;
    sheet_.text(4, y, text, 1, {235, 235, 235});
}

void Picture::save(const std::filesystem::path &file) const
{
    std::string error;
    if (!write_png(file.string(), sheet_.image(), error)) throw OutputError(error);
}

} // namespace crn::ct
