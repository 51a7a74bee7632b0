#include "tools/lab/ct/line_model.hpp"
#include "tools/lab/ct/measures.hpp"
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace
{

constexpr double reach_mm = 2.3, along_sigma_mm = 0.6;
constexpr double model_error = 0.12; // share of the model that streaks and hardening may remove
constexpr double cauchy = 2.5;       // residuals beyond this many sigmas count little
constexpr int fit_steps = 10;
constexpr std::size_t blur_places = 24; // number of places at which both blurs are fitted

double normal_share(double sigmas)
{
    return 0.5 * std::erfc(-sigmas / std::sqrt(2.0));
}

} // namespace

std::vector<Frame> frames_of(const std::vector<Vector3d> &line)
{
    std::vector<Frame> frames;
    double arc = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (i > 0) arc += (line[i] - line[i - 1]).norm();
        const Vector3d &before = line[i > 0 ? i - 1 : 0], &after = line[std::min(i + 1, line.size() - 1)];
        Frame frame{line[i], (after - before).normalized(), {}, {}, arc};
        frame.across1 = frame.tangent.unitOrthogonal();
        frame.across2 = frame.tangent.cross(frame.across1);
        frames.push_back(frame);
    }
    return frames;
}

LineFit::LineFit(const Volume &volume) : volume_(volume)
{
    axes_ = volume.scene_per_voxel();
    for (int axis = 0; axis < 3; ++axis) axes_.col(axis).normalize();
}

LineModel LineFit::first_model(const std::vector<Vector3d> &line) const
{
    LineModel model;
    model.highest_HU = static_cast<double>(*std::max_element(volume_.hu.begin(), volume_.hu.end()));
    model.blur_slice_mm = std::max(0.6, 0.5 * volume_.spacing_mm[2]);
    std::vector<double> around, deviations;
    const std::vector<Frame> frames = frames_of(line);
    for (std::size_t i = 0; i < frames.size(); i += 4)
        for (int turn = 0; turn < 8; ++turn) {
            const double angle = turn * M_PI / 4;
            const Vector3d p = frames[i].place + 2.8 * (std::cos(angle) * frames[i].across1 +
                                                        std::sin(angle) * frames[i].across2);
            around.push_back(volume_.value(volume_.voxel(p)));
        }
    model.around_HU = median(around);
    for (const double value : around) deviations.push_back(std::abs(value - model.around_HU));
    model.noise_HU = std::max(3.0, 1.48 * median(deviations));
    return model;
}

// Returns the voxels around one point of the centreline, each with its position across the centreline and
// along it. The line itself may bend.
std::vector<LineFit::Sample> LineFit::samples_at(const std::vector<Frame> &frames, std::size_t index,
                                                 double reach, double along) const
{
    const Frame &frame = frames[index];
    const Vector3d middle = volume_.voxel(frame.place),
                   sides = Vector3d::Constant(std::hypot(reach, along)).cwiseQuotient(volume_.spacing_mm);
    int low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::max(0, static_cast<int>(std::ceil(middle[axis] - sides[axis])));
        high[axis] = std::min(volume_.size[static_cast<std::size_t>(axis)] - 1,
                              static_cast<int>(std::floor(middle[axis] + sides[axis])));
    }
    const std::size_t around = static_cast<std::size_t>(std::ceil((along + 1) / 0.3));
    const std::size_t first = index > around ? index - around : 0,
                      last = std::min(frames.size() - 1, index + around);
    std::vector<Sample> samples;
    for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i) {
                const Vector3d place = volume_.scene({double(i), double(j), double(k)});
                std::size_t nearest = first;
                double least = 1e30;
                for (std::size_t n = first; n <= last; ++n)
                    if (const double square = (place - frames[n].place).squaredNorm(); square < least) {
                        least = square;
                        nearest = n;
                    }
                const Frame &foot = frames[nearest];
                const Vector3d off = place - foot.place;
                const double ahead = off.dot(foot.tangent);
                const double s = foot.arc_mm + ahead - frame.arc_mm;
                // Between the points of the centreline, positions on the curve are computed to second order.
                Vector3d across = off - ahead * foot.tangent;
                if (nearest > 0 && nearest + 1 < frames.size()) {
                    const double span = 0.5 * (frames[nearest + 1].arc_mm - frames[nearest - 1].arc_mm);
                    const Vector3d bend =
                        (frames[nearest + 1].tangent - frames[nearest - 1].tangent) / (2 * span);
                    across -= 0.5 * ahead * ahead * bend;
                }
                if (std::abs(s) > along || across.squaredNorm() > reach * reach) continue;
                samples.push_back({{across.dot(frame.across1), across.dot(frame.across2)},
                                   s,
                                   static_cast<double>(volume_.hu[volume_.at(i, j, k)]),
                                   std::exp(-0.5 * s * s / (along_sigma_mm * along_sigma_mm))});
            }
    return samples;
}

Eigen::Matrix2d LineFit::inverse_spread(const Frame &frame, const LineModel &model) const
{
    const Vector3d squares(model.blur_mm * model.blur_mm, model.blur_mm * model.blur_mm,
                           model.blur_slice_mm * model.blur_slice_mm);
    const Matrix3d spread = axes_ * squares.asDiagonal() * axes_.transpose();
    Eigen::Matrix<double, 3, 2> across;
    across << frame.across1, frame.across2;
    return Eigen::Matrix2d(across.transpose() * spread * across).inverse();
}

// Fits the displacement of the centreline and the logarithm of the peak's height by the Levenberg-Marquardt
// method. The fit has weights across the centreline, which reduce the influence of streaks.
AcrossFit LineFit::fit(const std::vector<Frame> &frames, std::size_t index, const LineModel &model) const
{
    const std::vector<Sample> samples = samples_at(frames, index, reach_mm, 1.5);
    const Eigen::Matrix2d inverse = inverse_spread(frames[index], model);
    const double room = model.highest_HU - model.around_HU;
    double brightest = 1;
    for (const Sample &sample : samples)
        if (sample.across.norm() < 1.2) brightest = std::max(brightest, sample.value - model.around_HU);
    Vector3d state(0, 0, std::log(brightest > 0.95 * room ? 4 * room : brightest));
    Matrix3d normal = Matrix3d::Identity();
    const auto pass = [&](const Vector3d &at, Matrix3d *matrix, Vector3d *slope) {
        double sum = 0;
        for (const Sample &sample : samples) {
            const Vector2d off = sample.across - at.head<2>(), pull = inverse * off;
            const double height = std::exp(at[2] - 0.5 * off.dot(pull));
            const bool is_cut = height > room;
            const double residual = sample.value - model.around_HU - std::min(height, room);
            const double of_model = model_error * std::min(height, room),
                         sigma = std::sqrt(model.noise_HU * model.noise_HU + of_model * of_model);
            const double scaled = residual / (cauchy * sigma);
            sum += sample.weight * std::log1p(scaled * scaled);
            if (!matrix) continue;
            const double weight = sample.weight / (1 + scaled * scaled) / (sigma * sigma);
            Vector3d derivative(height * pull.x(), height * pull.y(), height);
            // A saturated voxel (at the end of the grey scale) can show that the model's value is too low,
            // but not that it is too high.
            if (is_cut) derivative *= residual < -0.02 * room ? 0.3 * room / height : 0.0;
            *matrix += weight * derivative * derivative.transpose();
            *slope += weight * residual * derivative;
        }
        return sum;
    };
    double damping = 1e-2, misfit = pass(state, nullptr, nullptr);
    for (int step = 0; step < fit_steps; ++step) {
        normal.setZero();
        Vector3d slope = Vector3d::Zero();
        pass(state, &normal, &slope);
        Matrix3d damped = normal;
        damped.diagonal() *= 1 + damping;
        damped.diagonal().array() += 1e-9;
        Vector3d move = damped.ldlt().solve(slope);
        move.head<2>() = move.head<2>().cwiseMax(-0.3).cwiseMin(0.3);
        move[2] = std::clamp(move[2], -0.7, 0.7);
        Vector3d next = state + move;
        next[2] = std::clamp(next[2], std::log(20.0), std::log(60.0 * room));
        const double there = pass(next, nullptr, nullptr);
        if (there < misfit) {
            state = next;
            misfit = there;
            damping *= 0.3;
            if (move.norm() < 1e-4) break;
        } else {
            damping *= 8;
        }
    }
    AcrossFit result{state[0], state[1], std::exp(state[2]), 1, misfit, static_cast<int>(samples.size())};
    Matrix3d information = normal;
    information.diagonal().array() += 1e-9;
    const Matrix3d covariance = information.inverse();
    double weights = 0;
    for (const Sample &sample : samples) weights += sample.weight;
    // `excess` is the ratio of the residuals to the noise, but at least 1.
    const double excess = std::max(1.0, misfit / std::max(weights, 1.0) * cauchy * cauchy);
    result.variance_mm2 = std::clamp(0.5 * (covariance(0, 0) + covariance(1, 1)) * excess, 1e-6, 4.0);
    return result;
}

double LineFit::misfit_of(const std::vector<Frame> &frames, const LineModel &model) const
{
    double sum = 0;
    const std::size_t step = std::max<std::size_t>(1, frames.size() / blur_places);
    for (std::size_t i = step / 2; i < frames.size(); i += step) sum += fit(frames, i, model).misfit;
    return sum;
}

void LineFit::fit_blurs(const std::vector<Frame> &frames, LineModel &model) const
{
    double best = misfit_of(frames, model);
    for (double factor = 1.25; factor > 1.02; factor = std::sqrt(factor))
        for (double LineModel::*blur : {&LineModel::blur_mm, &LineModel::blur_slice_mm})
            for (const double by : {factor, 1 / factor})
                for (bool improves = true; improves;) {
                    LineModel other = model;
                    other.*blur = std::clamp(other.*blur * by, 0.25, 2.0);
                    const double there = misfit_of(frames, other);
                    improves = there < best * (1 - 1e-6) && other.*blur != model.*blur;
                    if (improves) {
                        best = there;
                        model = other;
                    }
                }
}

// At the end of the instrument, the profile along the centreline is a step that the point spread blurs.
double LineFit::fit_end(const std::vector<Frame> &frames, double low_mm, double high_mm, double height_HU,
                        const LineModel &model) const
{
    struct Part {
        double arc_mm, height, value, blur_mm;
    };
    std::vector<Part> parts;
    const double room = model.highest_HU - model.around_HU;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const Frame &frame = frames[i];
        if (frame.arc_mm < low_mm - 2 || frame.arc_mm > high_mm + 2) continue;
        const Vector3d in_grid = axes_.transpose() * frame.tangent;
        const double blur = Vector3d(in_grid.x() * model.blur_mm, in_grid.y() * model.blur_mm,
                                     in_grid.z() * model.blur_slice_mm)
                                .norm();
        const Eigen::Matrix2d inverse = inverse_spread(frame, model);
        for (const Sample &sample : samples_at(frames, i, 1.6, 0.15))
            parts.push_back({frame.arc_mm + sample.along_mm,
                             height_HU * std::exp(-0.5 * sample.across.dot(inverse * sample.across)),
                             sample.value - model.around_HU, blur});
    }
    double best = 1e30, end = high_mm;
    for (double at = low_mm; at <= high_mm; at += 0.02) {
        double sum = 0;
        for (const Part &part : parts) {
            const double height =
                std::min(room, part.height * normal_share((at - part.arc_mm) / part.blur_mm));
            const double sigma = std::sqrt(model.noise_HU * model.noise_HU + 0.15 * height * 0.15 * height);
            const double scaled = (part.value - height) / (cauchy * sigma);
            sum += std::log1p(scaled * scaled);
        }
        if (sum < best) {
            best = sum;
            end = at;
        }
    }
    return end;
}

} // namespace crn::ct
