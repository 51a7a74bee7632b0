// The commands `ct scan` and `ct simulate` make CT volumes with the virtual scanner.
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "tools/lab/case/case.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/instrument_scan.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include "tools/mesh/progress.hpp"
#include <cstdio>
#include <memory>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;
using Eigen::Vector3d;

bake::Mesh closed_mesh(const fs::path &file)
{
    bake::MeshText text;
    text.file = file;
    text.placement.unit = "mm";
    bake::Mesh mesh = bake::load_mesh(text);
    bake::check_closed(mesh, bake::Cap::none);
    return mesh;
}

// Outside the vessel, the instrument continues straight within the introducer up to the end of the scanned
// region.
std::vector<Vector3d> with_inserter(std::vector<Vector3d> line, const insertion::Case &c)
{
    constexpr double behind_mm = 300;
    line.insert(line.begin(), line.front() - behind_mm * c.direction);
    return line;
}

void tell(const Volume &volume, const fs::path &file)
{
    std::printf("%s: %d x %d x %d voxels of %.2f x %.2f x %.2f mm\n", file.string().c_str(), volume.size[0],
                volume.size[1], volume.size[2], volume.spacing_mm.x(), volume.spacing_mm.y(),
                volume.spacing_mm.z());
}

void make_parent(const fs::path &file)
{
    check_output_folder({"--output", file.parent_path().string()});
    std::error_code failure;
    if (!file.parent_path().empty()) fs::create_directories(file.parent_path(), failure);
    if (failure)
        throw Fault(file.parent_path().string() + ": the folder cannot be made: " + failure.message());
}

} // namespace

Report terminal_report()
{
    bake::Progress::catch_interrupts();
    auto progress = std::make_shared<bake::Progress>();
    auto begun = std::make_shared<std::string>();
    return [progress, begun](const std::string &stage, double share) {
        constexpr std::size_t steps = 1000;
        if (bake::Progress::interrupted()) throw Fault("interrupted: what was finished is kept");
        if (*begun != stage) {
            progress->stage(stage, steps);
            *begun = stage;
        }
        progress->step(static_cast<std::size_t>(share * steps));
        if (share >= 1) {
            progress->finish();
            begun->clear();
        }
    };
}

void command_scan(ScanOptions options)
{
    make_parent(options.output);
    if (options.output.has_extension())
        check_outputs({}, {{"--output", options.output.string()}});
    else
        check_output_folder({"--output", options.output.string()});
    const bake::Mesh lumen = closed_mesh(options.mesh);
    std::vector<ScanInstrument> instruments;
    for (const fs::path &line : options.lines)
        instruments.push_back({insertion::read_centreline(line),
                               options.instrument.empty()
                                   ? plain_stretch(options.radius_mm, options.bore_mm, options.material)
                                   : stretches_of(options.instrument)});
    if (!options.box_mm.empty())
        options.scanner.box_mm = {Vector3d(options.box_mm[0], options.box_mm[1], options.box_mm[2]),
                                  Vector3d(options.box_mm[3], options.box_mm[4], options.box_mm[5])};
    const Volume volume =
        simulate_scan(lumen, options.phantom, instruments, options.scanner, terminal_report());
    write_volume(volume, options.output);
    tell(volume, options.output);
}

static void make_truth(const SimulateOptions &options)
{
    reference::TruthRequest request = options.truth;
    request.folder = options.folder;
    request.seed = options.scanner.seed;
    if (request.scene.empty() || request.surface.empty() || request.depths.empty())
        throw Fault("--instrument also needs --scene, --surface and a --depth for each scan");
    const reference::Truth truth = reference::make_case(
        request, [](const std::string &depth) { std::fprintf(stderr, "  inserted to %s\n", depth.c_str()); });
    std::printf("%s: EI of the shaft %.4g N m2, alpha %.4g; %d steps, %d not at rest\n",
                (options.folder / "case.toml").string().c_str(), truth.stiffness.shaft_N_m2,
                truth.stiffness.tip_over_shaft, truth.run.steps, truth.run.unsettled);
}

void command_simulate(SimulateOptions options)
{
    if (!options.truth.instrument.empty()) make_truth(options);
    insertion::Case c = insertion::read_case(options.folder);
    if (c.surface.empty())
        throw Fault((c.folder / "case.toml").string() +
                    ": surface: is missing: the scanner needs the lumen as a closed mesh");
    const bake::Mesh lumen = closed_mesh(c.path_in(c.surface));
    // Returns the instrument that was inserted in the simulation, if it differs from the nominal instrument
    // file.
    const fs::path true_instrument = c.folder / "truth" / "instrument.toml";
    const std::vector<ScanStretch> stretches = stretches_of(
        fs::exists(true_instrument) ? true_instrument.string() : c.path_in(c.instrument).string());
    std::size_t scanned = 0;
    for (std::size_t i = 0; i < c.depths.size(); ++i) {
        insertion::Depth &depth = c.depths[i];
        const fs::path truth = c.folder / "truth" / depth.centreline.filename();
        if (!fs::exists(truth)) continue;
        const ScanInstrument instrument{with_inserter(insertion::read_centreline(truth), c), stretches};
        depth.scan =
            "scan_" + std::to_string(i + 1) + (options.format == "dicom" ? "" : "." + options.format);
        ScannerSettings settings = options.scanner;
        settings.seed = options.scanner.seed * 1000 + i; // gives every scan its own noise
        const Volume volume =
            simulate_scan(lumen, options.phantom, {instrument}, settings, terminal_report());
        write_volume(volume, c.path_in(depth.scan));
        tell(volume, c.path_in(depth.scan));
        insertion::write_case(
            c); // written after each scan, so that an interrupted run keeps what is finished
        ++scanned;
    }
    if (scanned == 0)
        throw Fault((c.folder / "truth").string() +
                    ": no centreline of a depth is there, so nothing to scan: make the case "
                    "with its truth first");
}

} // namespace crn::ct
