/* Claims about the memories of a board, through bytes on the simulated port: a large scene may take both
 * slots, and near memory must hold what a scene needs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/core/motion.h"
#include "firmware/core/near/near.h"
#include "firmware/tests/reference/client.h"
#include "firmware/tests/reference/tube_scene.h"

enum { SLOT_BYTES = 1 << 18, FILE_MAX = 1 << 20 };

static client host;
static crn_wire_status status;
static crn_wire_reject reject;

typedef struct scene_file {
    uint8_t bytes[FILE_MAX];
    uint32_t count;
} scene_file;
static scene_file large, medium, small;
static uint32_t near_medium, near_small; /* bytes of near memory that they need */

static uint32_t make_tube(scene_file *file, double length_m, double radius_m)
{
    const reference_piece straight = {length_m, 0, 0};
    reference_tube *tube = reference_tube_make(&straight, 1, radius_m, 0);
    file->count = (uint32_t)reference_tube_scene(tube, file->bytes, sizeof file->bytes);
    const uint32_t near_bytes = crn_lumen_near_bytes(&tube->lumen);
    reference_tube_free(tube);
    assert_true(file->count > 0);
    return near_bytes;
}

static int make_scenes(void **state)
{
    (void)state;
    make_tube(&large, 0.5, 0.0045);
    near_medium = make_tube(&medium, 0.2, 0.002);
    near_small = make_tube(&small, 0.1, 0.002);
    print_message("# scenes of %u, %u, %u bytes\n", large.count, medium.count, small.count);
    return large.count <= SLOT_BYTES || large.count > 2 * SLOT_BYTES || medium.count > SLOT_BYTES;
}

static int set_up(void **state)
{
    (void)state;
    client_open(&host, SLOT_BYTES);
    return host.sim == NULL;
}

static int tear_down(void **state)
{
    (void)state;
    client_close(&host);
    return 0;
}

static void greet(void)
{
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
}

/* Loads a scene, which must be refused with these figures. */
static void expect_refusal(const scene_file *scene, uint16_t code, uint32_t detail1, uint32_t detail2)
{
    assert_false(client_load_scene(&host, scene->bytes, scene->count));
    assert_true(crn_wire_decode_reject(host.decoder.payload, host.decoder.payload_bytes, &reject));
    if (reject.code != code || reject.detail1 != detail1 || reject.detail2 != detail2)
        fail_msg("refused with %s [%u, %u], expected %s [%u, %u]", crn_wire_reject_name(reject.code),
                 reject.detail1, reject.detail2, crn_wire_reject_name(code), detail1, detail2);
}

/* Returns the hash of the state after 200 ticks in which a soft wire is pushed by 10 mm, and falls to the
 * floor. */
static uint64_t hash_of_session(void)
{
    static crn_wire_tools tools;
    static crn_wire_ticks ticks;
    client_plain_tools(&tools, 1);
    tools.tools[0].knots[0].bend_stiffness_nN_m2 = tools.tools[0].knots[1].bend_stiffness_nN_m2 = 3000;
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    assert_true(client_entry_along(&host, 0, 80000));
    client_command(&host, CRN_WIRE_ACTION_ARM);
    assert_true(client_expect_status(&host, &status));
    client_command(&host, CRN_WIRE_ACTION_START);
    assert_true(client_expect_status(&host, &status));
    for (uint32_t tick = 0; tick < 200; tick += 50) {
        client_step(&host, tick, 50, (int32_t)(50 * tick), 50);
        assert_true(client_expect_ticks(&host, &ticks));
    }
    const crn_wire_tick_state *last = &ticks.states[ticks.states_count - 1];
    client_command(&host, CRN_WIRE_ACTION_RESET);
    assert_true(client_expect_status(&host, &status));
    return (uint64_t)last->hash_lane1 << 32 | last->hash_lane0;
}

/* The hash on a device whose slots hold every scene, and which reads it in place. */
static uint64_t hash_of(const scene_file *scene)
{
    client_close(&host);
    client_open(&host, FILE_MAX);
    greet();
    assert_true(client_load_scene(&host, scene->bytes, scene->count));
    const uint64_t hash = hash_of_session();
    client_close(&host);
    client_open(&host, SLOT_BYTES);
    return hash;
}

static void a_scene_larger_than_a_slot_takes_both(void **state)
{
    (void)state;
    const uint64_t large_hash = hash_of(&large), small_hash = hash_of(&small);
    assert_true(large_hash != small_hash);
    crn_sim_set_memory(host.sim, true, NULL, 0);
    greet();
    assert_true(client_load_scene(&host, small.bytes, small.count));
    assert_true(client_load_scene(&host, large.bytes, large.count));
    assert_true(hash_of_session() == large_hash);
    assert_true(client_load_scene(&host, small.bytes, small.count));
    assert_true(hash_of_session() == small_hash);
}

/* Loads a scene whose first byte is wrong: it is refused after its last byte. */
static void load_damaged(scene_file *scene)
{
    scene->bytes[0] ^= 0xff;
    assert_false(client_load_scene(&host, scene->bytes, scene->count));
    assert_true(crn_wire_decode_reject(host.decoder.payload, host.decoder.payload_bytes, &reject));
    scene->bytes[0] ^= 0xff;
}

/* The upload has written over the old scene, if either takes both slots. So free space is left, and no part
 * of a scene. */
static void a_damaged_scene_in_both_slots_leaves_free_space(void **state)
{
    (void)state;
    const uint64_t small_hash = hash_of(&small);
    crn_sim_set_memory(host.sim, true, NULL, 0);
    greet();
    const uint64_t free_hash = hash_of_session();
    assert_true(free_hash != small_hash);
    assert_true(client_load_scene(&host, small.bytes, small.count));
    load_damaged(&small); /* neither takes both slots: the old one stays */
    assert_true(hash_of_session() == small_hash);
    load_damaged(&large);
    assert_true(hash_of_session() == free_hash);
    assert_true(client_load_scene(&host, large.bytes, large.count));
    load_damaged(&small);
    assert_true(hash_of_session() == free_hash);
    assert_true(client_load_scene(&host, small.bytes, small.count));
    assert_true(hash_of_session() == small_hash);
}

/* Where the slots do not lie side by side, a scene larger than one is refused, and the old one stays. */
static void a_scene_larger_than_a_slot_is_refused_elsewhere(void **state)
{
    (void)state;
    const uint64_t small_hash = hash_of(&small);
    greet();
    assert_true(client_load_scene(&host, small.bytes, small.count));
    expect_refusal(&large, CRN_REJECT_SCENE_SIZE, large.count, SLOT_BYTES);
    assert_true(hash_of_session() == small_hash);
}

/* The reply names what the scene needs and what the device has; the old scene stays in near memory. */
static void a_scene_that_near_memory_cannot_hold_is_refused(void **state)
{
    (void)state;
    static uint8_t memory[1 << 18] __attribute__((aligned(32)));
    const uint64_t small_hash = hash_of(&small);
    assert_true(near_small < near_medium && near_small <= sizeof memory);
    crn_sim_set_memory(host.sim, false, memory, near_small);
    greet();
    assert_true(client_load_scene(&host, small.bytes, small.count));
    expect_refusal(&medium, CRN_REJECT_SCENE_NEAR, near_medium, near_small);
    const crn_near *near = (const crn_near *)(const void *)memory;
    assert_int_equal(near->slices_copied, 0);
    assert_true(hash_of_session() == small_hash);
    assert_true(near->slices_copied > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_scene_larger_than_a_slot_takes_both, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_damaged_scene_in_both_slots_leaves_free_space, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_scene_larger_than_a_slot_is_refused_elsewhere, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_scene_that_near_memory_cannot_hold_is_refused, set_up, tear_down),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, make_scenes, NULL);
}
