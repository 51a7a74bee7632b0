// The maker of a case with a known answer: the reference rod with stiffness that the instrument's file does
// not have, inserted into a baked lumen; what a scan and a hand would show of it, and, apart, the truth.
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
    std::filesystem::path instrument;     // file, with ":preset" if it is not `physical`
    std::filesystem::path scene;          // baked lumen
    std::filesystem::path surface;        // closed mesh of it; empty: none
    std::filesystem::path folder;         // of the case
    std::string name;                     // empty: instrument and scene
    double shaft_factor = 1.0;            // the truth's EI of the shaft over the file's
    double tip_factor = 1.0;              // the truth's alpha over the file's
    double friction = 0.1;                // of the whole instrument against the wall
    double speed_mm_per_s = 10.0;         // of the hand
    std::vector<insertion::Depth> depths; // name, inserted_mm and turn_deg are read; scans stay empty
    double shape_noise_mm = -1.0;         // negative: no depth_N.csv, which a scan shall give
    double force_noise_mN = 1.0;          // standard deviation; negative: no force is measured
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

// Inserts and writes FOLDER: case.toml, instrument.toml and scene (copies), surface, force.csv, depth_N.csv
// where noise is asked for, truth/parameters.toml, truth/depth_N.csv and truth/force.csv. `progress` is told
// the depth done and may be empty. The same request gives the same files. Throws std::runtime_error
// (FileError, CaseError, OutputError) with the remedy.
Truth make_case(const TruthRequest &request, const std::function<void(const std::string &)> &progress = {});

// What the instrument looks like to a scanner: outer radius along `centreline_mm` (from the mouth to the
// tip), in mm.
std::vector<double> radii_mm(const crn_wire_instrument &table, const std::vector<Vector> &centreline_mm);

// Independent normal deviates with standard deviation 1, the same on every machine.
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
