#include "tools/lab/ct/review/section.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

int normal_of(Section section)
{
    return static_cast<int>(section); // 0: x, 1: y, 2: z
}

Eigen::Vector3d voxel_of(const CtVolume &volume, const Eigen::Vector3d &place_mm)
{
    return (place_mm - volume.first_mm).cwiseQuotient(volume.spacing_mm);
}

bool is_inside(const CtVolume &volume, const Eigen::Vector3d &voxel)
{
    for (int axis = 0; axis < 3; ++axis)
        if (!(voxel[axis] >= -0.5 && voxel[axis] <= volume.size[axis] - 0.5)) return false;
    return true;
}

double nearest(const CtVolume &volume, const Eigen::Vector3d &voxel)
{
    int at[3];
    for (int axis = 0; axis < 3; ++axis)
        at[axis] = std::clamp(static_cast<int>(std::lround(voxel[axis])), 0, volume.size[axis] - 1);
    return volume.permille[volume.index(at[0], at[1], at[2])];
}

double interpolated(const CtVolume &volume, const Eigen::Vector3d &voxel)
{
    int low[3];
    double share[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double at = std::clamp(voxel[axis], 0.0, volume.size[axis] - 1.0);
        low[axis] = std::min(static_cast<int>(at), volume.size[axis] - 2);
        share[axis] = at - low[axis];
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
        const double weight =
            (dx ? share[0] : 1 - share[0]) * (dy ? share[1] : 1 - share[1]) * (dz ? share[2] : 1 - share[2]);
        if (weight > 0) sum += weight * volume.permille[volume.index(low[0] + dx, low[1] + dy, low[2] + dz)];
    }
    return sum;
}

double extent_mm(const CtVolume &volume, Section section)
{
    double most = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (axis != normal_of(section)) most = std::max(most, volume.size[axis] * volume.spacing_mm[axis]);
    return most;
}

std::uint8_t grey_of(double permille, const GreyHU &grey)
{
    const double share = (permille - 1000 - grey.black) / std::max(grey.white - grey.black, 1.0);
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

// The brightest of the voxels that a ray along the normal meets.
struct Brightest {
    double permille = 0, depth_mm = 0;
};

Brightest brightest_on(const CtVolume &volume, Eigen::Vector3d voxel, int normal, int first, int last)
{
    Brightest found{-1, 0};
    for (int at = first; at <= last; ++at) {
        voxel[normal] = at;
        const double value = nearest(volume, voxel);
        if (value > found.permille) found = {value, volume.first_mm[normal] + at * volume.spacing_mm[normal]};
    }
    return found;
}

} // namespace

double permille_near(const CtVolume &volume, const Eigen::Vector3d &place_mm)
{
    return nearest(volume, voxel_of(volume, place_mm));
}

SectionAxes axes_of(Section section)
{
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                          z = Eigen::Vector3d::UnitZ();
    switch (section) {
    case Section::axial:
        return {x, z, y};
    case Section::coronal:
        return {x, y, z};
    default:
        return {-z, y, x};
    }
}

Eigen::Vector3d SectionPicture::place(double column, double row) const
{
    const SectionAxes axes = axes_of(section);
    const double half = 0.5 * edge_px;
    Eigen::Vector3d at = middle_mm + mm_per_px * ((column - half) * axes.right + (half - row) * axes.up);
    const int x = static_cast<int>(std::floor(column)), y = static_cast<int>(std::floor(row));
    if (x >= 0 && y >= 0 && x < edge_px && y < edge_px)
        at[normal_of(section)] = depth_mm[static_cast<std::size_t>(y) * static_cast<std::size_t>(edge_px) +
                                          static_cast<std::size_t>(x)];
    return at;
}

Eigen::Vector2d SectionPicture::pixel(const Eigen::Vector3d &place_mm) const
{
    const SectionAxes axes = axes_of(section);
    const Eigen::Vector3d offset = (place_mm - middle_mm) / mm_per_px;
    return {0.5 * edge_px + offset.dot(axes.right), 0.5 * edge_px - offset.dot(axes.up)};
}

SectionPicture section_of(const CtVolume &volume, Section section, const Eigen::Vector3d &centre_mm,
                          double slab_mm, const GreyHU &grey, int edge_px)
{
    const int normal = normal_of(section);
    const SectionAxes axes = axes_of(section);
    SectionPicture picture;
    picture.section = section;
    picture.edge_px = edge_px;
    picture.mm_per_px = extent_mm(volume, section) / edge_px;
    for (int axis = 0; axis < 3; ++axis)
        picture.middle_mm[axis] =
            volume.first_mm[axis] + 0.5 * (volume.size[axis] - 1) * volume.spacing_mm[axis];
    picture.middle_mm[normal] = centre_mm[normal];
    const double middle_voxel = voxel_of(volume, picture.middle_mm)[normal];
    const double half_voxels = 0.5 * slab_mm / volume.spacing_mm[normal];
    const int first =
        std::clamp(static_cast<int>(std::ceil(middle_voxel - half_voxels)), 0, volume.size[normal] - 1);
    const int last =
        std::clamp(static_cast<int>(std::floor(middle_voxel + half_voxels)), 0, volume.size[normal] - 1);
    const bool is_plane = slab_mm <= 0 || first >= last;
    const std::size_t count = static_cast<std::size_t>(edge_px) * static_cast<std::size_t>(edge_px);
    picture.grey.assign(count, 0);
    picture.depth_mm.assign(count, static_cast<float>(centre_mm[normal]));
    for (int row = 0; row < edge_px; ++row)
        for (int column = 0; column < edge_px; ++column) {
            const Eigen::Vector3d at =
                picture.middle_mm + picture.mm_per_px * ((column + 0.5 - 0.5 * edge_px) * axes.right +
                                                         (0.5 * edge_px - row - 0.5) * axes.up);
            const Eigen::Vector3d voxel = voxel_of(volume, at);
            Eigen::Vector3d in_plane = voxel;
            in_plane[normal] = 0;
            if (!is_inside(volume, is_plane ? voxel : in_plane)) continue;
            const Brightest found = is_plane ? Brightest{interpolated(volume, voxel), centre_mm[normal]}
                                             : brightest_on(volume, voxel, normal, first, last);
            const std::size_t index = static_cast<std::size_t>(row) * static_cast<std::size_t>(edge_px) +
                                      static_cast<std::size_t>(column);
            picture.grey[index] = grey_of(found.permille, grey);
            picture.depth_mm[index] = static_cast<float>(found.depth_mm);
        }
    return picture;
}

Outline outline_of(const bake::Mesh &surface, Section section, double at_mm)
{
    const int normal = normal_of(section);
    Outline outline;
    for (const bake::Triangle &triangle : surface.triangles) {
        std::array<Eigen::Vector3d, 2> crossings;
        std::size_t count = 0;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Eigen::Vector3d &a = surface.vertices_mm[triangle[corner]],
                                  &b = surface.vertices_mm[triangle[(corner + 1) % 3]];
            const double above = a[normal] - at_mm, below = b[normal] - at_mm;
            // A corner on the plane counts as above it, so a triangle has no crossing or two.
            if ((above < 0) != (below < 0)) crossings[count++] = a + above / (above - below) * (b - a);
        }
        if (count == 2) outline.emplace_back(crossings[0], crossings[1]);
    }
    return outline;
}

} // namespace crn::ct
