#include "tools/lab/calibrate/judge.hpp"
#include "host/base/format.hpp"
#include <algorithm>
#include <cmath>

namespace crn::calibrate
{

double distance_to_line_mm(const Vector3d &point, std::span<const Vector3d> line)
{
    double least = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i + 1 < line.size(); i++) {
        const Vector3d along = line[i + 1] - line[i], off = point - line[i];
        const double length2 = along.squaredNorm();
        const double share = length2 > 0.0 ? std::clamp(off.dot(along) / length2, 0.0, 1.0) : 0.0;
        least = std::min(least, (off - share * along).squaredNorm());
    }
    return std::sqrt(least);
}

Distances distances_of(std::span<const Vector3d> nodes_mm, std::span<const Vector3d> reference_mm)
{
    Distances d;
    d.count = nodes_mm.size();
    if (nodes_mm.empty()) return d;
    double sum = 0.0, squares = 0.0;
    for (const Vector3d &node : nodes_mm) {
        const double distance = distance_to_line_mm(node, reference_mm);
        sum += distance;
        squares += distance * distance;
        d.max_mm = std::max(d.max_mm, distance);
    }
    const double n = static_cast<double>(d.count);
    d.mean_mm = sum / n;
    d.rms_mm = std::sqrt(squares / n);
    d.deviation_mm = std::sqrt(std::max(0.0, squares / n - d.mean_mm * d.mean_mm));
    return d;
}

std::optional<double> force_at(std::span<const insertion::ForceSample> trace, double inserted_mm,
                               double smooth_mm)
{
    const auto below = [](const insertion::ForceSample &sample, double mm) {
        return sample.inserted_mm < mm;
    };
    auto at = std::lower_bound(trace.begin(), trace.end(), inserted_mm - smooth_mm / 2, below);
    std::vector<double> near;
    for (; at != trace.end() && at->inserted_mm <= inserted_mm + smooth_mm / 2; ++at)
        near.push_back(at->axial_mN);
    if (near.empty()) return std::nullopt;
    const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
    std::nth_element(near.begin(), middle, near.end());
    return *middle;
}

std::optional<double> force_error(std::span<const insertion::ForceSample> simulated,
                                  std::span<const insertion::ForceSample> reference, double from_mm,
                                  double to_mm, double smooth_mm)
{
    double off = 0.0, whole = 0.0;
    for (const insertion::ForceSample &sample : reference) {
        if (sample.inserted_mm < from_mm || sample.inserted_mm > to_mm) continue;
        const std::optional<double> force = force_at(simulated, sample.inserted_mm, smooth_mm),
                                    wanted = force_at(reference, sample.inserted_mm, smooth_mm);
        if (!force || !wanted) continue;
        off += (*force - *wanted) * (*force - *wanted);
        whole += *wanted * *wanted;
    }
    return whole > 0.0 ? std::optional<double>(std::sqrt(off / whole)) : std::nullopt;
}

Judge::Judge(const insertion::Case &c, const JudgeSettings &settings) : settings_(settings)
{
    for (const insertion::Depth &depth : c.depths) {
        inserted_mm_.push_back(depth.inserted_mm);
        references_mm_.push_back(insertion::read_centreline(c.path_in(depth.centreline)));
    }
    settings_.fit_depths = std::min(settings_.fit_depths, references_mm_.size());
    if (c.force.empty() || settings_.force_weight_mm <= 0.0) return;
    force_ = insertion::read_force(c.path_in(c.force));
    const double to_mm = inserted_mm_[settings_.fit_depths - 1];
    if (!force_error(force_, force_, settings_.force_from_mm, to_mm, settings_.force_smooth_mm))
        throw Fault(c.path_in(c.force).string() + ": has no force between " +
                    std::to_string(settings_.force_from_mm) + " and " + std::to_string(to_mm) +
                    " mm of insertion, where it is fitted: give a trace that covers it, or none");
}

std::optional<double> Judge::force_error_to(const Insertion &insertion, std::size_t depth) const
{
    return force_error(insertion.force, force_, settings_.force_from_mm, inserted_mm_.at(depth),
                       settings_.force_smooth_mm);
}

Verdict Judge::judge(const Insertion &insertion) const
{
    Verdict verdict;
    double sum = 0.0;
    for (std::size_t i = 0; i < settings_.fit_depths; i++)
        sum += distances_of(insertion.nodes_mm.at(i), references_mm_[i]).rms_mm;
    verdict.error_mm = sum / static_cast<double>(settings_.fit_depths);
    verdict.objective = verdict.error_mm;
    if (force_.empty()) return verdict;
    // If the simulated and the measured force trace have no common inserted length, the relative force error
    // counts as 1, as for a simulated force of zero.
    verdict.force_error = force_error_to(insertion, settings_.fit_depths - 1).value_or(1.0);
    verdict.objective += settings_.force_weight_mm * verdict.force_error;
    return verdict;
}

Verdict Judge::evaluate(const Evaluator &evaluator, const std::vector<double> &values) const
{
    try {
        return judge(evaluator.insert(values, settings_.fit_depths));
    } catch (const TrialRefused &) {
        return {};
    }
}

std::string Judge::settings_text() const
{
    return formatted("judge 1 depths %zu force weight %.9g from %.9g smooth %.9g", settings_.fit_depths,
                     settings_.force_weight_mm, settings_.force_from_mm, settings_.force_smooth_mm);
}

} // namespace crn::calibrate
