// Merges scans of one phantom, each with the instrument at another depth, into one picture of the phantom.
#include "tools/lab/ct/lumen.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double noise_least_HU = 4;

// Estimates the standard deviation of noise and streaks, which varies over the volume. The volume's slices
// are divided into blocks. The estimate for a block follows from the median difference of voxel pairs two
// voxels apart. A wall covers too few voxels of a block to change the median.
class LocalNoise
{
  public:
    explicit LocalNoise(const Volume &volume) : volume_(volume)
    {
        columns_ = (volume.size[0] + side - 1) / side;
        rows_ = (volume.size[1] + side - 1) / side;
        std::vector<float> differences;
        for (int k = 0; k < volume.size[2]; ++k)
            for (int row = 0; row < rows_; ++row)
                for (int column = 0; column < columns_; ++column) {
                    differences.clear();
                    collect(column * side, row * side, k, differences);
                    sigma_.push_back(sigma_of(differences));
                }
    }

    // Interpolates the standard deviation between the middles of the nearest four blocks.
    double sigma_HU(int i, int j, int k) const
    {
        const double x = std::clamp((i + 0.5) / side - 0.5, 0.0, columns_ - 1.0),
                     y = std::clamp((j + 0.5) / side - 0.5, 0.0, rows_ - 1.0);
        const int a = std::min(static_cast<int>(x), std::max(columns_ - 2, 0)),
                  b = std::min(static_cast<int>(y), std::max(rows_ - 2, 0));
        const auto at = [&](int column, int row) {
            column = std::min(column, columns_ - 1), row = std::min(row, rows_ - 1);
            return static_cast<double>(
                sigma_[static_cast<std::size_t>((k * rows_ + row) * columns_ + column)]);
        };
        const double u = x - a, v = y - b;
        return (1 - v) * ((1 - u) * at(a, b) + u * at(a + 1, b)) +
               v * ((1 - u) * at(a, b + 1) + u * at(a + 1, b + 1));
    }

  private:
    static constexpr int side = 12; // voxels along one side of a block

    void collect(int first, int row, int k, std::vector<float> &differences) const
    {
        for (int j = row; j < std::min(row + side, volume_.size[1]); ++j)
            for (int i = first; i < std::min(first + side, volume_.size[0]); ++i) {
                const float here = volume_.hu[volume_.at(i, j, k)];
                if (i + 2 < volume_.size[0])
                    differences.push_back(std::abs(volume_.hu[volume_.at(i + 2, j, k)] - here));
                if (j + 2 < volume_.size[1])
                    differences.push_back(std::abs(volume_.hu[volume_.at(i, j + 2, k)] - here));
            }
    }
    static float sigma_of(std::vector<float> &differences)
    {
        if (differences.empty()) return 1e3f;
        const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
        std::nth_element(differences.begin(), middle, differences.end());
        return *middle / 0.954f; // median difference of normal deviates with a deviation of 1
    }

    const Volume &volume_;
    int columns_ = 0, rows_ = 0;
    std::vector<float> sigma_;
};

bool is_same_grid(const Volume &a, const Volume &b)
{
    return a.size == b.size && (a.spacing_mm - b.spacing_mm).norm() < 1e-6 &&
           (a.origin_mm - b.origin_mm).norm() < 1e-3 && (a.direction - b.direction).norm() < 1e-6;
}

// Returns the weight that a voxel of one scan has in the merged picture of the phantom; the weight is zero
// where the instrument hides the phantom.
double weight_of(double value, double away_mm, double sigma_HU, double masked_mm, double fluid)
{
    if (away_mm < masked_mm || (away_mm < streak_mm && (value > fluid + 280 || value < fluid - 180)))
        return 0;
    return 1 / (sigma_HU * sigma_HU + noise_least_HU * noise_least_HU);
}

void add_scan(const LumenScan &scan, Merged &merged, std::vector<float> &weights, double masked_mm,
              double fluid)
{
    const Volume &volume = *scan.volume, &grid = merged.filled;
    Volume distance = distance_volume(volume, scan.line, streak_mm);
    Volume hidden = scan.behind.empty() ? distance : distance_volume(volume, scan.behind, streak_mm);
    for (std::size_t i = 0; i < hidden.hu.size(); ++i) hidden.hu[i] = std::min(hidden.hu[i], distance.hu[i]);
    const LocalNoise noise(volume);
    const bool is_same = is_same_grid(volume, grid);
    const double low = fluid - 300, high = fluid + 400;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i) {
                const std::size_t at = grid.at(i, j, k);
                Vector3d voxel(i, j, k);
                if (!is_same) voxel = volume.voxel(grid.scene(voxel));
                const Eigen::Vector3i nearest = voxel.array().round().cast<int>();
                if (!volume.holds(nearest.x(), nearest.y(), nearest.z())) continue;
                const double value = is_same ? static_cast<double>(volume.hu[at]) : volume.value(voxel),
                             away = is_same ? static_cast<double>(hidden.hu[at]) : hidden.value(voxel);
                merged.distance.hu[at] =
                    std::min(merged.distance.hu[at],
                             is_same ? distance.hu[at] : static_cast<float>(distance.value(voxel)));
                const double weight = weight_of(
                    value, away, noise.sigma_HU(nearest.x(), nearest.y(), nearest.z()), masked_mm, fluid);
                merged.filled.hu[at] += static_cast<float>(weight * std::clamp(value, low, high));
                weights[at] += static_cast<float>(weight);
            }
}

} // namespace

Merged merge_scans(const std::vector<LumenScan> &scans, double masked_mm, double fluid_HU)
{
    const Volume &grid = *scans.front().volume;
    Merged merged{grid.like(0), grid.like(static_cast<float>(streak_mm)), grid.like(0)};
    std::vector<float> weights(grid.count(), 0.0f);
    for (const LumenScan &scan : scans) add_scan(scan, merged, weights, masked_mm, fluid_HU);
    std::vector<std::size_t> unseen;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] > 0) {
            merged.filled.hu[i] /= weights[i];
        } else {
            unseen.push_back(i);
            merged.hidden.hu[i] = 1;
        }
    }
    fill_in(merged.filled, unseen, fluid_HU);
    return merged;
}

Volume distance_volume(const Volume &grid, const std::vector<Vector3d> &line, double reach_mm)
{
    Volume result = grid.like(static_cast<float>(reach_mm));
    for (std::size_t p = 1; p < line.size(); ++p) {
        const std::vector<Vector3d> piece = {line[p - 1], line[p]};
        const Vector3d a = grid.voxel(line[p - 1]), b = grid.voxel(line[p]),
                       sides = Vector3d::Constant(reach_mm).cwiseQuotient(grid.spacing_mm);
        int low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(0, static_cast<int>(std::floor(std::min(a[axis], b[axis]) - sides[axis])));
            high[axis] = std::min(grid.size[static_cast<std::size_t>(axis)] - 1,
                                  static_cast<int>(std::ceil(std::max(a[axis], b[axis]) + sides[axis])));
        }
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    const double away =
                        distance_from(piece, grid.scene({double(i), double(j), double(k)})).distance_mm;
                    float &here = result.hu[grid.at(i, j, k)];
                    here = std::min(here, static_cast<float>(away));
                }
    }
    return result;
}

void fill_in(Volume &volume, const std::vector<std::size_t> &hidden, double start)
{
    for (const std::size_t at : hidden) volume.hu[at] = static_cast<float>(start);
    const Vector3d weight = volume.spacing_mm.cwiseProduct(volume.spacing_mm).cwiseInverse();
    const auto row = static_cast<std::size_t>(volume.size[0]),
               slice = row * static_cast<std::size_t>(volume.size[1]);
    for (int round = 0; round < 60; ++round)
        for (const std::size_t at : hidden) {
            const int i = static_cast<int>(at % row), j = static_cast<int>(at % slice / row),
                      k = static_cast<int>(at / slice);
            double values = 0, weights = 0;
            const auto look = [&](int a, int b, int c, double w) {
                if (!volume.holds(a, b, c)) return;
                values += w * static_cast<double>(volume.hu[volume.at(a, b, c)]);
                weights += w;
            };
            look(i - 1, j, k, weight[0]), look(i + 1, j, k, weight[0]), look(i, j - 1, k, weight[1]),
                look(i, j + 1, k, weight[1]), look(i, j, k - 1, weight[2]), look(i, j, k + 1, weight[2]);
            volume.hu[at] +=
                static_cast<float>(1.6 * (values / weights - static_cast<double>(volume.hu[at])));
        }
}

} // namespace crn::ct
