#include "tools/lab/validate/lumen_field.hpp"

#include "firmware/core/lumen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace crn::validate
{

// --- path ---

Path::Path(const Vector3d &start, const Vector3d &direction, const Vector3d &normal)
    : at_(start), direction_(direction.normalized()), normal_(normal.normalized()), low_(start), high_(start)
{
}

Vector3d Path::Piece::point(double arc_m) const
{
    if (radius_m == 0) return from + direction * arc_m;
    double angle = arc_m / radius_m;
    return from + radius_m * (direction * std::sin(angle) + normal * (1 - std::cos(angle)));
}

double Path::Piece::distance(const Vector3d &p) const
{
    if (radius_m == 0) {
        double along = std::clamp((p - from).dot(direction), 0.0, length_m);
        return (p - from - along * direction).norm();
    }
    Vector3d centre = from + radius_m * normal;
    Vector3d out = p - centre;
    double across = out.dot(direction.cross(normal));
    double x = out.dot(direction), y = -out.dot(normal);
    double angle = std::atan2(x, y); // 0 at the arc's start, growing along it
    double total = length_m / radius_m;
    if (angle < total - 2 * M_PI) angle += 2 * M_PI;
    if (angle >= 0 && angle <= total) return std::hypot(std::hypot(x, y) - radius_m, across);
    return std::min((p - from).norm(), (p - point(length_m)).norm());
}

void Path::add(const Piece &piece)
{
    for (int i = 0; i <= 64; i++) {
        Vector3d p = piece.point(piece.length_m * i / 64);
        low_ = low_.cwiseMin(p);
        high_ = high_.cwiseMax(p);
    }
    pieces_.push_back(piece);
    at_ = piece.point(piece.length_m);
    length_m_ += piece.length_m;
}

Path &Path::straight(double length_m)
{
    add({at_, direction_, normal_, length_m, 0});
    return *this;
}

Path &Path::bend(double radius_m, double angle_rad)
{
    add({at_, direction_, normal_, radius_m * angle_rad, radius_m});
    Vector3d ahead = direction_ * std::cos(angle_rad) + normal_ * std::sin(angle_rad);
    normal_ = normal_ * std::cos(angle_rad) - direction_ * std::sin(angle_rad);
    direction_ = ahead;
    return *this;
}

Path &Path::roll(double angle_rad)
{
    normal_ = Eigen::AngleAxisd(angle_rad, direction_) * normal_;
    return *this;
}

Vector3d Path::at(double arc_m) const
{
    std::size_t i = 0;
    while (i + 1 < pieces_.size() && arc_m > pieces_[i].length_m) arc_m -= pieces_[i++].length_m;
    return pieces_[i].point(arc_m);
}

double Path::distance(const Vector3d &point_m) const
{
    double least = INFINITY;
    for (const Piece &piece : pieces_) least = std::min(least, piece.distance(point_m));
    return least;
}

// --- field ---

struct LumenField::Storage {
    crn_lumen lumen{};
    std::vector<std::uint16_t> index, children;
    std::vector<std::int8_t> samples;
};

namespace
{

constexpr double voxel0_m = double(1 << CRN_LUMEN_VOXEL_LOG2_Q30) / (1 << 30);
constexpr double band_m = 0.0025;                 // beyond half the diagonal of a brick
constexpr int support = CRN_LUMEN_BRICK_EDGE + 4; // 10 coefficients and one sample on either side
constexpr double brick0_m = voxel0_m * int(CRN_LUMEN_BRICK_EDGE);

class Builder
{
  public:
    Builder(const Distance &distance, unsigned level, std::vector<std::uint16_t> &children,
            std::vector<std::int8_t> &samples)
        : distance_(distance), level_(level), children_(children), samples_(samples)
    {
    }

    // Returns the index entry for the cube of 8^3 voxels whose low corner is `corner`.
    std::uint16_t entry(const Vector3d &corner, unsigned level)
    {
        double voxel = voxel0_m / (1u << level);
        double d = distance_(corner + Vector3d::Constant(4 * voxel));
        double reach = 4 * voxel * std::sqrt(3.0) + band_m;
        if (d > reach) return CRN_LUMEN_ENTRY_OUTSIDE;
        if (d < -reach) return CRN_LUMEN_ENTRY_INSIDE;
        if (level == level_) return brick(corner, voxel);
        std::size_t row = children_.size() / 8;
        children_.resize(children_.size() + 8);
        if (row >= CRN_LUMEN_ENTRY_REFINED) throw std::runtime_error("lumen field: too many refined bricks");
        for (unsigned k = 0; k < 8; k++) {
            Vector3d octant(k & 1, k >> 1 & 1, k >> 2);
            std::uint16_t child = entry(corner + octant * 4 * voxel, level + 1);
            children_[row * 8 + k] = child;
        }
        return std::uint16_t(CRN_LUMEN_ENTRY_REFINED | row);
    }

    std::size_t bricks() const { return bricks_; }

  private:
    const Distance &distance_;
    unsigned level_;
    std::vector<std::uint16_t> &children_;
    std::vector<std::int8_t> &samples_;
    std::size_t bricks_ = 0;
    std::array<double, support * support * support> f_;

    double &at(int x, int y, int z) { return f_[std::size_t((z * support + y) * support + x)]; }

    // The spline's coefficients are c = f - (second differences) / 8 for the samples f, which is the
    // first-order inverse of the spline's own smoothing [1 6 1] / 8.
    std::uint16_t brick(const Vector3d &corner, double voxel)
    {
        for (int z = 0; z < support; z++) {
            for (int y = 0; y < support; y++) {
                for (int x = 0; x < support; x++) {
                    at(x, y, z) = distance_(corner + Vector3d(x - 1.5, y - 1.5, z - 1.5) * voxel) / voxel;
                }
            }
        }
        for (int z = 1; z < support - 1; z++) {
            for (int y = 1; y < support - 1; y++) {
                for (int x = 1; x < support - 1; x++) {
                    double around = at(x - 1, y, z) + at(x + 1, y, z) + at(x, y - 1, z) + at(x, y + 1, z) +
                                    at(x, y, z - 1) + at(x, y, z + 1);
                    double c = at(x, y, z) * 1.75 - around / 8;
                    samples_.push_back(std::int8_t(std::clamp(std::round(c * 32), -127.0, 127.0)));
                }
            }
        }
        if (bricks_ + CRN_LUMEN_ENTRY_FIRST_BRICK >= CRN_LUMEN_ENTRY_REFINED) {
            throw std::runtime_error("lumen field: too many bricks; use a lower level");
        }
        return std::uint16_t(CRN_LUMEN_ENTRY_FIRST_BRICK + bricks_++);
    }
};

} // namespace

LumenField::LumenField(const Distance &distance, const Vector3d &low, const Vector3d &high, unsigned level)
    : storage_(std::make_unique<Storage>())
{
    Storage &s = *storage_;
    Vector3d corner;
    for (int k = 0; k < 3; k++) {
        corner[k] = std::floor((low[k] - 0.003) / brick0_m) * brick0_m;
        s.lumen.origin_m_q30[k] = std::int32_t(std::lround(corner[k] * (1 << 30)));
        s.lumen.brick_count_xyz[k] = std::uint32_t(std::ceil((high[k] + 0.003 - corner[k]) / brick0_m));
    }
    const std::uint32_t *n = s.lumen.brick_count_xyz;
    Builder builder(distance, level, s.children, s.samples);
    s.index.reserve(std::size_t(n[0]) * n[1] * n[2]);
    for (std::uint32_t z = 0; z < n[2]; z++) {
        for (std::uint32_t y = 0; y < n[1]; y++) {
            for (std::uint32_t x = 0; x < n[0]; x++) {
                s.index.push_back(builder.entry(corner + Vector3d(x, y, z) * brick0_m, 0));
            }
        }
    }
    s.lumen.index = s.index.data();
    s.lumen.children = s.children.data();
    s.lumen.samples = s.samples.data();
    s.lumen.child_row_count = std::uint16_t(s.children.size() / 8);
    s.lumen.brick_count = std::uint32_t(builder.bricks());
}

LumenField::~LumenField() = default;
LumenField::LumenField(LumenField &&) noexcept = default;

const crn_lumen *LumenField::lumen() const
{
    return &storage_->lumen;
}

LumenField tube_field(const Path &path, double radius_m, unsigned level, bool flat_end)
{
    Vector3d end = path.end(), ahead = path.end_direction();
    Distance distance = [&](const Vector3d &p) {
        double tube = path.distance(p) - radius_m;
        return flat_end ? std::max(tube, (p - end).dot(ahead)) : tube;
    };
    Vector3d margin = Vector3d::Constant(radius_m);
    return LumenField(distance, path.low() - margin, path.high() + margin, level);
}

} // namespace crn::validate
