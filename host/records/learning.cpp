#include "host/records/learning.hpp"
#include <algorithm>
#include <cmath>
#include <map>

namespace crn
{

namespace
{

constexpr int scales = 60; // of the exponential, from half a session to four times their number

// The function is a deterministic generator of random numbers with a full period (Steele, Lea and Flood 2014,
// SplitMix64). Distributions of the C++ standard library may differ between implementations.
class Random
{
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next()
    {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        return z ^ z >> 31;
    }
    std::size_t below(std::size_t count) { return static_cast<std::size_t>((next() >> 32) * count >> 32); }
    double fraction() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  private:
    std::uint64_t state_;
};

// Holds the exponentials exp(-n / scale) for one scale, and the sums of them that a least-squares fit needs.
struct Basis {
    double scale = 0.0, sum = 0.0, sum_of_squares = 0.0;
    std::vector<double> decay;
};

std::vector<Basis> bases_for(std::size_t count)
{
    std::vector<Basis> bases;
    const double first = 0.5, last = 4.0 * static_cast<double>(count);
    for (int i = 0; i < scales; i++) {
        Basis basis;
        basis.scale = first * std::pow(last / first, i / double(scales - 1));
        for (std::size_t n = 0; n < count; n++) {
            basis.decay.push_back(std::exp(-static_cast<double>(n) / basis.scale));
            basis.sum += basis.decay.back();
            basis.sum_of_squares += basis.decay.back() * basis.decay.back();
        }
        bases.push_back(std::move(basis));
    }
    return bases;
}

struct Line {
    const Basis *basis = nullptr;
    double plateau = 0.0, gain = 0.0;
    double at(std::size_t n) const { return plateau + gain * basis->decay[n]; }
};

// For each scale, linear regression gives the plateau and the gain; the function returns the scale with the
// smallest sum of squared residuals.
Line best_line(const std::vector<Basis> &bases, const std::vector<double> &values)
{
    const double count = static_cast<double>(values.size());
    double sum = 0.0, squares = 0.0;
    for (double value : values) sum += value, squares += value * value;
    Line best;
    double best_explained = -1.0;
    for (const Basis &basis : bases) {
        double product = 0.0;
        for (std::size_t n = 0; n < values.size(); n++) product += values[n] * basis.decay[n];
        const double spread = basis.sum_of_squares - basis.sum * basis.sum / count;
        const double common = product - basis.sum * sum / count;
        const double explained = common * common / spread;
        if (explained <= best_explained) continue;
        best_explained = explained;
        best = {&basis, 0.0, common / spread};
        best.plateau = (sum - best.gain * basis.sum) / count;
    }
    return best;
}

using BySession = std::vector<const SessionRecord *>;

std::map<std::string, BySession> by_trainee(const std::vector<SessionRecord> &sessions)
{
    std::map<std::string, BySession> found;
    for (const SessionRecord &session : sessions) found[session.trainee].push_back(&session);
    return found;
}

void add_cohort(LearningCurve &curve, const std::vector<SessionRecord> &sessions,
                const std::set<std::string> &members)
{
    std::vector<std::vector<double>> attempts; // the values of attempt n, one per person
    std::vector<double> experts;
    for (const auto &[trainee, own] : by_trainee(sessions)) {
        std::size_t attempt = 0;
        for (const SessionRecord *session : own) {
            const auto value = session->metric(curve.metric);
            if (!value) continue;
            if (session->by_expert) {
                experts.push_back(*value);
            } else if (members.count(trainee)) {
                if (attempts.size() <= attempt) attempts.emplace_back();
                attempts[attempt++].push_back(*value);
            }
        }
    }
    for (std::size_t i = 0; i < attempts.size() && attempts[i].size() >= cohort_people_min; i++)
        curve.cohort.push_back({i + 1, attempts[i].size(), quantile(attempts[i], 0.25),
                                quantile(attempts[i], 0.5), quantile(attempts[i], 0.75)});
    if (!experts.empty())
        curve.expert = ExpertRange{experts.size(), quantile(experts, 0.0), quantile(experts, 0.5),
                                   quantile(experts, 1.0)};
}

} // namespace

double quantile(std::vector<double> values, double q)
{
    std::sort(values.begin(), values.end());
    const double place = q * static_cast<double>(values.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(place), values.size() - 1);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

std::optional<LearningFit> fit_learning(const std::vector<double> &values, int resamples)
{
    const std::size_t count = values.size();
    if (count < fit_sessions_min) return std::nullopt;
    const std::vector<Basis> bases = bases_for(count);
    const Line line = best_line(bases, values);
    LearningFit fit{line.plateau, line.gain, line.basis->scale, {}, {}, {}};
    // Before they are drawn again, the residuals are multiplied by a factor, because those of a fit with
    // three parameters are too small.
    const double inflation = std::sqrt(static_cast<double>(count) / static_cast<double>(count - 3));
    std::vector<double> residuals;
    for (std::size_t n = 0; n < count; n++) {
        fit.value.push_back(line.at(n));
        residuals.push_back((values[n] - line.at(n)) * inflation);
    }
    Random random(1);
    std::vector<std::vector<double>> resampled(count);
    std::vector<double> again(count);
    for (int round = 0; round < resamples; round++) {
        for (std::size_t n = 0; n < count; n++) again[n] = fit.value[n] + residuals[random.below(count)];
        const Line other = best_line(bases, again);
        for (std::size_t n = 0; n < count; n++) resampled[n].push_back(other.at(n));
    }
    for (const std::vector<double> &one : resampled) {
        fit.low.push_back(quantile(one, 0.025));
        fit.high.push_back(quantile(one, 0.975));
    }
    // A metric such as a count or a time cannot fall below 0, so its curve must not fall below 0 either.
    if (quantile(values, 0.0) >= 0.0)
        for (auto *line_of : {&fit.value, &fit.low, &fit.high})
            for (double &value : *line_of) value = std::max(0.0, value);
    return fit;
}

LearningCurve cohort_curve(const std::vector<SessionRecord> &sessions, const std::string &metric,
                           const std::set<std::string> &members)
{
    LearningCurve curve;
    curve.metric = metric;
    if (metric == "score") curve.unit = "%";
    if (metric == "duration_s") curve.unit = "s";
    for (const SessionRecord &session : sessions)
        for (const SessionMetric &one : session.metrics)
            if (one.name == metric) curve.unit = one.unit;
    add_cohort(curve, sessions, members);
    return curve;
}

LearningCurve learning_curve(const std::vector<SessionRecord> &sessions, const std::string &trainee,
                             const std::string &metric, const std::set<std::string> &members)
{
    LearningCurve curve = cohort_curve(sessions, metric, members);
    std::vector<double> values;
    for (const SessionRecord &session : sessions) {
        const auto value = session.metric(metric);
        if (session.trainee != trainee || !value) continue;
        curve.points.push_back({session.id, session.started_at, *value});
        values.push_back(*value);
    }
    curve.fit = fit_learning(values);
    return curve;
}

double cusum_limit(double rise, double fall, double rate, int horizon, double error)
{
    constexpr int runs = 20000;
    Random random(2);
    std::vector<double> highest;
    for (int run = 0; run < runs; run++) {
        double sum = 0.0, top = 0.0;
        for (int session = 0; session < horizon; session++) {
            sum = std::max(0.0, sum + (random.fraction() < rate ? rise : fall));
            top = std::max(top, sum);
        }
        highest.push_back(top);
    }
    std::sort(highest.begin(), highest.end());
    // The limit of a CUSUM is set between two sums that occur in the simulation, so that rounding errors have
    // no effect.
    const std::size_t place = static_cast<std::size_t>(std::ceil((1.0 - error) * runs));
    const double largest_allowed = highest[std::min(place, highest.size() - 1)];
    const auto next = std::upper_bound(highest.begin(), highest.end(), largest_allowed + 1e-9);
    return next == highest.end() ? largest_allowed + rise / 2.0 : (largest_allowed + *next) / 2.0;
}

Cusum cusum_of(const std::vector<bool> &passed, const CusumSettings &settings)
{
    Cusum cusum;
    cusum.settings = settings;
    cusum.success = std::log((1.0 - settings.rate_good) / (1.0 - settings.rate_bad));
    cusum.failure = std::log(settings.rate_good / settings.rate_bad);
    cusum.learning_limit =
        cusum_limit(cusum.success, cusum.failure, 1.0 - settings.rate_bad, settings.horizon, settings.error);
    cusum.relapse_limit =
        cusum_limit(-cusum.failure, -cusum.success, settings.rate_good, settings.horizon, settings.error);
    double learning = 0.0, relapse = 0.0;
    for (std::size_t i = 0; i < passed.size(); i++) {
        learning = std::max(0.0, learning + (passed[i] ? cusum.success : cusum.failure));
        if (cusum.competent_at)
            relapse = std::max(0.0, relapse - (passed[i] ? cusum.success : cusum.failure));
        if (!cusum.competent_at && learning >= cusum.learning_limit) cusum.competent_at = i;
        cusum.learning.push_back(learning);
        cusum.relapse.push_back(relapse);
        if (relapse < cusum.relapse_limit) continue;
        cusum.relapses.push_back(i);
        relapse = 0.0;
    }
    return cusum;
}

std::optional<bool> is_passed(const SessionRecord &session, double pass_score_pct)
{
    if (session.passed) return session.passed;
    const auto score = session.metric("score");
    if (!score) return std::nullopt;
    return *score >= pass_score_pct;
}

} // namespace crn
