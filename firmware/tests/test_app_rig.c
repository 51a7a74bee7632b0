/* These tests check the configuration of the rig's tracks (one per tool). The tests show which couplings a
 * rig can render at a given force gain, and which data about a rig a host may change without a person at the
 * rig. The tests exchange bytes with the simulated port. According to its builder's data, the rig of this
 * port has 1 um per count, its own damping of 1 N s/m and 2 uN m s/rad, and no lag. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app_internal.h"
#include "firmware/tests/reference/bench_fixture.h"

enum {
    FIELD_TRANSLATION = 0,
    FIELD_ROTATION = 1,
    FIELD_GAIN = 2,
    FIELD_OPTIONS = 7,
    FIELD_FORCE_SCALE = 9,
    FIELD_DAMPING_ALONG = 10,
    FIELD_DAMPING_ABOUT = 11,
    FIELD_COUPLING_ALONG = 15,
    FIELD_COUPLING_ABOUT = 16,
};

/* Makes a port with motors; the port sends and receives no bytes. */
static bool swallow(void *context, const uint8_t *frame, size_t bytes)
{
    (void)context;
    (void)frame;
    return bytes > 0;
}

static void ignore(void *context, const crn_port_outputs *outputs)
{
    (void)context;
    (void)outputs;
}

static const crn_port quiet_port = {
    .transmit = swallow, .outputs = ignore, .serial = "quiet", .capabilities = CRN_WIRE_CAPABILITY_MOTORS};

static void lock(bool is_unlocked)
{
    b.rig.local_unlock = is_unlocked;
    bench_tick(&b);
}

static void expect_taken(const crn_wire_track *track)
{
    bench_drain(&b);
    client_rig(&b.host, track, 1);
    if (!client_expect_status(&b.host, &status)) {
        fail_msg("refused: gain %u, coupling %u, damping %u, lag %u, %u pm", track->force_gain_milli,
                 track->coupling_N_per_m, track->damping_mN_s_per_m, track->actuator_lag_us,
                 track->translation_pm_per_count);
    }
}

static void expect_refused(const crn_wire_track *track, uint32_t field)
{
    crn_wire_reject reject;
    bench_drain(&b);
    client_rig(&b.host, track, 1);
    if (!client_expect_reject(&b.host, &reject)) {
        fail_msg("taken: gain %u, coupling %u, damping %u, lag %u, %u pm", track->force_gain_milli,
                 track->coupling_N_per_m, track->damping_mN_s_per_m, track->actuator_lag_us,
                 track->translation_pm_per_count);
    }
    assert_int_equal(reject.code, CRN_REJECT_RIG_RANGE);
    assert_int_equal(reject.detail2, field);
}

/* --- couplings that a rig can render --- */

/* By the condition for passivity, b > G (K (T / 2 + t) + B), a rig with a damping b of 1 N s/m and a lag t of
 * 0.5 ms has just enough damping for a coupling of K = 800 N/m and B = 0.2 N s/m (G: force gain, T: tick).
 * With a force gain of 2, the hand feels 1,600 N/m instead of 800 N/m, so only half of this stiffness and
 * half of the damping are allowed. */
/* Requirement: SR-07 */
static void a_gain_above_one_counts_as_stiffness_and_damping(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.coupling_uN_m_per_rad = track.coupling_nN_m_s_per_rad = 0;
    track.actuator_lag_us = 500;
    track.coupling_N_per_m = 800;
    lock(true);
    expect_taken(&track);
    track.force_gain_milli = 1001;
    expect_refused(&track, FIELD_COUPLING_ALONG);
    track.force_gain_milli = 2000;
    expect_refused(&track, FIELD_COUPLING_ALONG);
    track.coupling_N_per_m = 400;
    expect_refused(&track, FIELD_COUPLING_ALONG); /* 2 x (0.4 + 0.2) */
    track.coupling_mN_s_per_m = 100;
    expect_taken(&track);
    track.coupling_N_per_m = 401;
    expect_refused(&track, FIELD_COUPLING_ALONG);
}

/* With a force gain below one, the hand feels less than the tool's true force, but the stiffness of the
 * coupling itself is unchanged. */
static void a_gain_below_one_allows_nothing_stiffer(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.coupling_N_per_m = 1600;
    expect_taken(&track);
    track.force_gain_milli = 500;
    expect_taken(&track);
    track.coupling_N_per_m = 1601;
    expect_refused(&track, FIELD_COUPLING_ALONG);
}

static void a_gain_counts_about_the_line_too(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.coupling_N_per_m = track.coupling_mN_s_per_m = track.coupling_nN_m_s_per_rad = 0;
    track.coupling_uN_m_per_rad = 1000;
    track.force_gain_milli = 4000;
    lock(true);
    expect_taken(&track);
    track.coupling_uN_m_per_rad = 1001;
    expect_refused(&track, FIELD_COUPLING_ABOUT);
}

/* --- who may state which values --- */

/* Describes one value of a setting that the host sends, whether the local unlock is open at that time, and
 * whether the device must accept the value. */
typedef struct ask {
    uint32_t value;
    bool is_unlocked, is_taken;
} ask;

static void ask_each(crn_wire_track *track, uint32_t *value, uint32_t field, const ask *asks, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        lock(asks[i].is_unlocked);
        *value = asks[i].value;
        if (asks[i].is_taken) {
            expect_taken(track);
        } else {
            expect_refused(track, field);
        }
    }
}
#define ASK(field, number, ...)                                                                              \
    do {                                                                                                     \
        const ask asks[] = {__VA_ARGS__};                                                                    \
        ask_each(&track, &track.field, number, asks, sizeof asks / sizeof asks[0]);                          \
    } while (0)

/* Makes a coupling along the insertion axis that every damping and gain of this test supports. */
static crn_wire_track soft_track(void)
{
    crn_wire_track track = client_plain_track();
    track.coupling_N_per_m = 1;
    track.coupling_mN_s_per_m = track.coupling_uN_m_per_rad = track.coupling_nN_m_s_per_rad = 0;
    return track;
}

/* Without a person at the rig, no host can make the user feel a force greater than that of the tool. The host
 * may always set a smaller force gain than the present one, and may send the present gain again. */
static void a_gain_above_one_needs_the_local_unlock(void **state)
{
    (void)state;
    crn_wire_track track = soft_track();
    ASK(force_gain_milli, FIELD_GAIN, {1000, false, true}, {1001, false, false}, {4000, false, false},
        {0, false, true}, {1000, false, true}, {4000, true, true}, {4000, false, true}, {3999, false, false},
        {1000, false, true}, {4000, false, false}, {4001, true, false});
}

/* If a host could claim damping that the rig does not have, the device would accept a coupling that the rig
 * cannot render. */
/* Requirement: SR-18 */
static void more_damping_than_was_built_needs_the_local_unlock(void **state)
{
    (void)state;
    crn_wire_track track = soft_track();
    ASK(damping_mN_s_per_m, FIELD_DAMPING_ALONG, {1000, false, true}, {1001, false, false},
        {100, false, true}, {1000, false, true}, {1000000, false, false}, {2000, true, true},
        {2000, false, true}, {1999, false, false}, {1000, false, true});
    track = soft_track();
    ASK(damping_nN_m_s_per_rad, FIELD_DAMPING_ABOUT, {2000, false, true}, {2001, false, false},
        {2001, true, true}, {0, false, true});
}

/* If a host could conceal the motors' lag, the device would also accept a coupling that the rig cannot
 * render. The rig was built with a lag of 700 us. */
static void less_lag_than_was_built_needs_the_local_unlock(void **state)
{
    (void)state;
    crn_app_track track;
    crn_port port = {.built = {.actuator_lag_us = 700, .damping_mN_s_per_m = 1000}};
    crn_app_track_default(&track, &port);
    assert_int_equal(track.wire.actuator_lag_us, 700);
    crn_wire_track asked = soft_track();
    asked.damping_nN_m_s_per_rad = 0;
    static const ask asks[] = {{700, false, true},   {699, false, false}, {0, false, false},
                               {20000, false, true}, {0, true, true},     {0, false, true}};
    static crn_app app; /* the sim's own rig has no lag */
    crn_app_init(&app, &quiet_port);
    app.state = CRN_WIRE_STATE_READY;
    app.edge.has_rig = true;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) app.setup.tracks[k] = track;
    for (size_t i = 0; i < sizeof asks / sizeof asks[0]; i++) {
        const crn_wire_rig rig = {.tracks_count = 1, .tracks = {asked}};
        crn_wire_rig changed = rig;
        changed.tracks[0].actuator_lag_us = asks[i].value;
        app.edge.rig.local_unlock = asks[i].is_unlocked;
        const uint32_t before = app.setup.tracks[0].wire.actuator_lag_us;
        crn_app_rig_take(&app, &changed);
        assert_int_equal(app.setup.tracks[0].wire.actuator_lag_us, asks[i].is_taken ? asks[i].value : before);
    }
}

/* The rule for the encoder's scale is the same as for the force sensor's scale. A host may change the
 * encoder's scale by up to a quarter of the value that the rig's builder gave, and with the local unlock to
 * any value. In an earlier version, a host could change the encoder's scale by a factor of 5 x 10^5. */
static void an_encoder_s_scale_moves_by_a_quarter_without_the_local_unlock(void **state)
{
    (void)state;
    crn_wire_track track = soft_track();
    ASK(translation_pm_per_count, FIELD_TRANSLATION, {749999, false, false}, {750000, false, true},
        {1250000, false, true}, {1250001, false, false}, {1000, false, false}, {500000000, false, false},
        {25000000, true, true}, {25000000, false, true}, {24000000, false, false}, {1000000, false, true},
        {25000000, false, false}, {500000001, true, false});
    track = soft_track();
    ASK(rotation_counts_per_turn, FIELD_ROTATION, {49151, false, false}, {49152, false, true},
        {81920, false, true}, {81921, false, false}, {1024, true, true}, {1024, false, true},
        {65536, false, true});
}

/* If a host claims a quarter more travel per count than is true, the coupling becomes a quarter stiffer than
 * its setting. */
static void a_larger_scale_counts_as_stiffness(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.coupling_uN_m_per_rad = track.coupling_nN_m_s_per_rad = 0;
    track.coupling_mN_s_per_m = 0;
    track.coupling_N_per_m = 1600;
    track.translation_pm_per_count = 1250000;
    lock(false);
    expect_taken(&track); /* 1.25 x 1,600 x 0.5 ms = 1 N s/m */
    track.coupling_N_per_m = 1601;
    expect_refused(&track, FIELD_COUPLING_ALONG);
    track.translation_pm_per_count = 750000; /* and one that states less gains nothing */
    track.coupling_N_per_m = 2000;
    expect_taken(&track);
    track.coupling_N_per_m = 2001;
    expect_refused(&track, FIELD_COUPLING_ALONG);
    track.translation_pm_per_count = 50000000; /* a person at the rig has installed another encoder */
    track.coupling_N_per_m = 2000;
    lock(true);
    expect_taken(&track);
}

/* If a host claims the wrong counting direction of an encoder, every spring becomes a push away from its rest
 * position. */
static void the_sense_of_an_encoder_changes_only_with_the_local_unlock(void **state)
{
    (void)state;
    crn_wire_track track = soft_track();
    ASK(options, FIELD_OPTIONS, {0, false, true}, {CRN_WIRE_OPTION_TRANSLATION_REVERSED, false, false},
        {CRN_WIRE_OPTION_ROTATION_REVERSED, false, false}, {CRN_WIRE_OPTION_TRANSLATION_REVERSED, true, true},
        {CRN_WIRE_OPTION_TRANSLATION_REVERSED, false, true}, {0, false, true},
        {CRN_WIRE_OPTION_TRANSLATION_REVERSED, false, false});
}

/* In LOCKSTEP the host provides the positions of the user's hands, in its own counts, and no motor is driven.
 * If a person at the rig has confirmed values, they stay valid when the host sends the rig's settings again.
 * To judge a coupling, the device does not use a host's values that no person at the rig has confirmed. */
static void a_track_without_a_coupling_may_have_any_scale(void **state)
{
    (void)state;
    crn_wire_track rig = soft_track(), session = soft_track();
    rig.translation_pm_per_count = 25000000;
    rig.options = CRN_WIRE_OPTION_TRANSLATION_REVERSED;
    session.coupling_N_per_m = 0;
    session.force_gain_milli = 4000;
    session.translation_pm_per_count = 4000000;
    lock(true);
    expect_taken(&rig);
    lock(false);
    expect_taken(&session);
    session.coupling_N_per_m = 1;
    expect_refused(&session, FIELD_TRANSLATION);
    session.coupling_N_per_m = 0;
    session.force_uN_per_count = 1; /* the force sensor is checked in every state */
    expect_refused(&session, FIELD_FORCE_SCALE);
    expect_taken(&rig);
}

/* The same table of rules applies to every path; this test uses the path of HID. */
static void settings_without_frames_obey_the_same_table(void **state)
{
    (void)state;
    static crn_app app;
    crn_app_init(&app, &quiet_port);
    app.state = CRN_WIRE_STATE_READY;
    app.link.is_greeted = true;
    app.edge.has_rig = true;
    crn_wire_rig rig = {.tracks_count = 1, .tracks = {soft_track()}};
    rig.tracks[0].damping_nN_m_s_per_rad = 0;
    rig.tracks[0].force_gain_milli = 1001;
    crn_app_configure(&app, &rig);
    assert_int_equal(app.setup.tracks[0].wire.force_gain_milli, 1000);
    app.edge.rig.local_unlock = true;
    crn_app_configure(&app, &rig);
    assert_int_equal(app.setup.tracks[0].wire.force_gain_milli, 1001);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_gain_above_one_counts_as_stiffness_and_damping),
        TEST(a_gain_below_one_allows_nothing_stiffer),
        TEST(a_gain_counts_about_the_line_too),
        TEST(a_gain_above_one_needs_the_local_unlock),
        TEST(more_damping_than_was_built_needs_the_local_unlock),
        TEST(less_lag_than_was_built_needs_the_local_unlock),
        TEST(an_encoder_s_scale_moves_by_a_quarter_without_the_local_unlock),
        TEST(a_larger_scale_counts_as_stiffness),
        TEST(the_sense_of_an_encoder_changes_only_with_the_local_unlock),
        TEST(a_track_without_a_coupling_may_have_any_scale),
        TEST(settings_without_frames_obey_the_same_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
