// Tests the steps from a patient's CT to a scene with a virtual CTA whose truth is known: an aorta that
// divides into two iliac arteries, in a body on a table. The scan has partial volume, a scanner's blur and
// noise.
#include "host/base/tests/folder.hpp"
#include "tools/lab/ct/patient/vessels.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include "tools/mesh/fault.hpp"
#include "tools/patient/entry.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <fstream>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::ct;
using Eigen::Vector3d;

namespace
{

constexpr int aorta = 52, iliac_left = 65, iliac_right = 66, heart = 51;
constexpr double aorta_mm = 9.0, iliac_mm = 5.0, lumen_HU = 350, noise_HU = 20;

// The true distance to the wall of the arteries in the scene's axes, negative inside, and the artery's
// number.
struct Wall {
    double distance_mm;
    int label;
};

Wall wall_at(const Vector3d &p)
{
    using centreline::tapered_capsule_distance;
    const Wall walls[] = {
        {tapered_capsule_distance(p, {0, 70, -10}, aorta_mm, {0, -10, -10}, aorta_mm), aorta},
        {tapered_capsule_distance(p, {0, -10, -10}, iliac_mm, {30, -70, 0}, iliac_mm), iliac_left},
        {tapered_capsule_distance(p, {0, -10, -10}, iliac_mm, {-30, -70, 0}, iliac_mm), iliac_right}};
    return *std::min_element(std::begin(walls), std::end(walls),
                             [](const Wall &a, const Wall &b) { return a.distance_mm < b.distance_mm; });
}

double density_at(const Vector3d &p)
{
    if (wall_at(p).distance_mm < 0) return lumen_HU;
    if (std::hypot(p.x() / 70, p.z() / 50) < 1) return 45;
    return p.z() < -58 && p.z() > -64 ? 100 : -1000; // a table behind the back
}

struct Cta {
    Volume scan;
    LabelMap labels;
};

// Voxels of 0.9 x 0.9 x 1.5 mm, with the mean of 8 points each. The label map is that of the voxels' middles.
const Cta &cta()
{
    static const Cta made = [] {
        Cta of;
        of.scan.size = {180, 150, 92};
        of.scan.spacing_mm = {0.9, 0.9, 1.5};
        of.scan.origin_mm = {-80.5, -67.0, -68.0};
        of.scan.name = "virtual CTA";
        of.scan.hu.resize(of.scan.count());
        of.labels.volume = of.scan.like(0);
        of.labels.names = {{aorta, "aorta"},
                           {iliac_left, "iliac_artery_left"},
                           {iliac_right, "iliac_artery_right"},
                           {heart, "heart"}};
        std::uint32_t state = 1;
        for (int k = 0; k < of.scan.size[2]; ++k)
            for (int j = 0; j < of.scan.size[1]; ++j)
                for (int i = 0; i < of.scan.size[0]; ++i) {
                    const Vector3d middle = of.scan.scene({1.0 * i, 1.0 * j, 1.0 * k});
                    const Wall wall = wall_at(middle);
                    double sum = 0, lot = 0;
                    if (std::fabs(wall.distance_mm) > 2.5 && std::fabs(middle.z()) < 20 &&
                        std::fabs(middle.x()) < 50)
                        sum = 8 * (wall.distance_mm < 0 ? lumen_HU : 45.0);
                    else
                        for (int part = 0; part < 8; ++part)
                            sum += density_at(
                                of.scan.scene({i + (part & 1 ? 0.4 : -0.4), j + (part & 2 ? 0.4 : -0.4),
                                               k + (part & 4 ? 0.4 : -0.4)}));
                    for (int n = 0; n < 4; ++n) {
                        state = state * 1664525u + 1013904223u;
                        lot += (state >> 8) / 16777216.0 - 0.5;
                    }
                    of.scan.hu[of.scan.at(i, j, k)] =
                        static_cast<float>(sum / 8 + lot * noise_HU * std::sqrt(3.0));
                    if (wall.distance_mm < 0)
                        of.labels.volume.hu[of.scan.at(i, j, k)] = static_cast<float>(wall.label);
                    if (wall.distance_mm >= 0 && middle.y() > 60 &&
                        std::hypot(middle.x(), middle.z() - 10) < 15)
                        of.labels.volume.hu[of.scan.at(i, j, k)] = heart;
                }
        return of;
    }();
    return made;
}

std::string refusal(const Volume &scan)
{
    Findings findings;
    try {
        check_scan(scan, findings);
    } catch (const Fault &fault) {
        return fault.what();
    }
    return "";
}

void assert_names(const std::string &message, const char *part)
{
    if (message.find(part) == std::string::npos) fail_msg("'%s' does not name '%s'", message.c_str(), part);
}

const Report quiet = [](const std::string &, double) {};

} // namespace

static void the_lumen_tree_and_entry_are_those_of_the_truth(void **)
{
    const Cta &of = cta();
    Findings findings;
    const Contrast contrast = contrast_in(of.scan, of.labels, findings);
    assert_true(std::fabs(contrast.mean_HU - lumen_HU) < 10);
    const bake::Mesh lumen = lumen_of(artery_level(of.scan, of.labels, contrast, quiet));
    double sum = 0, most = 0;
    for (const Vector3d &vertex : lumen.vertices_mm) {
        if (std::fabs(vertex.y()) > 60) continue; // the ends of the scan
        sum += std::fabs(wall_at(vertex).distance_mm);
        most = std::max(most, std::fabs(wall_at(vertex).distance_mm));
    }
    const double mean_mm = sum / static_cast<double>(lumen.vertices_mm.size());
    std::printf("# lumen against truth: mean %.3f mm, most %.2f mm\n", mean_mm, most);
    assert_true(mean_mm < 0.25); // three times the measured error, as below
    const centreline::Tree tree = tree_of(lumen, of.labels, root_of(of.labels), findings);
    double line_mm = 0, radius_share = 0, count = 0;
    for (const centreline::Branch &branch : tree.branches)
        for (const centreline::Sphere &sphere : branch.spheres) {
            const Vector3d &p = sphere.centre_mm;
            if (std::fabs(p.y() + 10) < 25 || std::fabs(p.y()) > 55) continue; // the fork, and the ends
            const bool is_aorta = p.y() > -10;
            const double radius_mm = is_aorta ? aorta_mm : iliac_mm;
            line_mm += std::fabs(wall_at(p).distance_mm + radius_mm);
            radius_share += std::fabs(sphere.radius_mm / radius_mm - 1);
            count += 1;
        }
    std::printf("# %.0f spheres: centreline off by %.3f mm, radius by %.2f %%\n", count, line_mm / count,
                100 * radius_share / count);
    assert_true(count > 10);
    assert_true(line_mm / count < 0.1); // the goal is 0.3 mm
    assert_true(radius_share / count < 0.04);
    std::vector<std::string> names;
    for (const centreline::Branch &branch : tree.branches) names.push_back(branch.name);
    std::sort(names.begin(), names.end());
    for (const std::string &name : names) std::printf("# branch %s\n", name.c_str());
    // The aorta may be cut in two where the iliac arteries leave it one after the other.
    for (const char *name : {"aorta", "iliac_artery_left", "iliac_artery_right"})
        assert_true(std::count(names.begin(), names.end(), name) == 1);
    assert_string_equal(tree.branches.front().name.c_str(), "aorta");
    assert_true(tree.branches.front().spheres.front().centre_mm.y() > 50);
    const patient::Entry entry = patient::inside_end(tree, patient::low_end(tree));
    assert_true(entry.place_mm.y() < -40 && entry.direction.y() > 0.5);
    assert_true(wall_at(entry.place_mm).distance_mm < -3);
}

static void the_picture_has_no_table_and_no_contrast_medium(void **)
{
    const Cta &of = cta();
    Findings findings;
    const CtVolume ct = picture_volume(of.scan, body_of(of.scan), of.labels, {lumen_HU, noise_HU}, findings);
    std::string error;
    assert_true(check_ct_volume(ct, error));
    const auto at = [&](const Vector3d &p) {
        const Vector3d voxel = (p - ct.first_mm).cwiseQuotient(ct.spacing_mm);
        return int{ct.permille[ct.index(int(std::lround(voxel.x())), int(std::lround(voxel.y())),
                                        int(std::lround(voxel.z())))]};
    };
    assert_int_equal(at({0, 0, -61}), 0);           // the table
    assert_in_range(at({0, 40, -10}), 1000, 1056);  // the aorta
    assert_in_range(at({25, -60, -2}), 1000, 1056); // the left iliac artery
    assert_in_range(at({40, 0, 0}), 960, 1130);     // the body to the left
    assert_in_range(at({-40, 40, 0}), 960, 1130);
}

static void undiluted_medium_in_the_heart_becomes_blood_and_calcium_stays(void **)
{
    // A ball of 8 mm radius (2 ml) with 1200 HU and a speck of calcium in a heart of 25 mm radius.
    Volume scan = cta().scan.like(-1000);
    LabelMap labels{scan.like(0), {{heart, "heart"}, {aorta, "aorta"}}};
    for (int k = 0; k < scan.size[2]; ++k)
        for (int j = 0; j < scan.size[1]; ++j)
            for (int i = 0; i < scan.size[0]; ++i) {
                const Vector3d at = scan.scene({1.0 * i, 1.0 * j, 1.0 * k});
                const bool is_pool = (at - Vector3d(0, -10, 0)).norm() < 8,
                           is_speck = (at - Vector3d(0, 12, 0)).norm() < 2;
                float &value = scan.hu[scan.at(i, j, k)];
                if (std::hypot(at.x() / 70, at.z() / 50) < 1) value = is_pool || is_speck ? 1200.0f : 45.0f;
                if (at.norm() < 25) labels.volume.hu[scan.at(i, j, k)] = heart;
            }
    Findings findings;
    const CtVolume ct = picture_volume(scan, body_of(scan), labels, {lumen_HU, noise_HU}, findings);
    const auto at = [&](const Vector3d &p) {
        const Vector3d voxel = (p - ct.first_mm).cwiseQuotient(ct.spacing_mm);
        return int{ct.permille[ct.index(int(std::lround(voxel.x())), int(std::lround(voxel.y())),
                                        int(std::lround(voxel.z())))]};
    };
    assert_int_equal(at({0, -10, 0}), 1055);
    assert_int_equal(at({0, 12, 0}), 2200);
}

static void scans_that_cannot_serve_are_named(void **)
{
    Volume scan = cta().scan;
    assert_string_equal(refusal(scan).c_str(), "");
    scan.spacing_mm[2] = 6;
    assert_names(refusal(scan), "reconstruct them thinner");
    scan.spacing_mm[2] = 0.5;
    assert_names(refusal(scan), "give the whole series");
    scan.spacing_mm[2] = 1.5;
    for (float &value : scan.hu) value += 1024;
    assert_names(refusal(scan), "no CT in Hounsfield units");
}

static void every_order_of_voxels_becomes_that_of_the_patient(void **)
{
    Volume turned = cta().scan.like(0);
    for (std::size_t at = 0; at < turned.count(); ++at) turned.hu[at] = static_cast<float>(at % 1999);
    turned.direction = Vector3d(-1, 1, -1).asDiagonal();
    const Volume back = along_patient_axes(turned);
    assert_true(back.direction == Eigen::Matrix3d::Identity());
    for (const std::array<int, 3> &at :
         {std::array{3, 4, 5}, std::array{179, 0, 91}, std::array{90, 149, 1}}) {
        const Vector3d voxel = back.voxel(turned.scene({1.0 * at[0], 1.0 * at[1], 1.0 * at[2]}));
        const float value = back.hu[back.at(int(std::lround(voxel.x())), int(std::lround(voxel.y())),
                                            int(std::lround(voxel.z())))];
        assert_true(value == turned.hu[turned.at(at[0], at[1], at[2])]);
    }
    turned.direction << std::cos(0.2), -std::sin(0.2), 0, std::sin(0.2), std::cos(0.2), 0, 0, 0, 1;
    std::string refused;
    try {
        along_patient_axes(turned);
    } catch (const Fault &fault) {
        refused = fault.what();
    }
    assert_names(refused, "resample it");
}

static void arteries_that_vanish_are_named(void **)
{
    std::string refused;
    try {
        lumen_of(cta().scan.like(1)); // outside everywhere
    } catch (const Fault &fault) {
        refused = fault.what();
    }
    assert_names(refused, "no lumen remains");
}

static void a_label_map_needs_the_scans_grid_names_and_an_aorta(void **)
{
    const tests::Folder folder("patient");
    const std::filesystem::path map = folder.file("map.nrrd"), table = folder.file("names.csv");
    write_volume(cta().labels.volume, map);
    const auto read_with = [&](const std::string &names, const Volume &scan) -> std::string {
        std::ofstream(table) << names;
        try {
            return std::to_string(read_labels(map, table, scan).names.size());
        } catch (const Fault &fault) {
            return fault.what();
        }
    };
    const std::string all = "51 heart\n52 aorta\n65 iliac_artery_left\n66 iliac_artery_right\n";
    assert_string_equal(read_with(all, cta().scan).c_str(), "4");
    assert_string_equal(read_with("group,original_idx,structure,id\ncardiac,1,heart,51\ncardiac,2,aorta,52\n"
                                  "cardiac,15,iliac_artery_left,65\ncardiac,16,iliac_artery_right,66\n",
                                  cta().scan)
                            .c_str(),
                        "4");
    assert_names(read_with("51 heart\n52 aorta\n65 iliac_artery_left\n", cta().scan), "label 66 has no name");
    assert_names(read_with("51 heart\n52 vessel\n65 iliac_artery_left\n66 iliac_artery_right\n", cta().scan),
                 "no structure is named 'aorta'");
    assert_names(read_with("aorta is 52\n", cta().scan), "names.csv");
    Volume other = cta().scan;
    other.origin_mm[0] += 5;
    assert_names(read_with(all, other), "corners are 5.0 mm apart");
}

static void a_nifti_file_with_a_rescale_offset_is_read(void **)
{
    // ITK converts such values to float, which have twice the bytes of those in the file.
    const tests::Folder folder("patient");
    const std::string file = folder.file("scan.nii");
    Volume scan = cta().labels.volume;
    write_volume(scan, file);
    std::fstream header(file, std::ios::in | std::ios::out | std::ios::binary);
    const float slope_and_offset[] = {1.0f, -1024.0f};
    header.seekp(112);
    header.write(reinterpret_cast<const char *>(slope_and_offset), sizeof slope_and_offset);
    header.close();
    const Volume read = along_patient_axes(read_volume(file));
    const std::size_t middle = read.at(90, 75, 60);
    assert_true(read.hu[middle] == scan.hu[middle] - 1024.0f);
}

// The deep femoral artery may end lower than the femoral artery beside it.
static void instruments_enter_the_widest_of_the_low_ends(void **)
{
    const auto line = [](const char *name, int parent, double x_mm, double from_mm, double to_mm,
                         double radius_mm) {
        centreline::Branch branch;
        branch.name = name;
        branch.parent = parent;
        for (int i = 0; i <= 20; ++i)
            branch.spheres.push_back({Vector3d(x_mm, from_mm + (to_mm - from_mm) * i / 20.0, 0), radius_mm});
        return branch;
    };
    centreline::Tree tree;
    tree.branches = {line("aorta", -1, 0, 100, 0, 9), line("deep", 0, 20, 0, -100, 2),
                     line("femoral", 0, 25, 0, -80, 4)};
    const patient::Entry entry = patient::inside_end(tree, patient::low_end(tree));
    assert_string_equal(entry.branch.c_str(), "femoral");
    assert_true(std::fabs(entry.place_mm.y() + 65) < 5 && entry.direction.y() > 0.99);
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_lumen_tree_and_entry_are_those_of_the_truth),
        cmocka_unit_test(the_picture_has_no_table_and_no_contrast_medium),
        cmocka_unit_test(undiluted_medium_in_the_heart_becomes_blood_and_calcium_stays),
        cmocka_unit_test(scans_that_cannot_serve_are_named),
        cmocka_unit_test(every_order_of_voxels_becomes_that_of_the_patient),
        cmocka_unit_test(a_nifti_file_with_a_rescale_offset_is_read),
        cmocka_unit_test(instruments_enter_the_widest_of_the_low_ends),
        cmocka_unit_test(arteries_that_vanish_are_named),
        cmocka_unit_test(a_label_map_needs_the_scans_grid_names_and_an_aorta),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
