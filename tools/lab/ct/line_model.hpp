// Models the voxels of the blurred instrument, and fits this model across the centreline at one point. Across
// a straight round instrument, the blurred picture is a Gaussian. The covariance of the picture's Gaussian is
// that of the point spread plus that of the instrument's own cross-section, seen along the instrument. The
// model cuts off the top of the Gaussian at the end of the grey scale.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

// The following values of the model are constant along the whole instrument.
struct LineModel {
    double blur_mm = 0.5,
           blur_slice_mm = 0.6; // sigma along the first two axes of the grid, and along the third
    double around_HU = 0, highest_HU = 3071, noise_HU = 15;
};

// Holds a point of the centreline with its arc length, its tangent and two axes perpendicular to the tangent.
struct Frame {
    Eigen::Vector3d place, tangent, across1, across2;
    double arc_mm;
};
std::vector<Frame> frames_of(const std::vector<Eigen::Vector3d> &line);

struct AcrossFit {
    double shift1_mm = 0, shift2_mm = 0; // of the middle, relative to the line
    double height_HU = 0;
    double variance_mm2 = 0; // mean of both directions
    double misfit = 0;       // weighted sum of squares
    int voxels = 0;
};

class LineFit
{
  public:
    explicit LineFit(const Volume &volume);
    // Estimates the noise, the end of the grey scale, and the value of the voxels around the instrument.
    LineModel first_model(const std::vector<Eigen::Vector3d> &line) const;
    AcrossFit fit(const std::vector<Frame> &frames, std::size_t index, const LineModel &model) const;
    // Finds the widths of blur with which the model fits best at a few points of the centreline.
    void fit_blurs(const std::vector<Frame> &frames, LineModel &model) const;
    // Returns the arc length, between the two given values, at which the instrument ends; `height_HU` is the
    // height of the instrument's Gaussian there.
    double fit_end(const std::vector<Frame> &frames, double low_mm, double high_mm, double height_HU,
                   const LineModel &model) const;

  private:
    struct Sample {
        Eigen::Vector2d across;
        double along_mm, value, weight;
    };
    std::vector<Sample> samples_at(const std::vector<Frame> &frames, std::size_t index, double reach_mm,
                                   double along_mm) const;
    Eigen::Matrix2d inverse_spread(const Frame &frame, const LineModel &model) const;
    double misfit_of(const std::vector<Frame> &frames, const LineModel &model) const;

    const Volume &volume_;
    Eigen::Matrix3d axes_; // columns: the grid's axes in the scene, unit
};

} // namespace crn::ct
