// Finds the pixels that a cut cylinder may cover, so that the painter traces few rays that miss the cylinder.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <utility>

namespace crn
{

struct TubePiece;

// Encloses the image of a cylinder that two planes cut. The image is the convex hull of the images of the two
// cut ends, which are ellipses. Three strips that touch both ellipses enclose the image of the cylinder: one
// along the axis, one across the axis, and one along the rows of the picture.
class TubeOutline
{
  public:
    // `outer_mm` is the radius of the cylinder, and `half` is half of the picture's edge in pixels.
    TubeOutline(const TubePiece &piece, double outer_mm, double focal_pixels, double half);

    // Return the first and the last place, in pixels, that the outline may cover: of rows, and of columns in
    // the row [y, y + 1]. The outline does not cover a row if the first place is behind the last.
    std::pair<double, double> rows() const { return {top_, bottom_}; }
    std::pair<double, double> columns(int y) const;

  private:
    struct End;   // an end of the cylinder
    struct Strip; // the points p with low <= direction p <= high
    struct Edge { // the column of an edge of a strip, as a linear function of the row
        double at_row_0, per_row;
    };
    void add(const Strip &strip, std::size_t place);

    std::array<Edge, 2> left_, right_; // of the two strips along and across the axis
    double top_, bottom_;
};

} // namespace crn
