// The virtual scanner makes an axial CT image of a silicone phantom with an instrument in it (docs/ct.md,
// "The scanner").
//
// For every slice, the scanner computes the line integrals of parallel beams exactly, from chords through the
// cut meshes and through the instrument's tubes. The line integrals are averaged over the detector's aperture
// and the slice's profile. The scanner attenuates a polychromatic beam, counts photons, corrects beam
// hardening for water as real scanners do, and reconstructs by filtered back-projection. Blooming, streaks
// and photon starvation result from the simulated physics; the program does not draw them artificially. The
// scanner models neither scatter nor the geometry of a fan beam or a helical scan.
#pragma once
#include "host/xray/paths/materials.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>

namespace crn::ct
{

// Holds the Hounsfield units of the phantom's materials at 120 kV (xraylib's cross-sections at 70 keV:
// docs/ct.md).
struct PhantomMaterials {
    double fluid_HU = 80;     // water with 40 % glycerol, 1.10 g/cm3
    double silicone_HU = 230; // PDMS, 1.10 g/cm3
    double gel_HU = 20;       // agar gel that holds the vessels; assumed
    double wall_mm = 2;       // thickness of silicone around the lumen; assumed
};

// Describes a stretch of the instrument, counted from the tip, as a round tube with the layers of an
// instrument file.
struct ScanLayer {
    Material material = Material::steel;
    double fill = 1, radius_share = 1; // shares of the section and of the radius
};
struct ScanStretch {
    double arc_begin_mm = 0, arc_end_mm = 0; // from the tip
    double radius_mm = 0.4445, bore_mm = 0;  // radii
    std::vector<ScanLayer> layers;
};
struct ScanInstrument {
    std::vector<Eigen::Vector3d> line_mm; // scene's axes, from the introducer to the tip
    std::vector<ScanStretch> stretches;   // the last one continues beyond its end
};

struct ScannerSettings {
    Eigen::Vector3d spacing_mm = {0.53, 0.53, 1.0}; // left, front-back, head (slices)
    double blur_mm = 0.40;                          // sigma of the point spread in the slice
    double blur_slice_mm = 0.50;                    // sigma across the slice, cut off at 2.1 sigma
    double noise_HU = 15;     // standard deviation in the middle of the phantom; 0: none
    double highest_HU = 3071; // that of a 12-bit scanner
    double tube_kV = 120;
    int views = 600;           // over half a turn
    double detector_mm = 0.40; // pitch and aperture
    std::uint64_t seed = 1;
    int threads = 1;
    Eigen::AlignedBox3d box_mm; // box of the gel, scene's axes; empty: the phantom with 8 mm around it
};

// Receives the completed fraction of the work, 0 .. 1; the function may throw to stop the work.
using Report = std::function<void(const std::string &stage, double share)>;

// The mesh `lumen` must be closed, and its coordinates are in the scene's axes and in mm. Equal settings give
// equal volumes for any number of threads. Throws Fault for impossible sizes.
Volume simulate_scan(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                     const std::vector<ScanInstrument> &instruments, const ScannerSettings &settings,
                     const Report &report);

} // namespace crn::ct
