// Reads a scene file and evaluates the lumen's distance field in it. At the fraction u of a voxel, the
// weights of the spline are (1-u)^2/2, 1/2 + u - u^2 and u^2/2. The first derivatives of the spline's weights
// at the fraction u are -(1-u), 1-2u and u; the second derivatives are 1, -2 and 1.
#include "tools/lab/vcsim3/lumen.hpp"
#include "shared/scene/scene.h"
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace vcsim3
{
namespace
{

constexpr double far_m = 0.015625;
constexpr double voxel_m = 1.0 / (1 << (30 - CRN_LUMEN_VOXEL_LOG2_Q30));
constexpr double brick_m = static_cast<int>(CRN_LUMEN_BRICK_EDGE) * voxel_m;
constexpr double bends[3] = {1.0, -2.0, 1.0};
constexpr int row = 10, slice = 100; // number of coefficients along x, and in a plane

double metres(std::int32_t q30)
{
    return std::ldexp(q30, -30);
}

std::vector<std::uint8_t> read_bytes(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw std::runtime_error(path +
                                 ": cannot be read; `make thesis` makes out/phantom.scene, or give --scene");
    return {std::istreambuf_iterator<char>(file), {}};
}

// Returns the index entry of the brick (block of voxels) that contains a point; `place` receives the point in
// voxels of that brick's refinement level.
std::uint32_t find_entry(const crn_lumen &lumen, Eigen::Array3d &place, int &level)
{
    Eigen::Array3i cell = place.floor().cast<int>();
    const std::uint32_t *count = lumen.brick_count_xyz;
    for (int k = 0; k < 3; k++)
        if (cell[k] < 0 || cell[k] >= static_cast<int>(count[k])) return CRN_LUMEN_ENTRY_OUTSIDE;
    std::uint32_t entry =
        lumen.index[(static_cast<std::size_t>(cell[2]) * count[1] + cell[1]) * count[0] + cell[0]];
    place -= cell.cast<double>();
    for (level = 0; (entry & CRN_LUMEN_ENTRY_REFINED) != 0; level++) {
        place *= 2.0;
        cell = place.floor().cast<int>().min(1);
        place -= cell.cast<double>();
        entry = lumen.children[(entry - CRN_LUMEN_ENTRY_REFINED) * 8 + cell[0] + 2 * cell[1] + 4 * cell[2]];
    }
    place *= static_cast<double>(CRN_LUMEN_BRICK_EDGE);
    return entry;
}

struct Weights {
    double value[3], slope[3];
    explicit Weights(double u)
        : value{0.5 * (1 - u) * (1 - u), 0.5 + u - u * u, 0.5 * u * u}, slope{u - 1, 1 - 2 * u, u}
    {
    }
};

// Holds the sum over one row of spline coefficients along x: value, first derivative and second derivative.
struct Line {
    double value, slope, bend;
};

Line along_x(const std::int8_t *taps, const Weights &x)
{
    return {taps[0] * x.value[0] + taps[1] * x.value[1] + taps[2] * x.value[2],
            taps[0] * x.slope[0] + taps[1] * x.slope[1] + taps[2] * x.slope[2],
            static_cast<double>(taps[0] - 2 * taps[1] + taps[2])};
}

template <bool with_second> LumenField evaluate(const crn_lumen &lumen, const Vector &position_m)
{
    Eigen::Array3d place;
    for (int k = 0; k < 3; k++) place[k] = (position_m[k] - metres(lumen.origin_m_q30[k])) / brick_m;
    int level = 0;
    const std::uint32_t entry = find_entry(lumen, place, level);
    LumenField field;
    field.distance_m = entry == CRN_LUMEN_ENTRY_INSIDE ? -far_m : far_m;
    if (entry < CRN_LUMEN_ENTRY_FIRST_BRICK) return field;

    const Eigen::Array3i cell = place.floor().cast<int>().min(CRN_LUMEN_BRICK_EDGE - 1);
    const Weights x(place[0] - cell[0]), y(place[1] - cell[1]), z(place[2] - cell[2]);
    const std::int8_t *c =
        lumen.samples +
        static_cast<std::size_t>(entry - CRN_LUMEN_ENTRY_FIRST_BRICK) * CRN_LUMEN_BRICK_SAMPLES +
        cell[2] * slice + cell[1] * row + cell[0];
    double value = 0.0;
    Vector slope = Vector::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 3; k++) {
        for (int j = 0; j < 3; j++) {
            const Line line = along_x(c + k * slice + j * row, x);
            value += line.value * y.value[j] * z.value[k];
            slope.y() += line.value * y.slope[j] * z.value[k];
            slope.z() += line.value * y.value[j] * z.slope[k];
            slope.x() += line.slope * y.value[j] * z.value[k];
            if constexpr (with_second) {
                second(0, 0) += line.bend * y.value[j] * z.value[k];
                second(1, 1) += line.value * bends[j] * z.value[k];
                second(2, 2) += line.value * y.value[j] * bends[k];
                second(0, 1) += line.slope * y.slope[j] * z.value[k];
                second(0, 2) += line.slope * y.value[j] * z.slope[k];
                second(1, 2) += line.value * y.slope[j] * z.slope[k];
            }
        }
    }
    field.distance_m = std::ldexp(value * voxel_m / 32.0, -level);
    field.gradient = slope / 32.0;
    if constexpr (with_second) {
        second(1, 0) = second(0, 1);
        second(2, 0) = second(0, 2);
        second(2, 1) = second(1, 2);
        field.second_per_m = second * std::ldexp(1.0 / (32.0 * voxel_m), level);
    }
    return field;
}

} // namespace

LumenSample sample_lumen(const crn_lumen &lumen, const Vector &position_m)
{
    const LumenField field = evaluate<false>(lumen, position_m);
    LumenSample sample;
    sample.distance_m = field.distance_m;
    const double steepness = field.gradient.norm();
    if (steepness > 1e-9 / 32.0) sample.inward = -field.gradient / steepness;
    return sample;
}

LumenField lumen_field(const crn_lumen &lumen, const Vector &position_m)
{
    return evaluate<true>(lumen, position_m);
}

Vessel::Vessel(const std::string &path) : bytes_(read_bytes(path))
{
    crn_scene scene;
    std::uint32_t where_byte = 0;
    crn_scene_status status = crn_scene_open(bytes_.data(), bytes_.size(), &scene, &where_byte);
    if (status == CRN_SCENE_OK && scene.kind != CRN_SCENE_KIND_SCENE) status = CRN_SCENE_KIND;
    if (status != CRN_SCENE_OK)
        throw std::runtime_error(path + ": is no usable scene: " + crn_scene_status_text(status) +
                                 " (at byte " + std::to_string(where_byte) + ")");
    const crn_scene_lumen &given = scene.lumen;
    for (int k = 0; k < 3; k++) {
        lumen_.origin_m_q30[k] = given.origin_m_q30[k];
        lumen_.brick_count_xyz[k] = given.brick_count_xyz[k];
        mouth_m_[k] = metres(scene.entry_position_m_q30[k]);
        direction_[k] = metres(scene.entry_direction_q30[k]);
    }
    lumen_.child_row_count = given.child_row_count;
    lumen_.brick_count = given.brick_count;
    lumen_.index = given.index;
    lumen_.children = given.children;
    lumen_.samples = given.samples;
    direction_.normalize();
    name_ = scene.name;
}

Vessel::Vessel(const crn_lumen &lumen, const Vector &mouth_m, const Vector &direction)
    : lumen_(lumen), mouth_m_(mouth_m), direction_(direction.normalized()), name_("lumen in memory")
{
}

LumenSample Vessel::sample(const Vector &position_m) const
{
    return sample_lumen(lumen_, position_m);
}

Vector Vessel::low_m() const
{
    return {metres(lumen_.origin_m_q30[0]), metres(lumen_.origin_m_q30[1]), metres(lumen_.origin_m_q30[2])};
}

Vector Vessel::high_m() const
{
    const std::uint32_t *count = lumen_.brick_count_xyz;
    return low_m() + brick_m * Vector(count[0], count[1], count[2]);
}

} // namespace vcsim3
