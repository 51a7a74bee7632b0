// These tests check the following. The device accepts every preset of every shipped instrument. In free space
// without gravity the simulated instrument takes the shape that its file describes. The simulation accepts
// every guidewire together with every catheter into which it fits, and also when both lie in a guiding
// catheter.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <unistd.h>
#include <vector>

extern "C" {
#include "firmware/core/core.h"
}
#include "host/base/text.hpp"
#include "host/model/instrument.hpp"
#include "host/model/units.hpp"
#include "host/session/device.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::Instrument;
using crn::ShapePoint;
using Eigen::Vector3d;

const std::string folder = "shared/examples/instruments/";

std::vector<std::string> shipped_files()
{
    std::vector<std::string> files;
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
    assert_true(files.size() >= 15);
    return files;
}

// --- the only calls of the core
// ---------------------------------------------------------------------------------

crn_instrument core_instrument(const Instrument &instrument)
{
    const crn_wire_instrument &table = instrument.table;
    crn_instrument core{};
    core.knot_count = table.knots_count;
    for (std::uint16_t i = 0; i < table.knots_count; i++) {
        const crn_wire_knot &k = table.knots[i];
        core.knots[i] = {.arc_um = k.arc_um,
                         .bend_stiffness_nN_m2 = k.bend_stiffness_nN_m2,
                         .twist_stiffness_nN_m2 = k.twist_stiffness_nN_m2,
                         .mass_mg_per_m = k.mass_mg_per_m,
                         .radius_outer_um = k.radius_outer_um,
                         .radius_inner_um = k.radius_inner_um,
                         .friction_kinetic_milli = k.friction_kinetic_milli,
                         .friction_static_milli = k.friction_static_milli,
                         .rest_curvature1_per_m_milli = k.rest_curvature1_per_m_milli,
                         .rest_curvature2_per_m_milli = k.rest_curvature2_per_m_milli};
    }
    core.lumen_friction_milli = table.lumen_friction_milli;
    core.axial_stiffness_max_N = table.axial_stiffness_max_N;
    core.element_tip_um = table.element_tip_um;
    core.element_shaft_um = table.element_shaft_um;
    core.element_fine_um = table.element_fine_um;
    core.material = {.kind = table.material_kind,
                     .yield_strain_micro = table.yield_strain_micro,
                     .core_modulus_MPa = table.core_modulus_MPa,
                     .hardening_milli = table.hardening_milli,
                     .unload_milli = table.unload_milli,
                     .limit_milli = table.limit_milli};
    return core;
}

// Simulates nested tools in free space without gravity. The tools enter along +x, and their material axis d1
// is -z at the entry.
class FreeLine
{
  public:
    explicit FreeLine(const std::vector<const Instrument *> &tools)
        : model_bytes_(crn_model_size()), state_bytes_(crn_state_size())
    {
        std::vector<crn_instrument> core;
        for (const Instrument *tool : tools) core.push_back(core_instrument(*tool));
        const crn_entry entry = {{{0, 0, 0}}, {{CRN_ONE_Q30, 0, 0}}, 0};
        crn_build_place place{};
        status_ = crn_model_build(model(), core.data(), static_cast<std::uint32_t>(core.size()), nullptr,
                                  &entry, &place);
        if (status_ == CRN_BUILD_OK) crn_model_set_gravity(model(), 0, 0, 0);
    }
    crn_build_status status() const { return status_; }
    int node_count() { return static_cast<int>(crn_state_node_count(model())); }

    void start(double inserted_m)
    {
        const std::uint32_t inserted_um[CRN_TOOL_MAX] = {
            static_cast<std::uint32_t>(std::lround(inserted_m * 1e6))};
        crn_state_init(model(), state(), inserted_um);
    }
    void run(int ticks)
    {
        const crn_input input{};
        for (int tick = 0; tick < ticks; tick++) {
            crn_step(model(), state(), &input, &output_);
            strain_max = std::max(strain_max, std::abs(crn::units::ratio(output_.strain_max_q30)));
        }
    }
    double inserted_m() const { return crn::units::metres(output_.tools[0].inserted_m_q30); }
    std::uint32_t fault_bits() const { return output_.fault_bits; }

    struct Node {
        double arc_m;
        Vector3d position_m; // in the axes of crn::unloaded_shape: x forward, y along d1
    };
    std::vector<Node> free_nodes()
    {
        std::vector<Node> nodes;
        for (std::uint32_t i = 0; i < crn_state_free_count(state()); i++) {
            const crn_vec3 p = crn_state_position(state(), i);
            nodes.push_back(
                {crn::units::metres(crn_model_arc(model(), i)),
                 {crn::units::metres(p.v[0]), -crn::units::metres(p.v[2]), crn::units::metres(p.v[1])}});
        }
        return nodes;
    }
    double strain_max = 0.0;

  private:
    crn_model *model() { return reinterpret_cast<crn_model *>(model_bytes_.data()); }
    crn_state *state() { return reinterpret_cast<crn_state *>(state_bytes_.data()); }
    std::vector<unsigned char> model_bytes_, state_bytes_;
    crn_build_status status_ = CRN_BUILD_OK;
    crn_output output_{};
};

// --- shapes
// -----------------------------------------------------------------------------------------------------

double shaped_m(const Instrument &instrument)
{
    return instrument.shape.empty() ? 0.0 : instrument.shape.back().arc_end_m;
}

ShapePoint at_arc(const std::vector<ShapePoint> &shape, double arc_m)
{
    for (std::size_t i = 1; i < shape.size(); i++) {
        if (arc_m > shape[i].arc_m) continue;
        const double u = (arc_m - shape[i - 1].arc_m) / (shape[i].arc_m - shape[i - 1].arc_m);
        ShapePoint point = shape[i];
        point.position_m = shape[i - 1].position_m + u * (shape[i].position_m - shape[i - 1].position_m);
        return point;
    }
    return shape.back();
}

double angle_deg(const Vector3d &a, const Vector3d &b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

// The simulated instrument starts straight and stops moving within 4 s. The test compares the positions of
// the nodes one by one. The direction of the tip is compared with that of the first element.
void expect_rest_shape(const Instrument &instrument)
{
    constexpr double allowed_deg = 2.5, allowed_strain = 1e-3;
    const double allowed_mm = 0.05 + 0.005 * shaped_m(instrument) * 1e3;
    FreeLine line({&instrument});
    assert_int_equal(line.status(), CRN_BUILD_OK);
    line.start(shaped_m(instrument) + 0.05);
    line.run(4000);
    const std::vector<FreeLine::Node> nodes = line.free_nodes();
    const std::vector<ShapePoint> intended =
        crn::unloaded_shape(instrument, 1e-4, line.inserted_m() - shaped_m(instrument));
    double worst_mm = 0.0;
    for (const FreeLine::Node &node : nodes) {
        worst_mm =
            std::max(worst_mm, (node.position_m - at_arc(intended, node.arc_m).position_m).norm() * 1e3);
    }
    const double tip_deg =
        angle_deg(nodes[0].position_m - nodes[1].position_m, at_arc(intended, 0.5 * nodes[1].arc_m).forward);
    std::printf("# %-46s nodes off by %.3f mm (allowed %.2f), tip by %.2f deg (allowed %.1f), stretched on "
                "the way %.4f %% "
                "(allowed %.1f)\n",
                instrument.name.c_str(), worst_mm, allowed_mm, tip_deg, allowed_deg, line.strain_max * 1e2,
                allowed_strain * 1e2);
    if (worst_mm > allowed_mm || tip_deg > allowed_deg || line.strain_max > allowed_strain) {
        fail_msg("%s rests in another shape", instrument.name.c_str());
    }
    assert_int_equal(line.fault_bits() & ~std::uint32_t{CRN_FAULT_STEP_CAPPED}, 0);
}

void every_physical_instrument_rests_in_its_shape(void **)
{
    for (const std::string &file : shipped_files()) expect_rest_shape(crn::read_instrument(file));
}

// Unlike the shapes of the shipped instruments, the curve of this test lies in two planes: a quarter circle
// upwards, then a quarter circle to the side.
void a_shape_out_of_its_plane_rests_in_it(void **)
{
    std::string text = crn::read_text_file(folder + "simmons_2_5f.toml");
    const std::size_t begin = text.find("shape = ["), end = text.find("]\n\n[sources]");
    assert_true(begin != std::string::npos && end != std::string::npos);
    text.replace(
        begin, end - begin,
        "shape = [ { name = \"a\", radius_mm = 12, angle_deg = 90, plane_deg = 90, source = \"@simmons\" },\n"
        "{ name = \"b\", radius_mm = 15, angle_deg = 90, source = \"@simmons\" } ");
    const std::string path = "/tmp/cournand_shape_" + std::to_string(getpid()) + ".toml";
    std::ofstream(path) << text;
    const Instrument instrument = crn::read_instrument(path);
    std::remove(path.c_str());
    const ShapePoint tip = crn::unloaded_shape(instrument, 1e-3, 0.0).front();
    assert_true(angle_deg(tip.forward, -Vector3d::UnitZ()) <
                0.1); // d2 is -z in the straight part, and b turns about it
    assert_true((tip.position_m - Vector3d(0.015, 0.027, -0.012)).norm() < 1e-5);
    expect_rest_shape(instrument);
}

// --- what the device accepts
// --------------------------------------------------------------------------------------

void the_device_takes_every_preset(void **)
{
    const crn::SceneFile scene = crn::read_scene("");
    const crn_wire_entry entry = crn::entry_of(scene, 1, std::vector<std::uint32_t>{30000});
    for (const std::string &file : shipped_files()) {
        for (const std::string &preset : crn::read_instrument(file).presets) {
            const Instrument instrument = crn::read_instrument(file + ":" + preset);
            try {
                crn::Device(scene, {instrument}, entry, crn::host_rig());
            } catch (const std::exception &error) {
                fail_msg("%s: %s", instrument.name.c_str(), error.what());
            }
        }
    }
}

bool fits_into(const Instrument &inner, const Instrument &outer)
{
    std::uint32_t thickest_um = 0;
    for (std::uint16_t i = 0; i < inner.table.knots_count; i++) {
        thickest_um = std::max(thickest_um, inner.table.knots[i].radius_outer_um);
    }
    const crn_wire_instrument &around = outer.table;
    return std::all_of(around.knots, around.knots + around.knots_count,
                       [&](const crn_wire_knot &knot) { return thickest_um <= knot.radius_inner_um; });
}

void expect_line(const std::vector<const Instrument *> &tools)
{
    std::string names;
    std::vector<const crn_wire_instrument *> tables;
    for (const Instrument *tool : tools) {
        names += (names.empty() ? "" : " in ") + tool->name;
        tables.push_back(&tool->table);
    }
    FreeLine line(tools);
    if (line.status() != CRN_BUILD_OK) fail_msg("%s: build status %d", names.c_str(), line.status());
    const int nodes = crn::line_node_count(tables);
    if (nodes != line.node_count() || nodes > crn::line_nodes_max) {
        fail_msg("%s: %d nodes, in the core %d", names.c_str(), nodes, line.node_count());
    }
}

// Each guidewire is tested alone, in each catheter, and together with each catheter in each guiding catheter.
// The presets fitted to the thesis describe one instrument alone and are thicker than the lumens of
// catheters, so they are not combined.
void every_wire_goes_with_every_catheter(void **)
{
    std::vector<Instrument> all;
    for (const std::string &file : shipped_files()) all.push_back(crn::read_instrument(file));
    int pairs = 0, triples = 0, balloons = 0;
    for (const Instrument &wire : all) {
        if (wire.kind != crn::InstrumentKind::wire) continue;
        expect_line({&wire});
        for (const Instrument &catheter : all) {
            if (catheter.kind != crn::InstrumentKind::catheter) continue;
            const bool fits = fits_into(wire, catheter);
            if (catheter.balloon && !fits) continue; // only over a 0.014 in wire
            balloons += catheter.balloon.has_value();
            assert_true(fits);
            expect_line({&wire, &catheter});
            pairs++;
            for (const Instrument &guide : all) {
                if (guide.kind != crn::InstrumentKind::catheter || !fits_into(catheter, guide)) continue;
                expect_line({&wire, &catheter, &guide});
                triples++;
            }
        }
    }
    std::printf("# %d pairs and %d triples\n", pairs, triples);
    assert_true(balloons >= 2); // two balloons over the coronary wire at least
    assert_int_equal(pairs - balloons, 8 * 9);
    assert_true(triples >= 7 * 5 * 3); // five catheters of 4F and 5F pass a 6F guide
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_physical_instrument_rests_in_its_shape),
        cmocka_unit_test(a_shape_out_of_its_plane_rests_in_it),
        cmocka_unit_test(the_device_takes_every_preset),
        cmocka_unit_test(every_wire_goes_with_every_catheter),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
