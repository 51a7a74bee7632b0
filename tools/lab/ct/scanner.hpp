// The virtual scanner: a silicone phantom with an instrument in it, as an axial CT sees it (docs/ct.md, "The
// scanner").
//
// For every slice it computes the line integrals of parallel beams exactly (chords of the cut meshes, chords
// of the instrument's tube), averages them over the detector's aperture and the slice's profile, attenuates a
// polychromatic beam, counts photons, corrects for the hardening by water as scanners do, and reconstructs by
// filtered back-projection. Blooming, streaks and starved photons come out of that; nothing is painted. Left
// out: scatter, the fan's and the helix' geometry.
#pragma once
#include "host/xray/paths/materials.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>

namespace crn::ct
{

// Hounsfield units of what the phantom is made of, at 120 kV (xraylib's cross-sections at 70 keV:
// docs/ct.md).
struct PhantomMaterials {
    double fluid_HU = 80;     // water with 40 % glycerol, 1.10 g/cm3
    double silicone_HU = 230; // PDMS, 1.10 g/cm3
    double gel_HU = 20;       // agar gel that holds the vessels; assumption
    double wall_mm = 2;       // of silicone around the lumen; assumption
};

// A stretch of the instrument from its tip on: a round tube of layers as instrument files have them.
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
    std::vector<Eigen::Vector3d> line_mm; // scene's axes, from the mouth to the tip
    std::vector<ScanStretch> stretches;   // the last one goes on beyond its end
};

struct ScannerSettings {
    Eigen::Vector3d spacing_mm = {0.53, 0.53, 1.0}; // left, front-back, head (slices)
    double blur_mm = 0.40;                          // sigma of the point spread in the slice
    double blur_slice_mm = 0.50;                    // and across it, cut off at 2.1 sigma
    double noise_HU = 15;     // standard deviation in the middle of the phantom; 0: none
    double highest_HU = 3071; // of a 12-bit scanner
    double tube_kV = 120;
    int views = 600;           // over half a turn
    double detector_mm = 0.40; // pitch and aperture
    std::uint64_t seed = 1;
    int threads = 1;
    Eigen::AlignedBox3d box_mm; // of the gel, scene's axes; empty: the phantom with 8 mm around it
};

// Tells how much is done, 0 .. 1; throws to stop.
using Report = std::function<void(const std::string &stage, double share)>;

// `lumen` is closed, in the scene's mm. Same settings, same volume, whatever the threads. Throws Fault for
// sizes that cannot be.
Volume simulate_scan(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                     const std::vector<ScanInstrument> &instruments, const ScannerSettings &settings,
                     const Report &report);

} // namespace crn::ct
