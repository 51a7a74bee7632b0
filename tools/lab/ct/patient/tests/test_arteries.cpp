// Tests how arteries are found without a label map, in a virtual CTA whose truth is known. An aorta runs in
// front of a spine that is as bright as the medium, and gives off four branches: one into a kidney, one with
// an occlusion, one that touches a bone without a compact shell, and one of 2.4 mm that divides. One of its
// ends runs along a bone and touches it.
#include "tools/centreline/tree.hpp"
#include "tools/lab/ct/arteries/arteries.hpp"
#include "tools/lab/ct/arteries/ascending.hpp"
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/arteries/tubes.hpp"
#include "tools/lab/ct/patient/wall.hpp"
#include "tools/lab/ct/snake.hpp"
#include "tools/lab/ct/surface.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::ct;
using Eigen::Vector3d;

namespace
{

constexpr double blood_HU = 350, tissue_around_HU = 45, spread_HU = 15, trunk_mm = 9, branch_mm = 3,
                 thin_mm = 1.2;

double tube(const Vector3d &p, const Vector3d &a, const Vector3d &b, double radius_mm)
{
    return centreline::tapered_capsule_distance(p, a, radius_mm, b, radius_mm);
}

// Distance from the wall of the arteries that are connected with the aorta.
double distance_at(const Vector3d &p)
{
    return std::min(
        {tube(p, {0, -90, -10}, {0, 90, -10}, trunk_mm), tube(p, {0, 20, -10}, {45, 20, -10}, branch_mm),
         tube(p, {0, -20, -10}, {-25, -20, -10}, branch_mm),
         tube(p, {0, -45, -10}, {58, -45, -10}, branch_mm), tube(p, {0, 45, -10}, {-45, 45, -10}, thin_mm),
         tube(p, {-22, 45, -10}, {-22, 64, -10}, thin_mm), tube(p, {-22, 64, -10}, {-58, 64, -10}, thin_mm)});
}

double vertebra_at(const Vector3d &p)
{
    const double in_period = std::fmod(p.y() + 300, 30);
    const double ends = std::max(in_period - 24, -in_period); // discs of 6 mm
    const double body = std::max(std::hypot(p.x(), p.z() + 37) - 17, ends);
    const double process = std::max({std::fabs(p.x()) - 5, std::fabs(p.z() + 62) - 9, ends});
    return std::min(body, process);
}

// The value of what fills a body, with an edge of one voxel around the distance 0.
void fill(double &value, double distance_mm, double inside_HU)
{
    value += (inside_HU - value) * std::clamp(0.5 - distance_mm, 0.0, 1.0);
}

double value_at(const Vector3d &p)
{
    double value = -1000;
    fill(value, (std::hypot(p.x() / 76, (p.z() + 20) / 60) - 1) * 60, tissue_around_HU);
    const double vertebra = vertebra_at(p);
    fill(value, vertebra, 700);
    fill(value, vertebra + 2, blood_HU); // the marrow is as bright as blood
    fill(value, (p - Vector3d(36, -45, -26.5)).norm() - 14, blood_HU);
    fill(value, (p - Vector3d(58, 20, -10)).norm() - 15, 280);
    fill(value, tube(p, {-36, 64, -15.9}, {-70, 64, -15.9}, 4.5), 900);
    fill(value, tube(p, {-37, -20, -10}, {-55, -20, -10}, branch_mm), blood_HU);
    fill(value, distance_at(p), blood_HU);
    return value;
}

struct Trunk {
    Volume scan;
    Mask body;
};

const Trunk &trunk()
{
    static const Trunk made = [] {
        Trunk of;
        of.scan.size = {175, 140, 135};
        of.scan.spacing_mm = {0.9, 0.9, 1.0};
        of.scan.origin_mm = {-78.3, -42.5, -67};
        of.scan.name = "virtual CTA";
        of.scan.hu.resize(of.scan.count());
        std::uint32_t state = 1;
        for (std::size_t at = 0; at < of.scan.count(); ++at) {
            double lot = 0;
            for (int n = 0; n < 4; ++n) {
                state = state * 1664525u + 1013904223u;
                lot += (state >> 8) / 16777216.0 - 0.5;
            }
            of.scan.hu[at] =
                static_cast<float>(value_at(place_at(of.scan, at)) + lot * spread_HU * std::sqrt(3.0));
        }
        of.body = body_of(of.scan);
        return of;
    }();
    return made;
}

const Report silent = [](const std::string &, double) {};

FoundArteries found_with(const std::vector<Click> &clicks)
{
    Findings findings;
    return find_arteries(trunk().scan, trunk().body, clicks, findings, silent);
}

std::size_t voxel_at(const Volume &volume, const Vector3d &p)
{
    const Vector3d voxel = volume.voxel(p);
    return volume.at(static_cast<int>(std::lround(voxel.x())), static_cast<int>(std::lround(voxel.y())),
                     static_cast<int>(std::lround(voxel.z())));
}

// The level of the wall that is found in a scan without a click.
Volume wall_in(const Volume &scan)
{
    Findings findings;
    const FoundArteries of = find_arteries(scan, trunk().body, {}, findings, silent);
    return wall_level(scan, of.labels, contrast_of(of.descending), silent);
}

void assert_artery(const LabelMap &labels, const Vector3d &p, bool is_expected)
{
    const int label = labels.label(voxel_at(labels.volume, p));
    const bool is_found = label != 0 && is_artery(labels.names.at(label));
    if (is_found != is_expected)
        fail_msg("(%.0f, %.0f, %.0f) is %s artery", p.x(), p.y(), p.z(), is_found ? "an" : "no");
}

const FoundArteries &found()
{
    static const FoundArteries without_clicks = found_with({});
    return without_clicks;
}

} // namespace

static void the_aorta_is_found_beside_a_spine_as_bright(void **)
{
    const FoundArteries &of = found();
    assert_true(of.descending.back().slice - of.descending.front().slice > 120);
    for (const Disc &disc : of.descending) {
        const Vector3d middle = place_of(trunk().scan, disc);
        assert_true(std::hypot(middle.x(), middle.z() + 10) < 1.0);
    }
    const Contrast contrast = contrast_of(of.descending);
    std::printf("# %.0f HU, noise %.0f HU\n", contrast.mean_HU, contrast.noise_HU);
    assert_true(std::fabs(contrast.mean_HU - blood_HU) < 10);
}

// An arch between an ascending and a descending aorta. The end of the arch is read a second time, as a short
// stack beside the descending aorta, which comes first among the stacks.
static void the_ascending_aorta_is_the_tallest_stack_behind_the_arch(void **)
{
    const Vector3d feet(24, -60, 0), arch(24, 40, 0), crown(0, 58, 0), down(-24, 40, 0), root(-24, -20, 0);
    Volume scan;
    scan.size = {60, 30, 90};
    scan.spacing_mm = {1.5, 1.5, 1.5};
    scan.origin_mm = {-44, -22, -62};
    scan.hu.resize(scan.count());
    Mask inside(scan.count());
    for (std::size_t at = 0; at < scan.count(); ++at) {
        const Vector3d p = place_at(scan, at);
        inside[at] = std::min({tube(p, feet, arch, 10), tube(p, arch, crown, 11), tube(p, crown, down, 12),
                               tube(p, down, root, 12)}) < 0;
    }
    const auto stack_of = [&](const Vector3d &low, const Vector3d &high, double radius_mm) {
        Stack stack;
        const int last = static_cast<int>(std::lround(scan.voxel(high).z()));
        for (int k = static_cast<int>(std::lround(scan.voxel(low).z())); k <= last; ++k) {
            Disc disc;
            disc.slice = k;
            disc.middle = scan.voxel(low).head<2>();
            disc.radius_mm = radius_mm;
            stack.push_back(disc);
        }
        return stack;
    };
    const std::vector<Stack> stacks = {stack_of(feet, arch, 10),
                                       stack_of({22, 30, 0}, {22, 40, 0}, 11), // the same again
                                       stack_of(root, down, 12)};
    const Widths widths = widths_in(scan, inside);
    const std::size_t source = voxel_at(scan, feet);
    const Growth growth =
        grow_apart(scan, inside, widths, Mask(scan.count(), 0), {{source, widths[source]}}, {});
    const Stack found_stack = ascending_aorta(scan, growth, stacks, stacks[0]);
    assert_false(found_stack.empty());
    assert_true((place_of(scan, found_stack.front()) - root).norm() < 2);
}

static void arteries_end_at_bone_kidney_and_gap(void **)
{
    const LabelMap &labels = found().labels;
    for (const Vector3d &inside : {Vector3d(0, 60, -10), Vector3d(30, 20, -10), Vector3d(-20, -20, -10),
                                   Vector3d(56, -45, -10), Vector3d(-40, 45, -10)})
        assert_artery(labels, inside, true);
    assert_artery(labels, {0, 10, -37}, false);    // a vertebra
    assert_artery(labels, {58, 20, -10}, false);   // the kidney
    assert_artery(labels, {36, -45, -26}, false);  // the bone without a shell
    assert_artery(labels, {-45, -20, -10}, false); // behind the gap
}

static void a_bone_that_touches_an_artery_does_not_claim_it(void **)
{
    for (const double x : {-30.0, -38.0, -46.0, -54.0}) assert_artery(found().labels, {x, 64, -10}, true);
    for (const double x : {-38.0, -46.0, -60.0}) assert_artery(found().labels, {x, 64, -16}, false);
}

// Blood with little medium, such as that of the pulmonary artery, and much noise: a tenth of the voxels are
// as bright as arteries, and would be connected over all 26 neighbours.
static void noise_in_pale_blood_makes_no_vessel(void **)
{
    Volume scan;
    scan.size = {60, 60, 60};
    scan.spacing_mm = {0.9, 0.9, 1.25};
    scan.name = "pale blood";
    scan.hu.resize(scan.count());
    std::uint32_t state = 1;
    for (float &hu : scan.hu) {
        double lot = 0;
        for (int n = 0; n < 4; ++n) {
            state = state * 1664525u + 1013904223u;
            lot += (state >> 8) / 16777216.0 - 0.5;
        }
        hu = static_cast<float>(171 + lot * 45 * std::sqrt(3.0));
    }
    const Mask body(scan.count(), 1);
    Contrast contrast;
    contrast.mean_HU = 350;
    contrast.noise_HU = 20;
    const Bright bright = bright_of(scan, body, contrast);
    const auto count = std::count(bright.inside.begin(), bright.inside.end(), 1);
    std::printf("# %.2f %% of the voxels are bright\n", 100.0 * double(count) / double(scan.count()));
    assert_true(double(count) < 0.02 * double(scan.count()));
}

// A thigh: an artery of 6 mm that divides, beside a bone, and no aorta.
static const Volume &thigh()
{
    static const Volume scan = [] {
        Volume of;
        of.size = {110, 110, 90};
        of.spacing_mm = {0.9, 0.9, 1.0};
        of.origin_mm = {-49, -49, -45};
        of.name = "thigh";
        of.hu.resize(of.count());
        std::uint32_t state = 1;
        for (std::size_t at = 0; at < of.count(); ++at) {
            const Vector3d p = place_at(of, at);
            double value = -1000;
            fill(value, std::hypot(p.x(), p.z()) - 45, tissue_around_HU);
            fill(value, tube(p, {-15, -90, -10}, {-15, 90, -10}, 12), 1000);
            fill(value, tube(p, {-15, -90, -10}, {-15, 90, -10}, 8), 200); // marrow
            fill(value, tube(p, {10, 90, 5}, {10, 0, 5}, branch_mm), blood_HU);
            fill(value, tube(p, {10, 0, 5}, {20, -90, 15}, 2.4), blood_HU);
            fill(value, tube(p, {10, 0, 5}, {0, -90, 20}, 2.0), blood_HU);
            state = state * 1664525u + 1013904223u;
            of.hu[at] = static_cast<float>(value + ((state >> 8) / 16777216.0 - 0.5) * 40);
        }
        return of;
    }();
    return scan;
}

static void without_an_aorta_arteries_begin_at_a_click(void **)
{
    Findings findings;
    const Mask body = body_of(thigh());
    const FoundArteries of = find_arteries(thigh(), body, {click_of("artery:15,-40,10")}, findings, silent);
    assert_false(of.has_aorta);
    for (const Vector3d &inside : {Vector3d(10, 30, 5), Vector3d(14, -36, 9), Vector3d(6, -36, 11)})
        assert_artery(of.labels, inside, true);
    assert_artery(of.labels, {-15, 0, -10}, false); // the femur
    // The blood enters at the wide upper end.
    assert_true(of.root_mm.y() > 38 && std::hypot(of.root_mm.x() - 10, of.root_mm.z() - 5) < 1.5);
    const Contrast contrast = contrast_in_arteries(thigh(), of.labels, findings);
    std::printf("# %.0f HU, noise %.0f HU\n", contrast.mean_HU, contrast.noise_HU);
    assert_true(std::fabs(contrast.mean_HU - blood_HU) < 10);
}

// The voxels beside the clicked branch are calcium of 700 HU.
static void a_click_beside_calcium_does_not_replace_the_aorta(void **)
{
    Volume scan = trunk().scan;
    for (std::size_t at = 0; at < scan.count(); ++at)
        if ((place_at(scan, at) - Vector3d(30, 22.5, -10)).norm() < 1.6) scan.hu[at] = 700;
    Findings findings;
    const FoundArteries of =
        find_arteries(scan, trunk().body, {click_of("artery:30,21.5,-10")}, findings, silent);
    assert_true(of.has_aorta);
    assert_artery(of.labels, {0, 60, -10}, true);
}

// A label map of a scan without medium is accepted; a click into it must not fail.
static void without_medium_nothing_is_a_tube(void **)
{
    Contrast contrast;
    contrast.mean_HU = 40;
    contrast.noise_HU = 15;
    const Mask tubes = tubes_of(thigh(), Mask(thigh().count(), 1), contrast);
    assert_int_equal(std::count(tubes.begin(), tubes.end(), 1), 0);
}

static void without_an_aorta_and_a_click_the_message_asks_for_one(void **)
{
    Findings findings;
    Volume soft = thigh(); // without its bone, whose marrow is as round and even as an aorta
    for (std::size_t at = 0; at < soft.count(); ++at)
        if (tube(place_at(soft, at), {-15, -90, -10}, {-15, 90, -10}, 12) < 2) soft.hu[at] = tissue_around_HU;
    const Mask body = body_of(soft);
    const auto said = [&](const std::vector<Click> &clicks) -> std::string {
        try {
            find_arteries(soft, body, clicks, findings, silent);
        } catch (const std::exception &error) {
            return error.what();
        }
        return "";
    };
    for (const std::vector<Click> &clicks :
         {std::vector<Click>{}, {click_of("artery:30,0,-20")}}) // in muscle
        if (said(clicks).find("artery:x,y,z") == std::string::npos)
            fail_msg("%zu clicks: %s", clicks.size(), said(clicks).c_str());
}

static void a_bridge_joins_the_two_ends_of_a_gap(void **)
{
    const FoundArteries joined = found_with({click_of("bridge:-31,-20,-10")});
    const LabelMap &labels = joined.labels;
    const Volume level = wall_level(trunk().scan, labels, contrast_of(joined.descending), silent);
    assert_true(level.value(level.voxel({-31, -20, -10})) < 0);
    for (const double x : {-20.0, -31.0, -45.0}) assert_artery(labels, {x, -20, -10}, true);
    assert_artery(labels, {36, -45, -26}, false);
}

static void a_clicked_artery_is_joined_and_a_cut_takes_away(void **)
{
    const LabelMap labels = found_with({click_of("artery:-45,-20,-10"), click_of("cut:30,20,-10:5")}).labels;
    for (const double x : {-31.0, -45.0}) assert_artery(labels, {x, -20, -10}, true);
    assert_artery(labels, {18, 20, -10}, true);
    for (const double x : {30.0, 40.0}) assert_artery(labels, {x, 20, -10}, false);
}

// Adds an artery of 2 mm that is dark over 4 and over 3 mm, as by noise: too dark for the growth, and for the
// wall.
static Volume with_dark_artery(double y, double z)
{
    Volume scan = trunk().scan;
    for (std::size_t at = 0; at < scan.count(); ++at) {
        const Vector3d p = place_at(scan, at);
        const bool is_dark = (p.x() > -26 && p.x() < -22) || (p.x() > -50 && p.x() < -47);
        double value = static_cast<double>(scan.hu[at]);
        fill(value, tube(p, {-8, y, z}, {-66, y, z}, 1.0), is_dark ? 150 : blood_HU);
        scan.hu[at] = static_cast<float>(value);
    }
    return scan;
}

static void one_click_traces_a_thin_artery_both_ways_through_dark_places(void **)
{
    const double y = -58, z = -10;
    const Volume scan = with_dark_artery(y, z);
    Findings findings;
    const auto with = [&](const std::vector<Click> &clicks) {
        return find_arteries(scan, trunk().body, clicks, findings, silent);
    };
    const LabelMap without = with({}).labels;
    assert_artery(without, {-15, y, z}, true);
    for (const double x : {-40.0, -60.0}) assert_artery(without, {x, y, z}, false);
    const FoundArteries clicked = with({click_of("artery:-40,-58,-10")});
    const Volume level = wall_level(scan, clicked.labels, contrast_of(clicked.descending), silent);
    for (double x = -15; x >= -64; x -= 1)
        if (level.value(level.voxel({x, y, z})) >= 0) fail_msg("closed at x = %.0f", x);
    for (const double x : {-24.0, -40.0, -60.0}) assert_true(level.value(level.voxel({x, y + 2.2, z})) > 0);
    assert_artery(clicked.labels, {0, 10, -37}, false); // a vertebra
}

// A first click into the marrow of a bone, which an artery feeds, takes the bone. The way from a second
// click, into an artery beside this bone, must not end there, after 12 mm: the aorta is 21 mm away.
static void a_way_does_not_end_in_a_bone_that_another_click_took(void **)
{
    const double y = -58, z = -10;
    Volume scan = with_dark_artery(y, z);
    for (std::size_t at = 0; at < scan.count(); ++at) {
        const Vector3d p = place_at(scan, at), marrow(-38, -48.5, z), bend(-38, -36, z);
        const double feed = std::min(tube(p, {0, -36, z}, bend, 1.2), tube(p, bend, marrow, 1.2));
        double value = static_cast<double>(scan.hu[at]);
        fill(value, std::min((p - marrow).norm() - 7.5, feed), blood_HU);
        scan.hu[at] = static_cast<float>(value);
    }
    const auto traced_mm = [&](const std::vector<Click> &clicks) {
        Findings findings;
        find_arteries(scan, trunk().body, clicks, findings, silent);
        assert_false(findings.facts.empty());
        const std::string &fact = findings.facts.back();
        const std::string start = "traced over ";
        assert_true(fact.find(start) != std::string::npos);
        return std::stod(fact.substr(fact.find(start) + start.size()));
    };
    const Click in_bone = click_of("artery:-38,-48,-10"), in_artery = click_of("artery:-30,-58,-10");
    assert_true(traced_mm({in_artery}) > 130);
    assert_true(traced_mm({in_bone, in_artery}) == traced_mm({in_artery}));
}

static void the_wall_is_where_the_truth_has_it(void **)
{
    const Volume level = wall_level(trunk().scan, found().labels, contrast_of(found().descending), silent);
    const bake::Mesh mesh = surface_of(level, "wall");
    struct Part {
        const char *name;
        Vector3d low, high;
        double sum = 0, offset = 0, count = 0;
    } parts[] = {{"aorta", {-12, -60, -22}, {12, 60, 2}},
                 {"branch", {16, 10, -20}, {38, 30, 0}},
                 {"thin branch", {-38, 40, -20}, {-14, 50, 0}}};
    for (const Vector3d &vertex : mesh.vertices_mm)
        for (Part &part : parts) {
            if ((vertex.array() < part.low.array()).any() || (vertex.array() > part.high.array()).any())
                continue;
            const double distance_mm = distance_at(vertex);
            part.sum += std::fabs(distance_mm);
            part.offset += distance_mm;
            part.count += 1;
        }
    for (const Part &part : parts) {
        assert_true(part.count > 100);
        std::printf("# wall of the %s: off by %.3f mm in the mean, %+.3f mm with sign\n", part.name,
                    part.sum / part.count, part.offset / part.count);
        assert_true(part.sum / part.count < 0.3); // a third of a voxel
    }
}

// A plaque of 1.2 mm in the wall of the aorta, as blurred as by a scanner. Around it, its blur is as bright
// as blood, but the lumen has no pocket there.
static void the_blur_of_a_plaque_is_no_lumen(void **)
{
    Volume scan = trunk().scan;
    const auto in_plaque = [](const Vector3d &p) {
        return std::hypot(p.y() - 5, p.z() + 10) < 4 && p.x() < 0;
    };
    const auto off_axis = [](const Vector3d &p) { return std::hypot(p.x(), p.z() + 10); };
    for (std::size_t at = 0; at < scan.count(); ++at) {
        const Vector3d p = place_at(scan, at);
        const bool is_calcium = in_plaque(p) && off_axis(p) > trunk_mm - 0.6 && off_axis(p) < trunk_mm + 0.6;
        if (is_calcium) scan.hu[at] = 1200;
    }
    scan = smoothed(scan, 0.6);
    const Volume level = wall_in(scan);
    double farthest_mm = 0;
    for (const Vector3d &vertex : surface_of(level, "wall").vertices_mm)
        if (std::hypot(vertex.y() - 5, vertex.z() + 10) < 7 && vertex.x() < 0)
            farthest_mm = std::max(farthest_mm, off_axis(vertex) - trunk_mm);
    std::printf("# the lumen reaches %.2f mm over the wall beside a plaque\n", farthest_mm);
    assert_true(farthest_mm < 0.4);
}

// Single voxels of noise near the wall that are as bright as calcium do not dent the lumen.
static void bright_noise_near_the_wall_is_no_plaque(void **)
{
    Volume scan = trunk().scan;
    std::vector<Vector3d> spikes;
    for (double y = -50; y <= 55; y += 15) spikes.emplace_back(0.0, y, -10 + trunk_mm - 1.0);
    for (const Vector3d &spike : spikes) scan.hu[voxel_at(scan, spike)] = 700;
    const Volume level = wall_in(scan);
    double deepest_mm = 0;
    for (const Vector3d &vertex : surface_of(level, "wall").vertices_mm)
        for (const Vector3d &spike : spikes)
            if ((vertex - spike).norm() < 3)
                deepest_mm = std::max(deepest_mm, trunk_mm - std::hypot(vertex.x(), vertex.z() + 10));
    std::printf("# the lumen is dented by %.2f mm at a bright voxel\n", deepest_mm);
    assert_true(deepest_mm < 0.5);
}

// A vertebra lies beside the mouth of a branch of 2.4 mm, as beside a lumbar artery. It is no plaque, and
// does not close the branch.
static void a_bone_beside_the_mouth_of_a_branch_does_not_close_it(void **)
{
    Volume scan = trunk().scan;
    for (std::size_t at = 0; at < scan.count(); ++at) {
        double value = static_cast<double>(scan.hu[at]);
        fill(value, tube(place_at(scan, at), {-10, 50, -14.2}, {-10, 25, -14.2}, 2.9), 1200);
        scan.hu[at] = static_cast<float>(value);
    }
    const Volume level = wall_in(scan);
    for (double x = -8; x >= -20; x -= 0.5)
        if (level.value(level.voxel({x, 45, -10})) >= 0) fail_msg("closed at x = %.1f", x);
}

// The kidney behind its artery is bright, but neither an artery nor a chamber of the heart.
static void a_kidney_keeps_its_medium_in_the_picture(void **)
{
    const Vector3d kidney(62, 20, -10);
    assert_artery(found().labels, kidney, false);
    Findings findings;
    const Contrast contrast = contrast_in(trunk().scan, found().labels, findings);
    const CtVolume picture = picture_volume(trunk().scan, trunk().body, found().labels, contrast, findings);
    const auto HU_at = [&](const Vector3d &p) {
        const Vector3d voxel = (p - picture.first_mm).cwiseQuotient(picture.spacing_mm);
        return picture.permille[picture.index(static_cast<int>(std::lround(voxel.x())),
                                              static_cast<int>(std::lround(voxel.y())),
                                              static_cast<int>(std::lround(voxel.z())))] -
               1000.0;
    };
    assert_true(std::fabs(HU_at(kidney) - 280) < 4 * spread_HU);
    assert_true(HU_at({0, 0, -10}) < 100); // blood in the aorta
}

// A label map that has the aorta alone, as those without visceral arteries, and a click into a branch.
static void a_click_adds_a_branch_to_a_label_map(void **)
{
    const Volume &scan = trunk().scan;
    LabelMap labels{scan.like(0), {{7, "aorta"}}};
    for (std::size_t at = 0; at < scan.count(); ++at)
        if (tube(place_at(scan, at), {0, -90, -10}, {0, 90, -10}, trunk_mm) < 0) labels.volume.hu[at] = 7;
    Findings findings;
    const Contrast contrast = contrast_in(scan, labels, findings);
    mend_arteries(scan, trunk().body, contrast, {click_of("artery:30,20,-10")}, labels, findings);
    assert_artery(labels, {30, 20, -10}, true);
    assert_artery(labels, {62, 20, -10}, false); // not on into the kidney
    const Volume level = wall_level(scan, labels, contrast, silent);
    for (const double x : {12.0, 20.0, 30.0}) assert_true(level.value(level.voxel({x, 20, -10})) < 0);
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_click_adds_a_branch_to_a_label_map),
        cmocka_unit_test(a_kidney_keeps_its_medium_in_the_picture),
        cmocka_unit_test(the_blur_of_a_plaque_is_no_lumen),
        cmocka_unit_test(a_bone_beside_the_mouth_of_a_branch_does_not_close_it),
        cmocka_unit_test(bright_noise_near_the_wall_is_no_plaque),
        cmocka_unit_test(the_ascending_aorta_is_the_tallest_stack_behind_the_arch),
        cmocka_unit_test(the_aorta_is_found_beside_a_spine_as_bright),
        cmocka_unit_test(arteries_end_at_bone_kidney_and_gap),
        cmocka_unit_test(a_bone_that_touches_an_artery_does_not_claim_it),
        cmocka_unit_test(noise_in_pale_blood_makes_no_vessel),
        cmocka_unit_test(without_an_aorta_arteries_begin_at_a_click),
        cmocka_unit_test(a_click_beside_calcium_does_not_replace_the_aorta),
        cmocka_unit_test(without_medium_nothing_is_a_tube),
        cmocka_unit_test(without_an_aorta_and_a_click_the_message_asks_for_one),
        cmocka_unit_test(a_bridge_joins_the_two_ends_of_a_gap),
        cmocka_unit_test(a_clicked_artery_is_joined_and_a_cut_takes_away),
        cmocka_unit_test(one_click_traces_a_thin_artery_both_ways_through_dark_places),
        cmocka_unit_test(a_way_does_not_end_in_a_bone_that_another_click_took),
        cmocka_unit_test(the_wall_is_where_the_truth_has_it),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
