#include "tools/lab/ct/arteries/body.hpp"
#include "host/base/format.hpp"
#include "tools/lab/ct/arteries/scan_copy.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

constexpr double slice_max_mm = 5.0, stretch_min_mm = 80.0;
constexpr float tissue_HU = -300, metal_HU = 2500, blood_HU = 55;
constexpr double least_contrast_HU = 150;

bool is_along_axes(const Volume &scan)
{
    return scan.direction.diagonal().cwiseAbs().minCoeff() > 0.9998;
}

// Marks the pieces of bright voxels in the heart that are too large for calcium: undiluted medium in its
// right half. Their surroundings belong to them, because partial volume makes these brighter than blood.
void mark_pools(const Volume &scan, Mask heart, float bright_HU, Mask &marked)
{
    constexpr double pool_mm3 = 1000.0;
    enum : unsigned char { none, bright, tried, pool };
    for (std::size_t at = 0; at < heart.size(); ++at)
        heart[at] = heart[at] && scan.hu[at] > bright_HU ? bright : none;
    for (std::size_t at = 0; at < heart.size(); ++at) {
        if (heart[at] != bright) continue;
        const std::size_t count = flood(scan, heart, {at}, bright, tried);
        flood(scan, heart, {at}, tried,
              static_cast<double>(count) * scan.spacing_mm.prod() > pool_mm3 ? pool : none);
    }
    for (unsigned char &value : heart) value = value == pool;
    heart = grown(scan, std::move(heart), 2);
    for (std::size_t at = 0; at < heart.size(); ++at) marked[at] = marked[at] || heart[at];
}

} // namespace

Volume along_patient_axes(Volume volume)
{
    if (!is_along_axes(volume))
        throw Fault(
            volume.name +
            ": its slices are not axial, or are turned against the patient's axes by more than 1 degree: "
            "resample it along these axes (3D Slicer: Resample Scalar Volume)");
    const std::array<bool, 3> is_turned = {volume.direction(0, 0) < 0, volume.direction(1, 1) < 0,
                                           volume.direction(2, 2) < 0};
    if (!is_turned[0] && !is_turned[1] && !is_turned[2]) return volume;
    Volume result = volume.like(0);
    result.notes = volume.notes;
    const auto &[nx, ny, nz] = volume.size;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
                result.hu[result.at(is_turned[0] ? nx - 1 - i : i, is_turned[1] ? ny - 1 - j : j,
                                    is_turned[2] ? nz - 1 - k : k)] = volume.hu[volume.at(i, j, k)];
    result.origin_mm = volume.lps(
        {is_turned[0] ? nx - 1.0 : 0.0, is_turned[1] ? ny - 1.0 : 0.0, is_turned[2] ? nz - 1.0 : 0.0});
    for (int axis = 0; axis < 3; ++axis)
        if (is_turned[static_cast<std::size_t>(axis)]) result.direction.col(axis) *= -1.0;
    return result;
}

void check_scan(const Volume &scan, Findings &findings)
{
    const double slice_mm = scan.spacing_mm.maxCoeff();
    const std::string apart = formatted("%.2f mm", slice_mm);
    if (slice_mm > slice_max_mm)
        throw Fault(scan.name + ": its slices are " + apart + " apart, more than " +
                    formatted("%.0f mm", slice_max_mm) + ": reconstruct them thinner");
    const double stretch_mm = scan.spacing_mm[2] * scan.size[2];
    if (stretch_mm < stretch_min_mm)
        throw Fault(scan.name +
                    formatted(": it covers %.0f mm of the body, less than %.0f: give the whole series",
                              stretch_mm, stretch_min_mm));
    for (int axis = 0; axis < 3; ++axis)
        if (scan.size[static_cast<std::size_t>(axis)] > ct_size_max)
            throw Fault(scan.name +
                        formatted(": has %d voxels in a row, more than %d: cut it to the body, or "
                                  "reconstruct it with fewer pixels",
                                  scan.size[static_cast<std::size_t>(axis)], ct_size_max));
    std::size_t air = 0, tissue = 0, metal = 0;
    for (const float value : scan.hu) {
        air += value < -800;
        tissue += value > -200 && value < 300;
        metal += value > metal_HU;
    }
    const auto all = static_cast<double>(scan.count());
    if (static_cast<double>(air) < 0.01 * all || static_cast<double>(tissue) < 0.03 * all)
        throw Fault(scan.name +
                    formatted(": %.1f %% of its voxels have the HU of air and %.1f %% those of tissue: it is "
                              "no CT in Hounsfield units (an MR, or values without the rescale offset); "
                              "export it again in HU",
                              100.0 * static_cast<double>(air) / all,
                              100.0 * static_cast<double>(tissue) / all));
    findings.facts.push_back(formatted(
        "scan: %d x %d x %d voxels of %.3f x %.3f x %.3f mm, %.0f mm of the body", scan.size[0], scan.size[1],
        scan.size[2], scan.spacing_mm[0], scan.spacing_mm[1], scan.spacing_mm[2], stretch_mm));
    if (slice_mm > 2.0)
        findings.check.push_back("slices " + apart +
                                 " apart: arteries below 4 mm, and short stenoses, are not reliable");
    const double metal_ml = static_cast<double>(metal) * scan.spacing_mm.prod() * 1e-3;
    if (metal_ml > 0.5)
        findings.check.push_back(
            formatted("%.1f ml are brighter than %.0f HU (metal, or dense contrast medium): look for "
                      "streaks in the arteries",
                      metal_ml, static_cast<double>(metal_HU)));
}

void recentre(Volume &scan, Findings &findings)
{
    constexpr double far_mm = 1000;
    const Eigen::Vector3d last(scan.size[0] - 1.0, scan.size[1] - 1.0, scan.size[2] - 1.0);
    const double reach_mm =
        std::max(scan.lps({0, 0, 0}).cwiseAbs().maxCoeff(), scan.lps(last).cwiseAbs().maxCoeff());
    if (reach_mm <= far_mm) return;
    const Eigen::Vector3d middle = scan.lps(0.5 * last).array().round();
    scan.origin_mm -= middle;
    findings.assumed.push_back(formatted("the scan lies up to %.0f mm from its origin, so places are counted "
                                         "from its middle",
                                         reach_mm));
}

Mask body_of(const Volume &scan)
{
    enum : unsigned char { air, tissue, tried, body, outside };
    Mask mask(scan.count());
    for (std::size_t at = 0; at < mask.size(); ++at) mask[at] = scan.hu[at] > tissue_HU ? tissue : air;
    std::size_t largest = 0, start = 0;
    for (std::size_t at = 0; at < mask.size(); at += 7) { // a large piece is met by every seventh voxel
        if (mask[at] != tissue) continue;
        const std::size_t count = flood(scan, mask, {at}, tissue, tried);
        if (count > largest) largest = count, start = at;
    }
    if (largest == 0) throw Fault(scan.name + ": no tissue in it");
    flood(scan, mask, {start}, tried, body);
    for (unsigned char &value : mask)
        if (value != body) value = air;
    // What can be reached from the sides, the front and the back is outside. The ends are open: lungs and
    // bowel go on there.
    std::vector<std::size_t> border;
    for (int k = 0; k < scan.size[2]; ++k)
        for (int j = 0; j < scan.size[1]; ++j)
            for (int i = 0; i < scan.size[0]; ++i) {
                const bool is_side = i == 0 || j == 0 || i + 1 == scan.size[0] || j + 1 == scan.size[1];
                if (is_side && mask[scan.at(i, j, k)] == air) border.push_back(scan.at(i, j, k));
            }
    flood(scan, mask, std::move(border), air, outside);
    for (unsigned char &value : mask) value = value != outside;
    return mask;
}

Mask mask_of(const LabelMap &labels, const std::vector<int> &numbers)
{
    std::vector<unsigned char> is_wanted(65536, 0);
    for (const int number : numbers) is_wanted[static_cast<std::size_t>(number)] = 1;
    Mask mask(labels.volume.count());
    for (std::size_t at = 0; at < mask.size(); ++at)
        mask[at] =
            is_wanted[static_cast<std::size_t>(std::clamp(std::lround(labels.volume.hu[at]), 0l, 65535l))];
    return mask;
}

namespace
{

// The values of blood with medium and wall in `structure`, in any order.
Contrast contrast_of_values(std::vector<float> values, const LabelMap &labels, const std::string &structure,
                            const std::string &remedy, Findings &findings)
{
    if (values.size() < 100)
        throw Fault(labels.volume.name + ": the " + structure + " has " + std::to_string(values.size()) +
                    " voxels: " + remedy);
    std::sort(values.begin(), values.end());
    const auto share = [&](double part) {
        return static_cast<double>(
            values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))]);
    };
    // The wall is darker and calcium is brighter than blood, so the quartiles above the middle tell the
    // noise.
    Contrast contrast{share(0.5), std::max((share(0.75) - share(0.5)) / 0.674, 5.0)};
    findings.facts.push_back(formatted("%s: median %.0f HU, noise %.0f HU", structure.c_str(),
                                       contrast.mean_HU, contrast.noise_HU));
    if (contrast.mean_HU < least_contrast_HU)
        findings.check.push_back(
            formatted("the %s has %.0f HU, less than %.0f: no arterial contrast medium, so that the "
                      "lumen is only as good as the label map",
                      structure.c_str(), contrast.mean_HU, least_contrast_HU));
    return contrast;
}

} // namespace

Contrast contrast_in(const Volume &scan, const LabelMap &labels, Findings &findings)
{
    const Mask aorta =
        mask_of(labels, labels.numbers([](const std::string &name) { return name == "aorta"; }));
    std::vector<float> values;
    for (std::size_t at = 0; at < aorta.size(); ++at)
        if (aorta[at]) values.push_back(scan.hu[at]);
    return contrast_of_values(std::move(values), labels, "aorta", "the segmentation failed; segment again",
                              findings);
}

Contrast contrast_in_arteries(const Volume &scan, const LabelMap &labels, Findings &findings)
{
    const Mask arteries = mask_of(labels, labels.numbers(is_artery));
    std::vector<float> values;
    for (std::size_t at = 0; at < arteries.size(); ++at) {
        bool is_inside = arteries[at] != 0;
        if (is_inside)
            for_neighbours(scan, at, [&](std::size_t other) { is_inside = is_inside && arteries[other]; });
        if (is_inside) values.push_back(scan.hu[at]);
    }
    return contrast_of_values(std::move(values), labels, "artery",
                              "the click is in no artery; click into a wider one", findings);
}

CtVolume picture_volume(const Volume &scan, const Mask &body, const LabelMap &labels,
                        const Contrast &contrast, Findings &findings)
{
    // Partial volume makes the border of a vessel brighter than blood, one voxel beyond the label.
    const Mask filled = grown(scan, mask_of(labels, labels.numbers(may_hold_contrast)), 2);
    Mask vein = grown(scan, mask_of(labels, labels.numbers([](const std::string &name) {
                          return may_hold_contrast(name) && !is_artery(name) && name.find("heart") != 0;
                      })),
                      2);
    const auto calcium_HU = static_cast<float>(std::max(contrast.mean_HU + 4.0 * contrast.noise_HU, 300.0));
    mark_pools(
        scan,
        mask_of(labels, labels.numbers([](const std::string &name) { return name.find("heart") == 0; })),
        calcium_HU, vein);
    Volume shown = scan;
    double calcium_mm3 = 0.0;
    for (std::size_t at = 0; at < scan.count(); ++at) {
        float &value = shown.hu[at];
        if (!body[at]) {
            value = -1000;
            continue;
        }
        // Undiluted medium in the veins and in the right heart is brighter than calcium.
        if (vein[at] || (filled[at] && value <= calcium_HU))
            value = std::min(value, blood_HU);
        else if (filled[at])
            calcium_mm3 += scan.spacing_mm.prod();
    }
    findings.facts.push_back(
        formatted("brighter than %.0f HU within 2 voxels of vessels and heart (calcium, metal, bone "
                  "beside a vessel): %.1f ml; it stays in the picture",
                  static_cast<double>(calcium_HU), calcium_mm3 * 1e-3));
    findings.assumed.push_back(
        formatted("contrast medium up to %.0f HU in vessels and heart is replaced by blood (%.0f HU); "
                  "in kidneys, liver and other organs it stays",
                  static_cast<double>(calcium_HU), static_cast<double>(blood_HU)));
    return ct_of(shown);
}

} // namespace crn::ct
