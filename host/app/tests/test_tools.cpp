// Tests sessions with several tools. If the device refuses a tool, the error message must contain the tool's
// name as its instrument file gives it. A session with three tools replays bit for bit. The X-ray picture
// shows each tool only along that tool's own length, with its own layers and lumen. The report has an entry
// for every tool.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <unistd.h>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/base/text.hpp"
#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/rig/pedals.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"
#include "host/xray/xray.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const std::string folder = "/tmp/cournand_test_tools_" + std::to_string(getpid());
const crn::SceneFile scene = crn::read_scene("");

// Makes a straight tool of 300 mm with one layer of steel.
crn::Instrument straight(const std::string &name, std::uint32_t outer_um, std::uint32_t inner_um)
{
    crn::Instrument tool;
    tool.name = name;
    tool.length_m = 0.3;
    tool.table.lumen_friction_milli = 100;
    tool.table.axial_stiffness_max_N = 5000;
    tool.table.element_tip_um = 2000;
    tool.table.element_shaft_um = 4000;
    tool.table.element_fine_um = 20000;
    tool.table.knots_count = 2;
    for (int i = 0; i < 2; i++) {
        crn_wire_knot &knot = tool.table.knots[i];
        knot.arc_um = static_cast<std::uint32_t>(i) * 300000;
        knot.bend_stiffness_nN_m2 = 500000;
        knot.twist_stiffness_nN_m2 = 400000;
        knot.mass_mg_per_m = 4000;
        knot.radius_outer_um = outer_um;
        knot.radius_inner_um = inner_um;
        knot.friction_kinetic_milli = 100;
        knot.friction_static_milli = 120;
    }
    tool.layers.push_back({0.0, 0.3, "steel", 0.5, 1.0});
    return tool;
}

std::vector<crn::Instrument> three_tools()
{
    return {straight("wire A", 445, 0), straight("catheter B", 835, 500), straight("guide C", 1100, 900)};
}

struct Recorded {
    crn::RunResult result;
    std::vector<std::uint8_t> bytes;
};

Recorded record(const std::string &script)
{
    const std::vector<crn::Instrument> tools = three_tools();
    const crn::Session session = crn::parse_session(script, "test");
    const crn_wire_entry entry = crn::entry_of(scene, tools.size(), session.inserted_um);
    crn::Device device(scene, tools, entry, crn::host_rig());
    const crn::RecordingHeader header = device.recording_header("test");
    const std::string path = folder + ".rec";
    Recorded recorded;
    {
        crn::Recorder recorder(path, header);
        crn::Patient patient({}, tools);
        recorded.result = crn::run_session(device, patient, session, &recorder, nullptr, {});
    }
    recorded.bytes = crn::read_binary_file(path);
    std::remove(path.c_str());
    return recorded;
}

const Recorded &session()
{
    static const Recorded recorded =
        record("begin wire inserted 100 mm\nbegin catheter inserted 80 mm\n"
               "begin guide inserted 60 mm\n"
               "advance wire 60 mm at 30 mm/s while advance catheter 40 mm at 20 mm/s\n"
               "rotate catheter 180 deg while withdraw guide 30 mm\n"
               "withdraw wire until inserted 90 mm\nwait 0.5 s");
    return recorded;
}

// --- the device ---

void expect_refusal(const std::vector<crn::Instrument> &tools, const std::vector<std::uint32_t> &inserted_um,
                    const char *expected)
{
    try {
        crn::Device device(scene, tools, crn::entry_of(scene, tools.size(), inserted_um), crn::host_rig());
        fail_msg("accepted, expected '%s'", expected);
    } catch (const crn::LinkError &error) {
        if (!std::strstr(error.what(), expected))
            fail_msg("message '%s' does not hold '%s'", error.what(), expected);
    }
}

void a_refused_tool_is_named_with_place_and_rule(void **)
{
    std::vector<crn::Instrument> tools = three_tools();
    tools[1].table.knots[1].radius_inner_um = 400;
    expect_refusal(
        tools, {},
        "'wire A' (0.89 mm) does not pass the lumen of 'catheter B' (0.8 mm, at 300 mm from its tip)");
    expect_refusal({tools[1], tools[0]}, {}, "does not pass the lumen of 'wire A' (0 mm");
    tools = three_tools();
    tools[2].table.knots[1].mass_mg_per_m = 0;
    expect_refusal(tools, {}, "'guide C': the device refused tools: TOOL_RANGE");
    expect_refusal(three_tools(), {50000, 50000, 300001},
                   "'guide C': the device refused command: LENGTH_INSERTED");
    expect_refusal({}, {}, "a line holds 1 to 3 tools, not 0");
    expect_refusal({tools[0], tools[0], tools[0], tools[0]}, {}, "a line holds 1 to 3 tools, not 4");
}

// The test requests contact forces in free space, where nothing touches the tool; the reply must name the
// current tick.
void contact_forces_are_read_at_any_tick(void **)
{
    const std::vector<crn::Instrument> tools = three_tools();
    crn::Device device(scene, tools, crn::entry_of(scene, 3, {}), crn::host_rig());
    crn_wire_tick_input rest{};
    rest.hands_count = 3;
    device.link().step(std::vector<crn_wire_tick_input>(7, rest), false);
    assert_int_equal(device.link().read_contacts().tick, 7);
    assert_int_equal(device.link().read_contacts().contacts_count, 0);
}

// --- recordings ---

void a_session_of_three_tools_replays_bit_for_bit(void **)
{
    const crn::Recording recording = crn::parse_recording(session().bytes, "test");
    assert_true(recording.is_complete);
    assert_int_equal(recording.header.tools.size(), 3);
    assert_string_equal(recording.header.tools[2].name.c_str(), "guide C");
    assert_true(recording.snapshots.size() >= 1);
    for (double from_s : {0.0, recording.snapshots[0].tick * 1e-3 + 0.1}) {
        const crn::RecordingHeader &header = recording.header;
        crn::Device device(scene, header.tools, header.entry, header.rig);
        crn::ReplaySettings settings;
        settings.verifies = true;
        settings.from_s = from_s;
        const crn::ReplayResult result = crn::replay_recording(device, recording, nullptr, nullptr, settings);
        assert_false(result.first_difference_tick.has_value());
        assert_true(result.ticks_compared > 100);
        assert_true(result.hash == session().result.hash);
    }
}

// The test changes the recorded motion of one hand at one tick, and the replay must report that tick.
void a_changed_input_of_any_tool_is_found(void **)
{
    for (std::size_t k = 0; k < 3; k++) {
        crn::Recording recording = crn::parse_recording(session().bytes, "test");
        recording.ticks[700].input.hands[k].translation_counts += 40;
        const crn::RecordingHeader &header = recording.header;
        crn::Device device(scene, header.tools, header.entry, header.rig);
        crn::ReplaySettings settings;
        settings.verifies = true;
        const crn::ReplayResult result = crn::replay_recording(device, recording, nullptr, nullptr, settings);
        assert_true(result.first_difference_tick.has_value());
        assert_int_equal(*result.first_difference_tick, 701);
    }
}

// --- the line as the picture sees it ---

// The nested tools (one inside another) have different lengths. The tip of every tool must lie at its own arc
// length along the nested tools. At each point the radius of the nested tools must be that of the outermost
// tool at this point.
void each_tool_covers_the_line_from_its_own_tip(void **)
{
    const std::vector<crn::Instrument> tools = three_tools();
    const crn_wire_entry entry = crn::entry_of(scene, 3, std::vector<std::uint32_t>{100000, 120000, 40000});
    crn::Device device(scene, tools, entry, crn::host_rig());
    device.link().read_nodes();
    const crn::SessionFrame frame = crn::session_frame(device, {}, {});
    const double tips_mm[] = {20, 0, 80};
    for (std::size_t k = 0; k < 3; k++) {
        assert_true(std::abs(frame.wire.tip_arc_m[k] * 1e3 - tips_mm[k]) < 0.01);
        assert_true(std::abs(frame.tools[k].inserted_m * 1e3 - entry.inserted_um[k] * 1e-3) < 0.01);
    }
    for (const crn::WireNode &node : frame.wire.nodes) {
        const double expected_mm = node.arc_m >= frame.wire.tip_arc_m[2] ? 1.1 : 0.835;
        assert_true(std::abs(node.radius_m * 1e3 - expected_mm) < 1e-6);
    }
}

// Makes a straight set of three nested tools along x, 200 mm above the patient table. The three nested tools
// have nodes every 4 mm, and the tips of the tools lie between nodes.
crn::WireFrame line_frame()
{
    crn::WireFrame wire;
    wire.tick = 5;
    for (int i = 0; i <= 30; i++)
        wire.nodes.push_back({{-0.06 + i * 0.004, 0.0, 0.0}, i * 0.004, 0.001, 0.0});
    wire.tip_arc_m = {0.0, 0.0305, 0.07};
    return wire;
}

crn::XraySettings close_view()
{
    crn::XraySettings settings;
    settings.carm.field_m = 0.2;
    settings.size = 512;
    return settings;
}

// Returns the volume of one material in the picture, in mm^3. The function sums the path lengths in this
// material over all pixels, and applies the magnification of the plane through the isocentre.
double volume_mm3(const std::vector<crn::RadiopaqueInstrument> &tools, const crn::WireFrame &wire,
                  crn::Material material)
{
    const crn::XrayScene empty;
    crn::Xray xray(empty, 1);
    crn::XrayPicture picture;
    xray.render(close_view(), tools, wire, 1, picture);
    const crn::CArm carm = close_view().carm;
    const double pixel_mm =
        carm.field_m * 1e3 / close_view().size * carm.source_isocentre_m / carm.source_detector_m;
    double sum = 0.0;
    for (std::int32_t q10 : xray.instrument_path_q10mm(material)) sum += q10 / 1024.0;
    return sum * pixel_mm * pixel_mm;
}

void expect_volume(const char *what, double value_mm3, double expected_mm3)
{
    if (std::abs(value_mm3 / expected_mm3 - 1.0) > 0.02)
        fail_msg("%s: %.3f mm3, expected %.3f (2 %% allowed)", what, value_mm3, expected_mm3);
}

// The three tools have three different materials, so that the test can find every tool in the picture. Every
// tool must show the volume of its own length and cross-section. The arc lengths of a tool's layers are
// measured from the tool's own tip, and the tool's lumen is empty.
void each_tool_is_drawn_over_its_own_part_with_its_own_layers(void **)
{
    const double pi = std::acos(-1.0);
    const std::vector<crn::RadiopaqueInstrument> tools = {
        {{{0.0, 1.0, crn::Material::steel, 1.0, 1.0}}, {{0.0, 0.0004, 0.0}, {1.0, 0.0004, 0.0}}},
        {{{0.0, 0.0015, crn::Material::platinum, 0.3, 1.0},
          {0.0015, 1.0, crn::Material::polymer_barium, 0.64, 1.0}},
         {{0.0, 0.001, 0.0006}, {1.0, 0.001, 0.0006}}},
        {{{0.0, 1.0, crn::Material::nitinol, 0.19, 1.0}}, {{0.0, 0.0015, 0.00135}, {1.0, 0.0015, 0.00135}}},
    };
    const crn::WireFrame wire = line_frame();
    expect_volume("wire", volume_mm3(tools, wire, crn::Material::steel), 120.0 * pi * 0.16);
    expect_volume("marker", volume_mm3(tools, wire, crn::Material::platinum), 1.5 * pi * 0.3);
    expect_volume("wall", volume_mm3(tools, wire, crn::Material::polymer_barium), (120.0 - 32.0) * pi * 0.64);
    expect_volume("guide", volume_mm3(tools, wire, crn::Material::nitinol), 50.0 * pi * 0.19 * 2.25);
}

// In a hollow tool, a ray that passes just beside the lumen has a longer path in the wall than a ray through
// the middle.
void a_lumen_is_seen_as_a_brighter_middle(void **)
{
    const std::vector<crn::RadiopaqueInstrument> tools = {
        {{{0.0, 1.0, crn::Material::polymer_barium, 0.64, 1.0}},
         {{0.0, 0.002, 0.0012}, {1.0, 0.002, 0.0012}}}};
    crn::WireFrame wire = line_frame();
    wire.tip_arc_m = {0.0};
    const crn::XrayScene empty;
    crn::Xray xray(empty, 1);
    crn::XrayPicture picture;
    xray.render(close_view(), tools, wire, 1, picture);
    const std::vector<std::int32_t> path = xray.instrument_path_q10mm(crn::Material::polymer_barium);
    std::int32_t middle = 0, largest = 0;
    for (int y = 0; y < 512; y++) {
        const std::int32_t here = path[static_cast<std::size_t>(y) * 512 + 256];
        largest = std::max(largest, here);
        if (y == 255 || y == 256) middle = std::max(middle, here);
    }
    // The path in the tool's wall is 2 (2 - 1.2) = 1.6 mm long in the middle of the tool, and 2 sqrt(4 -
    // 1.44) = 3.2 mm beside the lumen.
    assert_in_range(middle, 1540, 1740);
    assert_in_range(largest, 2900, 3300);
}

// The tip of a tool may coincide with a node, lie beyond the end of the nested tools, or be NaN: the picture
// must still show every tool, and nothing may crash.
void tips_anywhere_are_drawn_or_left_out(void **)
{
    const std::vector<crn::RadiopaqueInstrument> tools = {
        {{{0.0, 1.0, crn::Material::steel, 1.0, 1.0}}, {{0.0, 0.0004, 0.0}, {1.0, 0.0004, 0.0}}}};
    crn::WireFrame wire = line_frame();
    const double pi = std::acos(-1.0);
    for (double tip_m : {0.004, 0.004 + 1e-9, 0.004 - 1e-9, 0.0401}) {
        wire.tip_arc_m = {tip_m};
        expect_volume("tip at a node", volume_mm3(tools, wire, crn::Material::steel),
                      (120.0 - tip_m * 1e3) * pi * 0.16);
    }
    for (double tip_m : {0.12, 0.5, std::nan(""), 1e300}) {
        wire.tip_arc_m = {tip_m};
        assert_true(volume_mm3(tools, wire, crn::Material::steel) < 1e-6);
    }
}

void a_tool_takes_its_radii_from_its_knots(void **)
{
    crn::Instrument tool = straight("stepped", 400, 200);
    tool.table.knots_count = 3;
    tool.table.knots[2] = tool.table.knots[1];
    tool.table.knots[1].arc_um = 100000;
    tool.table.knots[2].radius_outer_um = 600;
    assert_true(std::abs(crn::outer_radius_m(tool.table, -1.0) - 400e-6) < 1e-12);
    assert_true(std::abs(crn::outer_radius_m(tool.table, 0.05) - 400e-6) < 1e-12);
    assert_true(std::abs(crn::outer_radius_m(tool.table, 0.2) - 500e-6) < 1e-12);
    assert_true(std::abs(crn::outer_radius_m(tool.table, 9.0) - 600e-6) < 1e-12);
    const crn::RadiopaqueInstrument look = crn::instrument_look(tool);
    assert_int_equal(look.radii.size(), 3);
    assert_true(std::abs(look.radii[2].outer_m - 600e-6) < 1e-12 &&
                std::abs(look.radii[2].inner_m - 200e-6) < 1e-12);
}

// --- report and pedals ---

void the_report_has_every_tool(void **)
{
    const std::string path = folder + ".json";
    crn::Patient patient({}, three_tools());
    crn::write_report(path, crn::report_of(session().result, "", three_tools(), "test", patient));
    const nlohmann::json report = nlohmann::json::parse(crn::read_text_file(path));
    std::remove(path.c_str());
    assert_int_equal(report["tools"].size(), 3);
    assert_true(report["tools"][1]["name"] == "catheter B");
    assert_true(std::abs(report["tools"][0]["inserted_max_mm"].get<double>() - 160.0) < 0.5);
    assert_true(std::abs(report["tools"][1]["inserted_mm"].get<double>() - 120.0) < 0.5);
    assert_true(std::abs(report["tools"][2]["inserted_mm"].get<double>() - 30.0) < 0.5);
    assert_true(report["tools"][0]["handle_force_max_N"].get<double>() > 0.0);
    assert_true(report["tools"][1]["handle_torque_max_mN_m"].get<double>() > 0.0);
}

void pedals_of_a_rig_are_commands_when_they_change(void **)
{
    using crn::RoomAction, crn::RoomCommand;
    crn::RigPedals pedals;
    assert_true(pedals.changes(0).empty());
    assert_true(pedals.changes(1) == (std::vector<RoomCommand>{{RoomAction::fluoro_pedal, {1, 0, 0}}}));
    assert_true(pedals.changes(1).empty());
    assert_true(pedals.changes(0x83) == (std::vector<RoomCommand>{{RoomAction::acquire_pedal, {1, 0, 0}}}));
    assert_true(pedals.changes(0) == (std::vector<RoomCommand>{{RoomAction::fluoro_pedal, {0, 0, 0}},
                                                               {RoomAction::acquire_pedal, {0, 0, 0}}}));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_refused_tool_is_named_with_place_and_rule),
        cmocka_unit_test(contact_forces_are_read_at_any_tick),
        cmocka_unit_test(a_session_of_three_tools_replays_bit_for_bit),
        cmocka_unit_test(a_changed_input_of_any_tool_is_found),
        cmocka_unit_test(each_tool_covers_the_line_from_its_own_tip),
        cmocka_unit_test(each_tool_is_drawn_over_its_own_part_with_its_own_layers),
        cmocka_unit_test(a_lumen_is_seen_as_a_brighter_middle),
        cmocka_unit_test(tips_anywhere_are_drawn_or_left_out),
        cmocka_unit_test(a_tool_takes_its_radii_from_its_knots),
        cmocka_unit_test(the_report_has_every_tool),
        cmocka_unit_test(pedals_of_a_rig_are_commands_when_they_change),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
