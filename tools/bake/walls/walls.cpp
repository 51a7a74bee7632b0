#include "shared/scene/scene_write.h"
#include "tools/bake/fault.hpp"
#include "tools/bake/plaque.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crn::bake
{
namespace
{

void put(std::vector<std::uint8_t> &bytes, double value)
{
    bytes.resize(bytes.size() + 4);
    crn_scene_put_u32(bytes.data() + bytes.size() - 4, static_cast<std::uint32_t>(std::lround(value)));
}

// A pressure that widens the radius r by dr stretches the wall by dr / r: with the distensibility D = dA / (A
// dp), dp = 2 dr / (r D). Two opposite lines that press with f per length stretch a ring as the pressure f /
// (2 r) does, so f = 4 dr / D. The core adds the forces of both
// lines, 2 f = 8 dr / D.
double radial_N_m2(const WallLawText &law)
{
    return law.distensibility_per_kPa == 0 ? 0 : 8e3 / law.distensibility_per_kPa;
}

void put_law(std::vector<std::uint8_t> &bytes, const WallLawText &law)
{
    put(bytes, law.bed_kPa * 1e3);
    put(bytes, radial_N_m2(law));
    put(bytes, law.relax_ms);
    put(bytes, law.carry_mm * 1e3);
    put(bytes, law.way_max_mm * 1e3);
    put(bytes, law.widen_max_mm * 1e3);
    put(bytes, 0);
    put(bytes, 0);
}

// A pattern is a name, or its beginning with a '*' behind it.
bool fits(const std::string &name, const std::string &pattern)
{
    if (pattern.back() != '*') return name == pattern;
    return name.compare(0, pattern.size() - 1, pattern, 0, pattern.size() - 1) == 0;
}

// Returns the number of the law of each branch.
std::vector<std::uint8_t> laws_of_branches(const WallsText &text, const VesselTree *tree)
{
    std::vector<std::uint8_t> laws(tree ? tree->branches.size() : 0, 1);
    for (std::size_t i = 0; i < text.branches.size(); ++i)
        for (const std::string &pattern : text.branches[i].names) {
            bool is_found = false;
            for (std::size_t b = 0; b < laws.size(); ++b)
                if (fits(tree->branches[b].name, pattern)) {
                    laws[b] = static_cast<std::uint8_t>(2 + i);
                    is_found = true;
                }
            if (!is_found)
                throw Fault(text.branches[i].place + "names the branch '" + pattern +
                            "', which the scene's tree does not have: correct the name, or give [tree]");
        }
    return laws;
}

// The nearest wall counts, not the nearest centreline: a brick beside a wide vessel belongs to it.
std::uint8_t law_near(const Eigen::Vector3d &place_m, const VesselTree &tree,
                      const std::vector<std::uint8_t> &laws)
{
    double least = std::numeric_limits<double>::infinity();
    std::uint8_t law = 1;
    for (std::size_t b = 0; b < laws.size(); ++b) {
        const VesselBranch &branch = tree.branches[b];
        for (std::size_t i = 0; i < branch.points_m.size(); ++i) {
            const double distance = (branch.points_m[i] - place_m).norm() - branch.radii_m[i];
            if (distance < least) least = distance, law = laws[b];
        }
    }
    return law;
}

// Whether a brick or one of its neighbours holds a part of the lumen: the tools look at no others.
bool is_near_lumen(const Field &field, long x, long y, long z)
{
    const auto *n = field.lumen.brick_count_xyz;
    for (long k = std::max(z - 1, 0L); k <= std::min<long>(z + 1, n[2] - 1L); ++k)
        for (long j = std::max(y - 1, 0L); j <= std::min<long>(y + 1, n[1] - 1L); ++j)
            for (long i = std::max(x - 1, 0L); i <= std::min<long>(x + 1, n[0] - 1L); ++i)
                if (field.index[static_cast<std::size_t>((k * n[1] + j) * n[0] + i)] !=
                    CRN_LUMEN_ENTRY_OUTSIDE)
                    return true;
    return false;
}

} // namespace

std::vector<std::uint8_t> walls_section(const WallsText &text, const Field &field, const VesselTree *tree)
{
    if (text.branches.size() + 1 > CRN_SCENE_WALL_LAW_MAX)
        throw Fault("[walls]: at most " + std::to_string(CRN_SCENE_WALL_LAW_MAX - 1) +
                    " [[walls.branch]]: join those with the same values");
    const std::vector<std::uint8_t> laws = laws_of_branches(text, tree);
    std::vector<std::uint8_t> bytes;
    put(bytes, static_cast<double>(text.branches.size() + 1));
    bytes.resize(CRN_SCENE_WALLS_HEADER_BYTES);
    put_law(bytes, text.everywhere);
    for (const WallBranchText &branch : text.branches) put_law(bytes, branch.law);
    const auto *n = field.lumen.brick_count_xyz;
    const auto *origin = field.lumen.origin_m_q30;
    for (long z = 0; z < long(n[2]); ++z)
        for (long y = 0; y < long(n[1]); ++y)
            for (long x = 0; x < long(n[0]); ++x) {
                const Eigen::Vector3d middle_mm =
                    Eigen::Vector3d(origin[0], origin[1], origin[2]) * mm_per_q30 +
                    brick0_mm * Eigen::Vector3d(double(x) + 0.5, double(y) + 0.5, double(z) + 0.5);
                const bool has_choice = !text.branches.empty() && is_near_lumen(field, x, y, z);
                bytes.push_back(has_choice ? law_near(middle_mm * 1e-3, *tree, laws) : 1);
            }
    return bytes;
}

} // namespace crn::bake
