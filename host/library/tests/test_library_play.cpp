// Tests sessions by script in the C library. A play must give the report and the recording of `cournand run`,
// byte for byte, wherever its caller stops and whatever it reads meanwhile. An expectation that does not hold
// is a result, and a mistake in a script has its place.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/text.hpp"
#include "host/library/tests/worlds.hpp"
// After cournand.h:
#include "host/library/cournand_play.h"
#include "host/report/figures/reported_tools.hpp"
#include "host/script/session_checks.hpp"
#include "host/session/run.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn::tests;

// Steers, injects, and has pulses, a run and expectations.
const char *const whole_session = "begin wire inserted 8 mm\n"
                                  "begin catheter inserted 5 mm\n"
                                  "follow tip\n"
                                  "fluoro on rate 7.5 p/s\n"
                                  "advance wire until inserted 60 mm at 100 mm/s\n"
                                  "advance catheter 20 mm at 60 mm/s while rotate 0.5 turn\n"
                                  "steer wire into right iliac artery at 60 mm/s until 30 mm within 3 s\n"
                                  "fluoro off\n"
                                  "cine on rate 15 f/s\n"
                                  "wait 0.2 s\n"
                                  "inject 1 ml at 1.5 ml/s\n"
                                  "wait 0.8 s\n"
                                  "cine off\n"
                                  "expect inserted at least 50 mm\n"
                                  "expect tip in right iliac artery\n";

const Folder &folder()
{
    static const Folder kept("library-play");
    return kept;
}

std::string written(const std::string &name, const std::string &text)
{
    const std::string path = folder().file(name);
    std::ofstream(path) << text;
    return path;
}

std::string bytes_of(const std::string &path)
{
    const std::vector<unsigned char> bytes = crn::read_binary_file(path);
    return {bytes.begin(), bytes.end()};
}

const std::vector<std::string> names = {"bentson", "pigtail_5f"};

struct Played {
    std::string path, report, recording;
};

// Plays a script in the aorta as `cournand run` does: on a device, in one go.
Played played_by_run(const std::string &path)
{
    const crn::SceneFile scene = crn::read_scene(aorta_path());
    std::vector<crn::Instrument> tools;
    for (const std::string &name : names) tools.push_back(crn::read_instrument(instruments + name + ".toml"));
    crn::Session session = crn::read_session(path);
    crn::resolve_tools(session, names);
    crn::Device device(scene, tools, crn::entry_of(scene, tools.size(), session.inserted_um),
                       crn::host_rig());
    const std::string bodies = crn::bodies_beside(aorta_path());
    const crn::SceneAnatomy anatomy = crn::read_scene_anatomy(aorta_path(), bodies);
    crn::Patient patient(anatomy, tools, {.bodies_path = bodies, .stents = {}});
    const crn::TipPlaces tips(anatomy.bodies.vessels, anatomy.motion);
    const crn::EffectsWitness witness(tips.map(), patient);
    crn::RunSettings settings;
    settings.tips = &tips;
    settings.witness = &witness;
    const std::string recording = path + ".run.rec";
    crn::Recorder recorder(recording, device.recording_header(path));
    const crn::RunResult result = crn::run_session(device, patient, session, &recorder, nullptr, settings);
    return {path,
            crn::report_text(crn::report_of(result, scene.path, crn::reported_tools(patient), path, patient)),
            bytes_of(recording)};
}

cournand_script *script_of(const std::string &path)
{
    cournand_script *opened = nullptr;
    done(cournand_script_open(path.c_str(), nullptr, &opened));
    return opened;
}

cournand_play *play(const std::string &path, const std::string &record = "")
{
    cournand_script *const of = script_of(path);
    std::vector<cournand_tool *> tools;
    for (const std::string &name : names) tools.push_back(tool(name));
    auto options = sized<cournand_play_options>();
    options.record = record.c_str();
    cournand_play *made = nullptr;
    const cournand_status status =
        cournand_play_create(of, aorta(), tools.data(), tools.size(), &options, &made);
    for (cournand_tool *one : tools) done(cournand_tool_free(one));
    done(cournand_script_free(of));
    done(status);
    return made;
}

cournand_play_state state(cournand_play *of)
{
    auto read = sized<cournand_play_state>();
    done(cournand_play_read(of, &read));
    return read;
}

std::string report(cournand_play *of)
{
    const char *json = nullptr;
    done(cournand_play_report(of, &json));
    return json;
}

cournand_world *world_of(cournand_play *of)
{
    cournand_world *world = nullptr;
    done(cournand_play_world(of, &world));
    return world;
}

const Played &reference()
{
    static const Played kept = played_by_run(written("whole.session", whole_session));
    return kept;
}

void a_play_gives_the_report_and_the_recording_of_a_run(void **)
{
    const std::string record = folder().file("play.rec");
    cournand_play *played = play(reference().path, record);
    while (!state(played).is_over) done(cournand_play_advance(played, 1000, 0));
    const auto parsed = nlohmann::json::parse(reference().report);
    print_message("%u ticks, %u pulses, report %zu bytes, recording %zu bytes\n", state(played).tick,
                  state(played).pulses, reference().report.size(), reference().recording.size());
    assert_true(parsed["steered"].size() == 1 && parsed["expected"].size() == 2);
    assert_true(parsed["contrast"]["injected_ml"] > 0.95);
    assert_true(state(played).pulses > 20);
    assert_true(report(played) == reference().report);
    assert_true(bytes_of(record) == reference().recording);
    assert_int_equal(state(played).exit_status, 0);
    done(cournand_play_free(played));
}

// The intervals are coprime with the 16 ticks of a script's decisions, and everything is read at each stop.
void stops_and_readings_change_nothing(void **)
{
    const std::string record = folder().file("stops.rec");
    cournand_play *played = play(reference().path, record);
    cournand_world *world = world_of(played);
    cournand_renderer *renderer = nullptr;
    done(cournand_renderer_create(aorta(), 1, &renderer));
    std::uint32_t stops = 0;
    for (; !state(played).is_over; stops++) {
        done(cournand_play_advance(played, stops % 5 == 0 ? 1 : 37,
                                   stops % 3 == 0 ? COURNAND_PLAY_TO_PULSE : 0));
        assert_true(pose(world).tick == state(played).tick && reading(world).tick == state(played).tick);
        auto contacts = sized<cournand_contacts>();
        done(cournand_world_contacts(world, &contacts));
        auto place = sized<cournand_place>();
        done(cournand_world_tip(world, 0, &place));
        if (stops % 10 != 0) continue;
        auto view = sized<cournand_view>();
        view.size = 64;
        done(cournand_play_view(played, &view));
        auto picture = sized<cournand_picture>();
        done(cournand_render(renderer, world, &view, &picture));
    }
    print_message("%u stops\n", stops);
    assert_true(report(played) == reference().report);
    assert_true(bytes_of(record) == reference().recording);
    assert_true(nlohmann::json::parse(report(played))["hash"] ==
                nlohmann::json::parse(reference().report)["hash"]);
    done(cournand_play_free(played));
    assert_int_equal(pose(world).tick, nlohmann::json::parse(reference().report)["ticks"].get<int>());
    done(cournand_world_free(world));
    done(cournand_renderer_free(renderer));
}

// 15 pulses in 1 s at 15 pulses per second, one after each 66 or 67 ms.
void a_play_stops_at_every_pulse(void **)
{
    cournand_play *played =
        play(written("pulses.session", "fluoro on rate 15 p/s\nwait 1 s\nfluoro off\nwait 0.3 s\n"));
    std::vector<std::uint32_t> ticks;
    while (!state(played).is_over) {
        done(cournand_play_advance(played, 500, COURNAND_PLAY_TO_PULSE));
        if (state(played).is_at_pulse) ticks.push_back(state(played).tick);
        assert_int_equal(state(played).is_beam_on, state(played).tick < 1000);
    }
    assert_in_range(ticks.size(), 14, 15); // the first pulse is at tick 0
    for (std::size_t i = 1; i < ticks.size(); i++) assert_in_range(ticks[i] - ticks[i - 1], 66, 67);
    done(cournand_play_free(played));
}

void a_broken_expectation_is_a_result(void **)
{
    cournand_play *played =
        play(written("broken.session", "wait 0.1 s\nexpect inserted at least 900 mm\nwait 5 s\n"));
    done(cournand_play_advance(played, 60000, 0));
    const cournand_play_state end = state(played);
    assert_int_equal(end.is_over, 1);
    assert_int_equal(end.exit_status, 1);
    assert_in_range(end.tick, 100, 132); // the script has ended there
    assert_true(std::string(end.failures).find("broken.session:2") != std::string::npos);
    assert_true(nlohmann::json::parse(report(played))["failures"].size() == 1);
    assert_int_equal(cournand_play_advance(played, 1, 0), COURNAND_BAD_STATE);
    done(cournand_play_free(played));
}

void a_mistake_has_its_place(void **)
{
    const std::string wrong = written("wrong.session", "wait 0.1 s\nadvanse 3 mm at 10 mm/s\n");
    cournand_script *opened = nullptr;
    assert_int_equal(cournand_script_open(wrong.c_str(), nullptr, &opened), COURNAND_BAD_FILE);
    auto place = sized<cournand_error_place>();
    done(cournand_error_where(&place));
    assert_string_equal(place.file, wrong.c_str());
    assert_int_equal(place.line, 2);
    assert_int_equal(place.column, 1);
    const std::string unknown = written("unknown.session", "wait 0.1 s\nsteer wire into elbow\n");
    cournand_script *const of = script_of(unknown);
    cournand_tool *const wire = tool("j_wire");
    cournand_play *made = nullptr;
    assert_int_equal(cournand_play_create(of, aorta(), &wire, 1, nullptr, &made), COURNAND_BAD_FILE);
    done(cournand_error_where(&place));
    assert_int_equal(place.line, 2);
    // A later refusal that names no file has no place.
    assert_int_equal(cournand_play_create(of, aorta(), &wire, 0, nullptr, &made), COURNAND_BAD_ARGUMENT);
    done(cournand_error_where(&place));
    assert_string_equal(place.file, "");
    done(cournand_script_free(of));
    done(cournand_tool_free(wire));
}

void a_script_names_what_it_needs(void **)
{
    cournand_script *of =
        script_of(written("needs.session", "needs scene aorta\nneeds tools j_wire, guide_jr4_6f\n"
                                           "needs stent renal_6_0x18\nwait 1 s\nwait 1 s\n"));
    auto info = sized<cournand_script_info>();
    done(cournand_script_describe(of, &info));
    assert_string_equal(info.scene, "aorta");
    assert_int_equal(info.tool_count, 2);
    assert_string_equal(info.tools[1], "guide_jr4_6f");
    assert_int_equal(info.stent_count, 1);
    assert_string_equal(info.stents[0], "renal_6_0x18");
    assert_int_equal(info.statement_count, 2);
    done(cournand_script_free(of));
}

void a_led_world_can_only_be_read_and_branches_off(void **)
{
    cournand_play *played = play(reference().path);
    cournand_world *world = world_of(played);
    done(cournand_play_advance(played, 1003, 0));
    const float action[COURNAND_ACTION_FLOATS] = {0.01f};
    assert_int_equal(cournand_world_move(world, action, 1), COURNAND_BAD_STATE);
    assert_int_equal(cournand_world_inject(world, 1, 1, -1, 300), COURNAND_BAD_STATE);
    assert_int_equal(cournand_world_record(world, "x.rec", "x"), COURNAND_BAD_STATE);
    std::size_t bytes = 0;
    assert_int_equal(cournand_world_snapshot_bytes(world, &bytes),
                     COURNAND_BAD_STATE); // 1003 is no multiple of 16
    done(cournand_play_advance(played, 5, 0));
    const std::vector<std::uint8_t> snapshot = saved(world);
    assert_int_equal(cournand_world_restore(world, snapshot.data(), snapshot.size()), COURNAND_BAD_STATE);
    cournand_world *branch = nullptr;
    done(cournand_play_new_world(played, &branch));
    done(cournand_world_restore(branch, snapshot.data(), snapshot.size()));
    assert_int_equal(reading(branch).tick, 1008);
    assert_true(hash(branch) == hash(world));
    push(branch, 100);
    assert_true(hash(branch) != hash(world));
    done(cournand_play_free(played));
    assert_int_equal(cournand_world_move(world, action, 1), COURNAND_BAD_STATE); // also without its play
    done(cournand_world_free(world));
    done(cournand_world_free(branch));
}

void hands_of_a_novice_change_the_session(void **)
{
    const std::string path = written("novice.session", "advance 60 mm at 60 mm/s\n");
    std::uint32_t ticks[2] = {};
    cournand_tool *const wire = tool("j_wire");
    for (int i = 0; i < 2; i++) {
        cournand_script *of = nullptr;
        done(cournand_script_open(path.c_str(), i == 0 ? "" : "novice:7", &of));
        cournand_play *made = nullptr;
        done(cournand_play_create(of, free_space(), &wire, 1, nullptr, &made));
        done(cournand_play_advance(made, 60000, 0));
        ticks[i] = state(made).tick;
        done(cournand_play_free(made));
        done(cournand_script_free(of));
    }
    done(cournand_tool_free(wire));
    assert_true(ticks[0] >= 1000 && ticks[1] > ticks[0]);
    cournand_script *of = nullptr;
    assert_int_equal(cournand_script_open(path.c_str(), "expart:7", &of), COURNAND_BAD_ARGUMENT);
}

void a_play_that_is_freed_keeps_its_cut_recording(void **)
{
    const std::string record = folder().file("cut.rec");
    cournand_play *played = play(reference().path, record);
    done(cournand_play_advance(played, 700, 0));
    done(cournand_play_free(played));
    cournand_recording *cut = nullptr;
    done(cournand_recording_open(record.c_str(), &cut));
    auto info = sized<cournand_recording_info>();
    done(cournand_recording_describe(cut, &info));
    assert_int_equal(info.is_complete, 0);
    assert_int_equal(info.tick_count, 700);
    done(cournand_recording_free(cut));
}

void wrong_calls_are_refused(void **)
{
    cournand_play *played = play(reference().path);
    const char *json = nullptr;
    assert_int_equal(cournand_play_report(played, &json), COURNAND_BAD_STATE); // not at its end
    assert_int_equal(cournand_play_report(played, nullptr), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_play_advance(played, 0, 0), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_play_advance(played, COURNAND_TICKS_MAX + 1, 0), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_play_advance(played, 1, 2), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_play_advance(nullptr, 1, 0), COURNAND_BAD_HANDLE);
    cournand_play_state unsized{};
    assert_int_equal(cournand_play_read(played, &unsized), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_play_world(played, nullptr), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_play_view(played, nullptr), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_script_open(nullptr, nullptr, nullptr), COURNAND_BAD_ARGUMENT);
    cournand_script *of = nullptr;
    assert_int_equal(cournand_script_open("no such file", nullptr, &of), COURNAND_BAD_FILE);
    assert_int_equal(state(played).tick, 0);
    done(cournand_play_free(played));
    assert_int_equal(cournand_play_free(played), COURNAND_BAD_HANDLE);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_play_gives_the_report_and_the_recording_of_a_run),
        cmocka_unit_test(stops_and_readings_change_nothing),
        cmocka_unit_test(a_play_stops_at_every_pulse),
        cmocka_unit_test(a_broken_expectation_is_a_result),
        cmocka_unit_test(a_mistake_has_its_place),
        cmocka_unit_test(a_script_names_what_it_needs),
        cmocka_unit_test(a_led_world_can_only_be_read_and_branches_off),
        cmocka_unit_test(hands_of_a_novice_change_the_session),
        cmocka_unit_test(a_play_that_is_freed_keeps_its_cut_recording),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
