// This test checks that tools in a real aorta stay inside the vessel and keep their length; the aorta's
// centrelines come from stEVE_bench, which is not part of this project. The tests drive two kinds of
// guidewire with the shipped session from the right common iliac artery to the arch, and let a catheter
// follow a wire. The test's reference is the exact distance of the tools from the triangles of the vessel
// surface. The distance is sampled 50 times per second during the whole session, at points 0.5 mm apart along
// the tools, so also between nodes. The distance field that the core reads does not influence the reference
// distance. The test is skipped, with a message, if the files of the anatomy are missing.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>

#include "host/model/instrument.hpp"
#include "host/session/run.hpp"
#include "tools/bake/triangle_tree.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double sample_mm = 0.5;
constexpr std::uint32_t frames_per_second = 50;

fs::path anatomy_folder()
{
    const char *given = std::getenv("CRN_ANATOMY");
    return given ? fs::path(given) : fs::path("../shared/anatomy");
}

// Holds the scene and its surface; the scene is baked once for all tests of this program.
struct Baked {
    fs::path folder, scene;
    crn::bake::Mesh surface;
    std::unique_ptr<crn::bake::TriangleTree> tree;
    bool is_there = false;
};
Baked baked;

crn::bake::Mesh read_surface(const fs::path &file)
{
    crn::bake::MeshText text;
    text.file = file;
    text.placement.unit = "mm";
    return crn::bake::load_mesh(text);
}

int bake_scene(void **)
{
    if (!fs::exists(anatomy_folder() / "steve_bench")) return 0;
    baked.folder = fs::temp_directory_path() / ("cournand_anatomy_" + std::to_string(getpid()));
    fs::create_directories(baked.folder);
    baked.scene = baked.folder / "steve.scene";
    const char *build = std::getenv("BUILD"); // set by the test runner
    const fs::path surface = baked.folder / "steve.ply";
    const std::string command = std::string(build ? build : "build") + "/bin/bake" +
                                " shared/examples/steve_iliac_arch.toml --data '" +
                                anatomy_folder().string() + "' -o '" + baked.scene.string() +
                                "' --surface '" + surface.string() + "' > '" +
                                (baked.folder / "log").string() + "' 2>&1";
    if (std::system(command.c_str()) != 0) {
        std::fprintf(stderr, "failed: %s\n", command.c_str());
        return 1;
    }
    baked.surface = read_surface(surface);
    baked.tree = std::make_unique<crn::bake::TriangleTree>(baked.surface);
    baked.is_there = true;
    return 0;
}

int remove_scene(void **)
{
    if (!baked.folder.empty()) fs::remove_all(baked.folder);
    return 0;
}

// Observes the session, and in every frame measures the distance of the tools from the surface.
class Referee : public crn::SteadySink
{
  public:
    Referee() : SteadySink(frames_per_second) {}
    void picture(const crn::SessionFrame &frame) override
    {
        const auto &nodes = frame.wire.nodes;
        double length_mm = 0.0;
        for (std::size_t i = 0; i + 1 < nodes.size(); i++) {
            const Vector3d a = nodes[i].position_m * 1e3, b = nodes[i + 1].position_m * 1e3;
            length_mm += (b - a).norm();
            if (i + 2 < nodes.size()) segment(a, b, nodes[i].radius_m * 1e3, nodes[i + 1].radius_m * 1e3);
        }
        const double rest_mm = (nodes.back().arc_m - nodes.front().arc_m) * 1e3;
        length_error_max_pct = std::max(length_error_max_pct, 100.0 * std::abs(length_mm / rest_mm - 1.0));
        inserted_max_mm = std::max(inserted_max_mm, frame.tools[0].inserted_m * 1e3);
        axial_max_N = std::max(axial_max_N, frame.tools[0].axial_N);
    }

    std::uint64_t samples = 0, deep_samples = 0; // deeper than 0.3 mm
    double depth_max_mm = -1e9, length_error_max_pct = 0.0, inserted_max_mm = 0.0, axial_max_N = 0.0;

  private:
    void segment(const Vector3d &a, const Vector3d &b, double radius_a, double radius_b)
    {
        const int steps = std::max(1, static_cast<int>(std::ceil((b - a).norm() / sample_mm)));
        for (int s = 0; s < steps; s++) {
            const double u = static_cast<double>(s) / steps;
            const double radius = radius_a + u * (radius_b - radius_a);
            const double depth = baked.tree->nearest(a + u * (b - a)).distance_mm + radius;
            samples++;
            deep_samples += depth > 0.3;
            depth_max_mm = std::max(depth_max_mm, depth);
        }
    }
};

void check(const char *what, double value, double most)
{
    if (!(value <= most)) fail_msg("%s = %g, allowed %g", what, value, most);
}

// At most 0.1 % of the samples may be deeper in the wall than 0.3 mm, and no sample may be deeper than 1 mm.
// The length error may be at most 0.1 %, because no tool is pushed against an obstacle here. Every tool must
// be inserted by at least `inserted_mm`. The reference distance is measured from the surface of the outermost
// tool, not from the centreline.
void drive(const std::vector<std::string> &instrument_files, const crn::Session &session, double inserted_mm)
{
    if (!baked.is_there) skip();
    const crn::SceneFile scene = crn::read_scene(baked.scene.string());
    std::vector<crn::Instrument> tools;
    std::string names;
    for (const std::string &file : instrument_files) {
        tools.push_back(crn::read_instrument("shared/examples/instruments/" + file));
        names += (names.empty() ? "" : " + ") + file;
    }
    const crn_wire_entry entry = crn::entry_of(scene, tools.size(), session.inserted_um);
    crn::Device device(scene, tools, entry, crn::host_rig());
    Referee referee;
    crn::Patient patient({}, tools);
    const crn::RunSettings settings;
    const crn::RunResult result = crn::run_session(device, patient, session, nullptr, &referee, settings);
    const double deep_pct =
        100.0 * static_cast<double>(referee.deep_samples) / static_cast<double>(referee.samples);
    std::printf("# %s: %llu samples, %.4f %% deeper than 0.3 mm, deepest %.3f mm, length error %.4f %%, "
                "inserted %.0f mm, handle %.2f N\n",
                names.c_str(), static_cast<unsigned long long>(referee.samples), deep_pct,
                referee.depth_max_mm, referee.length_error_max_pct, referee.inserted_max_mm,
                referee.axial_max_N);
    assert_false(result.was_interrupted);
    assert_true(result.given_up_lines.empty());
    for (const crn::ToolFigures &tool : result.figures.tools)
        check("length asked for minus the inserted one", inserted_mm - tool.inserted_max_m * 1e3, 0.0);
    check("samples deeper than 0.3 mm in %", deep_pct, 0.1);
    check("deepest sample in mm", referee.depth_max_mm, 1.0);
    check("length error in %", referee.length_error_max_pct, 0.1);
}

// The tool is pushed in strokes and turned a little, as by a hand. The file iliac_to_arch.session names the
// shipped vessels when it steers, so this test has its own script.
crn::Session iliac_to_arch()
{
    return crn::parse_session(
        "begin inserted 5 mm\n"
        "wait 0.5 s\n"
        "advance 60 mm at 30 mm/s in strokes of 30 mm\n"
        "advance 120 mm at 50 mm/s in strokes of 40 mm while rotate 180 deg at 60 deg/s\n"
        "wait 0.3 s\n"
        "advance 120 mm at 50 mm/s in strokes of 60 mm\n"
        "rotate -90 deg at 120 deg/s\n"
        "advance until inserted 470 mm at 40 mm/s\n"
        "wait 2 s\n",
        "iliac to arch");
}

void super_stiff_wire_reaches_the_arch_inside_the_vessel(void **)
{
    drive({"amplatz_super_stiff.toml"}, iliac_to_arch(), 450.0);
}

void bentson_wire_reaches_the_arch_inside_the_vessel(void **)
{
    drive({"bentson.toml"}, iliac_to_arch(), 450.0);
}

// In the tested session the wire advances into the aorta, the catheter follows over it, both advance
// together, and the wire is drawn back into the catheter.
void a_catheter_follows_a_wire_inside_the_vessel(void **)
{
    drive({"bentson.toml", "beacon_5f.toml"},
          crn::parse_session("begin inserted 5 mm\n"
                             "advance wire until inserted 200 mm at 100 mm/s\n"
                             "advance catheter until inserted 150 mm at 80 mm/s\n"
                             "advance together 40 mm at 60 mm/s while rotate catheter 180 deg\n"
                             "withdraw wire until inserted 120 mm at 80 mm/s\n",
                             "over the wire"),
          150.0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(super_stiff_wire_reaches_the_arch_inside_the_vessel),
        cmocka_unit_test(bentson_wire_reaches_the_arch_inside_the_vessel),
        cmocka_unit_test(a_catheter_follows_a_wire_inside_the_vessel),
    };
    return cmocka_run_group_tests(tests, bake_scene, remove_scene);
}
