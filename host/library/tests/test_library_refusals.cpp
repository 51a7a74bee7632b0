// Tests that the C library refuses wrong calls, that every refusal has a text, and that a refused call does
// not change its world.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "host/library/tests/worlds.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn::tests;

// Checks that the call was refused with this status, and that the text of the refusal contains these words.
void refused(cournand_status status, cournand_status expected, const std::string &words)
{
    const std::string text = cournand_error_text();
    if (status != expected || text.find(words) == std::string::npos)
        print_error("%s '%s', expected %s '%s'\n", cournand_status_name(status), text.c_str(),
                    cournand_status_name(expected), words.c_str());
    assert_int_equal(status, expected);
    assert_true(text.find(words) != std::string::npos);
}

void null_freed_and_foreign_handles_are_refused(void **)
{
    cournand_world *freed = world(free_space());
    std::uint64_t value = 0;
    refused(cournand_world_hash(nullptr, &value), COURNAND_BAD_HANDLE, "this is no world");
    done(cournand_world_free(freed));
    refused(cournand_world_hash(freed, &value), COURNAND_BAD_HANDLE, "freed");
    refused(cournand_world_free(freed), COURNAND_BAD_HANDLE, "freed");
    cournand_world *next = world(free_space()); // has the place of the freed one
    refused(cournand_world_hash(freed, &value), COURNAND_BAD_HANDLE, "freed");
    refused(cournand_world_hash(reinterpret_cast<cournand_world *>(free_space()), &value),
            COURNAND_BAD_HANDLE, "another kind");
    refused(cournand_tool_free(reinterpret_cast<cournand_tool *>(next)), COURNAND_BAD_HANDLE, "no tool");
    assert_string_equal(cournand_world_error_text(freed), "");
    done(cournand_world_free(next));
}

void a_world_lives_on_when_its_scene_and_tools_are_freed(void **)
{
    cournand_scene *scene = nullptr;
    done(cournand_scene_open("", nullptr, &scene));
    cournand_world *kept = world(scene);
    done(cournand_scene_free(scene));
    push(kept, 10);
    done(cournand_world_free(kept));
}

void wrong_actions_change_nothing(void **)
{
    cournand_world *kept = world(free_space());
    push(kept, 50);
    const std::vector<std::uint8_t> before = saved(kept);
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinite = std::numeric_limits<float>::infinity();
    const struct {
        std::size_t index;
        float value;
    } wrong[] = {{0, nan}, {0, infinite}, {0, 1.5f},  {1, 0.1f}, {3, 1000.0f},
                 {3, nan}, {5, 1.0f},     {6, -1.0f}, {6, 1e9f}, {7, 1.0f}};
    for (const auto &one : wrong) {
        float action[COURNAND_ACTION_FLOATS] = {0.01f};
        action[one.index] = one.value;
        refused(cournand_world_move(kept, action, 10), COURNAND_BAD_ARGUMENT,
                "action[" + std::to_string(one.index) + "]");
        assert_string_equal(cournand_world_error_text(kept), cournand_error_text());
    }
    const float action[COURNAND_ACTION_FLOATS] = {0.01f};
    refused(cournand_world_move(kept, nullptr, 10), COURNAND_BAD_ARGUMENT, "NULL");
    refused(cournand_world_move(kept, action, 0), COURNAND_BAD_ARGUMENT, "ticks");
    refused(cournand_world_move(kept, action, UINT32_MAX), COURNAND_BAD_ARGUMENT, "ticks");
    assert_true(saved(kept) == before);
    done(cournand_world_free(kept));
}

void wrong_inputs_and_orders_change_nothing(void **)
{
    cournand_world *kept = world(free_space());
    push(kept, 50);
    const std::vector<std::uint8_t> before = saved(kept);
    std::vector<cournand_input> inputs(200);
    inputs[150].order_count = 1;
    inputs[150].orders[0] = {COURNAND_ORDER_RHYTHM, {1, 1000}};
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_REFUSED, "ORDER_RANGE");
    inputs[150].orders[0] = {9, {}};
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "kind 9");
    inputs[150].orders[0] = {COURNAND_ORDER_EXCHANGE, {2, 1}};
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "exchange");
    inputs[150].order_count = 5;
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "orders");
    inputs[150] = {};
    inputs[199].buttons = 1u << 20;
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "buttons");
    inputs[199] = {};
    inputs[199].push_um[0] = 100000; // would stop the device
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "5 mm");
    inputs[199] = {};
    inputs[199].turn_counts[0] = INT32_MIN;
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "quarter");
    inputs[199] = {};
    inputs[199].push_um[2] = 1;
    refused(cournand_world_advance(kept, inputs.data(), inputs.size()), COURNAND_BAD_ARGUMENT, "position");
    refused(cournand_world_advance(kept, inputs.data(), 0), COURNAND_BAD_ARGUMENT, "ticks");
    refused(cournand_world_advance(kept, nullptr, 1), COURNAND_BAD_ARGUMENT, "NULL");
    const cournand_order lonely = {COURNAND_ORDER_EXCHANGE, {0, 0}}; // the only tool leads
    refused(cournand_world_order(kept, &lonely), COURNAND_REFUSED, "exchange");
    assert_true(saved(kept) == before);
    done(cournand_world_free(kept));
}

void long_texts_are_cut_between_characters(void **)
{
    for (const std::string path : {"/", "/x", "/xy", "/xyz"}) {
        std::string name = path;
        for (int i = 0; i < 2000; i++) name += "\u00f6"; // two bytes each
        cournand_tool *made = nullptr;
        assert_int_equal(cournand_tool_open(name.c_str(), &made), COURNAND_BAD_FILE);
        const std::string text = cournand_error_text();
        assert_true(text.size() >= 1000 && text.size() < 1024);
        assert_int_equal(static_cast<unsigned char>(text.back()), 0xb6); // the second byte
    }
}

void damaged_snapshots_change_nothing(void **)
{
    cournand_world *kept = world(free_space());
    push(kept, 50);
    const std::vector<std::uint8_t> good = saved(kept);
    push(kept, 50);
    const std::vector<std::uint8_t> before = saved(kept);
    for (std::size_t at = 0; at < good.size(); at += at < 600 ? 1 : 997) {
        std::vector<std::uint8_t> bad = good;
        bad[at] ^= 0x10;
        if (at >= 12 && at < 16)
            continue; // tells whether physics left its range, of which the device knows nothing
        refused(cournand_world_restore(kept, bad.data(), bad.size()), COURNAND_BAD_SNAPSHOT, "snapshot");
    }
    refused(cournand_world_restore(kept, good.data(), good.size() - 1), COURNAND_BAD_SNAPSHOT, "bytes");
    std::vector<std::uint8_t> old = good;
    old[4] = 1;
    old.resize(old.size() - 16); // version 1 had no wall forces
    refused(cournand_world_restore(kept, old.data(), old.size()), COURNAND_BAD_SNAPSHOT, "version 1");
    refused(cournand_world_restore(kept, nullptr, good.size()), COURNAND_BAD_ARGUMENT, "NULL");
    std::vector<std::uint8_t> small(10);
    refused(cournand_world_save(kept, small.data(), small.size()), COURNAND_BAD_ARGUMENT, "smaller");
    cournand_world *other = world(free_space(), {"bentson"});
    refused(cournand_world_restore(other, good.data(), good.size()), COURNAND_BAD_SNAPSHOT, "another");
    assert_true(saved(kept) == before);
    done(cournand_world_free(kept));
    done(cournand_world_free(other));
}

void structs_of_another_size_are_refused_unless_the_rest_is_zero(void **)
{
    cournand_world *kept = world(free_space());
    struct {
        cournand_reading reading;
        std::uint32_t later[4];
    } newer = {};
    newer.reading.struct_bytes = sizeof newer;
    done(cournand_world_read(kept, &newer.reading));
    assert_int_equal(newer.reading.struct_bytes, sizeof newer);
    newer.later[3] = 1;
    refused(cournand_world_read(kept, &newer.reading), COURNAND_BAD_ARGUMENT, "does not know");
    newer.reading.struct_bytes = sizeof newer.reading - 4;
    refused(cournand_world_read(kept, &newer.reading), COURNAND_BAD_ARGUMENT, "struct_bytes");
    newer.reading.struct_bytes = UINT32_MAX;
    refused(cournand_world_read(kept, &newer.reading), COURNAND_BAD_ARGUMENT, "struct_bytes");
    refused(cournand_world_read(kept, nullptr), COURNAND_BAD_ARGUMENT, "NULL");
    done(cournand_world_free(kept));
}

void wrong_options_make_no_world(void **)
{
    cournand_tool *tools[] = {tool("j_wire"), tool("terumo_5f"), tool("bentson"), tool("rosen")};
    cournand_world *made = nullptr;
    const auto create = [&](std::size_t count, const cournand_world_options &options) {
        return cournand_world_create(free_space(), tools, count, &options, &made);
    };
    const auto usual = sized<cournand_world_options>();
    refused(create(4, usual), COURNAND_BAD_ARGUMENT, "more than three");
    refused(create(0, usual), COURNAND_BAD_ARGUMENT, "tool_count");
    refused(create(SIZE_MAX, usual), COURNAND_BAD_ARGUMENT, "tool_count");
    refused(create(3, usual), COURNAND_REFUSED, "does not pass the lumen"); // a wire around a catheter
    cournand_world_options options = usual;
    options.flags = 128;
    refused(create(1, options), COURNAND_BAD_ARGUMENT, "flags");
    options = usual;
    options.line_count = 2;
    options.line[0] = options.line[1] = 1;
    refused(create(2, options), COURNAND_BAD_ARGUMENT, "twice");
    options.line[1] = 7;
    refused(create(2, options), COURNAND_BAD_ARGUMENT, "not in");
    options = usual;
    options.inserted_count = 1;
    options.inserted_m[0] = -1.0f;
    refused(create(1, options), COURNAND_BAD_ARGUMENT, "inserted_m");
    options = usual;
    options.stent_count = 1;
    refused(create(1, options), COURNAND_BAD_ARGUMENT, "COURNAND_WITH_PATIENT");
    refused(cournand_world_create(free_space(), nullptr, 1, nullptr, &made), COURNAND_BAD_ARGUMENT, "NULL");
    refused(cournand_world_create(free_space(), tools, 1, nullptr, nullptr), COURNAND_BAD_ARGUMENT, "NULL");
    refused(cournand_world_create(nullptr, tools, 1, nullptr, &made), COURNAND_BAD_HANDLE, "scene");
    assert_null(made);
    for (cournand_tool *one : tools) done(cournand_tool_free(one));
}

void missing_and_wrong_files_are_named(void **)
{
    cournand_scene *scene = nullptr;
    cournand_tool *none = nullptr;
    cournand_recording *recording = nullptr;
    refused(cournand_scene_open("/nowhere/x.scene", nullptr, &scene), COURNAND_BAD_FILE, "/nowhere/x.scene");
    refused(cournand_scene_open("README.md", nullptr, &scene), COURNAND_BAD_FILE, "README.md");
    refused(cournand_tool_open("README.md", &none), COURNAND_BAD_FILE, "README.md");
    refused(cournand_recording_open("README.md", &recording), COURNAND_BAD_FILE, "README.md");
    refused(cournand_tool_open(nullptr, &none), COURNAND_BAD_ARGUMENT, "NULL");
    cournand_world *kept = world(free_space());
    refused(cournand_world_record(kept, "/nowhere/x.rec", ""), COURNAND_BAD_FILE, "/nowhere/x.rec");
    refused(cournand_world_end_recording(kept), COURNAND_BAD_STATE, "not being recorded");
    std::uint32_t number = 0;
    refused(cournand_scene_find_vessel(aorta(), "aortic arc", &number), COURNAND_BAD_ARGUMENT, "aortic arch");
    done(cournand_world_free(kept));
}

void calls_in_a_wrong_order_are_refused(void **)
{
    cournand_world *kept = world(free_space());
    refused(cournand_world_inject(kept, 5.0, 5.0, -1, 350.0), COURNAND_BAD_STATE, "COURNAND_WITH_PATIENT");
    push(kept, 1);
    const Folder folder("library-order");
    refused(cournand_world_record(kept, folder.file("a.rec").c_str(), ""), COURNAND_BAD_STATE, "tick 0");
    const cournand_order rate = {COURNAND_ORDER_RHYTHM, {1, 90}};
    done(cournand_world_order(kept, &rate));
    std::vector<std::uint8_t> bytes(100000);
    refused(cournand_world_save(kept, bytes.data(), bytes.size()), COURNAND_BAD_STATE, "waits");
    push(kept, 1);
    done(cournand_world_save(kept, bytes.data(), bytes.size()));
    auto options = sized<cournand_world_options>();
    options.flags = COURNAND_WITH_PATIENT;
    cournand_world *patient = world(free_space(), {"j_wire"}, &options);
    refused(cournand_world_inject(patient, 5.0, 5.0, -1, 350.0), COURNAND_REFUSED, "");
    refused(cournand_world_inject(patient, std::nan(""), 5.0, -1, 350.0), COURNAND_BAD_ARGUMENT, "volume");
    refused(cournand_world_load_stent(patient), COURNAND_BAD_STATE, "stents");
    done(cournand_world_free(patient));
    done(cournand_world_free(kept));
}

void a_world_and_a_pool_refuse_a_second_thread(void **)
{
    cournand_pool *pool = nullptr;
    done(cournand_pool_create(2, &pool));
    const auto again = [](void *context, std::size_t) {
        auto *own = static_cast<cournand_pool *>(context);
        if (cournand_pool_run(
                own, 1, [](void *, std::size_t) {}, nullptr) != COURNAND_BUSY)
            throw 1;
    };
    done(cournand_pool_run(pool, 4, again, pool));
    refused(cournand_pool_run(
                pool, 1, [](void *, std::size_t) { throw 1; }, nullptr),
            COURNAND_BAD_ARGUMENT, "exception");
    cournand_world *shared = world(free_space());
    std::thread other([&] {
        const float action[COURNAND_ACTION_FLOATS] = {0.01f};
        while (cournand_world_move(shared, action, 20000) == COURNAND_BUSY) continue;
    });
    std::uint64_t value = 0;
    cournand_status status = COURNAND_OK;
    for (int i = 0; i < 1000000 && status == COURNAND_OK; i++) status = cournand_world_hash(shared, &value);
    refused(status, COURNAND_BUSY, "another thread");
    other.join();
    cournand_world *twice[] = {shared, shared};
    const float actions[2 * COURNAND_ACTION_FLOATS] = {};
    refused(cournand_pool_move(pool, twice, 2, actions, 1, nullptr), COURNAND_BAD_ARGUMENT, "twice");
    cournand_world *one_missing[] = {shared, nullptr};
    std::int32_t statuses[2] = {-1, -1};
    refused(cournand_pool_move(pool, one_missing, 2, actions, 1, statuses), COURNAND_BAD_HANDLE, "world 1");
    assert_int_equal(statuses[0], COURNAND_OK);
    assert_int_equal(statuses[1], COURNAND_BAD_HANDLE);
    cournand_world *second = world(free_space());
    cournand_world *both[] = {shared, second};
    float one_wrong[2 * COURNAND_ACTION_FLOATS] = {0.01f};
    one_wrong[COURNAND_ACTION_FLOATS] = NAN;
    const std::uint32_t before = reading(shared).tick;
    refused(cournand_pool_move(pool, both, 2, one_wrong, 5, statuses), COURNAND_BAD_ARGUMENT, "world 1");
    assert_int_equal(statuses[1], COURNAND_BAD_ARGUMENT);
    assert_int_equal(reading(shared).tick, before); // no world has moved
    assert_int_equal(reading(second).tick, 0);
    done(cournand_world_free(second));
    refused(cournand_pool_create(0, &pool), COURNAND_BAD_ARGUMENT, "threads");
    refused(cournand_pool_create(100000, &pool), COURNAND_BAD_ARGUMENT, "threads");
    done(cournand_world_free(shared));
    done(cournand_pool_free(pool));
}

void a_child_of_fork_is_told_to_make_its_own_pool(void **)
{
    cournand_pool *pool = nullptr;
    done(cournand_pool_create(2, &pool));
    const pid_t child = fork();
    if (child == 0) {
        const cournand_status status = cournand_pool_run(
            pool, 1, [](void *, std::size_t) {}, nullptr);
        _exit(status == COURNAND_BAD_STATE && cournand_pool_free(pool) == COURNAND_OK ? 0 : 1);
    }
    int end = -1;
    assert_int_equal(waitpid(child, &end, 0), child);
    assert_int_equal(end, 0);
    done(cournand_pool_free(pool));
}

void a_replay_of_another_set_up_or_beyond_the_end_is_refused(void **)
{
    const Folder folder("library-replay");
    const std::string path = folder.file("a.rec");
    cournand_world *recorded = world(free_space());
    done(cournand_world_record(recorded, path.c_str(), "test"));
    push(recorded, 100);
    done(cournand_world_end_recording(recorded));
    cournand_recording *recording = nullptr;
    done(cournand_recording_open(path.c_str(), &recording));
    refused(cournand_world_replay(recorded, recording, 50), COURNAND_BAD_ARGUMENT, "before");
    refused(cournand_world_replay(recorded, recording, 101), COURNAND_BAD_ARGUMENT, "end");
    cournand_world *other = world(free_space(), {"bentson"});
    refused(cournand_world_replay(other, recording, 50), COURNAND_BAD_ARGUMENT, "set-up");
    cournand_world *made = nullptr;
    refused(cournand_recording_world(recording, aorta(), 0, &made), COURNAND_BAD_ARGUMENT, "not that of");
    cournand_world *pushed = world(free_space()); // has the set-up, but another history
    push(pushed, 10, 0.1f);
    refused(cournand_world_replay(pushed, recording, 100), COURNAND_DIFFERENT, "tick 11");
    for (cournand_world *one : {recorded, other, pushed}) done(cournand_world_free(one));
    done(cournand_recording_free(recording));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(null_freed_and_foreign_handles_are_refused),
        cmocka_unit_test(a_world_lives_on_when_its_scene_and_tools_are_freed),
        cmocka_unit_test(wrong_actions_change_nothing),
        cmocka_unit_test(wrong_inputs_and_orders_change_nothing),
        cmocka_unit_test(long_texts_are_cut_between_characters),
        cmocka_unit_test(damaged_snapshots_change_nothing),
        cmocka_unit_test(structs_of_another_size_are_refused_unless_the_rest_is_zero),
        cmocka_unit_test(wrong_options_make_no_world),
        cmocka_unit_test(missing_and_wrong_files_are_named),
        cmocka_unit_test(calls_in_a_wrong_order_are_refused),
        cmocka_unit_test(a_world_and_a_pool_refuse_a_second_thread),
        cmocka_unit_test(a_child_of_fork_is_told_to_make_its_own_pool),
        cmocka_unit_test(a_replay_of_another_set_up_or_beyond_the_end_is_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
