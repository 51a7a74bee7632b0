/* Configuration of the tracks: checked as a whole, read back as it is in force. Limits go down from the host, and up only
 * while the local unlock is closed. Called by: app.c. */
#include "firmware/app/app_internal.h"

enum {
    TRANSLATION_MIN_pm = 1000,
    TRANSLATION_MAX_pm = 500000000,
    ROTATION_MIN_counts = 16,
    ROTATION_MAX_counts = 16777216,
    GAIN_MAX_milli = 4000,
    OPTIONS_ALL = SELD_WIRE_OPTION_TRANSLATION_REVERSED | SELD_WIRE_OPTION_ROTATION_REVERSED,
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

/* b > K (T / 2 + t) + B: what a sampled spring and damper may be on a rig with damping b whose force comes t late
 * (docs/haptics.md). Format: K in N/m times us, b and B in 1/1000 of that. Without a coupling nothing is asked. */
static bool is_passive(uint32_t stiffness, uint32_t damping, uint32_t damping_rig, uint32_t lag_us)
{
    if (stiffness == 0) return damping == 0;
    if (damping_rig <= damping || lag_us > LAG_MAX_us) return false;
    return (uint64_t)stiffness * (SELD_TICK_us / 2 + lag_us) <= (uint64_t)(damping_rig - damping) * 1000;
}

/* 0 keeps what is there. */
static void keep_defaults(seld_wire_track *wire, const seld_wire_track *present)
{
    if (wire->force_slew_mN_per_tick == 0) wire->force_slew_mN_per_tick = present->force_slew_mN_per_tick;
    if (wire->torque_slew_uN_m_per_tick == 0)
        wire->torque_slew_uN_m_per_tick = present->torque_slew_uN_m_per_tick;
    if (wire->force_uN_per_count == 0) wire->force_uN_per_count = present->force_uN_per_count;
}

static const seld_wire_track first = {
    .translation_pm_per_count = 1000000, /* 1 um */
    .rotation_counts_per_turn = 65536,
    .force_gain_milli = 1000, /* true force */
    .force_limit_mN = SELD_APP_FORCE_LIMIT_mN,
    .torque_limit_uN_m = SELD_APP_TORQUE_LIMIT_uN_m,
    .force_slew_mN_per_tick = SELD_APP_FORCE_SLEW_mN_per_tick,
    .torque_slew_uN_m_per_tick = SELD_APP_TORQUE_SLEW_uN_m_per_tick,
};

/* A scale that is too small makes every force look small, and then no check sees a large one. So a host may correct what the rig's
 * builder stated by what sensors differ among themselves; another sensor needs somebody at the rig. */
static bool is_scale(uint32_t asked, const seld_app_track *present, bool is_free)
{
    const uint32_t built = present->force_built_uN_per_count;
    if (is_free) return asked <= FORCE_MAX_uN_per_count;
    return asked == present->wire.force_uN_per_count || in_range(asked, built - built / 4, built + built / 4);
}

/* What a host may change of a track beyond what it may always. */
typedef struct track_rights {
    bool raises_limits, moves_scale;
} track_rights;

/* False: *field names the offender. */
static bool track_is_good(const seld_wire_track *wire, const seld_app_track *present, track_rights rights,
                          uint32_t *field)
{
    const seld_wire_track *limits =
        rights.raises_limits ? &first : &present->wire; /* the largest allowed now */
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
        is_scale(wire->force_uN_per_count, present, rights.moves_scale),
        wire->damping_mN_s_per_m <= DAMPING_MAX,
        wire->damping_nN_m_s_per_rad <= DAMPING_MAX,
        wire->actuator_lag_us <= LAG_MAX_us,
        wire->coupling_N_per_m <= COUPLING_MAX_N_per_m,
        wire->coupling_uN_m_per_rad <= COUPLING_MAX_uN_m_per_rad,
        is_passive(wire->coupling_N_per_m, wire->coupling_mN_s_per_m, wire->damping_mN_s_per_m,
                   wire->actuator_lag_us),
        is_passive(wire->coupling_uN_m_per_rad, wire->coupling_nN_m_s_per_rad, wire->damping_nN_m_s_per_rad,
                   wire->actuator_lag_us),
        wire->seal_mN <= SEAL_MAX_mN,
        wire->seal_uN_m <= SEAL_MAX_uN_m,
    };
    for (*field = 0; *field < sizeof ok / sizeof ok[0]; ++*field) {
        if (!ok[*field]) return false;
    }
    return true;
}

/* Check everything, then take it over. False: *field names the offender. */
static bool track_set(seld_app_track *track, const seld_wire_track *asked, track_rights rights,
                      uint32_t *field)
{
    seld_wire_track wire = *asked;
    keep_defaults(&wire, &track->wire);
    if (!track_is_good(&wire, track, rights, field)) return false;
    track->wire = wire;
    /* 2^46 m / 10^12 = 2^34 / 5^12 per picometre; 5e8 x 2^34 < 2^63. */
    track->translation_m_q46_per_count =
        seld_divide_u64(((uint64_t)wire.translation_pm_per_count << 34) + 122070312u, 244140625u);
    track->rotation_turn48_per_count = seld_divide_u64(
        ((uint64_t)1 << 48) + wire.rotation_counts_per_turn / 2, wire.rotation_counts_per_turn);
    track->translation_jump_counts =
        (uint32_t)seld_divide_u64((uint64_t)SELD_APP_JUMP_um * 1000000u, wire.translation_pm_per_count);
    track->rotation_jump_counts = wire.rotation_counts_per_turn / 4;
    track->force_limit_mN = (int32_t)wire.force_limit_mN;
    track->torque_limit_uN_m = (int32_t)wire.torque_limit_uN_m;
    seld_app_axis_set(&track->axes[SELD_APP_ALONG], SELD_APP_ALONG, &wire);
    seld_app_axis_set(&track->axes[SELD_APP_ABOUT], SELD_APP_ABOUT, &wire);
    return true;
}

void seld_app_track_default(seld_app_track *track, uint32_t force_uN_per_count)
{
    uint32_t field;
    track->wire = first;
    track->force_built_uN_per_count = force_uN_per_count != 0 ? force_uN_per_count : FORCE_BUILT_uN_per_count;
    track->wire.force_uN_per_count = track->force_built_uN_per_count;
    track_set(track, &first, (track_rights){true, true}, &field);
}

/* Checked as a whole before a single track changes. */
void seld_app_rig_take(seld_app *app, const seld_wire_rig *wire)
{
    const uint16_t type = SELD_WIRE_TYPE_rig;
    seld_app_track candidates[SELD_TOOL_MAX];
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, wire->tracks_count == 0, SELD_REJECT_TOOL_COUNT, 0, SELD_TOOL_MAX);
    bool is_unlocked = app->has_rig && app->rig.local_unlock;
    bool has_motors = (app->port->capabilities & SELD_WIRE_CAPABILITY_MOTORS) != 0;
    const track_rights rights = {.raises_limits = is_unlocked, .moves_scale = is_unlocked || !has_motors};
    for (uint16_t k = 0; k < wire->tracks_count; k++) {
        uint32_t field = 0;
        candidates[k] = app->tracks[k];
        bool ok = track_set(&candidates[k], &wire->tracks[k], rights, &field);
        SELD_REJECT_IF(app, type, !ok, SELD_REJECT_RIG_RANGE, k, field);
    }
    for (uint16_t k = 0; k < wire->tracks_count; k++) app->tracks[k] = candidates[k];
    seld_app_send_status(app, type);
}

void seld_app_rig(seld_app *app, const uint8_t *payload, size_t length)
{
    seld_wire_rig wire;
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_rig, !seld_wire_decode_rig(payload, length, &wire),
                   SELD_REJECT_MALFORMED, length, SELD_WIRE_BYTES_rig);
    seld_app_rig_take(app, &wire);
}
