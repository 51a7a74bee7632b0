// Draws short cylinders into ToolPaths; the path length of every ray between the two cutting planes is exact.
#pragma once
#include "host/xray/paths/paths.hpp"
#include "host/xray/paths/tube_labels.hpp"

namespace crn
{

// Describes a piece of a tool or curve in camera axes: x right, y up, z away from the source. The piece is a
// cylinder about the line from a to b, cut by the planes through a and b.
struct TubePiece {
    Eigen::Vector3d a_mm, b_mm, normal_a, normal_b;
    double outer_mm = 0.0, inner_mm = 0.0;
    Material material = Material::steel;
    double share = 1.0;              // share of the ring that the material fills
    double displaced_contrast = 0.0; // share of iohexol 350 in the surrounding blood
};

class TubePainter
{
  public:
    // Empties `paths`. `materials` must list all materials that will be drawn. `displaced` is the material,
    // usually blood, that tools and contrast medium displace.
    TubePainter(const View &view, std::span<const Material> materials, Material displaced, ToolPaths &paths);

    // Sets the label image for the following pieces, and the bit that they set; a bit of 0 stands for no
    // label. If `is_summed` is true, the path lengths are added to the sums of the pixels, and the caller
    // sets the bits later.
    void label(TubeLabels *labels, std::uint8_t bit, bool is_summed);
    void paint(const TubePiece &piece);
    void finish(); // lists the touched pixels after the last piece

  private:
    struct Line; // one row of rays and the data that a piece needs for it
    void trace(const Line &line, int rays, int y, int x0, int x1);
    void paint_wide(const Line &line, int y, int x0, int x1);
    void paint_narrow(const Line &line, int y, int x0, int x1);
    std::size_t slot(Material material) const;
    std::int32_t *row_of(int y); // the entries of the pixels of a row
    std::size_t
    entry(std::int32_t &place); // of a pixel with the entry `place`, which becomes a new one if it is -1
    std::int32_t *narrow(std::int32_t &place); // the path lengths [material][ray]
    void mark(int pixel, std::int32_t sum_of_rays);

    ToolPaths &paths_;
    double focal_pixels_, half_;
    int size_;
    std::size_t displaced_, contrast_;
    std::vector<std::int32_t> rows_; // of rays: of one or three rows
    TubeLabels *labels_ = nullptr;
    std::uint8_t bit_ = 0;
    bool is_summed_ = false;
};

} // namespace crn
