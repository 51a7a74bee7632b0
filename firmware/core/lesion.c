/* This file computes the vessel wall at lesions that a balloon can open (lesion.h, docs/lesions.md). */
#include "firmware/core/lesion.h"
#include "firmware/core/balloon.h"

enum {
    RELAX_LOG2 = 5, /* a 32nd of what is missing, in each tick */
    /* the rest at once when less than a thousandth is missing, so that recoil ends exactly */
    SNAP_Q30 = 1 << 20,
    STEEP_Q26 = 1 << 28, /* 4: largest change of k times the distance across, within one spacing */
};

/* --- places --------------------------------------------------------------------------------------------- */

/* The segment between two stations. */
typedef struct segment {
    const crn_lesion_station *a, *b;
    uint32_t index;
    int32_t share_q30; /* of b */
} segment;

static int32_t end_m_q30(const crn_lesion *lesion)
{
    return (int32_t)(lesion->station_count - 1) << lesion->spacing_log2_q30;
}

static segment segment_at(const crn_lesion *lesion, int32_t arc_m_q30)
{
    uint32_t index = (uint32_t)arc_m_q30 >> lesion->spacing_log2_q30;
    index = index > lesion->station_count - 2 ? lesion->station_count - 2 : index;
    int32_t beyond = arc_m_q30 - (int32_t)(index << lesion->spacing_log2_q30);
    return (segment){&lesion->stations[index], &lesion->stations[index + 1], index,
                     beyond << (30 - lesion->spacing_log2_q30)};
}

/* Overflow is impossible, because the coordinates a and b differ by less than 2^31 (checked when a scene is
 * loaded). */
static inline int32_t between(int32_t a, int32_t b, int32_t share_q30)
{
    return a + crn_scale_q30(b - a, share_q30);
}

static inline crn_vec3 point_between(const int32_t a[3], const int32_t b[3], int32_t share_q30)
{
    return crn_vec3_make(between(a[0], b[0], share_q30), between(a[1], b[1], share_q30),
                         between(a[2], b[2], share_q30));
}

static bool is_near(const crn_lesion *lesion, const crn_vec3 *p)
{
    for (int k = 0; k < 3; k++) {
        if (p->v[k] < lesion->low_m_q30[k] || p->v[k] > lesion->high_m_q30[k]) {
            return false;
        }
    }
    return true;
}

/* The arc length is first estimated along the chord; two corrections then follow the direction of the
 * centreline itself. Each correction reduces an error e to about e times the curvature times the distance
 * from the centreline; in a vessel, curvature times distance is below a half. */
bool crn_lesion_arc(const crn_lesion *lesion, const crn_vec3 *place_m_q30, int32_t *arc_m_q30)
{
    if (!is_near(lesion, place_m_q30)) {
        return false;
    }
    const int32_t end = end_m_q30(lesion);
    const crn_vec3 chord = {{lesion->chord_q30[0], lesion->chord_q30[1], lesion->chord_q30[2]}};
    const int32_t *first = lesion->stations[0].healthy_m_q30;
    crn_vec3 off = crn_vec3_sub(*place_m_q30, crn_vec3_make(first[0], first[1], first[2]));
    int64_t guess = ((int64_t)crn_vec3_dot_unit(&off, &chord) * lesion->stretch_q28) >> 28;
    int32_t arc = crn_sat32(guess);
    for (int round = 0; round < 2; round++) {
        arc = crn_clamp(arc, 0, end);
        const segment at = segment_at(lesion, arc);
        const crn_vec3 middle = point_between(at.a->healthy_m_q30, at.b->healthy_m_q30, at.share_q30),
                       along = point_between(at.a->along_q30, at.b->along_q30, at.share_q30);
        off = crn_vec3_sub(*place_m_q30, middle);
        arc += crn_vec3_dot_unit(&off, &along);
    }
    *arc_m_q30 = arc;
    return arc > 0 && arc < end;
}

/* --- the wall of an open lesion ------------------------------------------------------------------------- */

/* Holds the map X = c + k (x - middle) from a point x at the opened lesion to the point X at the narrowed
 * one, for one point of the lesion; k is the ratio of the radii, and c and `middle` are the centres of the
 * narrowed and the opened lumen. */
typedef struct station_map {
    int32_t ratio_q30; /* k */
    crn_vec3 middle_m_q30;
} station_map;

static station_map map_of(const crn_lesion_station *station, int32_t open_q30)
{
    const int32_t *c = station->channel_m_q30, *h = station->healthy_m_q30;
    const int32_t r = station->channel_radius_m_q30;
    const int32_t now = r + crn_scale_q30(station->healthy_radius_m_q30 - r, open_q30);
    return (station_map){now > r ? crn_quotient(r, now, 30) : CRN_ONE_Q30, point_between(c, h, open_q30)};
}

/* Returns how steeply the opening changes along the lesion: the change of the scale factor k between two
 * points, times the distance from the lesion's centreline, divided by the spacing of the points. Format: Q30,
 * Q30 m -> Q26. */
static int32_t steepness(int32_t change_q30, int32_t across_m_q30, uint32_t spacing_log2)
{
    int64_t product = crn_asr64((int64_t)change_q30 * across_m_q30, spacing_log2 + 4);
    return crn_clamp(crn_sat32(product), -STEEP_Q26, STEEP_Q26);
}

/* Converts a sample of the narrowed vessel wall to a sample of the opened wall. */
static crn_lumen_sample mapped(crn_lumen_sample sample, const crn_vec3 *slope_q26, int32_t ratio_q30,
                               const crn_vec3 *along_q30)
{
    const crn_vec3 none = {{0, 0, 0}};
    const int32_t drift = crn_vec3_dot_unit(slope_q26, &sample.normal_q30);
    crn_vec3 gradient_q26;
    for (int k = 0; k < 3; k++) {
        gradient_q26.v[k] = crn_asr32(crn_scale_q30(ratio_q30, sample.normal_q30.v[k]), 4) +
                            crn_scale_q30(drift, along_q30->v[k]);
    }
    int32_t length_q26;
    sample.normal_q30 = crn_vec3_normalise(gradient_q26, none, &length_q26);
    if (length_q26 > 0) {
        sample.distance_m_q30 = crn_quotient(sample.distance_m_q30, length_q26, 26);
    }
    return sample;
}

/* The wall of one lesion. Returns false for a point beyond the lesion's ends, for a point farther than two
 * healthy radii from the middle of the opened channel, or where the lesion is closed. */
static bool wall_of(const crn_lumen *lumen, const crn_lesion *lesion, const int32_t *open_q30,
                    const crn_vec3 *place, crn_lumen_sample *sample)
{
    int32_t arc;
    if (!crn_lesion_arc(lesion, place, &arc)) {
        return false;
    }
    const segment at = segment_at(lesion, arc);
    const int32_t open_a = open_q30[at.index], open_b = open_q30[at.index + 1];
    if ((open_a | open_b) == 0) {
        return false;
    }
    const station_map a = map_of(at.a, open_a), b = map_of(at.b, open_b);
    const int32_t ratio = between(a.ratio_q30, b.ratio_q30, at.share_q30);
    const crn_vec3 middle = point_between(a.middle_m_q30.v, b.middle_m_q30.v, at.share_q30),
                   channel = point_between(at.a->channel_m_q30, at.b->channel_m_q30, at.share_q30),
                   along = point_between(at.a->along_q30, at.b->along_q30, at.share_q30),
                   across = crn_vec3_sub(*place, middle);
    const int32_t reach = 2 * between(at.a->healthy_radius_m_q30, at.b->healthy_radius_m_q30, at.share_q30);
    if (crn_vec3_dot64(across, across) > crn_product(reach, reach)) {
        return false;
    }
    const uint32_t log2 = lesion->spacing_log2_q30;
    crn_vec3 in_channel, slope_q26;
    for (int k = 0; k < 3; k++) {
        in_channel.v[k] = channel.v[k] + crn_scale_q30(across.v[k], ratio);
        const int32_t c = (at.b->channel_m_q30[k] - at.a->channel_m_q30[k]) * (1 << (26 - log2)),
                      m = (b.middle_m_q30.v[k] - a.middle_m_q30.v[k]) * (1 << (26 - log2));
        slope_q26.v[k] =
            c - crn_scale_q30(m, ratio) + steepness(b.ratio_q30 - a.ratio_q30, across.v[k], log2);
    }
    *sample = mapped(crn_lumen_contact(lumen, &in_channel), &slope_q26, ratio, &along);
    return true;
}

bool crn_lesion_contact(const crn_lumen *lumen, const crn_lesion_state *lesions, const crn_vec3 *place_m_q30,
                        crn_lumen_sample *sample)
{
    bool is_in_one = false;
    for (uint32_t i = 0; i < lumen->lesion_count; i++) {
        crn_lumen_sample here;
        if ((lesions->bits >> i & 1u) == 0 ||
            !wall_of(lumen, &lumen->lesions[i], lesions->open_q30[i], place_m_q30, &here)) {
            continue;
        }
        if (!is_in_one) {
            *sample = crn_lumen_contact(lumen, place_m_q30);
        }
        is_in_one = true;
        if (here.distance_m_q30 < sample->distance_m_q30) {
            *sample = here;
        }
    }
    return is_in_one;
}

bool crn_lesion_section_at(const crn_lumen *lumen, const crn_lesion_state *lesions,
                           const crn_vec3 *place_m_q30, crn_lesion_section *section)
{
    for (uint32_t i = 0; i < lumen->lesion_count; i++) {
        const crn_lesion *lesion = &lumen->lesions[i];
        int32_t arc;
        if ((lesions->bits >> i & 1u) == 0 || !crn_lesion_arc(lesion, place_m_q30, &arc)) {
            continue;
        }
        const segment at = segment_at(lesion, arc);
        const int32_t *open_q30 = &lesions->open_q30[i][at.index];
        if ((open_q30[0] | open_q30[1]) == 0) {
            continue;
        }
        const station_map a = map_of(at.a, open_q30[0]), b = map_of(at.b, open_q30[1]);
        section->middle_m_q30 = point_between(a.middle_m_q30.v, b.middle_m_q30.v, at.share_q30);
        section->channel_m_q30 = point_between(at.a->channel_m_q30, at.b->channel_m_q30, at.share_q30);
        section->ratio_q30 = between(a.ratio_q30, b.ratio_q30, at.share_q30);
        section->widened_q24 = crn_quotient(CRN_ONE_Q30, section->ratio_q30 > 0 ? section->ratio_q30 : 1, 24);
        return true;
    }
    return false;
}

int32_t crn_lesion_section_distance(const crn_lumen *lumen, const crn_lesion_section *section,
                                    const crn_vec3 *place_m_q30)
{
    enum { FAR_M_Q30 = 1 << 24 };
    const crn_vec3 across = crn_vec3_sub(*place_m_q30, section->middle_m_q30);
    crn_vec3 in_channel;
    for (int k = 0; k < 3; k++) {
        in_channel.v[k] =
            crn_add_sat(section->channel_m_q30.v[k], crn_scale_q30(across.v[k], section->ratio_q30));
    }
    const int64_t open = ((int64_t)crn_lumen_distance(lumen, &in_channel) * section->widened_q24) >> 24;
    const int32_t limited = crn_clamp(crn_sat32(open), -FAR_M_Q30, FAR_M_Q30),
                  closed = crn_lumen_distance(lumen, place_m_q30);
    return closed < limited ? closed : limited;
}

bool crn_lesion_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, crn_lumen_sample *sample)
{
    const crn_motion *motion = model->lumen->motion;
    if (motion == NULL) {
        return crn_lesion_contact(model->lumen, &words->lesions, world_m_q30, sample);
    }
    const crn_vec3 reference = crn_motion_pull(motion, pose, world_m_q30);
    pose->reference_m_q30 = reference;
    if (!crn_lesion_contact(model->lumen, &words->lesions, &reference, sample)) {
        return false;
    }
    *sample = crn_motion_carry(motion, pose, *sample);
    return true;
}

/* --- giving way ----------------------------------------------------------------------------------------- */

/* Moves the opening of each point of a lesion towards the opening that belongs to the pressure at this point.
 */
static void step(const crn_lesion *lesion, crn_lesion_state *lesions, uint32_t index,
                 const int32_t pressure_Pa[CRN_LESION_STATION_MAX])
{
    uint32_t any = 0;
    for (uint32_t i = 0; i < lesion->station_count; i++) {
        int32_t *open = &lesions->open_q30[index][i], *kept = &lesions->kept_q30[index][i];
        int32_t beyond_Pa = pressure_Pa[i] - lesion->yield_Pa;
        int32_t wanted =
            beyond_Pa > 0 ? crn_clamp(crn_quotient(beyond_Pa, lesion->full_Pa, 30), 0, CRN_ONE_Q30) : 0;
        wanted = wanted < *kept ? *kept : wanted;
        int32_t missing = wanted - *open;
        bool is_there = missing < SNAP_Q30 && missing > -SNAP_Q30;
        *open += is_there ? missing
                          : crn_clamp(crn_asr32(missing, RELAX_LOG2), -lesion->pace_q30, lesion->pace_q30);
        int32_t stays = crn_scale_q30(*open, CRN_ONE_Q30 - lesion->recoil_q30);
        *kept = *kept < stays ? stays : *kept;
        any |= (uint32_t)(*open | *kept);
    }
    lesions->bits = (lesions->bits & ~(1u << index)) | (any != 0 ? 1u << index : 0);
}

/* Computes the positions of the balloon's balls (spheres) in the reference pose of a vessel that no tool has
 * pushed aside. */
static void places_of(const crn_model *model, crn_state *state, crn_vec3 places_m_q30[])
{
    const crn_motion *motion = model->lumen->motion;
    for (uint32_t j = 0; j < model->balloon.ball_count; j++) {
        crn_vec3 centre = state->words.balloon.balls[j].centre_m_q30;
        if (state->words.wall.used != 0) {
            const crn_wall_give give = crn_wall_give_at(&state->words.wall, crn_balloon_arc(model, state, j));
            centre = crn_vec3_sub(centre, give.way_m_q30);
        }
        places_m_q30[j] = motion == NULL ? centre : crn_motion_pull(motion, &state->scratch.pose, &centre);
    }
}

/* Interpolates the pressure of two neighbouring balls of the balloon at the points of a lesion between the
 * two balls. */
static void press_between(const crn_lesion *lesion, int32_t from_m_q30, int32_t from_Pa, int32_t to_m_q30,
                          int32_t to_Pa, int32_t pressure_Pa[CRN_LESION_STATION_MAX])
{
    if (from_m_q30 > to_m_q30) {
        const int32_t place = from_m_q30, pressure = from_Pa;
        from_m_q30 = to_m_q30;
        from_Pa = to_Pa;
        to_m_q30 = place;
        to_Pa = pressure;
    }
    const uint32_t log2 = lesion->spacing_log2_q30;
    const int32_t end = end_m_q30(lesion);
    const int32_t first = (int32_t)(((uint32_t)crn_clamp(from_m_q30, 0, end) + (1u << log2) - 1) >> log2),
                  last = crn_clamp(to_m_q30, -1, end) >> log2;
    for (int32_t i = first; i <= last; i++) {
        const int32_t share = crn_quotient((i << log2) - from_m_q30, to_m_q30 - from_m_q30 + 1, 30);
        const int32_t here = between(from_Pa, to_Pa, crn_clamp(share, 0, CRN_ONE_Q30));
        pressure_Pa[i] = here > pressure_Pa[i] ? here : pressure_Pa[i];
    }
}

void crn_lesions_give_way(const crn_model *model, crn_state *state)
{
    const crn_lumen *lumen = model->lumen;
    const bool is_up = state->words.balloon.pressure_Pa > 0;
    if (lumen == NULL || lumen->lesion_count == 0 || (!is_up && state->words.lesions.bits == 0)) {
        return;
    }
    crn_vec3 places[CRN_BALLOON_BALL_MAX];
    if (is_up) {
        places_of(model, state, places);
    }
    for (uint32_t i = 0; i < lumen->lesion_count; i++) {
        const crn_lesion *lesion = &lumen->lesions[i];
        int32_t pressure_Pa[CRN_LESION_STATION_MAX] = {0}, before_m_q30 = 0;
        bool has_before = false;
        for (uint32_t j = 0; is_up && j < model->balloon.ball_count; j++) {
            int32_t arc = 0;
            const bool is_on_it = crn_lesion_arc(lesion, &places[j], &arc);
            if (is_on_it && has_before) {
                press_between(lesion, before_m_q30, state->scratch.press_Pa[j - 1], arc,
                              state->scratch.press_Pa[j], pressure_Pa);
            }
            has_before = is_on_it;
            before_m_q30 = arc;
        }
        step(lesion, &state->words.lesions, i, pressure_Pa);
    }
}

/* --- orders and queries --------------------------------------------------------------------------------- */

bool crn_state_scaffold(const crn_model *model, crn_state *state, const crn_scaffold *order)
{
    const crn_lumen *lumen = model->lumen;
    if (lumen == NULL || order->lesion >= lumen->lesion_count || order->first > order->last ||
        order->last >= lumen->lesions[order->lesion].station_count || order->open_q30 < 0 ||
        order->open_q30 > CRN_ONE_Q30) {
        return false;
    }
    crn_lesion_state *lesions = &state->words.lesions;
    for (uint32_t i = order->first; i <= order->last; i++) {
        int32_t *kept = &lesions->kept_q30[order->lesion][i];
        *kept = *kept < order->open_q30 ? order->open_q30 : *kept;
        lesions->bits |= (*kept != 0 ? 1u : 0u) << order->lesion;
    }
    return true;
}

uint32_t crn_model_stations(const crn_model *model, uint32_t lesion)
{
    return model->lumen == NULL || lesion >= model->lumen->lesion_count
               ? 0
               : model->lumen->lesions[lesion].station_count;
}

int32_t crn_state_open(const crn_state *state, uint32_t lesion, uint32_t station)
{
    return lesion < CRN_LESION_MAX && station < CRN_LESION_STATION_MAX
               ? state->words.lesions.open_q30[lesion][station]
               : 0;
}

bool crn_lesion_is_valid(const crn_lumen *lumen, const crn_lesion_state *lesions)
{
    const uint32_t count = lumen == NULL ? 0 : lumen->lesion_count;
    uint32_t bits = 0;
    for (uint32_t i = 0; i < CRN_LESION_MAX; i++) {
        const uint32_t stations = i < count ? lumen->lesions[i].station_count : 0;
        for (uint32_t k = 0; k < CRN_LESION_STATION_MAX; k++) {
            const int32_t most = k < stations ? CRN_ONE_Q30 : 0;
            const int32_t open = lesions->open_q30[i][k], kept = lesions->kept_q30[i][k];
            if (open < 0 || open > most || kept < 0 || kept > most) {
                return false;
            }
            bits |= (open | kept) != 0 ? 1u << i : 0;
        }
    }
    return lesions->bits == bits;
}
