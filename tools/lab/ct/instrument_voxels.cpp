// Selects the instrument's voxels: bright voxels that are connected over a greater length than any streak of
// the picture.
#include "host/base/format.hpp"
#include "tools/lab/ct/centreline.hpp"
#include "tools/mesh/fault.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double brightest_least_HU =
    800; // metal and marked polymer are brighter; silicone and the streaks in it are not
constexpr double length_least_mm = 12; // least length of an instrument in the picture
constexpr double gap_mm = 6;           // pieces whose ends are this close together are one instrument

struct Piece {
    std::vector<std::size_t> voxels;
    Eigen::AlignedBox3d box; // in the scene's axes
    double length_mm() const { return box.sizes().norm(); }
};

std::string place_text(const Vector3d &p)
{
    return formatted("(%.0f, %.0f, %.0f) mm", p.x(), p.y(), p.z());
}

std::array<int, 3> index_of(const Volume &volume, std::size_t at)
{
    const auto row = static_cast<std::size_t>(volume.size[0]),
               slice = row * static_cast<std::size_t>(volume.size[1]);
    return {static_cast<int>(at % row), static_cast<int>(at % slice / row), static_cast<int>(at / slice)};
}

Vector3d place_of(const Volume &volume, std::size_t at)
{
    const std::array<int, 3> index = index_of(volume, at);
    return volume.scene({double(index[0]), double(index[1]), double(index[2])});
}

// Returns the groups of connected voxels above the threshold, and lists the longest group first.
std::vector<Piece> pieces_above(const Volume &volume, double threshold)
{
    std::vector<Piece> pieces;
    std::vector<bool> seen(volume.count(), false);
    std::vector<std::size_t> open;
    for (std::size_t start = 0; start < volume.count(); ++start) {
        if (seen[start] || static_cast<double>(volume.hu[start]) < threshold) continue;
        Piece piece;
        seen[start] = true;
        open.assign(1, start);
        while (!open.empty()) {
            const std::size_t at = open.back();
            open.pop_back();
            piece.voxels.push_back(at);
            piece.box.extend(place_of(volume, at));
            const std::array<int, 3> c = index_of(volume, at);
            for (int k = c[2] - 1; k <= c[2] + 1; ++k)
                for (int j = c[1] - 1; j <= c[1] + 1; ++j)
                    for (int i = c[0] - 1; i <= c[0] + 1; ++i) {
                        if (!volume.holds(i, j, k)) continue;
                        const std::size_t next = volume.at(i, j, k);
                        if (seen[next] || static_cast<double>(volume.hu[next]) < threshold) continue;
                        seen[next] = true;
                        open.push_back(next);
                    }
        }
        if (piece.voxels.size() >= 4) pieces.push_back(std::move(piece));
    }
    std::stable_sort(pieces.begin(), pieces.end(),
                     [](const Piece &a, const Piece &b) { return a.length_mm() > b.length_mm(); });
    return pieces;
}

double gap_between(const Volume &volume, const Piece &a, const Piece &b)
{
    double least = 1e9;
    if (a.box.exteriorDistance(b.box.center()) > gap_mm + b.length_mm()) return least;
    for (const std::size_t p : b.voxels) {
        const Vector3d place = place_of(volume, p);
        for (const std::size_t q : a.voxels)
            least = std::min(least, (place - place_of(volume, q)).squaredNorm());
    }
    return std::sqrt(least);
}

[[noreturn]] void refuse_none(const Volume &volume, double brightest)
{
    const std::string text =
        formatted(": no instrument in the scan: its brightest voxel has %.0f HU, metal and marked polymer "
                  "have over %.0f",
                  brightest, brightest_least_HU);
    throw Fault(volume.name + text +
                "; scan with the instrument in place, or give --threshold if it is a faint one");
}

} // namespace

Volume find_instrument(const Volume &volume, LineOptions &options)
{
    const double brightest = static_cast<double>(*std::max_element(volume.hu.begin(), volume.hu.end()));
    if (options.threshold_HU <= 0) {
        if (brightest < brightest_least_HU) refuse_none(volume, brightest);
        options.threshold_HU = 0.5 * brightest;
    }
    std::vector<Piece> pieces = pieces_above(volume, options.threshold_HU);
    if (pieces.empty() || pieces.front().length_mm() < length_least_mm) refuse_none(volume, brightest);
    std::size_t chosen = 0;
    if (options.seed_mm) {
        double nearest = 1e9;
        for (std::size_t i = 0; i < pieces.size(); ++i)
            for (const std::size_t at : pieces[i].voxels)
                if (const double away = (place_of(volume, at) - *options.seed_mm).norm(); away < nearest) {
                    nearest = away;
                    chosen = i;
                }
        if (nearest > 5)
            throw Fault(volume.name + ": nothing bright within 5 mm of the seed " +
                        place_text(*options.seed_mm) +
                        ": give a place on the instrument (scene's axes, mm), or a lower --threshold");
    }
    std::swap(pieces[0], pieces[chosen]);
    Piece whole = pieces[0];
    // A group of voxels that continues the instrument is part of the instrument; an equally long group
    // elsewhere is another instrument.
    std::vector<bool> joined(pieces.size(), false);
    for (bool changes = true; changes;) {
        changes = false;
        for (std::size_t i = 1; i < pieces.size(); ++i) {
            if (joined[i] || gap_between(volume, whole, pieces[i]) > gap_mm) continue;
            joined[i] = changes = true;
            whole.voxels.insert(whole.voxels.end(), pieces[i].voxels.begin(), pieces[i].voxels.end());
            whole.box.extend(pieces[i].box);
        }
    }
    for (std::size_t i = 1; i < pieces.size() && !options.seed_mm; ++i)
        if (!joined[i] && pieces[i].length_mm() > length_least_mm)
            throw Fault(volume.name + ": two instruments: one around " + place_text(whole.box.center()) +
                        ", one around " + place_text(pieces[i].box.center()) +
                        "; scan one alone, or choose by --seed");
    Volume mask = volume.like(0);
    for (const std::size_t at : whole.voxels) mask.hu[at] = 1;
    return mask;
}

} // namespace crn::ct
