/* Walls that give way: a vessel that its tools push aside and widen (docs/walls.md).
 *
 * The lumen's distance field describes the vessel at rest. Along the tools, from the leading tip to the
 * sheath, the state holds how far the vessel is displaced from there: at stations that lie 7.8 mm apart, the
 * way u (a vector) and the widening w (a length). Between two stations both are linear. A node at x touches
 * the wall as if it were at x - u, and the distance is w less:
 *
 *     phi(x) = phi_rest(x - u) - w
 *
 * A station follows the force f per length with which the tools press on the wall around it, as a string on a
 * bed of tissue does (T: pull along the vessel, k: stiffness of the bed, tau: time of the tissue):
 *
 *     tau du/dt = f / k - u + (T / k) u''         tau dw/dt = |f| / k_w - w
 *
 * The stations move with the tip. While the tip advances, the way that belongs to a place of the vessel moves
 * to the stations behind. At the sheath the vessel is held. Ahead of the tip, where nothing presses on it,
 * its way decays as exp(-s / carry), carry = sqrt(T / k).
 *
 * Which law holds is a property of the place: the scene names a law for each coarse brick of its lattice. */
#include "firmware/core/lesion.h"
#include "firmware/core/rod.h"

enum {
    SPACING_LOG2 = CRN_WALL_SPACING_LOG2_Q30,
    BRICK_LOG2 = CRN_LUMEN_VOXEL_LOG2_Q30 + 3,
    RIGID_RELAX_ms = 50, /* a way that the tip carries into a rigid wall ends within this time */
    FORCE_MAX_N_Q22 = 1 << 30,
    STIFFNESS_MAX_N_m = 1 << 24,
    WAIT_MAX_Q8 = 1 << 29,
    REST_M_Q30 = 256, /* 0.24 um: what is displaced less than this and pushed by nothing is at rest */
};

/* --- set-up --------------------------------------------------------------------------------------------- */

/* Returns 1 / (k spacing). Format: N/m^2 -> Q30 m per Q22 N, with 16 more bits. 2^24 / (k 2^-7) = 2^31 / k.
 * Overflow: k is at least 1000, so the result is below 2^22. */
static int32_t give_q16(uint32_t per_m2)
{
    return per_m2 == 0 ? 0 : (int32_t)crn_divide_u64(((uint64_t)1 << 31) + per_m2 / 2, per_m2);
}

static int32_t um_to_q30(uint32_t um)
{
    return (int32_t)crn_divide_u64(((uint64_t)um << 30) + 500000u, 1000000u);
}

/* Returns tau + bed + 2 (carry / l)^2, the terms of a station's own way in an implicit step. Unit: ticks. */
static int32_t wait_of(const crn_wall_ready *law, int at_tip)
{
    return law->wait_q8 + (law->bed_q24[at_tip] >> 16) + (law->carry_q24 >> 15);
}

void crn_wall_build(const crn_walls *walls, crn_wall_ready ready[CRN_WALL_LAW_MAX + 1])
{
    static const crn_wall_law rigid = {.relax_ms = RIGID_RELAX_ms};
    for (uint32_t i = 0; i <= walls->law_count && i <= CRN_WALL_LAW_MAX; i++) {
        const crn_wall_law *law = i == 0 ? &rigid : &walls->laws[i - 1];
        crn_wall_ready *to = &ready[i];
        const uint32_t carry_um =
            law->bed_N_m2 == 0 ? 0 : law->carry_um;               /* a fixed vessel takes no way over */
        const uint64_t carry_um2 = (uint64_t)carry_um * carry_um; /* below 2^29 */
        to->carry_q24 = (int32_t)crn_divide_u64(carry_um2 << 34, 62500000000u); /* l^2 is 61.0e6 um^2 */
        to->bed_q24[0] = 1 << 24;
        to->bed_q24[1] = (1 << 24) + (int32_t)crn_divide_u64((uint64_t)carry_um << 26, 15625u);
        to->way_q16[0] = give_q16(law->bed_N_m2);
        to->way_q16[1] = (int32_t)crn_divide_u64((uint64_t)to->way_q16[0] << 25, (uint64_t)to->bed_q24[1]);
        to->widen_q16[0] = give_q16(law->radial_N_m2);
        to->widen_q16[1] = 2 * to->widen_q16[0];
        to->wait_q8 = (int32_t)(law->relax_ms << 8);
        for (int at_tip = 0; at_tip < 2; at_tip++) {
            to->way_share_q30[at_tip] = crn_quotient(1 << 8, wait_of(to, at_tip), 30);
        }
        to->widen_share_q30 = crn_quotient(1 << 8, to->wait_q8 + (1 << 8), 30);
        to->way_max_m_q30 = um_to_q30(law->way_max_um);
        to->widen_max_m_q30 = um_to_q30(law->widen_max_um);
    }
}

/* --- reading -------------------------------------------------------------------------------------------- */

static bool is_displaced(const crn_wall_give *give)
{
    return (give->way_m_q30.v[0] | give->way_m_q30.v[1] | give->way_m_q30.v[2] | give->widen_m_q30) != 0;
}

crn_wall_give crn_wall_give_at(const crn_wall_state *wall, int32_t arc_m_q30)
{
    const uint32_t j = (uint32_t)arc_m_q30 >> SPACING_LOG2;
    crn_wall_give give = {{{0, 0, 0}}, 0};
    if (j >= wall->used) {
        return give;
    }
    const int32_t share_q30 = (arc_m_q30 & ((1 << SPACING_LOG2) - 1)) << (30 - SPACING_LOG2);
    const crn_wall_give *here = &wall->stations[j];
    if (j + 1 < CRN_WALL_STATION_MAX) {
        give = here[1];
    }
    for (int k = 0; k < 3; k++) { /* both are within 20 mm, so their difference is below 2^26 */
        const int32_t from = here->way_m_q30.v[k];
        give.way_m_q30.v[k] = from + crn_scale_q30(give.way_m_q30.v[k] - from, share_q30);
    }
    give.widen_m_q30 = here->widen_m_q30 + crn_scale_q30(give.widen_m_q30 - here->widen_m_q30, share_q30);
    return give;
}

CRN_RARE void crn_wall_move_view(const crn_wall_state *wall, int32_t arc_m_q30, crn_wall_view *view)
{
    const crn_wall_give give = crn_wall_give_at(wall, arc_m_q30);
    for (int k = 0; k < 3; k++) { /* ways are within 20 mm of positions within 1.98 m */
        view->moved_m_q30.v[k] = crn_sub_sat(view->at_m_q30->v[k], give.way_m_q30.v[k]);
    }
    view->at_m_q30 = &view->moved_m_q30;
    view->widen_m_q30 = give.widen_m_q30;
}

bool crn_wall_is_valid(const crn_model *model, const crn_wall_state *wall)
{
    const bool gives = model->lumen != NULL && model->lumen->walls != NULL;
    if (wall->used > (gives ? (uint32_t)CRN_WALL_STATION_MAX : 0u)) {
        return false;
    }
    if (wall->used > 0 && !is_displaced(&wall->stations[wall->used - 1])) {
        return false; /* `used` counts up to the last station that is displaced */
    }
    for (uint32_t j = 0; j < CRN_WALL_STATION_MAX; j++) {
        const crn_wall_give *at = &wall->stations[j];
        const int32_t most = j < wall->used ? CRN_WALL_WAY_MAX_M_Q30 : 0;
        for (int k = 0; k < 3; k++) {
            if (at->way_m_q30.v[k] > most || at->way_m_q30.v[k] < -most) {
                return false;
            }
        }
        if (at->widen_m_q30 < 0 || at->widen_m_q30 > (j < wall->used ? CRN_WALL_WIDEN_MAX_M_Q30 : 0)) {
            return false;
        }
    }
    return true;
}

/* --- a tick --------------------------------------------------------------------------------------------- */

/* What the tools do to the wall around one station. */
typedef struct station_load {
    crn_vec3 force_N_q22;
    int32_t press_N_q22;   /* sum of the magnitudes */
    int32_t stiffness_N_m; /* of the contacts, so that a station gives no farther than the contact is deep */
} station_load;

/* Passes over the stations from the tip to the sheath. */
typedef struct wall_pass {
    uint32_t number;             /* of the station whose load is complete next */
    crn_wall_give before;        /* the station in front of it, as it was before this tick */
    station_load load[2];        /* of this station and the next */
    const crn_vec3 *place_m_q30; /* the first node at or behind the station */
    int32_t advance_q30;         /* of the tip in this tick, in spacings */
    uint32_t count, used;
} wall_pass;

static uint32_t law_at(const crn_lumen *lumen, const crn_vec3 *place_m_q30, const crn_wall_give *give)
{
    uint32_t number = 0;
    for (int k = 3; k-- > 0;) {
        const int32_t rest = crn_sub_sat(place_m_q30->v[k], give->way_m_q30.v[k]);
        /* modulo 2^32, as in lumen.c */
        const uint32_t brick = ((uint32_t)rest - (uint32_t)lumen->origin_m_q30[k]) >> BRICK_LOG2;
        if (brick >= lumen->brick_count_xyz[k]) {
            return 0;
        }
        number = number * lumen->brick_count_xyz[k] + brick;
    }
    return lumen->walls->law_of_brick[number];
}

/* Returns 1 / (wait + stiffness of the contacts / stiffness of the wall): the part of what draws at a station
 * by which it moves in this tick. This is an implicit step for the station alone, so a stiff contact cannot
 * throw a station beyond its equilibrium. */
static int32_t share_under(int32_t wait_q8, int32_t give_q16_per_N, int32_t stiffness_N_m)
{
    const int64_t wait = wait_q8 + (((int64_t)give_q16_per_N * stiffness_N_m) >> 16);
    return crn_quotient(1 << 8, wait > WAIT_MAX_Q8 ? WAIT_MAX_Q8 : (int32_t)wait, 30);
}

/* Returns the way at which the bed holds a force, at most as long as the law allows. */
static crn_vec3 way_under(const crn_wall_ready *law, int at_tip, const crn_vec3 *force_N_q22)
{
    crn_vec3 way;
    int64_t square = 0;
    for (int k = 0; k < 3; k++) {
        const int64_t part = ((int64_t)force_N_q22->v[k] * law->way_q16[at_tip]) >> 16;
        way.v[k] = crn_clamp(crn_sat32(part), -CRN_ONE_Q30, CRN_ONE_Q30);
        square += (int64_t)way.v[k] * way.v[k]; /* at most 2^60 each */
    }
    if (square <= (int64_t)law->way_max_m_q30 * law->way_max_m_q30) {
        return way;
    }
    const int32_t share_q30 = crn_quotient(law->way_max_m_q30, crn_sqrt64((uint64_t)square) + 1, 30);
    for (int k = 0; k < 3; k++) {
        way.v[k] = crn_scale_q30(way.v[k], share_q30);
    }
    return way;
}

static int32_t carried(int32_t here, int32_t ahead, int32_t behind, int32_t advance_q30)
{
    const int32_t from = advance_q30 > 0 ? ahead : behind;
    return here + crn_mul_q30(from - here, advance_q30 > 0 ? advance_q30 : -advance_q30);
}

/* The new way is a mean of the goal and of the ways here, ahead and behind, with weights of which none is
 * negative: those of the goal and the neighbours sum to less than (bed + 2 (carry / l)^2) / wait, which is
 * below 0.5, and the tip advances by at most 0.07 spacings. So no way gets longer than the longest goal, 20
 * mm. Overflow: a difference of two numbers here is below 2^26, and times at most 6.2 (bed) or 6.6 below
 * 2^29. */
static void follow_way(const crn_wall_ready *law, const station_load *load, const wall_pass *pass,
                       const crn_wall_give *behind, crn_wall_give *give)
{
    const int at_tip = pass->number == 0;
    const crn_vec3 goal_m_q30 = way_under(law, at_tip, &load->force_N_q22);
    const int32_t held_q24 = law->bed_q24[at_tip];
    const int32_t share = load->stiffness_N_m == 0
                              ? law->way_share_q30[at_tip]
                              : share_under(wait_of(law, at_tip), crn_mul(law->way_q16[at_tip], held_q24, 24),
                                            load->stiffness_N_m);
    for (int k = 0; k < 3; k++) {
        const int32_t now = give->way_m_q30.v[k], next = behind->way_m_q30.v[k];
        /* at the tip, the vessel ahead is part of the bed, and only half a spacing lies behind */
        const int32_t ahead = at_tip ? next : pass->before.way_m_q30.v[k];
        const int32_t draw = crn_mul(goal_m_q30.v[k] - now, held_q24, 24) +
                             crn_mul(ahead - 2 * now + next, law->carry_q24, 24);
        const int32_t moved = carried(now, at_tip ? now : ahead, next, pass->advance_q30);
        give->way_m_q30.v[k] = crn_clamp(moved + crn_mul_q30(draw, share), -CRN_WALL_WAY_MAX_M_Q30,
                                         CRN_WALL_WAY_MAX_M_Q30); /* the rounding */
    }
}

static void follow_widening(const crn_wall_ready *law, const station_load *load, const wall_pass *pass,
                            const crn_wall_give *behind, crn_wall_give *give)
{
    const int at_tip = pass->number == 0;
    const int64_t wide = ((int64_t)load->press_N_q22 * law->widen_q16[at_tip]) >> 16;
    const int32_t goal = wide < law->widen_max_m_q30 ? (int32_t)wide : law->widen_max_m_q30;
    const int32_t now = give->widen_m_q30;
    const int32_t share = load->stiffness_N_m == 0 ? law->widen_share_q30
                                                   : share_under(law->wait_q8 + (1 << 8),
                                                                 law->widen_q16[at_tip], load->stiffness_N_m);
    const int32_t moved =
        carried(now, at_tip ? now : pass->before.widen_m_q30, behind->widen_m_q30, pass->advance_q30);
    give->widen_m_q30 = crn_clamp(moved + crn_mul_q30(goal - now, share), 0, CRN_WALL_WIDEN_MAX_M_Q30);
}

static bool is_all_but_at_rest(const crn_wall_give *give)
{
    bool is_small = give->widen_m_q30 < REST_M_Q30;
    for (int k = 0; k < 3; k++) {
        is_small = is_small && give->way_m_q30.v[k] < REST_M_Q30 && give->way_m_q30.v[k] > -REST_M_Q30;
    }
    return is_small;
}

/* Moves the station whose load is complete, and goes on to the next. A station at rest that nothing moves
 * needs no law. */
static void finish_station(const crn_model *model, crn_wall_state *wall, wall_pass *pass)
{
    static const crn_wall_give none = {{{0, 0, 0}}, 0};
    const uint32_t j = pass->number;
    crn_wall_give *give = &wall->stations[j];
    const crn_wall_give old = *give;
    const crn_wall_give *behind = j + 1 < pass->count ? &wall->stations[j + 1] : &none;
    const station_load *load = &pass->load[0];
    if (load->stiffness_N_m != 0 || is_displaced(give) || is_displaced(behind) ||
        is_displaced(&pass->before)) {
        const uint32_t number = law_at(model->lumen, pass->place_m_q30, give);
        if (number <= CRN_WALL_LAW_MAX) {
            follow_way(&model->walls[number], load, pass, behind, give);
            follow_widening(&model->walls[number], load, pass, behind, give);
        }
        if (load->stiffness_N_m == 0 && is_all_but_at_rest(give) && is_all_but_at_rest(behind) &&
            is_all_but_at_rest(&pass->before)) {
            *give = none;
        }
        pass->used = is_displaced(give) ? j + 1 : pass->used;
    }
    pass->before = old;
    pass->load[0] = pass->load[1];
    pass->load[1] = (station_load){{{0, 0, 0}}, 0, 0};
    pass->number++;
}

static void load_station(station_load *load, const crn_vec3 *normal_q30, int32_t force_N_q22,
                         int32_t stiffness_N_m)
{
    for (int k = 0; k < 3; k++) { /* the wall is pushed against its inward normal */
        const int32_t sum = crn_sub_sat(load->force_N_q22.v[k], crn_scale_q30(force_N_q22, normal_q30->v[k]));
        load->force_N_q22.v[k] = crn_clamp(sum, -FORCE_MAX_N_Q22, FORCE_MAX_N_Q22);
    }
    load->press_N_q22 = crn_clamp(crn_add_sat(load->press_N_q22, force_N_q22), 0, FORCE_MAX_N_Q22);
    load->stiffness_N_m = crn_clamp(load->stiffness_N_m + stiffness_N_m, 0, STIFFNESS_MAX_N_m);
}

/* Shares the contact of a node between the two stations beside it, as crn_wall_give_at() takes their ways. */
static void load_by_node(const crn_work *work, int32_t arc_m_q30, wall_pass *pass)
{
    if (!work->touching) {
        return;
    }
    const int32_t deviation = along(&work->solution_m_q33, &work->normal_q30);
    const int32_t depth = crn_sub_sat(work->depth_m_q30, deviation >> 3);
    if (depth <= 0) {
        return;
    }
    const int32_t force = crn_contact_force(depth), stiffness = crn_contact_stiffness_N_m(depth);
    const int32_t share_q30 = (arc_m_q30 & ((1 << SPACING_LOG2) - 1)) << (30 - SPACING_LOG2);
    const int32_t far_force = crn_scale_q30(force, share_q30), far = crn_scale_q30(stiffness, share_q30);
    load_station(&pass->load[0], &work->normal_q30, force - far_force, stiffness - far);
    load_station(&pass->load[1], &work->normal_q30, far_force, far);
}

void crn_wall_step(const crn_model *model, crn_state *state)
{
    if (model->lumen == NULL || model->lumen->walls == NULL) {
        return;
    }
    crn_wall_state *wall = &state->words.wall;
    const uint32_t length = (uint32_t)crn_lead_inserted(model, &state->words) >> SPACING_LOG2;
    wall_pass pass = {.place_m_q30 = &state->scratch.nodes[0].position_m_q30};
    pass.count = length < CRN_WALL_STATION_MAX ? length + 1 : CRN_WALL_STATION_MAX;
    /* Q33 m in spacings of 2^23 Q30 units; a tick advances the tip by at most 0.5 mm */
    pass.advance_q30 = state->scratch.feed_m_q33 * 16;
    for (uint32_t i = 0; i < state->words.free_count && pass.number < pass.count; i++) {
        const crn_work *work = &state->scratch.nodes[i];
        const int32_t arc = model->mesh[i].arc_m_q30;
        while (pass.number < (uint32_t)arc >> SPACING_LOG2 && pass.number < pass.count) {
            finish_station(model, wall, &pass);
            pass.place_m_q30 = &work->position_m_q30;
        }
        load_by_node(work, arc, &pass);
    }
    while (pass.number < pass.count) {
        finish_station(model, wall, &pass);
    }
    for (uint32_t j = pass.count; j < wall->used; j++) {
        wall->stations[j] = (crn_wall_give){{{0, 0, 0}}, 0};
    }
    wall->used = pass.used;
}
