/* Configuration of the tracks. The app accepts or refuses a request for settings as a whole, and the host can
 * read back the values that are in force. A host may always lower force limits, but may raise them only while
 * the local unlock (a switch inside the rig) is closed. */
#include "firmware/app/app_internal.h"

enum {
    TRANSLATION_MIN_pm = 1000,
    TRANSLATION_MAX_pm = 500000000,
    ROTATION_MIN_counts = 16,
    ROTATION_MAX_counts = 16777216,
    GAIN_ONE_milli = 1000, /* true force */
    GAIN_MAX_milli = 4000,
    OPTIONS_ALL = CRN_WIRE_OPTION_TRANSLATION_REVERSED | CRN_WIRE_OPTION_ROTATION_REVERSED,
    FORCE_MAX_uN_per_count = 1000000,
    FORCE_BUILT_uN_per_count = 1000, /* where the port does not say */
    DAMPING_MAX = 1000000,           /* in both units */
    COUPLING_MAX_N_per_m = 5000,
    COUPLING_MAX_uN_m_per_rad = 100000,
    LAG_MAX_us = 20000,
    SEAL_MAX_mN = 2000,
    SEAL_MAX_uN_m = 5000,
};

static bool in_range(uint32_t value, uint32_t low, uint32_t high)
{
    return value >= low && value <= high;
}

/* A force gain above one multiplies the stiffness of the coupling that the hand feels. If the host gives an
 * encoder scale with k times the known travel per count, the hand feels k times the stiffness. Returns the
 * product of the force gain and the scale factor in 1/1000, rounded up. Overflow is possible only if a value
 * is outside its range, and the app refuses this value anyway; otherwise the product is below 2^41. */
static uint64_t loop_milli(const crn_wire_track *wire, uint32_t said, uint32_t known)
{
    const uint64_t gain_milli =
        wire->force_gain_milli > GAIN_ONE_milli ? wire->force_gain_milli : GAIN_ONE_milli;
    if (known == 0 || said <= known) return gain_milli;
    return crn_divide_u64(gain_milli * said + known - 1, known);
}

/* The condition b > G (K (T / 2 + t) + B) limits a spring K and a damper B that are computed once in each
 * tick of length T. The damping b is that of the rig itself; the motor's force acts after the lag t and is
 * multiplied by G (docs/haptics.md). Format: K in N/m, b and B in 1/1000 N s/m, G in 1/1000; both sides in
 * 1e-9 N s/m. Overflow is impossible: G is below 2^32 (at most a gain of 4 000 times a scale factor of 5 x
 * 10^5), and 10^5 x 2^32 x 20 500 and 10^6 x 2^32 are below 2^63. For a track without a virtual coupling, the
 * condition on spring and damper does not apply. */
/* Requirement: SR-07 */
static bool is_passive(uint32_t stiffness, uint32_t damping, uint32_t damping_rig, uint32_t lag_us,
                       uint64_t factor_milli)
{
    if (stiffness == 0) return damping == 0;
    if (stiffness > COUPLING_MAX_uN_m_per_rad || damping > DAMPING_MAX || lag_us > LAG_MAX_us) return false;
    if (factor_milli > UINT32_MAX) return false;
    const uint64_t spring = stiffness * factor_milli * (CRN_TICK_us / 2 + lag_us);
    const uint64_t damper = damping * factor_milli, rig = (uint64_t)damping_rig * GAIN_ONE_milli;
    return damper < rig && spring <= (rig - damper) * 1000;
}

/* 0 keeps what is there. */
static void keep_defaults(crn_wire_track *wire, const crn_wire_track *present)
{
    if (wire->force_slew_mN_per_tick == 0) wire->force_slew_mN_per_tick = present->force_slew_mN_per_tick;
    if (wire->torque_slew_uN_m_per_tick == 0)
        wire->torque_slew_uN_m_per_tick = present->torque_slew_uN_m_per_tick;
    if (wire->force_uN_per_count == 0) wire->force_uN_per_count = present->force_uN_per_count;
}

static const crn_wire_track first = {
    .translation_pm_per_count = 1000000, /* 1 um */
    .rotation_counts_per_turn = 65536,
    .force_gain_milli = GAIN_ONE_milli,
    .force_limit_mN = CRN_APP_FORCE_LIMIT_mN,
    .torque_limit_uN_m = CRN_APP_TORQUE_LIMIT_uN_m,
    .force_slew_mN_per_tick = CRN_APP_FORCE_SLEW_mN_per_tick,
    .torque_slew_uN_m_per_tick = CRN_APP_TORQUE_SLEW_uN_m_per_tick,
};

/* --- who may state what --- */

/* A rule defines which values of a track's setting a host may send without confirmation by a person at the
 * rig. The rule compares the host's value with the value that the rig's builder gave. */
typedef enum step_rule {
    STEP_SCALE, /* a quarter up or down, as sensors differ among themselves */
    STEP_UP_TO, /* anything up to the builder's value: less is safer */
    STEP_FROM,  /* anything from the builder's value on: more is safer */
    STEP_NONE,  /* only that */
} step_rule;

static bool is_free_step(step_rule rule, uint32_t asked, uint32_t built)
{
    switch (rule) {
    case STEP_SCALE:
        return in_range(asked, built - built / 4, built + built / 4);
    case STEP_UP_TO:
        return asked <= built;
    case STEP_FROM:
        return asked >= built;
    case STEP_NONE:
        break;
    }
    return asked == built;
}

static bool is_coupled(const crn_wire_track *wire)
{
    return wire->coupling_N_per_m > 0 || wire->coupling_uN_m_per_rad > 0;
}

/* For each setting of a track, this table gives the rule for the values that a host may send without
 * confirmation by a person at the rig. A scale that is too small hides large values from every check: every
 * force of a force sensor, or every speed of an encoder, then looks small. The virtual coupling becomes
 * stiffer than the rig can render if the host gives too large an encoder scale, a high gain, too short a lag,
 * or a damping that the rig does not have. If the host gives the wrong counting direction for an encoder,
 * every simulated spring pushes the hand away instead of pulling it back. A track without a coupling is never
 * driven, so a host may set any of its values except the force sensor's scale, because that sensor is checked
 * in every state. The host may send again a value that a person at the rig has confirmed. False: *field names
 * the offender. */
/* Requirement: SR-18 */
static bool steps_are_free(const crn_wire_track *asked, const crn_app_track *present, uint32_t *field)
{
    const crn_wire_track *vouched = &present->vouched, *built = &present->built;
    const bool is_driven = is_coupled(asked);
    const struct {
        uint32_t field;
        bool counts;
        step_rule rule;
        uint32_t asked, vouched, built;
    } steps[] = {
#define STEP(number, counts, rule, name) {number, counts, rule, asked->name, vouched->name, built->name}
        STEP(0, is_driven, STEP_SCALE, translation_pm_per_count),
        STEP(1, is_driven, STEP_SCALE, rotation_counts_per_turn),
        STEP(2, is_driven, STEP_UP_TO, force_gain_milli),
        STEP(7, is_driven, STEP_NONE, options),
        STEP(9, true, STEP_SCALE, force_uN_per_count),
        STEP(10, is_driven, STEP_UP_TO, damping_mN_s_per_m),
        STEP(11, is_driven, STEP_UP_TO, damping_nN_m_s_per_rad),
        STEP(12, is_driven, STEP_FROM, actuator_lag_us),
#undef STEP
    };
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        *field = steps[i].field;
        if (!steps[i].counts || steps[i].asked == steps[i].vouched) continue;
        if (!is_free_step(steps[i].rule, steps[i].asked, steps[i].built)) return false;
    }
    return true;
}

/* Lists the additional rights that a host may have when it changes the settings of a track. */
typedef struct track_rights {
    bool raises_limits, states_all;
} track_rights;

/* False: *field names the offender. */
/* Requirement: SR-18 */
static bool track_is_good(const crn_wire_track *wire, const crn_app_track *present, track_rights rights,
                          uint32_t *field)
{
    const crn_wire_track *limits =
        rights.raises_limits ? &first : &present->wire; /* the largest allowed now */
    /* If a person at the rig has entered the travel per count, this value is taken as true. If nobody at the
     * rig has entered the travel per count, its true value may be smaller than the value that the host
     * sent. */
    const uint64_t along_milli = loop_milli(wire, rights.states_all ? 0 : wire->translation_pm_per_count,
                                            present->scale_pm_per_count),
                   about_milli = loop_milli(wire, rights.states_all ? 0 : present->scale_counts_per_turn,
                                            wire->rotation_counts_per_turn);
    const bool ok[] = {
        in_range(wire->translation_pm_per_count, TRANSLATION_MIN_pm, TRANSLATION_MAX_pm),
        in_range(wire->rotation_counts_per_turn, ROTATION_MIN_counts, ROTATION_MAX_counts),
        wire->force_gain_milli <= GAIN_MAX_milli,
        wire->force_limit_mN <= limits->force_limit_mN,
        wire->torque_limit_uN_m <= limits->torque_limit_uN_m,
        wire->force_slew_mN_per_tick <= limits->force_slew_mN_per_tick,
        wire->torque_slew_uN_m_per_tick <= limits->torque_slew_uN_m_per_tick,
        (wire->options & ~(uint32_t)OPTIONS_ALL) == 0,
        true, /* any zero of the force sensor */
        wire->force_uN_per_count <= FORCE_MAX_uN_per_count,
        wire->damping_mN_s_per_m <= DAMPING_MAX,
        wire->damping_nN_m_s_per_rad <= DAMPING_MAX,
        wire->actuator_lag_us <= LAG_MAX_us,
        wire->coupling_N_per_m <= COUPLING_MAX_N_per_m,
        wire->coupling_uN_m_per_rad <= COUPLING_MAX_uN_m_per_rad,
        is_passive(wire->coupling_N_per_m, wire->coupling_mN_s_per_m, wire->damping_mN_s_per_m,
                   wire->actuator_lag_us, along_milli),
        is_passive(wire->coupling_uN_m_per_rad, wire->coupling_nN_m_s_per_rad, wire->damping_nN_m_s_per_rad,
                   wire->actuator_lag_us, about_milli),
        wire->seal_mN <= SEAL_MAX_mN,
        wire->seal_uN_m <= SEAL_MAX_uN_m,
    };
    for (*field = 0; *field < sizeof ok / sizeof ok[0]; ++*field) {
        if (!ok[*field]) return false;
    }
    return rights.states_all || steps_are_free(wire, present, field);
}

/* Checks all settings of a track before accepting any of these settings. False: *field names the offender. */
static bool track_set(crn_app_track *track, const crn_wire_track *asked, track_rights rights, uint32_t *field)
{
    crn_wire_track wire = *asked;
    keep_defaults(&wire, &track->wire);
    if (!track_is_good(&wire, track, rights, field)) return false;
    track->wire = wire;
    if (rights.states_all || is_coupled(&wire)) track->vouched = wire;
    if (rights.states_all) {
        track->scale_pm_per_count = wire.translation_pm_per_count;
        track->scale_counts_per_turn = wire.rotation_counts_per_turn;
    }
    return true;
}

static uint32_t stated(uint32_t built, uint32_t otherwise)
{
    return built != 0 ? built : otherwise;
}

/* At power-up a track has the settings that its builder gave, but the given damping does not count as
 * reliable. */
void crn_app_track_default(crn_app_track *track, const crn_port *port)
{
    uint32_t field;
    const crn_port_built *built = &port->built;
    crn_wire_track wire = first;
    wire.translation_pm_per_count = stated(built->translation_pm_per_count, first.translation_pm_per_count);
    wire.rotation_counts_per_turn = stated(built->rotation_counts_per_turn, first.rotation_counts_per_turn);
    wire.force_uN_per_count = stated(port->force_uN_per_count, FORCE_BUILT_uN_per_count);
    wire.actuator_lag_us = built->actuator_lag_us;
    wire.options = built->options;
    *track = (crn_app_track){.wire = first, .built = wire};
    track->built.damping_mN_s_per_m = built->damping_mN_s_per_m;
    track->built.damping_nN_m_s_per_rad = built->damping_nN_m_s_per_rad;
    (void)track_set(track, &wire, (track_rights){true, true}, &field);
}

/* The whole request is checked before any track changes. */
void crn_app_rig_take(crn_app *app, const crn_wire_rig *wire)
{
    const uint16_t type = CRN_WIRE_TYPE_rig;
    crn_app_track candidates[CRN_TOOL_MAX];
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    CRN_REJECT_IF(app, type, wire->tracks_count == 0, CRN_REJECT_TOOL_COUNT, 0, CRN_TOOL_MAX);
    bool is_unlocked = app->edge.has_rig && app->edge.rig.local_unlock;
    bool has_motors = (app->port->capabilities & CRN_WIRE_CAPABILITY_MOTORS) != 0;
    const track_rights rights = {.raises_limits = is_unlocked, .states_all = is_unlocked || !has_motors};
    for (uint16_t k = 0; k < wire->tracks_count; k++) {
        uint32_t field = 0;
        candidates[k] = app->setup.tracks[k];
        bool ok = track_set(&candidates[k], &wire->tracks[k], rights, &field);
        CRN_REJECT_IF(app, type, !ok, CRN_REJECT_RIG_RANGE, k, field);
    }
    for (uint16_t k = 0; k < wire->tracks_count; k++) {
        app->setup.tracks[k] = candidates[k];
        crn_app_track_apply(app, k);
    }
    crn_app_send_status(app, type);
}

void crn_app_rig(crn_app *app, const uint8_t *payload, size_t length)
{
    crn_wire_rig wire;
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_rig, !crn_wire_decode_rig(payload, length, &wire), CRN_REJECT_MALFORMED,
                  length, CRN_WIRE_BYTES_rig);
    crn_app_rig_take(app, &wire);
}
