// Makes a calibration case whose correct answer is known (see truth.hpp).
#include "tools/lab/reference_rod/truth.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "host/model/instrument.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace crn::reference
{
namespace
{

namespace fs = std::filesystem;

void copy_whole(const fs::path &from, const fs::path &to)
{
    std::error_code failure;
    if (fs::equivalent(from, to, failure)) return;
    fs::copy_file(from, to, fs::copy_options::overwrite_existing, failure);
    if (failure)
        throw std::runtime_error(to.string() + ": cannot be written from " + from.string() + ": " +
                                 failure.message());
}

void make_folder(const fs::path &folder)
{
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure)
        throw std::runtime_error(folder.string() + ": the folder cannot be made: " + failure.message());
}

insertion::Case case_of(const TruthRequest &request, const lumen::Vessel &vessel,
                        const Instrument &instrument)
{
    insertion::Case c;
    c.folder = request.folder;
    c.name = request.name.empty() ? instrument.name + " in " + vessel.name() : request.name;
    c.instrument = "instrument.toml" + (instrument.preset == "physical" ? "" : ":" + instrument.preset);
    c.scene = "phantom.scene";
    if (!request.surface.empty()) c.surface = "phantom" + request.surface.extension().string();
    c.mouth_mm = vessel.mouth_m() * 1e3;
    c.direction = vessel.direction();
    c.friction_kinetic = c.friction_static = request.friction;
    c.speed_mm_per_s = request.speed_mm_per_s;
    c.depths = request.depths;
    for (std::size_t i = 0; i < c.depths.size(); i++) {
        c.depths[i].scan.clear();
        c.depths[i].centreline = "depth_" + std::to_string(i + 1) + ".csv";
    }
    if (request.force_noise_mN >= 0.0) c.force = "force.csv";
    return c;
}

void write_parameters(const TruthRequest &request, const Truth &truth)
{
    std::ostringstream file;
    file << "# What the reference rod (docs/reference_rod.md) was made with. calibrate never reads it.\n"
         << "shaft_bend_stiffness_N_m2 = " << number_text(truth.stiffness.shaft_N_m2, insertion::file_digits)
         << "\n"
         << "tip_over_shaft = " << number_text(truth.stiffness.tip_over_shaft, insertion::file_digits) << "\n"
         << "friction = " << number_text(request.friction, insertion::file_digits) << "\n"
         << "nominal_shaft_bend_stiffness_N_m2 = "
         << number_text(truth.nominal.shaft_N_m2, insertion::file_digits) << "\n"
         << "nominal_tip_over_shaft = " << number_text(truth.nominal.tip_over_shaft, insertion::file_digits)
         << "\n"
         << "shape_noise_mm = " << number_text(std::max(0.0, request.shape_noise_mm), insertion::file_digits)
         << "\n"
         << "force_noise_mN = " << number_text(std::max(0.0, request.force_noise_mN), insertion::file_digits)
         << "\n"
         << "seed = " << request.seed << "\n"
         << "edge_tip_mm = " << number_text(request.cut.tip_m * 1e3, insertion::file_digits) << "\n"
         << "edge_shaft_mm = " << number_text(request.cut.shaft_m * 1e3, insertion::file_digits) << "\n"
         << "feed_step_mm = " << number_text(request.step.feed_m * 1e3, insertion::file_digits) << "\n"
         << "steps = " << truth.run.steps << "\n"
         << "steps_not_at_rest = " << truth.run.unsettled << "\n"
         << "residual_mN = " << number_text(truth.run.residual_mN, insertion::file_digits) << "\n"
         << "contact_depth_mm = " << number_text(truth.run.depth_mm, insertion::file_digits) << "\n";
    write_whole_file((request.folder / "truth" / "parameters.toml").string(), file.str());
}

// Returns the points of a centreline as a scan without bias would give them. Each point has independent
// noise, except the first point, which is known exactly.
std::vector<Vector> noisy(const std::vector<Vector> &points_mm, double noise_mm, Noise &noise)
{
    std::vector<Vector> out = points_mm;
    for (std::size_t i = 1; i < out.size(); i++)
        for (int k = 0; k < 3; k++) out[i][k] += noise_mm * noise.next();
    return out;
}

// Returns the force on the hand at equal steps of inserted length, with noise.
std::vector<insertion::ForceSample> measured(const TruthRequest &request,
                                             const std::vector<insertion::ForceSample> &force, Noise &noise)
{
    std::vector<insertion::ForceSample> out;
    double next_mm = force.front().inserted_mm;
    for (const insertion::ForceSample &sample : force) {
        if (sample.inserted_mm < next_mm - 1e-9) continue;
        out.push_back({sample.inserted_mm, sample.axial_mN + request.force_noise_mN * noise.next()});
        next_mm += request.force_every_mm;
    }
    return out;
}

void write_files(const TruthRequest &request, const Truth &truth)
{
    const fs::path &folder = request.folder;
    const auto [instrument, preset] = split_preset(request.instrument.string());
    copy_whole(instrument, folder / "instrument.toml");
    copy_whole(request.scene, folder / truth.c.scene);
    if (!request.surface.empty()) copy_whole(request.surface, folder / truth.c.surface);
    Noise noise(request.seed);
    for (std::size_t i = 0; i < truth.c.depths.size(); i++) {
        const std::vector<Vector> &line = truth.run.centrelines_mm[i];
        insertion::write_centreline(folder / "truth" / truth.c.depths[i].centreline, line);
        if (request.shape_noise_mm >= 0.0)
            insertion::write_centreline(folder / truth.c.depths[i].centreline,
                                        noisy(line, request.shape_noise_mm, noise));
    }
    insertion::write_force(folder / "truth" / "force.csv", truth.run.force);
    if (request.force_noise_mN >= 0.0)
        insertion::write_force(folder / "force.csv", measured(request, truth.run.force, noise));
    write_parameters(request, truth);
    insertion::write_case(truth.c);
}

} // namespace

Truth make_case(const TruthRequest &request, const std::function<void(const std::string &)> &progress)
{
    if (request.depths.empty())
        throw std::invalid_argument("a case needs at least one depth, as NAME:INSERTED_MM:TURN_DEG");
    const lumen::Vessel vessel(request.scene.string());
    const Instrument instrument = read_instrument(request.instrument.string());
    Truth truth;
    truth.c = case_of(request, vessel, instrument);
    truth.nominal = insertion::stiffness_of(instrument.table);
    truth.stiffness = {truth.nominal.shaft_N_m2 * request.shaft_factor,
                       truth.nominal.tip_over_shaft * request.tip_factor};
    const crn_wire_instrument table = insertion::with_stiffness(instrument.table, truth.stiffness);
    const Wall wall = [&](const Vector &place) { return lumen::lumen_field(vessel.lumen(), place); };
    make_folder(request.folder / "truth");
    truth.run = insert(truth.c, table, wall, request.friction, request.cut, request.step, progress);
    write_files(request, truth);
    return truth;
}

std::vector<double> radii_mm(const crn_wire_instrument &table, const std::vector<Vector> &centreline_mm)
{
    std::vector<double> radii(centreline_mm.size());
    double arc_mm = 0.0;
    for (std::size_t i = centreline_mm.size(); i-- > 0;) {
        if (i + 1 < centreline_mm.size()) arc_mm += (centreline_mm[i + 1] - centreline_mm[i]).norm();
        radii[i] = radius_at_m(table, arc_mm * 1e-3) * 1e3;
    }
    return radii;
}

double Noise::even()
{
    // The following lines are the random number generator SplitMix64 (Steele, Lea and Flood, 2014).
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

double Noise::next()
{
    const double radius = std::sqrt(-2.0 * std::log(even()));
    return radius * std::cos(2.0 * std::numbers::pi * even());
}

} // namespace crn::reference
