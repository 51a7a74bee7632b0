// Tests learning curves against simulated trainees whose true curve is known, the protection of single
// persons in a cohort, and the limits and signals of the CUSUM.
#include "host/records/learning.hpp"
#include "host/records/tests/sample_records.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <random>
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn;

double truth(std::size_t n)
{
    return 20.0 + 30.0 * std::exp(-static_cast<double>(n) / 4.0);
}

// The sum of twelve uniform numbers is nearly normal, and does not depend on the C++ standard library.
double noise(std::mt19937 &random)
{
    double sum = -6.0;
    for (int i = 0; i < 12; i++) sum += static_cast<double>(random()) / 4294967296.0;
    return sum;
}

void a_curve_without_noise_is_found(void **)
{
    std::vector<double> values;
    for (std::size_t n = 0; n < 20; n++) values.push_back(truth(n));
    const LearningFit fit = *fit_learning(values);
    std::printf("# plateau %.3f, gain %.3f, scale %.3f\n", fit.plateau, fit.gain, fit.scale_sessions);
    assert_float_equal(fit.plateau, 20.0, 0.25); // the scales are a grid: measured 20.08
    assert_float_equal(fit.gain, 30.0, 0.25);
    for (std::size_t n = 0; n < 20; n++) {
        assert_float_equal(fit.value[n], truth(n), 0.25);
        assert_true(fit.low[n] <= fit.value[n] + 1e-9 && fit.value[n] <= fit.high[n] + 1e-9);
    }
}

// Returns the share of the sessions whose true value lies in the band, over many simulated trainees.
double coverage(std::size_t sessions, double sigma, int trainees)
{
    std::mt19937 random(5);
    int inside = 0, all = 0;
    for (int i = 0; i < trainees; i++) {
        std::vector<double> values;
        for (std::size_t n = 0; n < sessions; n++) values.push_back(truth(n) + sigma * noise(random));
        const LearningFit fit = *fit_learning(values, 300);
        for (std::size_t n = 0; n < sessions; n++, all++)
            inside += fit.low[n] <= truth(n) && truth(n) <= fit.high[n];
    }
    return static_cast<double>(inside) / all;
}

void the_band_covers_the_truth_as_often_as_it_says(void **)
{
    const double ten = coverage(10, 4.0, 150), thirty = coverage(30, 4.0, 80);
    std::printf("# coverage: %.3f with 10 sessions, %.3f with 30\n", ten, thirty);
    assert_true(ten > 0.86 && ten < 0.99);
    assert_true(thirty > 0.90 && thirty < 0.99);
}

void the_same_sessions_give_the_same_band(void **)
{
    std::mt19937 random(6);
    std::vector<double> values;
    for (std::size_t n = 0; n < 12; n++) values.push_back(truth(n) + 3.0 * noise(random));
    const LearningFit one = *fit_learning(values), two = *fit_learning(values);
    assert_true(one.low == two.low && one.high == two.high);
}

void few_or_equal_sessions_are_no_trap(void **)
{
    assert_false(fit_learning({1.0, 2.0, 3.0, 4.0, 5.0}).has_value());
    const LearningFit fit = *fit_learning(std::vector<double>(8, 7.0));
    for (std::size_t n = 0; n < 8; n++) {
        assert_float_equal(fit.low[n], 7.0, 1e-9);
        assert_float_equal(fit.high[n], 7.0, 1e-9);
    }
}

void quantiles_are_those_of_type_seven(void **)
{
    assert_float_equal(quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5, 1e-12);
    assert_float_equal(quantile({1.0, 2.0, 3.0, 4.0, 5.0}, 0.25), 2.0, 1e-12);
    assert_float_equal(quantile({9.0}, 0.975), 9.0, 1e-12);
}

// Four trainees of this class play three sessions each, a fifth plays two sessions, and an expert plays one.
std::vector<SessionRecord> class_of(int people)
{
    std::vector<SessionRecord> sessions;
    for (int person = 0; person < people; person++)
        for (int number = 0; number < (person == 4 ? 2 : 3); number++)
            sessions.push_back(
                sample_record("t" + std::to_string(person), 10 * number + person, 50.0 + 10.0 * person));
    SessionRecord expert = sample_record("expert", 99, 98.0);
    expert.by_expert = true;
    sessions.push_back(expert);
    return sessions;
}

std::set<std::string> members(int people)
{
    std::set<std::string> names;
    for (int person = 0; person < people; person++) names.insert("t" + std::to_string(person));
    return names;
}

void a_cohort_is_shown_only_where_five_people_are(void **)
{
    const LearningCurve four = learning_curve(class_of(4), "t0", "score", members(4));
    assert_int_equal(four.cohort.size(), 0);
    const LearningCurve five = learning_curve(class_of(5), "t0", "score", members(5));
    assert_int_equal(five.cohort.size(), 2); // the third session has four people
    assert_float_equal(five.cohort[0].median, 70.0, 1e-9);
    assert_float_equal(five.cohort[0].low, 60.0, 1e-9);
    assert_int_equal(five.points.size(), 3);
    assert_float_equal(five.expert->median, 98.0, 1e-9); // experts are not in the cohort
    assert_int_equal(five.expert->sessions, 1);
}

// The expected weights are those of Biau and others 2008 for failure rates of 10 and 30 %.
void weights_are_the_published_ones(void **)
{
    const Cusum cusum = cusum_of({}, {});
    assert_float_equal(cusum.success, 0.251, 0.0005);
    assert_float_equal(cusum.failure, -1.099, 0.0005);
}

double share_of_signals(double rate, double Cusum::*limit, bool is_relapse, int seed)
{
    const Cusum settings = cusum_of({}, {});
    std::mt19937 random(static_cast<unsigned>(seed));
    int signals = 0;
    constexpr int runs = 10000;
    for (int run = 0; run < runs; run++) {
        double sum = 0.0;
        bool is_signalled = false;
        for (int n = 0; n < settings.settings.horizon; n++) {
            const bool passed = static_cast<double>(random()) / 4294967296.0 >= rate;
            const double weight = passed ? settings.success : settings.failure;
            sum = std::max(0.0, sum + (is_relapse ? -weight : weight));
            is_signalled = is_signalled || sum >= settings.*limit;
        }
        signals += is_signalled;
    }
    return signals / double(runs);
}

// The trainees in this test have known failure rates; their random numbers come from another generator than
// those with which the limits were found.
void wrong_signals_are_as_rare_as_promised(void **)
{
    const double wrong = share_of_signals(0.3, &Cusum::learning_limit, false, 3),
                 right = share_of_signals(0.05, &Cusum::learning_limit, false, 4),
                 wrong_relapse = share_of_signals(0.1, &Cusum::relapse_limit, true, 5),
                 right_relapse = share_of_signals(0.4, &Cusum::relapse_limit, true, 6);
    const Cusum cusum = cusum_of({}, {});
    std::printf("# limits %.3f, %.3f; competent: %.4f at 30 %% failures, %.3f at 5 %%; relapse: %.4f at 10 "
                "%%, %.3f at "
                "40 %%\n",
                cusum.learning_limit, cusum.relapse_limit, wrong, right, wrong_relapse, right_relapse);
    assert_true(wrong <= 0.055 && right > 0.5);
    assert_true(wrong_relapse <= 0.055 && right_relapse > 0.9);
}

void competence_is_followed_by_a_watch_for_relapses(void **)
{
    std::vector<bool> passed(5, false);
    passed.insert(passed.end(), 25, true);
    passed.insert(passed.end(), 12, false);
    const Cusum cusum = cusum_of(passed, {});
    assert_true(cusum.competent_at.has_value());
    assert_true(*cusum.competent_at > 5 && *cusum.competent_at < 30);
    assert_false(cusum.relapses.empty());
    assert_true(cusum.relapses.front() >= 30);
    for (std::size_t i = 0; i < *cusum.competent_at; i++) assert_float_equal(cusum.relapse[i], 0.0, 0.0);
}

void a_session_passes_by_its_case_or_by_its_score(void **)
{
    SessionRecord session = sample_record("t", 1, 85.0);
    session.passed = false;
    assert_true(is_passed(session, 80.0) == std::optional<bool>(false));
    session.passed.reset();
    assert_true(is_passed(session, 80.0) == std::optional<bool>(true));
    session.score.reset();
    assert_false(is_passed(session, 80.0).has_value());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_curve_without_noise_is_found),
        cmocka_unit_test(the_band_covers_the_truth_as_often_as_it_says),
        cmocka_unit_test(the_same_sessions_give_the_same_band),
        cmocka_unit_test(few_or_equal_sessions_are_no_trap),
        cmocka_unit_test(quantiles_are_those_of_type_seven),
        cmocka_unit_test(a_cohort_is_shown_only_where_five_people_are),
        cmocka_unit_test(weights_are_the_published_ones),
        cmocka_unit_test(wrong_signals_are_as_rare_as_promised),
        cmocka_unit_test(competence_is_followed_by_a_watch_for_relapses),
        cmocka_unit_test(a_session_passes_by_its_case_or_by_its_score),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
