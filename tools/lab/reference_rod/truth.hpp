// Makes a calibration case whose correct answer is known. The program inserts the reference rod into a baked
// lumen; the rod's stiffness differs from that in the instrument file. The case holds the data that a scan
// and a force sensor at the hand would give; the true values are stored separately.
#pragma once
#include "tools/lab/case/stiffness.hpp"
#include "tools/lab/reference_rod/insertion.hpp"
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace crn::reference
{

struct TruthRequest {
    std::filesystem::path instrument;     // file, followed by ":preset" unless the preset is `physical`
    std::filesystem::path scene;          // baked lumen
    std::filesystem::path surface;        // closed mesh of it; empty: none
    std::filesystem::path folder;         // folder of the case
    std::string name;                     // empty: made from instrument and scene
    double shaft_factor = 1.0;            // the truth's EI of the shaft over the file's
    double tip_factor = 1.0;              // the truth's alpha over the file's
    double friction = 0.1;                // of the whole instrument against the wall
    double speed_mm_per_s = 10.0;         // of the hand
    std::vector<insertion::Depth> depths; // name, inserted_mm and turn_deg are read; scans stay empty
    double shape_noise_mm = -1.0; // negative: no depth_N.csv is written, because a scan will provide it
    double force_noise_mN = 1.0;  // standard deviation; negative: no force is measured
    double force_every_mm = 1.0;
    std::uint64_t seed = 1;
    Cut cut;
    Step step;
};

struct Truth {
    insertion::Case c;
    insertion::Stiffness nominal, stiffness;
    Run run;
};

// Simulates the insertion and writes these files into FOLDER: case.toml, instrument.toml and scene (copies),
// surface, force.csv, depth_N.csv if noise is requested, truth/parameters.toml, truth/depth_N.csv and
// truth/force.csv. The function `progress` is called after each depth; it may be empty. Equal requests give
// equal files. Throws std::runtime_error (Fault or OutputError), whose message states the remedy.
Truth make_case(const TruthRequest &request, const std::function<void(const std::string &)> &progress = {});

// Returns the outer radius, in mm, that a scanner sees at each point of `centreline_mm`, from the sheath's
// end to the tip.
std::vector<double> radii_mm(const crn_wire_instrument &table, const std::vector<Vector> &centreline_mm);

// Generates independent normally distributed numbers with standard deviation 1; the numbers are identical on
// every machine.
class Noise
{
  public:
    explicit Noise(std::uint64_t seed) : state_(seed) {}
    double next();

  private:
    double even(); // 0 < . < 1
    std::uint64_t state_;
};

} // namespace crn::reference
