// Computes learning curves: how a trainee's sessions in one case compare with those of experts and of the
// cohort. docs/records.md has the formulas, their sources, and how well the band covers the truth.
//   const LearningCurve curve = learning_curve(sessions_of_case, "otter", "fluoroscopy_min", everybody);
#pragma once
#include "host/records/record.hpp"
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace crn
{

inline constexpr std::size_t cohort_people_min = 5; // fewer people could be recognised
inline constexpr std::size_t fit_sessions_min = 6;  // three parameters, and three sessions to judge them by
inline constexpr int fit_resamples = 2000;

// Holds the exponential curve value(n) = plateau + gain exp(-(n - 1) / scale), fitted by least squares, where
// n = 1, 2, ... is the number of the session. The learning of a single person follows an exponential, not a
// power law (Heathcote, Brown and Mewhort 2000). The pointwise 95 % band of the curve comes from a bootstrap
// of the residuals (Efron and Tibshirani 1993, 9.4).
struct LearningFit {
    double plateau = 0.0, gain = 0.0, scale_sessions = 0.0;
    std::vector<double> value, low, high; // one per session
};
// If no value of the metric is below 0, the fitted curve and its band do not go below 0. Returns no fit for
// fewer than fit_sessions_min values. The same values give the same fit on every machine with the same
// floating-point arithmetic. All values must be finite.
std::optional<LearningFit> fit_learning(const std::vector<double> &values, int resamples = fit_resamples);

struct LearningPoint {
    std::string session_id, started_at;
    double value = 0.0;
};

// Holds the quartiles of the metric over all people who played the case at least `attempt` times.
struct CohortStep {
    std::size_t attempt = 0, people = 0;
    double low = 0.0, median = 0.0, high = 0.0; // quartiles
};

struct ExpertRange {
    std::size_t sessions = 0;
    double low = 0.0, median = 0.0, high = 0.0; // least, median, largest
};

struct LearningCurve {
    std::string metric, unit;
    std::vector<LearningPoint> points;
    std::optional<LearningFit> fit;
    std::optional<ExpertRange> expert; // of all sessions by experts
    std::vector<CohortStep> cohort;    // without experts; only steps of at least cohort_people_min people
};

// `sessions` are the sessions of one case with their details, ordered by starting time. `members` are the
// pseudonyms of the trainees in the cohort.
LearningCurve learning_curve(const std::vector<SessionRecord> &sessions, const std::string &trainee,
                             const std::string &metric, const std::set<std::string> &members);
// Returns the curve of the cohort and of the experts only, without that of a single trainee.
LearningCurve cohort_curve(const std::vector<SessionRecord> &sessions, const std::string &metric,
                           const std::set<std::string> &members);

// Returns the quantile q (0 .. 1) by linear interpolation between the sorted values (type 7 of Hyndman and
// Fan 1996). `values` may not be empty.
double quantile(std::vector<double> values, double q);

struct CusumSettings {
    double rate_good = 0.1, rate_bad = 0.3; // rates of failures, 0 < good < bad < 1
    int horizon = 50;                       // sessions
    double error = 0.05;                    // chance of a wrong signal within the horizon
};

// Computes a learning-curve CUSUM (cumulative sum; Biau and others 2008): S = max(0, S + W), where W is ln((1
// - good)/(1 - bad)) after a success and ln(good/bad) after a failure, with a good and a bad rate of
// failures. The trainee counts as competent when the cumulative sum S reaches its limit. After a trainee has
// become competent, a second CUSUM detects a relapse: a failure adds ln(bad/good), and a success adds ln((1 -
// bad)/(1 - good)). When the sum of the second CUSUM reaches its limit, a relapse is signalled and the sum
// begins again at 0. The limit of each CUSUM was computed from 20,000 simulated trainees.
struct Cusum {
    CusumSettings settings;
    double success = 0.0, failure = 0.0; // what each adds to `learning`
    double learning_limit = 0.0, relapse_limit = 0.0;
    std::vector<double> learning, relapse;   // after each session; `relapse` is 0 before the competence
    std::optional<std::size_t> competent_at; // index of the session
    std::vector<std::size_t> relapses;       // indices of sessions
};
Cusum cusum_of(const std::vector<bool> &passed, const CusumSettings &settings);
// Returns the smallest limit that the sum reaches within the horizon with a probability of at most `error`.
// Each session adds `rise` with the probability `rate`, and otherwise `fall` (below 0).
double cusum_limit(double rise, double fall, double rate, int horizon, double error);

// Returns whether the trainee passed the session: the case's own result if there is one, or else the result
// by score. Empty if neither is known.
std::optional<bool> is_passed(const SessionRecord &session, double pass_score_pct);

} // namespace crn
