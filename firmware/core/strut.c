/* This file moves the rings of a stent's struts and computes their contact with a node (lesion.h,
 * docs/lesions.md). */
#include "firmware/core/lesion.h"
#include "firmware/core/rod.h"

enum {
    MARGIN_M_Q30 = 536871,           /* 0.5 mm: the most that a tick may move a node */
    NODE_RADIUS_MAX_M_Q30 = 2147484, /* 2 mm: the widest tool (core.h) */
    PACE_M_Q30 = 5369,               /* 5 um a tick, the pace at which a balloon grows */
    APART_MAX_M_Q30 = 1 << 24,       /* rings farther apart in any direction, or wider, are not joined */
    STEEP_Q30 = 1 << 29,             /* largest change of the radius along the stent */
    CENTRE_MAX_um = 1900000,
    INSIDE_MIN_um = 200,
    INSIDE_MAX_um = 20000,
    THICKNESS_MIN_um = 10,
    THICKNESS_MAX_um = 1000,
};

/* --- orders --------------------------------------------------------------------------------------------- */

static bool is_within(int32_t value, int32_t low, int32_t high)
{
    return value >= low && value <= high;
}

bool crn_strut_order_is_valid(const crn_strut_order *order)
{
    const int32_t *c = order->centre_um;
    if (order->number == 0 || order->inside_um == 0) {
        return order->number <= CRN_STRUT_RING_MAX && order->inside_um == 0 && order->thickness_um == 0 &&
               order->is_joined == 0 && (c[0] | c[1] | c[2]) == 0;
    }
    for (int k = 0; k < 3; k++) {
        if (!is_within(c[k], -CENTRE_MAX_um, CENTRE_MAX_um)) {
            return false;
        }
    }
    return order->number <= CRN_STRUT_RING_MAX && order->inside_um >= INSIDE_MIN_um &&
           order->inside_um <= INSIDE_MAX_um && order->thickness_um >= THICKNESS_MIN_um &&
           order->thickness_um <= THICKNESS_MAX_um && order->is_joined <= 1;
}

/* 2^30 / 10^6 in Q20. Overflow is impossible: the largest coordinate, 1.9e6 x 2^30 / 10^6, fits 32 bits, and
 * the product is below 2^52. Error: 1/2 LSB. */
static int32_t from_um(int32_t um)
{
    return (int32_t)crn_rshift_round64((int64_t)um * 1125899907, 20);
}

static void put_bit(uint32_t *bits, uint32_t i, bool is_set)
{
    const uint32_t bit = 1u << (i & 31);
    bits[i >> 5] = (bits[i >> 5] & ~bit) | (is_set ? bit : 0);
}

static bool has_bit(const uint32_t *bits, uint32_t i)
{
    return (bits[i >> 5] >> (i & 31) & 1) != 0;
}

static bool is_moving(const crn_strut_ring *ring)
{
    const int32_t *now = ring->centre_m_q30.v, *wanted = ring->wanted_m_q30.v;
    return now[0] != wanted[0] || now[1] != wanted[1] || now[2] != wanted[2] ||
           ring->inside_m_q30 != ring->wanted_inside_m_q30;
}

static void take_away(crn_strut_state *struts, uint32_t i)
{
    const crn_strut_ring none = {.thickness_m_q30 = 0};
    struts->rings[i] = none;
    put_bit(struts->joined_bits, i, false);
    put_bit(struts->moving_bits, i, false);
    while (struts->used > 0 && struts->rings[struts->used - 1].thickness_m_q30 == 0) {
        struts->used--;
    }
}

bool crn_state_strut(crn_state *state, const crn_strut_order *order)
{
    if (order->number == 0 || !crn_strut_order_is_valid(order)) {
        return false;
    }
    crn_strut_state *struts = &state->words.struts;
    const uint32_t i = order->number - 1;
    if (order->inside_um == 0) {
        take_away(struts, i);
        return true;
    }
    crn_strut_ring *ring = &struts->rings[i];
    for (int k = 0; k < 3; k++) {
        ring->wanted_m_q30.v[k] = from_um(order->centre_um[k]);
    }
    ring->wanted_inside_m_q30 = from_um((int32_t)order->inside_um);
    if (ring->thickness_m_q30 == 0) {
        ring->centre_m_q30 = ring->wanted_m_q30;
        ring->inside_m_q30 = ring->wanted_inside_m_q30;
    }
    ring->thickness_m_q30 = from_um((int32_t)order->thickness_um);
    put_bit(struts->joined_bits, i, order->is_joined != 0);
    put_bit(struts->moving_bits, i, is_moving(ring));
    struts->used = struts->used > i ? struts->used : i + 1;
    return true;
}

/* Overflow: the two values are below 2^31 in magnitude; their difference, which is below 2^32, saturates. */
static int32_t next(int32_t now, int32_t wanted)
{
    return now + crn_clamp(crn_sub_sat(wanted, now), -PACE_M_Q30, PACE_M_Q30);
}

static void move_on(crn_strut_state *struts, uint32_t i)
{
    crn_strut_ring *ring = &struts->rings[i];
    for (int k = 0; k < 3; k++) {
        ring->centre_m_q30.v[k] = next(ring->centre_m_q30.v[k], ring->wanted_m_q30.v[k]);
    }
    ring->inside_m_q30 = next(ring->inside_m_q30, ring->wanted_inside_m_q30);
    put_bit(struts->moving_bits, i, is_moving(ring));
}

void crn_struts_step(crn_state *state)
{
    crn_strut_state *struts = &state->words.struts;
    crn_vec3 low = {{INT32_MAX, INT32_MAX, INT32_MAX}}, high = {{INT32_MIN, INT32_MIN, INT32_MIN}};
    for (uint32_t i = 0; i < struts->used; i++) {
        const crn_strut_ring *ring = &struts->rings[i];
        if (ring->thickness_m_q30 == 0) {
            continue;
        }
        if (has_bit(struts->moving_bits, i)) {
            move_on(struts, i);
        }
        /* below 25 mm, and a place is below 1.9 m: within 2^31 */
        const int32_t reach =
            ring->inside_m_q30 + ring->thickness_m_q30 + NODE_RADIUS_MAX_M_Q30 + MARGIN_M_Q30;
        for (int k = 0; k < 3; k++) {
            const int32_t place = ring->centre_m_q30.v[k];
            low.v[k] = place - reach < low.v[k] ? place - reach : low.v[k];
            high.v[k] = place + reach > high.v[k] ? place + reach : high.v[k];
        }
    }
    state->scratch.struts_low_m_q30 = low;
    state->scratch.struts_high_m_q30 = high;
}

/* --- contact -------------------------------------------------------------------------------------------- */

static bool is_joined(const crn_strut_state *struts, uint32_t i)
{
    if (i + 1 >= struts->used || !has_bit(struts->joined_bits, i) ||
        struts->rings[i + 1].thickness_m_q30 == 0) {
        return false;
    }
    for (int k = 0; k < 3; k++) {
        const int32_t apart =
            crn_sub_sat(struts->rings[i + 1].centre_m_q30.v[k], struts->rings[i].centre_m_q30.v[k]);
        if (!is_within(apart, -APART_MAX_M_Q30, APART_MAX_M_Q30)) {
            return false;
        }
    }
    return true;
}

/* Returns the direction of the chain of strut rings at one ring, which points from the previous ring to the
 * next ring. Overflow is impossible, because joined rings are less than 2^24 (Q30 m) apart. */
static crn_vec3 along_chain(const crn_strut_state *struts, uint32_t i, bool has_before, bool has_behind)
{
    const crn_strut_ring *ring = &struts->rings[i];
    return crn_vec3_sub(ring[has_behind ? 1 : 0].centre_m_q30, (ring - (has_before ? 1 : 0))->centre_m_q30);
}

/* Describes the struts of a stent at one position along the chain of rings. */
typedef struct section {
    crn_vec3 centre_m_q30, along_q30;
    int32_t inside_m_q30, thickness_m_q30, slope_q30;
    int32_t beyond_m_q30; /* at an end of the chain: distance of the place beyond it, where along_q30 points
                             outwards */
} section;

/* Interpolates between a and b. Overflow: impossible, a convex sum. */
static int32_t between(int32_t a, int32_t b, int32_t share_q30)
{
    return crn_scale_q30(a, CRN_ONE_Q30 - share_q30) + crn_scale_q30(b, share_q30);
}

static crn_vec3 vector_between(const crn_vec3 *a, const crn_vec3 *b, int32_t share_q30)
{
    return crn_vec3_make(between(a->v[0], b->v[0], share_q30), between(a->v[1], b->v[1], share_q30),
                         between(a->v[2], b->v[2], share_q30));
}

/* Returns whether a point is within the box around the strut rings i and i + 1, with a margin for the node.
 * Overflow is impossible, because radii are below 2^25 and coordinates are below 2^30.93. */
static bool is_near(const crn_strut_ring *ring, const crn_vec3 *place, int32_t radius_m_q30)
{
    const int32_t wider =
        ring[0].inside_m_q30 > ring[1].inside_m_q30 ? ring[0].inside_m_q30 : ring[1].inside_m_q30;
    const int32_t thicker =
        ring[0].thickness_m_q30 > ring[1].thickness_m_q30 ? ring[0].thickness_m_q30 : ring[1].thickness_m_q30;
    const int32_t room = wider + thicker + radius_m_q30 + MARGIN_M_Q30;
    for (int k = 0; k < 3; k++) {
        const int32_t a = ring[0].centre_m_q30.v[k], b = ring[1].centre_m_q30.v[k];
        if (place->v[k] < (a < b ? a : b) - room || place->v[k] > (a < b ? b : a) + room) {
            return false;
        }
    }
    return true;
}

static section end_at(const crn_strut_ring *ring, const crn_vec3 *out_q30, int32_t beyond_m_q30)
{
    return (section){ring->centre_m_q30,    *out_q30, ring->inside_m_q30,
                     ring->thickness_m_q30, 0,        beyond_m_q30};
}

static crn_vec3 unit_of(const crn_vec3 *way)
{
    const crn_vec3 none = {{0, 0, 0}};
    return crn_vec3_normalise(*way, none, NULL);
}

/* Returns the struts' cross-section at a point between two neighbouring rings of a stent. Each of the two
 * strut rings lies in a plane perpendicular to the stent's axis, and the point lies between the two planes.
 * Overflow is impossible, because a point within the box around two rings is less than 2^26 (Q30 m) from each
 * of the rings. */
static section section_between(const crn_strut_ring *ring, const crn_vec3 *first, const crn_vec3 *last,
                               const crn_vec3 *off_a, const crn_vec3 *off_b)
{
    const crn_strut_ring *a = ring, *b = ring + 1;
    const int32_t behind_a = crn_vec3_dot_unit(off_a, first), before_b = -crn_vec3_dot_unit(off_b, last);
    const int32_t from_a = behind_a > 0 ? behind_a : 0, to_b = before_b > 0 ? before_b : 0;
    const int32_t share = crn_quotient(from_a, from_a + to_b + 1, 30);
    const crn_vec3 none = {{0, 0, 0}};
    int32_t apart;
    (void)crn_vec3_normalise(crn_vec3_sub(b->centre_m_q30, a->centre_m_q30), none, &apart);
    const int32_t slope = apart > 0 ? crn_quotient(b->inside_m_q30 - a->inside_m_q30, apart, 30) : 0;
    const crn_vec3 along = vector_between(first, last, share);
    return (section){vector_between(&a->centre_m_q30, &b->centre_m_q30, share),
                     unit_of(&along),
                     between(a->inside_m_q30, b->inside_m_q30, share),
                     between(a->thickness_m_q30, b->thickness_m_q30, share),
                     crn_clamp(slope, -STEEP_Q30, STEEP_Q30),
                     0};
}

/* Finds the struts' cross-section for a point that lies between ring i and the next ring. Returns false when
 * the point does not lie between the two rings of struts. The code tests the signs of the dot products first,
 * because these signs exclude all but one or two of the pairs of rings near a point. */
static bool section_at(const crn_strut_state *struts, uint32_t i, const crn_vec3 *place, section *at)
{
    const crn_strut_ring *a = &struts->rings[i], *b = a + 1;
    const bool has_before = i > 0 && is_joined(struts, i - 1), has_behind = is_joined(struts, i + 1);
    const crn_vec3 way_a = along_chain(struts, i, has_before, true),
                   off_a = crn_vec3_sub(*place, a->centre_m_q30);
    const bool is_before_a = crn_vec3_dot64(off_a, way_a) < 0;
    if (is_before_a && has_before) {
        return false;
    }
    const crn_vec3 way_b = along_chain(struts, i + 1, true, has_behind),
                   off_b = crn_vec3_sub(*place, b->centre_m_q30);
    const bool is_behind_b = crn_vec3_dot64(off_b, way_b) >= 0;
    if (is_behind_b && !is_before_a && has_behind) {
        return false;
    }
    const crn_vec3 none = {{0, 0, 0}}, first = unit_of(&way_a), last = unit_of(&way_b);
    if (is_before_a) {
        const crn_vec3 out = crn_vec3_sub(none, first);
        *at = end_at(a, &out, crn_vec3_dot_unit(&off_a, &out));
    } else if (is_behind_b) {
        *at = end_at(b, &last, crn_vec3_dot_unit(&off_b, &last));
    } else {
        *at = section_between(a, &first, &last, &off_a, &off_b);
    }
    return true;
}

/* Returns the contact at the rounded edge at the end of a stent; the contact's normal is tilted at least 45
 * degrees to the side. */
static crn_lumen_sample beside_edge(const section *at, const crn_vec3 *outwards_q30, int32_t off_middle_m_q30)
{
    const int32_t beyond = at->beyond_m_q30,
                  size = off_middle_m_q30 < 0 ? -off_middle_m_q30 : off_middle_m_q30;
    const int32_t aside = size > beyond ? size : beyond, sideways = off_middle_m_q30 < 0 ? -aside : aside;
    const crn_vec3 none = {{0, 0, 0}};
    crn_lumen_sample sample;
    crn_vec3 way;
    int32_t away;
    (void)crn_vec3_normalise(crn_vec3_make(beyond, off_middle_m_q30, 0), none, &away);
    for (int k = 0; k < 3; k++) {
        way.v[k] = crn_scale_q30(beyond, at->along_q30.v[k]) + crn_scale_q30(sideways, outwards_q30->v[k]);
    }
    sample.distance_m_q30 = at->thickness_m_q30 / 2 - away;
    sample.normal_q30 = crn_vec3_normalise(way, none, NULL);
    return sample;
}

/* Returns the contact with the struts' surface, inside or outside the stent. Overflow is impossible, because
 * the sum of slope and unit vector is below 1.5. */
static crn_lumen_sample beside_struts(const section *at, const crn_vec3 *outwards_q30, int32_t rho_m_q30,
                                      bool is_inside)
{
    const crn_vec3 none = {{0, 0, 0}};
    crn_vec3 away;
    for (int k = 0; k < 3; k++) {
        const int32_t out = outwards_q30->v[k] - crn_scale_q30(at->slope_q30, at->along_q30.v[k]);
        away.v[k] = is_inside ? -out : out;
    }
    const int32_t beyond =
        is_inside ? rho_m_q30 - at->inside_m_q30 : at->inside_m_q30 + at->thickness_m_q30 - rho_m_q30;
    crn_lumen_sample sample;
    int32_t length_q30;
    sample.normal_q30 = crn_vec3_normalise(away, none, &length_q30);
    sample.distance_m_q30 = crn_quotient(beyond, length_q30, 30);
    return sample;
}

/* Contact with one shell. Returns false on the axis of the stent's shell, where there is no normal. */
static bool contact_of(const section *at, const crn_vec3 *place, int32_t radius_m_q30,
                       crn_lumen_sample *sample)
{
    const crn_vec3 none = {{0, 0, 0}};
    const crn_vec3 off = crn_vec3_sub(*place, at->centre_m_q30);
    const int32_t along = crn_vec3_dot_unit(&off, &at->along_q30);
    crn_vec3 across;
    int32_t rho;
    for (int k = 0; k < 3; k++) {
        across.v[k] = off.v[k] - crn_scale_q30(along, at->along_q30.v[k]);
    }
    across = crn_vec3_normalise(across, none, &rho);
    if (rho == 0) {
        return false;
    }
    const int32_t off_middle = rho - at->inside_m_q30 - at->thickness_m_q30 / 2;
    *sample = at->beyond_m_q30 > 0 ? beside_edge(at, &across, off_middle)
                                   : beside_struts(at, &across, rho, off_middle < 0);
    /* a tool that is wider than the inside of the struts settles on their axis */
    if (off_middle < 0 && sample->distance_m_q30 > rho - radius_m_q30) {
        sample->distance_m_q30 = rho - radius_m_q30;
    }
    return true;
}

static bool is_in_box(const crn_scratch *scratch, const crn_vec3 *place_m_q30)
{
    for (int k = 0; k < 3; k++) {
        if (place_m_q30->v[k] < scratch->struts_low_m_q30.v[k] ||
            place_m_q30->v[k] > scratch->struts_high_m_q30.v[k]) {
            return false;
        }
    }
    return true;
}

bool crn_struts_contact(const crn_strut_state *struts, const crn_vec3 *place_m_q30, int32_t radius_m_q30,
                        crn_lumen_sample *sample)
{
    bool is_near_one = false;
    for (uint32_t i = 0; i + 1 < struts->used; i++) {
        section at;
        crn_lumen_sample here;
        if (!has_bit(struts->joined_bits, i) || !is_near(&struts->rings[i], place_m_q30, radius_m_q30) ||
            !is_joined(struts, i) || !section_at(struts, i, place_m_q30, &at) ||
            !contact_of(&at, place_m_q30, radius_m_q30, &here)) {
            continue;
        }
        if (!is_near_one || here.distance_m_q30 > sample->distance_m_q30) {
            *sample = here;
        }
        is_near_one = true;
    }
    return is_near_one;
}

static void carry(const crn_motion *motion, crn_motion_pose *pose, crn_lumen_sample *sample)
{
    if (motion != NULL) {
        *sample = crn_motion_carry(motion, pose, *sample);
    }
}

bool crn_struts_here(const crn_model *model, crn_state *state, const crn_vec3 *world_m_q30,
                     int32_t radius_m_q30, crn_lumen_sample *sample)
{
    const crn_motion *motion = model->lumen->motion;
    crn_motion_pose *pose = &state->scratch.pose;
    const crn_vec3 *reference = motion == NULL ? world_m_q30 : &pose->reference_m_q30;
    if (!is_in_box(&state->scratch, reference) ||
        !crn_struts_contact(&state->words.struts, reference, radius_m_q30, sample)) {
        return false;
    }
    carry(motion, pose, sample);
    return true;
}

bool crn_struts_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, int32_t radius_m_q30, crn_lumen_sample *sample)
{
    const crn_motion *motion = model->lumen->motion;
    const crn_vec3 reference = motion == NULL ? *world_m_q30 : crn_motion_pull(motion, pose, world_m_q30);
    if (!crn_struts_contact(&words->struts, &reference, radius_m_q30, sample)) {
        return false;
    }
    carry(motion, pose, sample);
    return true;
}

/* --- a restored state ----------------------------------------------------------------------------------- */

static bool ring_is_valid(const crn_strut_ring *ring)
{
    const int32_t most = from_um(CENTRE_MAX_um);
    for (int k = 0; k < 3; k++) {
        if (!is_within(ring->centre_m_q30.v[k], -most, most) ||
            !is_within(ring->wanted_m_q30.v[k], -most, most)) {
            return false;
        }
    }
    const int32_t low = from_um(INSIDE_MIN_um), high = from_um(INSIDE_MAX_um);
    return is_within(ring->inside_m_q30, low, high) && is_within(ring->wanted_inside_m_q30, low, high) &&
           is_within(ring->thickness_m_q30, from_um(THICKNESS_MIN_um), from_um(THICKNESS_MAX_um));
}

static bool ring_is_none(const crn_strut_ring *ring)
{
    const int32_t *c = ring->centre_m_q30.v, *w = ring->wanted_m_q30.v;
    return (c[0] | c[1] | c[2] | w[0] | w[1] | w[2] | ring->inside_m_q30 | ring->wanted_inside_m_q30 |
            ring->thickness_m_q30) == 0;
}

bool crn_struts_are_valid(const crn_strut_state *struts)
{
    if (struts->used > CRN_STRUT_RING_MAX ||
        (struts->used > 0 && struts->rings[struts->used - 1].thickness_m_q30 == 0)) {
        return false;
    }
    for (uint32_t i = 0; i < CRN_STRUT_RING_MAX; i++) {
        const crn_strut_ring *ring = &struts->rings[i];
        const bool is_none = i >= struts->used || ring->thickness_m_q30 == 0;
        if (is_none ? !ring_is_none(ring) : !ring_is_valid(ring)) {
            return false;
        }
        if ((is_none && has_bit(struts->joined_bits, i)) ||
            has_bit(struts->moving_bits, i) != is_moving(ring)) {
            return false;
        }
    }
    return true;
}
