// These tests check that the coronary arteries of a person's own vessels are known by their names, that their
// branches count as well, and that a stenosis in one of them is judged with hyperaemic flow: against the flow
// at which the pressure drops by Poiseuille, by Young and Tsai, and in the bed add up. A stenosis elsewhere
// is said to be judged with resting flow.
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/effects/lesion_figures.hpp"
#include "host/model/bodies.hpp"
#include "tools/bake/bake.hpp"
#include "tools/centreline/tests/shapes.hpp"
#include "tools/patient/coronary.hpp"
#include "tools/patient/scene_folder.hpp"
#include <numbers>

using namespace crn;
using namespace crn::patient;
using centreline::tests::Folder;
using Eigen::Vector3d;
using std::numbers::pi;

// All tests of this room are one unit, so these names have a namespace of their own.
namespace coronary_tests
{

static bake::Progress own_progress;

static centreline::Branch branch(const std::string &name, int parent, const Vector3d &to)
{
    return {name, parent, 0, {{Vector3d::Zero(), 2.0}, {to, 2.0}}};
}

static void coronary_arteries_are_known_by_their_names(void **)
{
    for (const char *name : {"VH_M_left_coronary_artery", "LAD", "circumflex branch", "RCA_2", "left_main",
                             "VHF_posterior_left_ventricular_branch", "right_marginal_branch",
                             "coronary_arteries", "anterior_interventricular_branch"})
        if (!is_coronary_name(name)) fail_msg("%s is a coronary artery", name);
    for (const char *name : {"aorta", "ascending_aorta", "coronary_sinus", "coronary_vein",
                             "left_carotid_artery", "lateral_circumflex_femoral_artery",
                             "marginal_artery_of_colon", "lady", "posterior_cerebral_artery", "branch_1"})
        if (is_coronary_name(name)) fail_msg("%s is no coronary artery", name);
}

static void branches_of_a_coronary_artery_are_coronary_and_of_its_side(void **)
{
    const centreline::Tree tree = {
        {branch("aorta", -1, {0, 50, 0}), branch("left_coronary_artery", 0, {20, 0, 0}),
         branch("branch_1", 1, {40, 0, 0}), branch("posterior_descending", 1, {0, -9, 0}),
         branch("coronary_arteries", 0, {-30, 0, 0}), branch("branch_2", 0, {9, 9, 0})}};
    const CoronaryBranches found = coronary_branches(tree, "");
    assert_string_equal(found.scene_text().c_str(),
                        "left_coronary = [\"left_coronary_artery\", \"branch_1\", \"posterior_descending\"]\n"
                        "right_coronary = [\"coronary_arteries\"]\n");
    assert_true(coronary_branches({{tree.branches[0]}}, "").is_empty());
    // The mesh of one artery: its branches have numbers, and the name is that of the file.
    assert_int_equal(coronary_branches({{branch("branch_1", -1, {0, 50, 0})}}, "RCA").right.size(), 1);
}

// An artery of the gut is called marginal artery of Drummond.
static void arteries_of_another_organ_are_not_coronary(void **)
{
    const centreline::Tree gut = {
        {branch("left_colic_artery", -1, {0, 50, 0}), branch("marginal_artery_of_drummond", 0, {20, 0, 0}),
         branch("marginal_artery", 1, {40, 0, 0}), branch("superior_mesenteric_artery", 2, {0, -9, 0})}};
    assert_true(coronary_branches(gut, "").is_empty());
    const centreline::Tree heart = {{branch("aorta", -1, {0, 50, 0}), branch("LCX", 0, {20, 0, 0}),
                                     branch("marginal_artery", 0, {40, 0, 0})}};
    assert_int_equal(coronary_branches(heart, "").left.size(), 2);
}

// --- the flow reserve of a stenosis ---

constexpr double radius_mm = 2.0, length_mm = 100.0, at_mm = 40.0, lesion_mm = 20.0, narrowed = 0.6;
constexpr double viscosity_mPa_s = 3.5, mmHg_per_Pa = 1 / 133.322;

// The scene that the command makes of one tube with this name, baked again with a stenosis of 60 % by
// diameter.
static std::vector<LesionFigures> judged(const std::string &name, std::string &made, std::string &baked)
{
    const Folder folder;
    Choices choices;
    SceneWish wish;
    wish.folder = folder.path / "scene";
    wish.has_bodies = false;
    make_scene_folder({{name, centreline::tests::tube_mesh(radius_mm, length_mm, 0, 100, 60)}},
                      {"mm", "+x,+y,+z", {}}, wish, choices, own_progress);
    made = choices.text("");
    std::string text = read_text_file((wish.folder / "scene.toml").string());
    text +=
        formatted("\n[[lesion]]\nname = \"plaque\"\nbranch = \"branch_1\"\nat_mm = %.0f\nlength_mm = %.0f\n"
                  "stenosis_percent = %.0f\n",
                  at_mm, lesion_mm, narrowed * 100);
    write_whole_file((wish.folder / "scene.toml").string(), text);
    bake::Options options;
    options.scene = wish.folder / "scene.toml";
    options.output = wish.folder / "patient.scene";
    options.points = 2000;
    options.poses = 100;
    baked = bake::bake(options, own_progress);
    Bodies bodies;
    std::string error;
    if (!read_bodies((wish.folder / "patient.bodies").string(), bodies, error)) fail_msg("%s", error.c_str());
    return lesion_figures(bodies.vessels, viscosity_mPa_s);
}

// The drop over a cosine stenosis and its jet at a flow, less that of the healthy vessel there.
static double added_drop_mmHg(double flow_ml_s)
{
    constexpr int steps = 20000;
    double per_r4_mm3 = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double u = (i + 0.5) / steps - 0.5, lost = narrowed * (1 + std::cos(2 * pi * u)) / 2;
        per_r4_mm3 += lesion_mm / steps * (std::pow(radius_mm * (1 - lost), -4) - std::pow(radius_mm, -4));
    }
    const double widening = 1 / ((1 - narrowed) * (1 - narrowed)) - 1;
    const double speed_m_s = flow_ml_s / (pi * radius_mm * radius_mm);
    return (8 * viscosity_mPa_s / pi * per_r4_mm3 * flow_ml_s +
            1.5 * 1060 / 2 * widening * widening * speed_m_s * speed_m_s) *
           mmHg_per_Pa;
}

// The ratio of the pressures behind the stenosis and at the inlet, if the bed conducts so many times what it
// does at rest: by bisection for the flow at which all drops add up to 88 mmHg.
static double ratio_by_closed_form(double openness, double &flow_ml_s)
{
    const double rest_ml_s = pi * std::pow(radius_mm, 2) * 0.16;                         // at 160 mm/s
    const double tube = 8 * viscosity_mPa_s / pi / std::pow(radius_mm, 4) * mmHg_per_Pa; // mmHg s/ml and mm
    const double bed = (88.0 / rest_ml_s - tube * length_mm) / openness;
    double low = 0.0, high = openness * rest_ml_s;
    for (int i = 0; i < 80; ++i) {
        const double q = 0.5 * (low + high);
        (q * (bed + tube * length_mm) + added_drop_mmHg(q) > 88.0 ? high : low) = q;
    }
    flow_ml_s = low;
    return 1.0 - (low * tube * (at_mm + lesion_mm) + added_drop_mmHg(low)) / 88.0;
}

static void is_near(double got, double wanted, double share, const char *what)
{
    std::printf("# %s: %.4g, expected %.4g\n", what, got, wanted);
    if (!(std::abs(got - wanted) <= share * std::abs(wanted)))
        fail_msg("%s is %.6g, expected %.6g within %.1f %%", what, got, wanted, 100 * share);
}

static void says(const std::string &text, const char *words)
{
    if (text.find(words) == text.npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), words);
}

// Before, the flow of a person's own coronary artery in hyperaemia was that at rest, and the ratio was 0.94.
static void a_stenosis_of_an_own_coronary_artery_meets_hyperaemic_flow(void **)
{
    std::string made, baked;
    const LesionFigures found = judged("LAD", made, baked).at(0);
    double flow_ml_s = 0.0;
    const double ratio = ratio_by_closed_form(hyperaemia_openness, flow_ml_s);
    is_near(found.hyperaemic_flow_ml_s, flow_ml_s, 0.03, "hyperaemic flow in ml/s");
    is_near(found.ffr, ratio, 0.03, "fractional flow reserve");
    assert_true(found.is_coronary);
    says(made, "FFR there is with hyperaemic flow");
    assert_true(baked.find("resting flow") == baked.npos);
}

static void a_stenosis_elsewhere_is_said_to_meet_resting_flow(void **)
{
    std::string made, baked;
    const LesionFigures found = judged("tube", made, baked).at(0);
    double flow_ml_s = 0.0;
    const double ratio = ratio_by_closed_form(1.0, flow_ml_s);
    is_near(found.hyperaemic_flow_ml_s, flow_ml_s, 0.03, "flow in ml/s");
    is_near(found.ffr, ratio, 0.03, "ratio of pressures");
    assert_false(found.is_coronary);
    says(made, "FFR of lesions is with resting flow");
    says(baked, "the FFR of plaque is with resting flow");
}

} // namespace coronary_tests

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(coronary_tests::coronary_arteries_are_known_by_their_names),
        cmocka_unit_test(coronary_tests::branches_of_a_coronary_artery_are_coronary_and_of_its_side),
        cmocka_unit_test(coronary_tests::arteries_of_another_organ_are_not_coronary),
        cmocka_unit_test(coronary_tests::a_stenosis_of_an_own_coronary_artery_meets_hyperaemic_flow),
        cmocka_unit_test(coronary_tests::a_stenosis_elsewhere_is_said_to_meet_resting_flow)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
