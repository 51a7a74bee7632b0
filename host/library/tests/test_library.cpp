// Tests the worlds (simulated sessions) of the C library. A world must give the same state hash as `cournand
// run` with the same orders, for any number of threads, and a restored world must continue bit for bit. The
// tests also cover readings in SI units, tips in named vessels, recordings and replays. The tests of refusals
// are in test_library_refusals.cpp, and the tests of pictures in test_library_pictures.cpp.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "host/library/tests/worlds.hpp"
#include "host/link/sim_transport.hpp"
#include "host/patient/patient.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"
#include "host/session/set_up.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn::tests;

const char *const script = "begin inserted 5 mm\nadvance 200 mm at 80 mm/s while rotate 1 turn\nwait 0.2 s";

// Holds the result of a session that `cournand run` has played in the aorta.
struct Ran {
    std::string path;
    std::uint64_t hash;
    std::uint32_t ticks;
};

const Ran &ran()
{
    static const Folder folder("library-run");
    static const Ran kept = [] {
        const crn::SceneFile scene = crn::read_scene(aorta_path());
        const std::vector<crn::Instrument> tools = {crn::read_instrument(instruments + "j_wire.toml")};
        const crn::Session session = crn::parse_session(script, "test");
        crn::Device device(scene, tools, crn::entry_of(scene, 1, session.inserted_um), crn::host_rig());
        crn::Patient patient({}, tools);
        const std::string path = folder.file("a.rec");
        crn::Recorder recorder(path, device.recording_header("test"));
        const crn::RunResult result = crn::run_session(device, patient, session, &recorder, nullptr, {});
        return Ran{path, result.hash, result.figures.ticks};
    }();
    return kept;
}

cournand_recording *recording(const std::string &path)
{
    cournand_recording *opened = nullptr;
    done(cournand_recording_open(path.c_str(), &opened));
    return opened;
}

void the_inputs_of_a_session_of_run_give_its_state_hash(void **)
{
    cournand_recording *recorded = recording(ran().path);
    std::vector<cournand_input> inputs(ran().ticks);
    done(cournand_recording_inputs(recorded, 0, ran().ticks, inputs.data()));
    auto options = sized<cournand_world_options>();
    options.inserted_count = 1;
    options.inserted_m[0] = 0.005f;
    cournand_world *advanced = world(aorta(), {"j_wire"}, &options);
    done(cournand_world_advance(advanced, inputs.data(), inputs.size()));
    print_message("hash %016llx after %u ticks\n", static_cast<unsigned long long>(hash(advanced)),
                  ran().ticks);
    assert_true(hash(advanced) == ran().hash);
    assert_true(reading(advanced).contact_count > 0); // the wall took part
    done(cournand_world_free(advanced));
    done(cournand_recording_free(recorded));
}

void a_recording_of_run_replays_in_a_world(void **)
{
    cournand_recording *recorded = recording(ran().path);
    auto info = sized<cournand_recording_info>();
    done(cournand_recording_describe(recorded, &info));
    assert_int_equal(info.tick_count, ran().ticks);
    assert_int_equal(info.is_complete, 1);
    assert_true(info.last_hash == ran().hash);
    cournand_world *replayed = nullptr;
    done(cournand_recording_world(recorded, aorta(), 0, &replayed));
    done(cournand_world_replay(replayed, recorded, 1000));
    assert_int_equal(reading(replayed).tick, 1000);
    done(cournand_world_replay(replayed, recorded, info.tick_count));
    assert_true(hash(replayed) == ran().hash);
    done(cournand_world_free(replayed));
    done(cournand_recording_free(recorded));
}

void one_call_gives_the_same_bits_as_many(void **)
{
    cournand_world *at_once = world(aorta()), *in_steps = world(aorta());
    push(at_once, 600);
    for (const std::uint32_t ticks : {1u, 63u, 64u, 65u, 407u}) push(in_steps, ticks);
    assert_true(hash(at_once) == hash(in_steps));
    done(cournand_world_free(at_once));
    done(cournand_world_free(in_steps));
}

void worlds_have_the_same_bits_with_1_2_and_4_threads(void **)
{
    constexpr std::size_t count = 8;
    std::vector<std::vector<std::uint64_t>> hashes;
    for (const std::uint32_t threads : {1u, 2u, 4u}) {
        cournand_pool *pool = nullptr;
        done(cournand_pool_create(threads, &pool));
        std::vector<cournand_world *> worlds;
        std::vector<float> actions(count * COURNAND_ACTION_FLOATS, 0.0f);
        for (std::size_t i = 0; i < count; i++) {
            worlds.push_back(world(aorta()));
            actions[i * COURNAND_ACTION_FLOATS] = 0.05f + 0.005f * static_cast<float>(i);
            actions[i * COURNAND_ACTION_FLOATS + 3] = static_cast<float>(i) - 4.0f;
        }
        std::vector<std::int32_t> statuses(count, -1);
        for (int step = 0; step < 3; step++)
            done(cournand_pool_move(pool, worlds.data(), count, actions.data(), 100, statuses.data()));
        assert_true(std::all_of(statuses.begin(), statuses.end(), [](std::int32_t one) { return one == 0; }));
        std::vector<std::uint64_t> &found = hashes.emplace_back();
        for (cournand_world *one : worlds) {
            found.push_back(hash(one));
            done(cournand_world_free(one));
        }
        done(cournand_pool_free(pool));
    }
    assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
    assert_true(hashes[0][0] != hashes[0][1]); // and the worlds differ
}

void a_step_calls_the_function_after_each_world_has_moved(void **)
{
    constexpr std::size_t count = 5;
    cournand_pool *pool = nullptr;
    done(cournand_pool_create(2, &pool));
    struct Called {
        cournand_world *worlds[count];
        std::uint32_t ticks[count], calls[count];
    } called{};
    for (cournand_world *&one : called.worlds) one = world(free_space());
    const float actions[count * COURNAND_ACTION_FLOATS] = {};
    const auto note = [](void *context, std::size_t i) {
        Called &to = *static_cast<Called *>(context);
        to.ticks[i] = reading(to.worlds[i]).tick;
        to.calls[i]++;
    };
    done(cournand_pool_step(pool, called.worlds, count, actions, 50, note, &called, nullptr));
    for (std::size_t i = 0; i < count; i++) assert_true(called.ticks[i] == 50 && called.calls[i] == 1);
    assert_int_equal(cournand_pool_step(pool, called.worlds, count, actions, 0, note, &called, nullptr),
                     COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_pool_step(pool, called.worlds, count, actions, 1, nullptr, nullptr, nullptr),
                     COURNAND_BAD_ARGUMENT);
    assert_true(called.calls[0] == 1 && reading(called.worlds[0]).tick == 50);
    for (cournand_world *one : called.worlds) done(cournand_world_free(one));
    done(cournand_pool_free(pool));
}

void a_restored_world_continues_bit_for_bit(void **)
{
    cournand_world *first = world(aorta()), *other = world(aorta());
    push(first, 500);
    const std::vector<std::uint8_t> bytes = saved(first);
    const cournand_reading then = reading(first);
    push(first, 300, 0.04f, -2.0f);
    const std::uint64_t after = hash(first);
    for (cournand_world *restored : {first, other}) {
        done(cournand_world_restore(restored, bytes.data(), bytes.size()));
        const cournand_reading now = reading(restored);
        assert_int_equal(now.tick, 500);
        assert_memory_equal(&now, &then, sizeof now); // forces and contacts of the last tick, too
        push(restored, 300, 0.04f, -2.0f);
        assert_true(hash(restored) == after);
    }
    assert_true(saved(first) == saved(other));
    done(cournand_world_free(first));
    done(cournand_world_free(other));
}

// A snapshot that is taken directly from a device in this process must have the same bytes as a snapshot
// through the wire protocol.
void a_snapshot_in_memory_is_that_of_the_wire(void **)
{
    const crn::SceneFile scene = crn::read_scene("");
    const std::vector<crn::Instrument> tools = {crn::read_instrument(instruments + "j_wire.toml")};
    const crn::LineNumbers line = {1};
    const crn_wire_entry entry = crn::entry_of(scene, 1, {});
    const crn_wire_rig rig = crn::host_rig();
    crn::SimTransport pipe(0), other_pipe(0);
    crn::Link link(pipe), other(other_pipe);
    std::vector<std::uint8_t> bytes(crn::SimTransport::snapshot_bytes());
    assert_false(pipe.take_snapshot(bytes)); // no session yet
    for (crn::Link *one : {&link, &other}) {
        one->hello();
        crn::set_up_session(*one, {scene, tools, line, entry, rig});
    }
    std::vector<crn_wire_tick_input> inputs(50);
    for (std::size_t i = 0; i < inputs.size(); i++)
        inputs[i] = {1, {{static_cast<std::int32_t>(40 * i), 100}}, 0, 0, 0, {}};
    link.step(inputs, false);
    assert_true(pipe.take_snapshot(bytes));
    assert_true(link.read_snapshot() == bytes);
    const std::uint64_t before = other.read_hash64().hash;
    std::vector<std::uint8_t> bad = bytes;
    bad[0] ^= 1;
    assert_false(other_pipe.put_snapshot(bad));
    assert_false(other_pipe.put_snapshot({bytes.data(), bytes.size() - 1}));
    assert_true(other.read_hash64().hash == before);
    assert_true(other_pipe.put_snapshot(bytes));
    other.continue_at(50);
    link.step(inputs, false);
    other.step(inputs, false);
    assert_true(link.read_hash64().hash == other.read_hash64().hash);
}

// A device that shares the scene's bytes must compute the same as a device that has received these bytes, and
// must refuse damaged bytes.
void a_shared_scene_is_that_of_an_upload(void **)
{
    const crn::SceneFile scene = crn::read_scene(aorta_path());
    const std::vector<crn::Instrument> tools = {crn::read_instrument(instruments + "j_wire.toml")};
    const crn::LineNumbers line = {1};
    const crn_wire_entry entry = crn::entry_of(scene, 1, {});
    const crn_wire_rig rig = crn::host_rig();
    crn::SimTransport sharing(0), sent;
    crn::Link link(sharing), other(sent);
    assert_false(sharing.share_scene(scene.bytes, scene.crc32)); // before HELLO
    std::vector<std::uint64_t> hashes;
    for (crn::Link *one : {&link, &other}) {
        one->hello();
        if (one == &link) {
            std::vector<std::uint8_t> damaged = scene.bytes;
            damaged[damaged.size() / 2] ^= 1;
            assert_false(sharing.share_scene(damaged, scene.crc32));
            assert_int_equal(link.read_set_up().scene_bytes, 0);
            assert_true(sharing.share_scene(scene.bytes, scene.crc32));
        }
        crn::set_up_session(*one, {scene, tools, line, entry, rig});
        std::vector<crn_wire_tick_input> inputs(60);
        for (std::size_t i = 0; i < inputs.size(); i++)
            inputs[i] = {1, {{static_cast<std::int32_t>(40 * i), 100}}, 0, 0, 0, {}};
        one->step(inputs, false);
        hashes.push_back(one->read_hash64().hash);
    }
    assert_false(sharing.share_scene(scene.bytes, scene.crc32)); // during a session
    assert_true(hashes[0] == hashes[1]);
}

// This test restores one snapshot many times, as a search program does for each branch of its search tree.
// The printed time is only for information (docs/library.md).
void a_snapshot_gives_the_same_world_however_often_it_is_restored(void **)
{
    auto options = sized<cournand_world_options>();
    options.contact_ticks = 19;
    cournand_world *restored = world(aorta(), {"j_wire"}, &options);
    push(restored, 2000);
    const cournand_reading before = reading(restored);
    assert_true(before.wall_force_N > 0.0f && before.wall_force_peak_N >= before.wall_force_N);
    const std::vector<std::uint8_t> bytes = saved(restored);
    double least_us = 1e9;
    for (int branch = 0; branch < 20; branch++) {
        push(restored, 5);
        assert_false(saved(restored) == bytes);
        const auto begin = std::chrono::steady_clock::now();
        done(cournand_world_restore(restored, bytes.data(), bytes.size()));
        const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
        least_us = std::min(least_us, took.count());
        assert_true(saved(restored) == bytes);
        const cournand_reading after = reading(restored);
        assert_true(after.wall_force_N == before.wall_force_N); // bit for bit
        assert_true(after.wall_force_peak_N == before.wall_force_peak_N);
    }
    print_message("restore: %.1f us, %zu bytes\n", least_us, bytes.size());
    done(cournand_world_free(restored));
}

void a_pose_is_a_view_in_metres_and_in_exact_numbers(void **)
{
    cournand_world *seen = world(aorta());
    push(seen, 400);
    const cournand_pose shape = pose(seen);
    assert_int_equal(shape.tick, 400);
    assert_int_equal(shape.position_count, 1);
    assert_true(shape.node_count > 10 && shape.node_count <= 384);
    for (std::uint32_t i = 0; i < 3 * shape.node_count; i++)
        assert_true(std::fabs(shape.positions_m[i] - std::ldexp(shape.positions_q30[i], -30)) < 1e-7);
    for (std::uint32_t i = 1; i < shape.node_count; i++) {
        double square = 0.0;
        for (int axis = 0; axis < 3; axis++)
            square += std::pow(shape.positions_m[3 * i + axis] - shape.positions_m[3 * i - 3 + axis], 2);
        // a chord is never longer than its arc, up to 1 % of stretch
        assert_true(std::sqrt(square) <= 1.01 * (shape.arcs_m[i] - shape.arcs_m[i - 1]));
    }
    assert_true(shape.arcs_m[0] == 0.0f && shape.tip_arcs_m[0] == 0.0f);
    assert_true(std::fabs(shape.radii_m[shape.node_count - 1] - 0.00045) < 0.0002); // 0.035 inch
    assert_true(shape.positions_m == pose(seen).positions_m);                       // a view, no copy
    done(cournand_world_free(seen));
}

void hands_move_the_stated_way(void **)
{
    cournand_world *moved = world(free_space());
    const double before = reading(moved).inserted_m[0];
    push(moved, 1000, 0.05f, 0.0f);
    const double way = reading(moved).inserted_m[0] - before;
    // The first tick defines the zero of the hands, and the feed follows the hand within a few ticks;
    // together these may add an error of 0.2 mm.
    print_message("inserted %.6f m in 1 s at 0.05 m/s\n", way);
    assert_true(std::fabs(way - 0.05) < 6e-4);
    push(moved, 1000, -0.05f, 0.0f);
    assert_true(std::fabs(reading(moved).inserted_m[0] - before) < 6e-4);
    done(cournand_world_free(moved));
}

void forces_of_the_wall_are_read_node_by_node_and_as_a_peak(void **)
{
    auto options = sized<cournand_world_options>();
    options.contact_ticks = 10;
    cournand_world *touching = world(aorta(), {"j_wire"}, &options);
    push(touching, 1500);
    auto contacts = sized<cournand_contacts>();
    done(cournand_world_contacts(touching, &contacts));
    const cournand_reading read = reading(touching);
    assert_int_equal(contacts.tick, 1500);
    assert_true(contacts.count > 0);
    double sum = 0.0;
    for (std::uint32_t i = 0; i < contacts.count; i++) {
        assert_true(i == 0 || contacts.nodes[i - 1] < contacts.nodes[i]);
        const float *force = contacts.forces_N + 3 * i;
        sum += std::sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
    }
    print_message("%u contacts, %.4f N now, %.4f N at most\n", contacts.count, sum, read.wall_force_peak_N);
    assert_true(std::fabs(sum - read.wall_force_N) < 1e-4);
    assert_true(read.wall_force_peak_N >= read.wall_force_N);
    done(cournand_world_free(touching));
}

void a_tip_lies_in_a_vessel_that_the_scene_names(void **)
{
    cournand_world *placed = world(aorta());
    push(placed, 2000);
    auto place = sized<cournand_place>();
    done(cournand_world_tip(placed, 0, &place));
    print_message("tip in %s\n", place.name);
    std::uint32_t number = 99;
    done(cournand_scene_find_vessel(aorta(), place.name, &number));
    assert_int_equal(number, place.vessel);
    assert_true(place.radii < 1.0 && place.inside_m > 0.0);
    auto vessel = sized<cournand_vessel>();
    done(cournand_scene_vessel(aorta(), number, &vessel));
    assert_string_equal(vessel.name, place.name);
    double least = 1.0; // the tip is near a point of the vessel's centreline
    for (std::uint32_t i = 0; i < vessel.point_count; i++) {
        double square = 0.0;
        for (int axis = 0; axis < 3; axis++)
            square += std::pow(vessel.points_m[4 * i + axis] - place.tip_m[axis], 2);
        least = std::min(least, std::sqrt(square));
    }
    assert_true(least < 0.02);
    done(cournand_world_free(placed));
}

void points_of_a_scene_that_rests_stay(void **)
{
    cournand_world *resting = world(aorta());
    push(resting, 100);
    const double rest_m[6] = {0.01, -0.2, 0.03, 0.0, 0.15, 0.02};
    double now_m[6] = {};
    done(cournand_world_moved(resting, rest_m, 2, now_m));
    assert_memory_equal(now_m, rest_m, sizeof now_m);
    const double wrong_m[3] = {0.0, NAN, 0.0};
    assert_int_equal(cournand_world_moved(resting, wrong_m, 1, now_m), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_world_moved(resting, nullptr, 1, now_m), COURNAND_BAD_ARGUMENT);
    assert_memory_equal(now_m, rest_m, sizeof now_m);
    done(cournand_world_moved(resting, nullptr, 0, nullptr));
    done(cournand_world_free(resting));
}

void an_order_changes_the_heart_rate(void **)
{
    cournand_world *calm = world(free_space()), *fast = world(free_space());
    const cournand_order rate = {COURNAND_ORDER_RHYTHM, {1, 140}};
    done(cournand_world_order(fast, &rate));
    push(calm, 2500, 0.0f);
    push(fast, 2500, 0.0f);
    assert_true(hash(calm) != hash(fast));
    assert_true(std::fabs(reading(calm).heart_phase - reading(fast).heart_phase) > 0.05f);
    done(cournand_world_free(calm));
    done(cournand_world_free(fast));
}

void tools_are_exchanged_by_an_order(void **)
{
    auto options = sized<cournand_world_options>();
    options.line_count = 2;
    options.line[0] = 1;
    options.inserted_count = 1;
    options.inserted_m[0] = 0.05f;
    cournand_world *changed = world(free_space(), {"j_wire", "terumo_5f"}, &options);
    push(changed, 10);
    assert_int_equal(reading(changed).line[1], 0);
    const cournand_order load = {COURNAND_ORDER_EXCHANGE, {1, 2}};
    done(cournand_world_order(changed, &load));
    push(changed, 1);
    assert_int_equal(reading(changed).exchange, 1);
    assert_int_equal(reading(changed).line[1], 2);
    done(cournand_world_free(changed));
}

void a_scaled_tool_is_as_stiff_as_asked(void **)
{
    cournand_tool *usual = tool("j_wire"), *stiff = nullptr;
    cournand_tool_scales scales = {sizeof scales, 0, 3.0, 3.0, 1.0, 1.0, 1.0};
    done(cournand_tool_scaled(usual, &scales, &stiff));
    cournand_world *made[2];
    cournand_tool *tools[] = {usual, stiff};
    for (int i = 0; i < 2; i++) {
        done(cournand_world_create(aorta(), &tools[i], 1, nullptr, &made[i]));
        push(made[i], 1000);
    }
    assert_true(hash(made[0]) != hash(made[1]));
    for (int i = 0; i < 2; i++) done(cournand_world_free(made[i]));
    done(cournand_tool_free(usual));
    done(cournand_tool_free(stiff));
}

// The instrument's file states 8.5 and 27.5 mm.
void the_marker_bands_of_a_balloon_are_named_from_the_tip(void **)
{
    cournand_tool *balloon = tool("balloon_6x20"), *wire = tool("j_wire");
    double arcs_m[3] = {-1.0, -1.0, -1.0};
    std::size_t count = 0;
    done(cournand_tool_markers(balloon, arcs_m, 1, &count));
    assert_int_equal(count, 2);
    assert_float_equal(arcs_m[0], 0.0085, 1e-9);
    assert_float_equal(arcs_m[1], -1.0, 0.0); // beyond the capacity
    done(cournand_tool_markers(balloon, arcs_m, 3, &count));
    assert_float_equal(arcs_m[1], 0.0275, 1e-9);
    done(cournand_tool_markers(wire, nullptr, 0, &count));
    assert_int_equal(count, 0);
    assert_int_equal(cournand_tool_markers(balloon, nullptr, 1, &count), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_tool_markers(balloon, arcs_m, 3, nullptr), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_tool_markers(nullptr, arcs_m, 3, &count), COURNAND_BAD_HANDLE);
    done(cournand_tool_free(balloon));
    done(cournand_tool_free(wire));
}

// The program `cournand replay --verify` also checks a recording with this function.
void a_recording_of_a_world_replays_in_the_program(void **)
{
    const Folder folder("library-record");
    const std::string path = folder.file("mine.rec");
    cournand_world *recorded = world(aorta());
    done(cournand_world_record(recorded, path.c_str(), "a test"));
    push(recorded, 700);
    done(cournand_world_end_recording(recorded));
    const crn::Recording read = crn::read_recording(path);
    assert_true(read.is_complete && read.header.session_path == "a test");
    const crn::SceneFile scene = crn::read_scene(read.header.scene_path);
    crn::Device device(scene, read.header.tools, read.header.entry, read.header.rig);
    crn::ReplaySettings settings;
    settings.verifies = true;
    const crn::ReplayResult result = crn::replay_recording(device, read, nullptr, nullptr, settings);
    assert_false(result.first_difference_tick.has_value());
    assert_int_equal(result.ticks_compared, 700);
    assert_true(result.hash == hash(recorded));
    done(cournand_world_free(recorded));
}

void a_patient_receives_medium_and_changes_no_hash(void **)
{
    auto options = sized<cournand_world_options>();
    cournand_world *without = world(aorta(), {"terumo_5f"}, &options);
    options.flags = COURNAND_WITH_PATIENT;
    cournand_world *with = world(aorta(), {"terumo_5f"}, &options);
    done(cournand_world_inject(with, 5.0, 5.0, -1, 350.0));
    push(with, 500, 0.02f);
    push(without, 500, 0.02f);
    auto read = sized<cournand_patient_reading>();
    done(cournand_world_read_patient(with, &read));
    print_message("%.2f ml injected, %.0f mmHg, notice '%s'\n", read.injected_ml, read.pressure_mmHg,
                  read.notice);
    assert_true(read.injected_ml > 1.0 && read.injected_ml <= 5.0);
    assert_true(read.pressure_mmHg > 40.0 && read.pressure_mmHg < 200.0);
    assert_true(hash(with) == hash(without));
    done(cournand_world_free(with));
    done(cournand_world_free(without));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_inputs_of_a_session_of_run_give_its_state_hash),
        cmocka_unit_test(a_recording_of_run_replays_in_a_world),
        cmocka_unit_test(one_call_gives_the_same_bits_as_many),
        cmocka_unit_test(worlds_have_the_same_bits_with_1_2_and_4_threads),
        cmocka_unit_test(a_step_calls_the_function_after_each_world_has_moved),
        cmocka_unit_test(a_restored_world_continues_bit_for_bit),
        cmocka_unit_test(a_snapshot_in_memory_is_that_of_the_wire),
        cmocka_unit_test(a_shared_scene_is_that_of_an_upload),
        cmocka_unit_test(a_snapshot_gives_the_same_world_however_often_it_is_restored),
        cmocka_unit_test(a_pose_is_a_view_in_metres_and_in_exact_numbers),
        cmocka_unit_test(hands_move_the_stated_way),
        cmocka_unit_test(forces_of_the_wall_are_read_node_by_node_and_as_a_peak),
        cmocka_unit_test(a_tip_lies_in_a_vessel_that_the_scene_names),
        cmocka_unit_test(points_of_a_scene_that_rests_stay),
        cmocka_unit_test(an_order_changes_the_heart_rate),
        cmocka_unit_test(tools_are_exchanged_by_an_order),
        cmocka_unit_test(a_scaled_tool_is_as_stiff_as_asked),
        cmocka_unit_test(the_marker_bands_of_a_balloon_are_named_from_the_tip),
        cmocka_unit_test(a_recording_of_a_world_replays_in_the_program),
        cmocka_unit_test(a_patient_receives_medium_and_changes_no_hash),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
