// Tests sessions in which tools are exchanged, that is, replaced by others (docs/session.md, "Exchange"). The
// commands of the script reach the core, and patient and pictures use the tools that are in use in the core.
// A recording replays bit for bit from its start and from a snapshot, and a refused exchange ends the script
// with its reason.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <unistd.h>
#include <vector>

#include "host/base/text.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"
#include "host/session/witness.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const std::string exchange_path = "/tmp/cournand_test_exchange_" + std::to_string(getpid()) + ".rec";
const crn::SceneFile empty_scene = crn::read_scene("");

const std::vector<std::string> &names()
{
    static const std::vector<std::string> list = {"terumo_4f", "coronary_014", "guide_jl4_6f", "balloon_3x20",
                                                  "amplatz_super_stiff"};
    return list;
}

const std::vector<crn::Instrument> &table()
{
    static const std::vector<crn::Instrument> tools = [] {
        std::vector<crn::Instrument> read;
        for (const std::string &name : names())
            read.push_back(crn::read_instrument("shared/examples/instruments/" + name + ".toml"));
        return read;
    }();
    return tools;
}

struct Recorded {
    crn::RunResult result;
    crn::Recording recording;
    crn::LineNumbers line;          // of the patient, at the end
    std::vector<std::string> tools; // their names
    std::string notice;
};

Recorded record_exchange(const std::string &script)
{
    crn::Session session = crn::parse_session(script, "a.session");
    const crn::LineNumbers line = crn::resolve_tools(session, names());
    const crn_wire_entry entry = crn::entry_of(empty_scene, line.size(), session.inserted_um);
    crn::Device device(empty_scene, table(), entry, crn::host_rig(), {}, line);
    crn::PatientSettings settings;
    settings.line = line;
    crn::Patient patient({}, table(), settings);
    Recorded recorded;
    {
        crn::Recorder recorder(exchange_path, device.recording_header("a.session"));
        recorded.result = crn::run_session(device, patient, session, &recorder, nullptr, {});
    }
    recorded.recording = crn::read_recording(exchange_path);
    std::remove(exchange_path.c_str());
    recorded.line = patient.line();
    for (const crn::Instrument &tool : patient.tools()) recorded.tools.push_back(tool.name);
    recorded.notice = patient.notice().text;
    return recorded;
}

// A guidewire is withdrawn from a guiding catheter, another guidewire is inserted, and a balloon catheter is
// advanced over it; the recording contains more than one snapshot.
const Recorded &whole()
{
    static const Recorded recorded =
        record_exchange("begin with amplatz_super_stiff nothing guide_jl4_6f\n"
                        "begin wire inserted 120 mm\nbegin guide inserted 100 mm\n"
                        "withdraw wire until inserted 0 mm at 100 mm/s\n"
                        "exchange wire for coronary_014\n"
                        "advance wire 130 mm at 60 mm/s\n"
                        "load balloon_3x20 as catheter\n"
                        "advance catheter 90 mm at 60 mm/s\n"
                        "withdraw catheter until inserted 0 mm at 100 mm/s\n"
                        "remove catheter\nwait 100 ms");
    return recorded;
}

std::uint32_t answers(const crn::Recording &recording, std::uint8_t tool)
{
    std::uint32_t count = 0;
    for (const crn::RecordedTick &tick : recording.ticks)
        for (std::uint16_t i = 0; i < tick.input.orders.items_count; i++) {
            const crn_wire_order &order = tick.input.orders.items[i];
            count += order.kind == CRN_WIRE_KIND_exchange && order.exchange.tool == tool;
        }
    return count;
}

void a_script_exchanges_tools_and_the_patient_follows(void **)
{
    const Recorded &recorded = whole();
    if (!recorded.result.failures.empty()) fail_msg("%s", recorded.result.failures[0].c_str());
    assert_true(recorded.line == (crn::LineNumbers{2, 0, 3}));
    assert_string_equal(recorded.tools[0].c_str(), table()[1].name.c_str());
    assert_string_equal(recorded.tools[1].c_str(), "");
    assert_true(recorded.recording.header.line == (crn::LineNumbers{5, 0, 3}));
    assert_int_equal(recorded.recording.header.tools.size(), 5);
    assert_int_equal(answers(recorded.recording, 2), 1);
    assert_int_equal(answers(recorded.recording, 4), 1);
    assert_int_equal(answers(recorded.recording, 0), 1);
}

// Returns the final hash of a session that advances a wire; the session's table of tools may have another
// tool that is not in use.
std::uint64_t hash_beside(const std::string &other)
{
    const auto file = [](const std::string &name) { return "shared/examples/instruments/" + name + ".toml"; };
    std::vector<crn::Instrument> tools = {crn::read_instrument(file("j_wire"))};
    std::vector<std::string> known = {"j_wire"};
    if (!other.empty()) {
        tools.push_back(crn::read_instrument(file(other)));
        known.push_back(other);
    }
    crn::Session session =
        crn::parse_session("begin with j_wire\nbegin wire inserted 20 mm\nadvance wire 40 mm at 80 mm/s\n"
                           "rotate wire 90 deg at 360 deg/s",
                           "a.session");
    const crn::LineNumbers line = crn::resolve_tools(session, known);
    crn::Device device(empty_scene, tools, crn::entry_of(empty_scene, line.size(), session.inserted_um),
                       crn::host_rig(), {}, line);
    crn::PatientSettings settings;
    settings.line = line;
    crn::Patient patient({}, tools, settings);
    return crn::run_session(device, patient, session, nullptr, nullptr, {}).hash;
}

// All tools of a session's table share one mesh. A guiding catheter needs no finer mesh than the wire,
// whereas a Rosen wire needs shorter elements.
void a_tool_on_the_table_changes_hashes_only_by_its_mesh(void **)
{
    const std::uint64_t alone = hash_beside("");
    assert_true(hash_beside("guide_jl4_6f") == alone);
    assert_true(hash_beside("rosen") != alone);
}

void a_recorded_exchange_replays_bit_for_bit(void **)
{
    const crn::Recording &recording = whole().recording;
    const crn::RecordingHeader &header = recording.header;
    assert_true(!recording.snapshots.empty());
    for (const double from_s : {0.0, recording.snapshots.back().tick * 1e-3}) {
        crn::Device device(empty_scene, header.tools, header.entry, header.rig, {}, header.line);
        crn::ReplaySettings settings;
        settings.verifies = true;
        settings.from_s = from_s;
        const crn::ReplayResult result = crn::replay_recording(device, recording, nullptr, nullptr, settings);
        if (result.first_difference_tick) fail_msg("%s", result.difference.c_str());
        assert_true(result.hash == whole().result.hash);
        assert_true(result.line == whole().line);
    }
}

void a_refused_exchange_ends_the_script_by_name(void **)
{
    const Recorded recorded = record_exchange("begin with coronary_014 nothing guide_jl4_6f\n"
                                              "begin wire inserted 120 mm\nbegin guide inserted 100 mm\n"
                                              "wait 100 ms\nexchange wire for terumo_4f\nwait 10 s");
    assert_int_equal(recorded.result.failures.size(), 1);
    assert_string_equal(
        recorded.result.failures[0].c_str(),
        "a.session:5: exchange: the device at this position is still in the patient; withdraw it "
        "into the introducer sheath first");
    assert_true(recorded.notice.find("NO EXCHANGE - the device at this position is still") == 0);
    assert_true(recorded.recording.ticks.size() < 1000);
}

// In FREE_RUN, a rig could report to the host tools that are not in use.
void the_witness_refuses_a_false_line(void **)
{
    const crn::LineNumbers line = {5, 0, 3};
    const std::uint32_t inserted_um[] = {120000, 0, 100000};
    const crn_wire_entry entry = crn::entry_of(empty_scene, line.size(), inserted_um);
    crn::Witness rig(empty_scene, table(), line, entry, crn::host_rig(), "the rig");
    crn::SimTransport pipe;
    crn::Link link(pipe);
    std::vector<crn_wire_instrument> tables;
    for (const crn::Instrument &tool : table()) tables.push_back(tool.table);
    link.hello();
    link.load_scene(empty_scene.bytes);
    link.load_tools(tables, line);
    link.set_entry(entry);
    link.set_rig(crn::host_rig());
    link.use_lockstep();
    link.arm();
    link.start();
    crn_wire_tick_input input{};
    input.hands_count = 3;
    rig.tick(input, link.step({&input, 1}, false).front());
    crn_wire_tick_state state = link.step({&input, 1}, false).front();
    state.line_count = 1;
    try {
        rig.tick(input, state);
        fail_msg("a line of one tool was accepted");
    } catch (const crn::LinkError &error) {
        assert_non_null(std::strstr(error.what(), "tools 5, answer"));
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_script_exchanges_tools_and_the_patient_follows),
        cmocka_unit_test(the_witness_refuses_a_false_line),
        cmocka_unit_test(a_tool_on_the_table_changes_hashes_only_by_its_mesh),
        cmocka_unit_test(a_recorded_exchange_replays_bit_for_bit),
        cmocka_unit_test(a_refused_exchange_ends_the_script_by_name),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
