// Defines the parts of the virtual scanner: planes through the phantom, chords of the instrument, the beam
// and the reconstruction. In the parts of the scanner, positions are in mm in LPS axes (left, posterior,
// superior), and the scanner's axis passes through `centre`.
#pragma once
#include "tools/lab/ct/scanner.hpp"
#include <array>
#include <memory>

namespace crn::ct
{

// Describes the parallel rays of one slice. The rays of view v have the direction (-sin, cos) of the view's
// angle, and ray i lies at the distance s = (i + 0.5 - bins / 2) pitch along (cos, sin).
struct Rays {
    Rays(int views, int bins, double pitch_mm);
    int views, bins;
    double pitch_mm;
    std::vector<double> cosine, sine;
    std::size_t count() const { return static_cast<std::size_t>(views) * static_cast<std::size_t>(bins); }
};

// Holds one edge of a closed outline in a plane; the enclosed region lies to the left of the edge.
struct Edge {
    Eigen::Vector2d a, b;
    double value; // HU / 1000 inside minus outside
};

// Computes the outlines of lumen, wall and gel in planes of constant height.
class PhantomPlanes
{
  public:
    // Positions are relative to `centre`, in LPS axes (left, posterior, superior).
    PhantomPlanes(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                  const Eigen::AlignedBox3d &box_lps, const Eigen::Vector3d &centre);
    void edges_at(double height_mm, std::vector<Edge> &edges) const;
    // Returns the middle of the lumen in the plane at the given height. If the plane does not cut the lumen,
    // returns the point on the scanner's axis.
    Eigen::Vector2d middle_at(double height_mm) const;

  private:
    void cut_lumen(double height_mm, double value, std::vector<Edge> &edges) const;
    void measure_distance();
    void mark_inside();
    void outline_wall(double height_mm, double value, std::vector<Edge> &edges) const;

    PhantomMaterials phantom_;
    Eigen::AlignedBox3d box_;
    std::vector<std::array<Eigen::Vector3d, 3>> triangles_;
    std::vector<std::vector<std::uint32_t>> at_height_; // triangles that reach into each millimetre of height
    // Holds the distance from the lumen's surface (negative inside), sampled on a grid of 1 mm, up to
    // slightly beyond the wall.
    Eigen::Vector3d field_origin_;
    std::array<int, 3> field_size_;
    std::vector<float> field_;
};

// Adds, for each ray, its mean length in mm inside the region that the edges enclose, multiplied by the
// edges' value.
void add_chords(const std::vector<Edge> &edges, const Rays &rays, double weight, std::vector<float> &sums);

inline constexpr int rays_per_bin = 3;
inline constexpr int beam_energies = 8;

// Holds the length over which one sub-ray of a plane passes through the metal or polymer of an instrument.
struct TubeChord {
    std::uint32_t ray; // view * bins * rays_per_bin + sub-ray
    float length_mm;   // multiplied by `fill`
    std::uint8_t material;
};
class InstrumentTubes
{
  public:
    InstrumentTubes(const std::vector<ScanInstrument> &instruments, const Eigen::Vector3d &centre);
    void chords_at(double height_mm, const Rays &rays, std::vector<TubeChord> &chords) const;
    const std::vector<Material> &materials() const { return materials_; }

  private:
    struct Layer {
        double outer_mm, inner_mm, fill;
        std::uint8_t material;
    };
    struct Piece { // from a to b, cut at the planes that bisect the angles with its neighbours
        Eigen::Vector3d a, b, axis, normal_a, normal_b;
        double reach_mm; // radius of the widest layer
        std::vector<Layer> layers;
    };
    void add(const ScanInstrument &instrument, const Eigen::Vector3d &centre);
    std::uint8_t index_of(Material material);

    std::vector<Piece> pieces_;
    std::vector<Material> materials_;
};

// Represents the X-ray beam by a few photon energies, weighted by the detector's response.
class Beam
{
  public:
    Beam(double tube_kV, const std::vector<Material> &materials);
    // Returns the fraction of the signal that remains after the beam has passed through the given lengths, in
    // mm, of water and of each material.
    double transmission(double water_mm, const float *lengths_mm) const;
    double water_transmission(double water_mm) const;
    // Returns the length of water that would transmit the same fraction of the signal; real scanners correct
    // beam hardening in this way.
    double water_for(double transmission) const;
    std::size_t material_count() const { return per_mm_.size(); }

  private:
    std::array<double, beam_energies> weight_{}, water_per_mm_{};
    std::vector<std::array<double, beam_energies>> per_mm_;
    std::vector<double> table_; // -log of the transmission behind 0, 1, 2 .. mm of water
};

// Filtered back-projection of lengths of water into a slice of HU.
class Reconstruction
{
  public:
    Reconstruction(const Rays &rays, double blur_mm);
    ~Reconstruction();
    // Filters the rays in place.
    void filter(std::vector<float> &lengths_mm) const;
    void project_back(const std::vector<float> &filtered, const Eigen::Vector2d &first,
                      const Eigen::Vector2d &spacing, int columns, int rows, float *out_HU) const;
    // Returns the standard deviation, in HU, of a pixel at `place`. The rays are independent, and
    // `variance_mm2` holds the variance of each ray in mm2.
    double noise_HU(const std::vector<float> &variance_mm2, const Eigen::Vector2d &place) const;

  private:
    const Rays &rays_;
    std::vector<float> response_; // response of the filter, by frequency
    double row_gain_ = 0;         // sum of squares of the filter in space, after interpolation
};

} // namespace crn::ct
