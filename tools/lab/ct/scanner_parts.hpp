// The parts of the virtual scanner: planes through the phantom, chords of the instrument, the beam, the
// reconstruction. Inside a part lengths are mm in LPS with the scanner's axis through `centre`.
#pragma once
#include "tools/lab/ct/scanner.hpp"
#include <array>
#include <memory>

namespace crn::ct
{

// Parallel rays of one slice: view v looks along (-sin, cos), ray i lies at s = (i + 0.5 - bins / 2) pitch
// along (cos, sin).
struct Rays {
    Rays(int views, int bins, double pitch_mm);
    int views, bins;
    double pitch_mm;
    std::vector<double> cosine, sine;
    std::size_t count() const { return static_cast<std::size_t>(views) * static_cast<std::size_t>(bins); }
};

// An edge of a closed outline in a plane, with what it encloses on its left.
struct Edge {
    Eigen::Vector2d a, b;
    double value; // HU / 1000 inside minus outside
};

// Outlines of lumen, wall and gel in planes of constant height.
class PhantomPlanes
{
  public:
    // Places relative to `centre` (LPS).
    PhantomPlanes(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                  const Eigen::AlignedBox3d &box_lps, const Eigen::Vector3d &centre);
    void edges_at(double height_mm, std::vector<Edge> &edges) const;
    // The middle of the lumen in this plane; the axis where there is none.
    Eigen::Vector2d middle_at(double height_mm) const;

  private:
    void cut_lumen(double height_mm, double value, std::vector<Edge> &edges) const;
    void measure_distance();
    void mark_inside();
    void outline_wall(double height_mm, double value, std::vector<Edge> &edges) const;

    PhantomMaterials phantom_;
    Eigen::AlignedBox3d box_;
    std::vector<std::array<Eigen::Vector3d, 3>> triangles_;
    std::vector<std::vector<std::uint32_t>> at_height_; // triangles that reach into each millimetre
    // Distance from the lumen's surface (negative inside) on a grid of 1 mm, cut off beyond the wall.
    Eigen::Vector3d field_origin_;
    std::array<int, 3> field_size_;
    std::vector<float> field_;
};

// Adds the mean chords times value, in mm, of what the edges enclose.
void add_chords(const std::vector<Edge> &edges, const Rays &rays, double weight, std::vector<float> &sums);

inline constexpr int rays_per_bin = 3;
inline constexpr int beam_energies = 8;

// Metal and polymer of the instruments along sub-rays of one plane.
struct TubeChord {
    std::uint32_t ray; // view * bins * rays_per_bin + sub-ray
    float length_mm;   // times fill
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
    struct Piece { // from a to b, cut at the planes that halve the angles with its neighbours
        Eigen::Vector3d a, b, axis, normal_a, normal_b;
        double reach_mm; // of the widest layer
        std::vector<Layer> layers;
    };
    void add(const ScanInstrument &instrument, const Eigen::Vector3d &centre);
    std::uint8_t index_of(Material material);

    std::vector<Piece> pieces_;
    std::vector<Material> materials_;
};

// The beam as few energies, weighted by what the detector makes of them.
class Beam
{
  public:
    Beam(double tube_kV, const std::vector<Material> &materials);
    // Share of the signal behind so much water and so much of each material, mm.
    double transmission(double water_mm, const float *lengths_mm) const;
    double water_transmission(double water_mm) const;
    // The water that lets through as much: what scanners' correction of hardening gives.
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
    // Rays in place become filtered.
    void filter(std::vector<float> &lengths_mm) const;
    void project_back(const std::vector<float> &filtered, const Eigen::Vector2d &first,
                      const Eigen::Vector2d &spacing, int columns, int rows, float *out_HU) const;
    // Standard deviation of a pixel for independent rays with these variances (mm2) at `place`, HU.
    double noise_HU(const std::vector<float> &variance_mm2, const Eigen::Vector2d &place) const;

  private:
    const Rays &rays_;
    std::vector<float> response_; // of the filter, by frequency
    double row_gain_ = 0;         // sum of squares of the filter in space, after interpolation
};

} // namespace crn::ct
