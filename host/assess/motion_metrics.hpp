// Computes measures of the motion of a hand and a tip: path length, smoothness and submovements.
//
// Smoothness is defined for single movements, so the motion of a hand is first split at its pauses. Sources:
//   SPARC  Balasubramanian, Melendez-Calderon, Roby-Brami, Burdet: On the analysis of movement smoothness,
//          J NeuroEng Rehabil 2015;12:112, with the parameters of the authors' program
//   LDLJ   Hogan, Sternad: Sensitivity of smoothness measures to movement duration, amplitude, and arrests,
//          J Mot Behav 2009;41:529, with the logarithm
#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace crn
{

struct SparcSettings {
    int pad_level = 4;                 // zeros up to 2^pad_level times the next power of two
    double cut_Hz = 10.0;              // frequencies above it do not count
    double amplitude_threshold = 0.05; // of the largest amplitude
};

// Returns the spectral arc length of a speed profile (negative; nearer to 0 is smoother). `speed` has at
// least two values, not all of them zero; otherwise the result is 0.
double sparc(std::span<const double> speed, double rate_Hz, const SparcSettings &settings = {});

// Returns the logarithmic dimensionless jerk of a speed profile v: -ln(T^3 / v_peak^2 * integral of
// (d2v/dt2)^2), where T is the duration and v_peak the highest speed. A larger result means a smoother
// motion. `speed` has at least three values; a profile without jerk gives 0.
double ldlj(std::span<const double> speed, double rate_Hz);

// Returns the number of peaks of a speed profile. A peak is counted if it rises above the higher of the two
// minima beside it by at least `prominence` times the largest speed.
int submovements(std::span<const double> speed, double prominence = 0.1);

// Holds a part of a motion in which the hand did not pause: the samples begin .. end - 1.
struct Movement {
    std::size_t begin = 0, end = 0;
};

struct MovementSettings {
    double pause_mm_s = 1.0; // a slower hand pauses
    double pause_s = 0.1;    // a shorter pause does not split a movement
    double least_s = 0.3;    // a shorter movement does not count
};
std::vector<Movement> split_movements(std::span<const double> speed_mm_s, double rate_Hz,
                                      const MovementSettings &settings = {});

// Returns the speed for a position that was sampled at a constant rate; the speed is smoothed with a Gaussian
// of width `sigma_s`. The list of speeds has as many values as the list of positions.
std::vector<double> speed_of(std::span<const double> position, double rate_Hz, double sigma_s = 0.032);

// Measures the length of a path and ignores displacements shorter than `step`, so that the path of a
// trembling point has length 0.
template <int N> class PathLength
{
  public:
    using Point = Eigen::Matrix<double, N, 1>;
    explicit PathLength(double step) : step_(step) {}
    void add(const Point &point)
    {
        const double way = has_corner_ ? (point - corner_).norm() : 0.0;
        if (has_corner_ && way < step_) return;
        sum_ += way;
        corner_ = point;
        has_corner_ = true;
    }
    void interrupt() { has_corner_ = false; } // the next point begins a new piece of the path
    double length() const { return sum_; }

  private:
    double step_, sum_ = 0.0;
    Point corner_ = Point::Zero();
    bool has_corner_ = false;
};

// Holds the measures of one tool's motion in a session. The smoothness is the mean over the hand's movements;
// it has no value if the hand made no movement.
struct MotionFigures {
    double hand_path_mm = 0.0; // forwards and backwards
    double tip_path_mm = 0.0;  // in space, without the motion of heart and breath
    double tip_path_px = 0.0;  // in the picture, while the X-ray is on and nothing of the C-arm moves
    double hand_turn_deg = 0.0;
    int movements = 0, submovements = 0;
    double moving_s = 0.0;
    std::optional<double> sparc, ldlj, speed_mean_mm_s;
};

struct SessionLog;
inline constexpr double tip_step_mm = 0.5, tip_step_px = 2.0;
MotionFigures motion_of(const SessionLog &log, std::size_t tool);

} // namespace crn
