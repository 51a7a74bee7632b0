// These tests check the drawn coronary arteries: every seed gives arteries that a person could have, and
// always the same arteries.
#include "host/base/pending_file.hpp"
#include "host/base/tests/folder.hpp"
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/varied/coronaries.hpp"
#include "tools/anatomy/varied/plausible.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>
extern "C" {
#include <cmocka.h>
}

using namespace anatomy;

namespace
{

constexpr std::uint64_t HEARTS = 60;

const std::vector<DrawnCoronaries> &hearts()
{
    static const std::vector<DrawnCoronaries> all = [] {
        std::vector<DrawnCoronaries> drawn;
        for (std::uint64_t seed = 0; seed < HEARTS; ++seed) drawn.push_back(drawn_coronaries(seed));
        return drawn;
    }();
    return all;
}

std::vector<Vessel> tree_vessels(const DrawnCoronaries &drawn)
{
    return tree_of(drawn.draft, "heart.toml").vessels;
}

const Vessel &vessel_named(const std::vector<Vessel> &vessels, const std::string &name)
{
    const auto at =
        std::find_if(vessels.begin(), vessels.end(), [&](const Vessel &one) { return one.name == name; });
    assert_true(at != vessels.end());
    return *at;
}

void a_seed_always_gives_the_same_arteries_and_seeds_differ(void **)
{
    std::set<std::string> texts;
    for (const DrawnCoronaries &drawn : hearts()) texts.insert(coronary_file_text(drawn));
    assert_int_equal(texts.size(), HEARTS);
    assert_string_equal(coronary_file_text(drawn_coronaries(13)).c_str(),
                        coronary_file_text(hearts()[13]).c_str());
}

void the_file_of_a_seed_has_the_drawn_arteries(void **)
{
    const crn::tests::Folder folder("coronaries");
    for (const DrawnCoronaries &drawn : hearts()) {
        const std::string file = folder.file("vessels.toml");
        crn::write_whole_file(file, coronary_file_text(drawn));
        const std::vector<Vessel> read = read_vessels(file).vessels, made = tree_vessels(drawn);
        assert_int_equal(read.size(), made.size());
        for (size_t k = 0; k < made.size(); ++k) {
            assert_string_equal(read[k].name.c_str(), made[k].name.c_str());
            assert_string_equal(read[k].parent.c_str(), made[k].parent.c_str());
            assert_int_equal(read[k].bed, made[k].bed);
            assert_true(std::abs(read[k].flow_ml_min - made[k].flow_ml_min) < 1e-9);
            assert_int_equal(read[k].stations.size(), made[k].stations.size());
            for (size_t s = 0; s < made[k].stations.size(); ++s) {
                const Station &a = read[k].stations[s], &b = made[k].stations[s];
                assert_true((a.position_mm - b.position_mm).norm() < 1e-9);
                assert_true(std::abs(a.diameter_mm - b.diameter_mm) < 1e-9);
            }
        }
    }
}

void every_drawn_heart_keeps_the_rules(void **)
{
    for (const DrawnCoronaries &drawn : hearts())
        assert_string_equal(broken_coronary_rule(tree_vessels(drawn)).c_str(), "");
}

void the_rules_refuse_arteries_that_touch_or_bend_sharply(void **)
{
    std::vector<Vessel> touching = tree_vessels(hearts()[0]);
    for (Vessel &vessel : touching)
        if (vessel.name == "D2") // moved back to where D1 runs
            for (size_t i = 2; i < vessel.stations.size(); ++i)
                vessel.stations[i].position_mm =
                    vessel_named(touching, "D1")
                        .stations[std::min(i + 2, vessel_named(touching, "D1").stations.size() - 1)]
                        .position_mm +
                    Vec3(0.1 * static_cast<double>(i), 0, 0);
    assert_non_null(std::strstr(broken_coronary_rule(touching).c_str(), "D2: "));

    std::vector<Vessel> bent = tree_vessels(hearts()[0]);
    for (Vessel &vessel : bent)
        if (vessel.name == "LAD") vessel.stations[vessel.stations.size() / 2].position_mm += Vec3(0, 0, 8);
    assert_true(broken_coronary_rule(bent).starts_with("LAD: a bend of"));
}

// In a right dominant heart the RCA supplies the back, in a left dominant one the circumflex artery, which
// then reaches the crux. In a balanced heart each of them has one of the two arteries.
void dominance_decides_which_artery_supplies_the_back(void **)
{
    std::array<int, 3> counts = {};
    for (const DrawnCoronaries &drawn : hearts()) {
        const std::vector<Vessel> vessels = tree_vessels(drawn);
        const std::string back = vessel_named(vessels, "PDA").parent,
                          side = vessel_named(vessels, "PL").parent;
        assert_string_equal(back.c_str(), drawn.dominance == Dominance::left ? "LCX" : "RCA");
        assert_string_equal(side.c_str(), drawn.dominance == Dominance::right ? "RCA" : "LCX");
        assert_non_null(std::strstr(drawn.draft.title.c_str(), dominance_name(drawn.dominance)));
        ++counts[static_cast<size_t>(drawn.dominance)];
    }
    // 85, 7.5 and 7.5 % of 60 hearts are 51, 4.5 and 4.5; three standard deviations are 8.3, 6.1 and 6.1.
    assert_true(std::abs(counts[0] - 51) <= 8 && counts[1] >= 1 && counts[1] <= 10 && counts[2] >= 1 &&
                counts[2] <= 10);
}

// The means of 60 hearts lie within three standard errors, 3 s / sqrt(60), of the published means: 0.19 mm
// for the left main artery (4.5 mm, s 0.5), 0.16 mm for the proximal LAD (3.7 mm, s 0.4).
void diameters_are_the_published_ones(void **)
{
    double left_main = 0, anterior = 0;
    for (const DrawnCoronaries &drawn : hearts()) {
        const std::vector<Vessel> vessels = tree_vessels(drawn);
        left_main += vessel_named(vessels, "LM").stations[1].diameter_mm / 1.02 / HEARTS;
        anterior += vessel_named(vessels, "LAD").stations[0].diameter_mm / HEARTS;
    }
    assert_true(std::abs(left_main - 4.5) < 0.19);
    assert_true(std::abs(anterior - 3.7) < 0.16);
}

// The length behind the apex is measured on the curve, from where the LAD is 35 degrees behind the front of
// the septum. It differs from the stated one by at most 1.5 mm, since the stated length is measured along
// chords of 6 mm.
void the_anterior_descending_artery_ends_where_it_is_said(void **)
{
    int wrapped = 0;
    for (const DrawnCoronaries &drawn : hearts()) {
        const Curve curve = vessel_curve(vessel_named(tree_vessels(drawn), "LAD"), 0.5);
        const double end_height = heart_axes().height(curve.back().position_mm);
        if (drawn.past_apex_mm <= 0) {
            assert_true(end_height > 0.09);
            continue;
        }
        ++wrapped;
        const Vec3 apex = *on_heart(0.03, -35);
        const auto at =
            std::min_element(curve.begin(), curve.end(), [&](const CurvePoint &a, const CurvePoint &b) {
                return (a.position_mm - apex).norm() < (b.position_mm - apex).norm();
            });
        assert_true((at->position_mm - apex).norm() < 1); // 0.52 at most
        assert_true(std::abs(curve.back().arc_mm - at->arc_mm - drawn.past_apex_mm) < 1.5);
    }
    assert_true(std::abs(wrapped - 42) <= 10); // 70 %; three standard deviations are 10.6
}

// A ramus in 59 % of 60 hearts is 35.4, with a standard deviation of 3.8; three diagonals in half of them are
// 30 (3.9); each number of marginals in a third is 20 (3.7). The test allows three standard deviations.
void branches_occur_as_often_as_stated(void **)
{
    int ramus = 0, third_diagonals = 0, marginals[4] = {}, draws = 0;
    std::map<std::string, std::pair<double, double>> lengths_mm;
    for (const DrawnCoronaries &drawn : hearts()) {
        ramus += drawn.has_ramus;
        third_diagonals += drawn.diagonals == 3;
        ++marginals[drawn.marginals];
        draws += static_cast<int>(drawn.refused) + 1;
        const std::vector<Vessel> vessels = tree_vessels(drawn);
        const auto has = [&](const std::string &name) {
            return std::any_of(vessels.begin(), vessels.end(),
                               [&](const Vessel &one) { return one.name == name; });
        };
        assert_int_equal(has("RI"), drawn.has_ramus);
        assert_int_equal(has("D3"), drawn.diagonals == 3);
        assert_int_equal(has("OM3"), drawn.marginals == 3);
        for (const char *name : {"LAD", "LCX", "RCA"}) {
            const double mm = vessel_curve(vessel_named(vessels, name), 1.0).back().arc_mm;
            auto &[least, most] = lengths_mm.try_emplace(name, mm, mm).first->second;
            least = std::min(least, mm);
            most = std::max(most, mm);
        }
    }
    print_message("%d draws of %d hearts\n", draws, static_cast<int>(HEARTS));
    for (const auto &[name, ends] : lengths_mm)
        print_message("%s: %.0f to %.0f mm\n", name.c_str(), ends.first, ends.second);
    assert_true(std::abs(ramus - 35.4) < 11.4 && std::abs(third_diagonals - 30) < 11.7);
    for (int number = 1; number <= 3; ++number) assert_true(std::abs(marginals[number] - 20) < 11.1);
}

// Blood leaves at the ends: an artery that ends in a fork has no flow of its own.
void the_flow_at_rest_is_shared_among_the_ends(void **)
{
    for (const DrawnCoronaries &drawn : hearts()) {
        double sum_ml_min = 0;
        for (const CoronaryArtery &artery : drawn.arteries) {
            sum_ml_min += artery.flow_ml_min;
            if (artery.name == "LM") assert_true(artery.flow_ml_min == 0);
            if (artery.name == "RCA")
                assert_int_equal(artery.flow_ml_min > 0, drawn.dominance == Dominance::left);
            if (artery.name == "LCX")
                assert_int_equal(artery.flow_ml_min > 0, drawn.dominance == Dominance::right);
        }
        assert_true(sum_ml_min > 186 - 63 && sum_ml_min < 186 + 63); // two deviations of 31, and rounding
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_seed_always_gives_the_same_arteries_and_seeds_differ),
        cmocka_unit_test(the_file_of_a_seed_has_the_drawn_arteries),
        cmocka_unit_test(every_drawn_heart_keeps_the_rules),
        cmocka_unit_test(the_rules_refuse_arteries_that_touch_or_bend_sharply),
        cmocka_unit_test(dominance_decides_which_artery_supplies_the_back),
        cmocka_unit_test(branches_occur_as_often_as_stated),
        cmocka_unit_test(diameters_are_the_published_ones),
        cmocka_unit_test(the_anterior_descending_artery_ends_where_it_is_said),
        cmocka_unit_test(the_flow_at_rest_is_shared_among_the_ends),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
