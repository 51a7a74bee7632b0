/* This file checks the PLAQUES section of a scene and gives access to the plaques. Every number of a plaque
 * must be within the range for which the core's arithmetic is proved to be correct. */
#include "shared/scene/scene_check.h"

/* Gives the fields of a plaque as byte offsets from the beginning of its record and from the beginning of one
 * of its points. */
enum {
    BOX_AT = 0,
    CHORD_AT = 24,
    STRETCH_AT = 36,
    SPACING_AT = 40,
    STATIONS_AT = 44,
    YIELD_AT = 48,
    FULL_AT = 52,
    RECOIL_AT = 56,
    PACE_AT = 60,
    FIRST_AT = 64, /* index of its first station in the list of all */
    RESERVED_AT = 68,
    HEALTHY_AT = 0,
    CHANNEL_AT = 16,
    RADIUS_AT = 12, /* offset of the radius behind the point of vessel and channel */
    ALONG_AT = 32,
    STATION_RESERVED_AT = 44,
    BOX_MAX_Q30 = 1 << 27,     /* 125 mm */
    RADIUS_MIN_Q30 = 10737,    /* 10 um */
    RADIUS_MAX_Q30 = 21474836, /* 20 mm */
    PRESSURE_MAX_Pa = 4000000,
    SPACINGS_APART_MAX = 2, /* neighbours */
    SPACINGS_ASIDE_MAX = 4, /* largest distance of the channel's middle from the vessel's */
};

static const uint8_t *record_at(const uint8_t *plaques, uint32_t index)
{
    return plaques + CRN_SCENE_PLAQUES_HEADER_BYTES + (size_t)index * CRN_SCENE_PLAQUE_BYTES;
}

static bool is_between(int32_t value, int32_t low, int32_t high)
{
    return value >= low && value <= high;
}

/* Returns whether the length of a vector of three words in Q30 is within 2^-19 of one. */
static bool is_unit(const uint8_t *words)
{
    const uint64_t one_q60 = (uint64_t)1 << 60, tolerance_q60 = (uint64_t)1 << 42;
    uint64_t square_q60 = 0;
    for (int k = 0; k < 3; k++) {
        const int64_t part = crn_scene_i32(words + 4 * k);
        if (part > (1 << 30) || part < -(1 << 30)) return false;
        square_q60 += (uint64_t)(part * part);
    }
    return square_q60 <= one_q60 + tolerance_q60 && square_q60 >= one_q60 - tolerance_q60;
}

static bool is_apart_at_most(const uint8_t *a, const uint8_t *b, int64_t most)
{
    for (int k = 0; k < 3; k++) {
        const int64_t apart = (int64_t)crn_scene_i32(a + 4 * k) - crn_scene_i32(b + 4 * k);
        if (apart > most || apart < -most) return false;
    }
    return true;
}

static bool record_is_good(const uint8_t *record, uint32_t stations_before)
{
    for (int k = 0; k < 3; k++) {
        const int64_t low = crn_scene_i32(record + BOX_AT + 4 * k),
                      high = crn_scene_i32(record + BOX_AT + 12 + 4 * k);
        if (low >= high || high - low > BOX_MAX_Q30 || low < -CRN_SCENE_ENTRY_REACH_Q30 ||
            high > CRN_SCENE_ENTRY_REACH_Q30 || crn_scene_u32(record + RESERVED_AT + 4 * k) != 0)
            return false;
    }
    return is_unit(record + CHORD_AT) && is_between(crn_scene_i32(record + STRETCH_AT), 1 << 28, 1 << 29) &&
           is_between(crn_scene_i32(record + SPACING_AT), 17, 22) &&
           is_between(crn_scene_i32(record + STATIONS_AT), 3, CRN_SCENE_PLAQUE_STATION_MAX) &&
           is_between(crn_scene_i32(record + YIELD_AT), 1000, PRESSURE_MAX_Pa) &&
           is_between(crn_scene_i32(record + FULL_AT), 1000, PRESSURE_MAX_Pa) &&
           is_between(crn_scene_i32(record + RECOIL_AT), 0, 1 << 30) &&
           is_between(crn_scene_i32(record + PACE_AT), 1, 1 << 28) &&
           crn_scene_u32(record + FIRST_AT) == stations_before;
}

/* `before` is NULL for the first point (station) of a plaque. */
static bool station_is_good(const uint8_t *record, const uint8_t *station, const uint8_t *before)
{
    const int64_t spacing = (int64_t)1 << crn_scene_u32(record + SPACING_AT);
    const uint8_t *healthy = station + HEALTHY_AT, *channel = station + CHANNEL_AT;
    for (int k = 0; k < 3; k++) {
        const int32_t low = crn_scene_i32(record + BOX_AT + 4 * k),
                      high = crn_scene_i32(record + BOX_AT + 12 + 4 * k);
        if (!is_between(crn_scene_i32(healthy + 4 * k), low, high) ||
            !is_between(crn_scene_i32(channel + 4 * k), low, high))
            return false;
    }
    const int32_t radius = crn_scene_i32(healthy + RADIUS_AT), left = crn_scene_i32(channel + RADIUS_AT);
    return is_between(radius, RADIUS_MIN_Q30, RADIUS_MAX_Q30) && is_between(left, RADIUS_MIN_Q30, radius) &&
           is_unit(station + ALONG_AT) && crn_scene_u32(station + STATION_RESERVED_AT) == 0 &&
           is_apart_at_most(channel, healthy, SPACINGS_ASIDE_MAX * spacing) &&
           (before == NULL || (is_apart_at_most(healthy, before + HEALTHY_AT, SPACINGS_APART_MAX * spacing) &&
                               is_apart_at_most(channel, before + CHANNEL_AT, SPACINGS_APART_MAX * spacing)));
}

crn_scene_plaque_view crn_scene_plaque(const crn_scene *scene, uint32_t index)
{
    const uint8_t *record = record_at(scene->plaques, index);
    crn_scene_plaque_view view;
    for (int k = 0; k < 3; k++) {
        view.low_m_q30[k] = crn_scene_i32(record + BOX_AT + 4 * k);
        view.high_m_q30[k] = crn_scene_i32(record + BOX_AT + 12 + 4 * k);
        view.chord_q30[k] = crn_scene_i32(record + CHORD_AT + 4 * k);
    }
    view.stretch_q28 = crn_scene_i32(record + STRETCH_AT);
    view.spacing_log2_q30 = crn_scene_u32(record + SPACING_AT);
    view.station_count = crn_scene_u32(record + STATIONS_AT);
    view.yield_Pa = crn_scene_i32(record + YIELD_AT);
    view.full_Pa = crn_scene_i32(record + FULL_AT);
    view.recoil_q30 = crn_scene_i32(record + RECOIL_AT);
    view.pace_q30 = crn_scene_i32(record + PACE_AT);
    view.stations = record_at(scene->plaques, scene->plaque_count) +
                    (size_t)crn_scene_u32(record + FIRST_AT) * CRN_SCENE_PLAQUE_STATION_BYTES;
    return view;
}

crn_scene_status crn_scene_check_plaques(crn_scene_check *check, crn_scene_span span, uint32_t *plaque_count)
{
    if (span.size < CRN_SCENE_PLAQUES_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    const uint32_t plaques = crn_scene_u32(header), stations = crn_scene_u32(header + 4);
    if (plaques == 0 || plaques > CRN_SCENE_PLAQUE_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_PLAQUE, span.offset);
    if (crn_scene_u32(header + 8) != 0 || crn_scene_u32(header + 12) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, span.offset + 8);
    if (span.size != CRN_SCENE_PLAQUES_HEADER_BYTES + (uint64_t)plaques * CRN_SCENE_PLAQUE_BYTES +
                         (uint64_t)stations * CRN_SCENE_PLAQUE_STATION_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *station = record_at(header, plaques);
    uint32_t before = 0;
    for (uint32_t i = 0; i < plaques; i++) {
        const uint8_t *record = record_at(header, i);
        const uint32_t count = crn_scene_u32(record + STATIONS_AT);
        if (!record_is_good(record, before) || count > stations - before)
            return crn_scene_fault_at(check, CRN_SCENE_PLAQUE, (size_t)(record - check->bytes));
        before += count;
        for (uint32_t k = 0; k < count; k++, station += CRN_SCENE_PLAQUE_STATION_BYTES) {
            const uint8_t *last = k > 0 ? station - CRN_SCENE_PLAQUE_STATION_BYTES : NULL;
            if (!station_is_good(record, station, last))
                return crn_scene_fault_at(check, CRN_SCENE_PLAQUE, (size_t)(station - check->bytes));
        }
    }
    if (before != stations) return crn_scene_fault_at(check, CRN_SCENE_PLAQUE, span.offset + 4);
    *plaque_count = plaques;
    return CRN_SCENE_OK;
}
