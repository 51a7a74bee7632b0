/* Model of the balloon (docs/balloon.md). */
#include "firmware/core/balloon.h"
#include "firmware/core/lesion.h"

enum {
    GROW_M_Q30 = 5369,            /* 5 um a tick: 5 mm/s */
    FIT_M_Q30 = 21475,            /* 20 um: the farthest that a ball is moved off a wall in one tick */
    SLIP_M_Q30 = 536871,          /* 0.5 mm */
    STIFFNESS_N_m = 2000,         /* spring of one ball: as stiff as a friction bristle */
    BY_STIFFNESS_Q30 = 137438953, /* 256 / STIFFNESS */
    FOLLOW_LOG2 = 3, /* a ball that nothing holds closes an eighth of its distance to the line in each tick */
    BALL_MAX_N_Q22 = 128 << 22,     /* wall force of one ball */
    LENGTH_OF_BALL_M_Q30 = 1 << 20, /* about 1 mm */
    FELT_M_Q30 = 1 << 22,           /* 3.9 mm: greater depths are cut to this */
    /* 20 um: a wall this near on all sides is felt, whichever directions this tick looks in */
    CLOSE_M_Q30 = 21475,
    ROOT_HALF_Q30 = 759250125,
    TWO_PI_Q28 = 1686629713,
    UNFOLDED_Q30 = 1041529569, /* 0.97 of the first diameter in the table: from here on the balloon's own wall
                                  bears load */
};

/* --- set-up --------------------------------------------------------------------------------------------- */

static bool table_is_one(const crn_balloon *balloon, uint32_t folded_radius_um)
{
    if (balloon->point_count < 2 || balloon->point_count > CRN_BALLOON_POINT_MAX) {
        return false;
    }
    for (uint32_t i = 0; i < balloon->point_count; i++) {
        uint32_t kPa = balloon->pressure_kPa[i], um = balloon->diameter_um[i];
        if (kPa < 100 || kPa > CRN_PRESSURE_MAX_Pa / 1000 || um > 20000) {
            return false;
        }
        if (i == 0 ? um * 97 / 100 <= 2 * folded_radius_um
                   : kPa <= balloon->pressure_kPa[i - 1] || um <= balloon->diameter_um[i - 1]) {
            return false;
        }
    }
    return balloon->burst_kPa > balloon->pressure_kPa[balloon->point_count - 1] &&
           balloon->burst_kPa <= CRN_PRESSURE_MAX_Pa / 1000;
}

/* Returns the outer radius of a tool at an arc length, interpolated between its knots. Set-up only. */
static uint32_t radius_at_um(const crn_instrument *tool, uint32_t arc_um)
{
    uint32_t i = 0;
    while (i + 2 < tool->knot_count && tool->knots[i + 1].arc_um <= arc_um) {
        i++;
    }
    const crn_knot *a = &tool->knots[i], *b = &tool->knots[i + 1];
    if (arc_um <= a->arc_um || a->arc_um == b->arc_um) {
        return a->radius_outer_um;
    }
    if (arc_um >= b->arc_um) {
        return b->radius_outer_um;
    }
    uint64_t before = arc_um - a->arc_um, after = b->arc_um - arc_um;
    uint64_t sum = a->radius_outer_um * after + b->radius_outer_um * before;
    return (uint32_t)crn_divide_u64(sum, b->arc_um - a->arc_um);
}

/* Returns the radius of the folded balloon, which is the largest outer radius of the tool within the
 * balloon's length. */
static uint32_t folded_um(const crn_instrument *tool)
{
    uint32_t distal = radius_at_um(tool, tool->balloon.distal_um),
             proximal = radius_at_um(tool, tool->balloon.proximal_um);
    uint32_t widest = distal > proximal ? distal : proximal;
    for (uint32_t i = 0; i < tool->knot_count; i++) {
        bool is_under = tool->knots[i].arc_um >= tool->balloon.distal_um &&
                        tool->knots[i].arc_um <= tool->balloon.proximal_um;
        widest =
            is_under && tool->knots[i].radius_outer_um > widest ? tool->knots[i].radius_outer_um : widest;
    }
    return widest;
}

bool crn_balloon_check(const crn_instrument *tool)
{
    const crn_balloon *balloon = &tool->balloon;
    if (balloon->point_count == 0) {
        return true;
    }
    uint32_t end_um = tool->knots[tool->knot_count - 1].arc_um, folded = folded_um(tool);
    bool lies_on_it = balloon->distal_um < balloon->proximal_um && balloon->proximal_um <= end_um &&
                      balloon->proximal_um - balloon->distal_um >= 2000 &&
                      balloon->proximal_um - balloon->distal_um <= 60000;
    return lies_on_it && folded != 0 && table_is_one(balloon, folded);
}

static int32_t um_to_q30(uint32_t um)
{
    return (int32_t)crn_divide_u64(((uint64_t)um << 30) + 500000u, 1000000u);
}

void crn_balloon_build(crn_balloon_model *model, const crn_instrument *tool)
{
    const crn_balloon *balloon = &tool->balloon;
    if (balloon->point_count == 0) {
        return;
    }
    model->distal_m_q30 = um_to_q30(balloon->distal_um);
    int32_t length = um_to_q30(balloon->proximal_um) - model->distal_m_q30;
    uint32_t gaps = (uint32_t)(length + LENGTH_OF_BALL_M_Q30 / 2) / LENGTH_OF_BALL_M_Q30;
    gaps = gaps > CRN_BALLOON_BALL_MAX - 1 ? CRN_BALLOON_BALL_MAX - 1 : gaps;
    model->ball_count = gaps + 1;
    model->spacing_m_q30 = (int32_t)crn_divide_u64((uint64_t)(uint32_t)length, gaps);
    model->burst_Pa = (int32_t)balloon->burst_kPa * 1000;
    model->point_count = balloon->point_count + 2;
    model->pressure_Pa[0] = 0;
    model->radius_m_q30[0] = um_to_q30(folded_um(tool));
    int32_t first = um_to_q30(balloon->diameter_um[0]) / 2;
    model->pressure_Pa[1] = CRN_BALLOON_UNFOLD_Pa;
    model->radius_m_q30[1] = crn_scale_q30(first, UNFOLDED_Q30);
    for (uint32_t i = 0; i < balloon->point_count; i++) {
        model->pressure_Pa[i + 2] = (int32_t)balloon->pressure_kPa[i] * 1000;
        model->radius_m_q30[i + 2] = um_to_q30(balloon->diameter_um[i]) / 2;
    }
}

/* --- the maker's table ---------------------------------------------------------------------------------- */

/* Returns y at x on the straight line through two points. Overflow is impossible: neighbouring points of a
 * table differ by less than 2^23 in x and in y. Beyond the last point of the table, the last straight piece
 * of the curve continues, and the result is at most a few times the last y. */
static int32_t on_line(int32_t x, int32_t x0, int32_t x1, int32_t y0, int32_t y1)
{
    return y0 + crn_scale_q30(y1 - y0, crn_quotient(x - x0, x1 - x0, 28)) * 4;
}

int32_t crn_balloon_free_radius(const crn_balloon_model *model, int32_t pressure_Pa)
{
    const int32_t *p = model->pressure_Pa, *r = model->radius_m_q30;
    if (pressure_Pa <= 0) {
        return r[0];
    }
    uint32_t i = 0;
    while (i + 2 < model->point_count && p[i + 1] < pressure_Pa) {
        i++;
    }
    return on_line(pressure_Pa, p[i], p[i + 1], r[i], r[i + 1]);
}

int32_t crn_balloon_own_pressure(const crn_balloon_model *model, int32_t radius_m_q30)
{
    const int32_t *p = model->pressure_Pa, *r = model->radius_m_q30;
    if (radius_m_q30 <= r[1]) {
        return 0;
    }
    uint32_t i = 1;
    while (i + 2 < model->point_count && r[i + 1] < radius_m_q30) {
        i++;
    }
    return on_line(radius_m_q30, r[i], r[i + 1], i == 1 ? 0 : p[i], p[i + 1]);
}

/* --- where the balls are -------------------------------------------------------------------------------- */

/* Describes the position of one of the balloon's balls (spheres) on the tools' common centreline, at the
 * predicted configuration. */
typedef struct place {
    uint32_t node;     /* the place lies between this node and the next */
    int32_t share_q30; /* of the next */
    bool is_free;      /* the place is outside the inserter and no other tool surrounds it */
    crn_vec3 point_m_q30;
    crn_vec3 along_q30; /* unit vector towards the hand */
    crn_wall_give give; /* how far the wall has given way there */
} place;

int32_t crn_balloon_arc(const crn_model *model, const crn_state *state, uint32_t ball)
{
    const crn_balloon_model *balloon = &model->balloon;
    return state->line.offset_m_q30[balloon->tool] + balloon->distal_m_q30 +
           (int32_t)ball * balloon->spacing_m_q30;
}

/* Finds the position of one of the balloon's balls (spheres) on the tools' common centreline. The search
 * starts at the node `from`, which lies at or before the ball's position, and goes towards the user's hand.
 */
static place place_of(const crn_model *model, const crn_state *state, uint32_t ball, uint32_t from)
{
    const crn_balloon_model *balloon = &model->balloon;
    const int32_t arc = crn_balloon_arc(model, state, ball);
    uint32_t i = from;
    while (i + 1 < model->node_count && model->mesh[i + 1].arc_m_q30 <= arc) {
        i++;
    }
    place at = {i,
                0,
                i + 1 < state->words.free_count && state->line.nodes[i].outer == balloon->tool,
                {{0, 0, 0}},
                state->words.nodes[i].tangent_q30,
                {{{0, 0, 0}}, 0}};
    if (!at.is_free) {
        return at;
    }
    if (state->words.wall.used != 0) {
        at.give = crn_wall_give_at(&state->words.wall, arc);
    }
    at.share_q30 = crn_clamp(crn_quotient(arc - model->mesh[i].arc_m_q30, model->mesh[i].length_m_q30, 30), 0,
                             CRN_ONE_Q30);
    const crn_vec3 *a = &state->scratch.nodes[i].position_m_q30,
                   *b = &state->scratch.nodes[i + 1].position_m_q30;
    for (int k = 0; k < 3; k++) {
        /* an edge is shorter than 2^25 */
        at.point_m_q30.v[k] = a->v[k] + crn_scale_q30(b->v[k] - a->v[k], at.share_q30);
    }
    return at;
}

/* Returns where a point lies in a vessel that no tool has pushed aside. */
static crn_vec3 at_rest(const crn_vec3 *place_m_q30, const crn_wall_give *give)
{
    return crn_vec3_sub(*place_m_q30, give->way_m_q30);
}

/* Converts a point from patient coordinates to the reference pose, in which the lumen is described. */
static crn_vec3 in_reference(const crn_model *model, crn_state *state, const crn_vec3 *place_m_q30)
{
    const crn_motion *motion = model->lumen->motion;
    return motion == NULL ? *place_m_q30 : crn_motion_pull(motion, &state->scratch.pose, place_m_q30);
}

/* `section` describes the opened lesion that contains the point; NULL means that no opened lesion contains
 * the point. */
static int32_t wall_distance(const crn_model *model, crn_state *state, const crn_lesion_section *section,
                             const crn_vec3 *place_m_q30)
{
    const crn_lumen *lumen = model->lumen;
    if (lumen == NULL) {
        return -FELT_M_Q30;
    }
    if (section != NULL) {
        const crn_vec3 reference = in_reference(model, state, place_m_q30);
        return crn_lesion_section_distance(lumen, section, &reference);
    }
    return lumen->motion == NULL
               ? crn_lumen_distance(lumen, place_m_q30)
               : crn_motion_contact(lumen, lumen->motion, &state->scratch.pose, place_m_q30).distance_m_q30;
}

/* --- growing -------------------------------------------------------------------------------------------- */

/* Outer radius of a ball. A ball (sphere) of the balloon that is still inside the introducer sheath or inside
 * another tool has the radius 0 in the state and counts as folded. */
static int32_t radius_of(const crn_model *model, const crn_balloon_ball *ball)
{
    const int32_t folded = model->balloon.radius_m_q30[0];
    return ball->radius_m_q30 > folded ? ball->radius_m_q30 : folded;
}

/* Returns the centre of one of the balloon's balls before the ball grows in this tick. A ball of the balloon
 * that touches the vessel wall moves with the wall; any other ball follows the tools' centreline. */
static crn_vec3 carried(const crn_model *model, crn_state *state, const crn_balloon_ball *ball,
                        const place *at)
{
    crn_vec3 centre = ball->centre_m_q30;
    if (ball->wall_N_q22 > 0 && model->lumen != NULL) {
        if (model->lumen->motion != NULL) {
            (void)crn_motion_contact(model->lumen, model->lumen->motion, &state->scratch.pose, &centre);
            crn_vec3 step = crn_motion_wall_step(model->lumen->motion, &state->scratch.pose);
            for (int k = 0; k < 3; k++) {
                centre.v[k] += step.v[k] / 8;
            }
        }
        return centre;
    }
    crn_vec3 off = crn_vec3_sub(centre, at->point_m_q30);
    int32_t along = crn_vec3_dot_unit(&off, &at->along_q30);
    for (int k = 0; k < 3; k++) {
        int32_t across = off.v[k] - crn_scale_q30(along, at->along_q30.v[k]);
        centre.v[k] = at->point_m_q30.v[k] + across - crn_asr32(across, FOLLOW_LOG2);
    }
    return centre;
}

/* Returns the force N = p 2 pi r ds with which a ball of the balloon presses on the vessel wall (p: pressure
 * on the wall, r: radius of the ball, ds: length that the ball represents). Format: Pa, Q30 m -> Q22 N.
 * Overflow: r below 2^24 and ds below 2^22, so their product is below 2^26 in Q40; times 2 pi below 2^29,
 * times 2^22 Pa below 2^51. */
static int32_t wall_force(int32_t pressure_Pa, int32_t radius_m_q30, int32_t length_m_q30)
{
    int64_t area_q40 = ((int64_t)radius_m_q30 * length_m_q30) >> 20;
    area_q40 = (area_q40 * TWO_PI_Q28) >> 28;
    int64_t force = (area_q40 * pressure_Pa) >> 18;
    return force > BALL_MAX_N_Q22 ? BALL_MAX_N_Q22 : (int32_t)force;
}

/* Computes two directions that are perpendicular to each other and to the tools' centreline. In each tick the
 * code probes the wall in four directions: along each of the two directions and opposite to it. The two probe
 * directions turn by 45 degrees from tick to tick, so that two successive ticks probe the wall in eight
 * directions. */
static void directions(const crn_vec3 *along_q30, bool is_turned, crn_vec3 pair_q30[2])
{
    int least = 0;
    for (int k = 1; k < 3; k++) {
        int32_t here = along_q30->v[k] < 0 ? -along_q30->v[k] : along_q30->v[k];
        int32_t best = along_q30->v[least] < 0 ? -along_q30->v[least] : along_q30->v[least];
        least = here < best ? k : least;
    }
    crn_vec3 helper = {{0, 0, 0}};
    helper.v[least] = CRN_ONE_Q30;
    crn_vec3 first = crn_vec3_normalise(crn_vec3_cross_unit(along_q30, &helper), helper, NULL);
    crn_vec3 second = crn_vec3_cross_unit(along_q30, &first);
    for (int k = 0; k < 3; k++) {
        int32_t sum = crn_scale_q30(first.v[k], ROOT_HALF_Q30) + crn_scale_q30(second.v[k], ROOT_HALF_Q30);
        int32_t difference =
            crn_scale_q30(first.v[k], ROOT_HALF_Q30) - crn_scale_q30(second.v[k], ROOT_HALF_Q30);
        pair_q30[0].v[k] = is_turned ? sum : first.v[k];
        pair_q30[1].v[k] = is_turned ? difference : second.v[k];
    }
}

/* Returns the signed distance from the vessel wall to the surface of one of the balloon's balls,
 * along the given direction. The distance is positive if the ball's surface lies beyond the vessel wall. The
 * distance field of the lumen is accurate at the vessel wall. The distance field is not accurate on the axis
 * of a narrow vessel, because the spline rounds off the ridge that the distance has there. */
static int32_t behind_wall(const crn_model *model, crn_state *state, const crn_lesion_section *section,
                           const crn_wall_give *give, const crn_vec3 *centre_m_q30,
                           const crn_vec3 *direction_q30, int32_t radius_m_q30)
{
    crn_vec3 surface;
    for (int k = 0; k < 3; k++) {
        surface.v[k] = crn_add_sat(centre_m_q30->v[k], crn_scale_q30(radius_m_q30, direction_q30->v[k]));
    }
    const crn_vec3 rest = at_rest(&surface, give);
    return crn_clamp(crn_sub_sat(wall_distance(model, state, section, &rest), give->widen_m_q30), -FELT_M_Q30,
                     FELT_M_Q30);
}

/* Moves the ball away from the two parts of the vessel wall that lie on opposite sides of the ball along one
 * direction. Returns half of the difference between the ball's diameter and the clearance between the two
 * walls. The returned value is negative where the vessel is wider than the ball. */
static int32_t fit_between(const crn_model *model, crn_state *state, const crn_lesion_section *section,
                           const crn_wall_give *give, crn_vec3 *centre_m_q30, const crn_vec3 *direction_q30,
                           int32_t radius_m_q30)
{
    int32_t ahead = behind_wall(model, state, section, give, centre_m_q30, direction_q30, radius_m_q30);
    int32_t back = behind_wall(model, state, section, give, centre_m_q30, direction_q30, -radius_m_q30);
    int32_t way = 0; /* displacement backwards, off the wall ahead */
    if (ahead + back > 0) {
        way = (ahead - back) / 2;
    } else if (ahead > 0) {
        way = ahead;
    } else if (back > 0) {
        way = -back;
    }
    way = crn_clamp(way, -FIT_M_Q30, FIT_M_Q30);
    for (int k = 0; k < 3; k++) {
        centre_m_q30->v[k] = crn_sub_sat(centre_m_q30->v[k], crn_scale_q30(way, direction_q30->v[k]));
    }
    return (ahead + back) / 2;
}

/* Advances one of the balloon's balls (spheres) by one tick. `length_m_q30` is the length of the vessel wall
 * that the ball represents. Returns the pressure with which a ball of the balloon presses on the vessel wall.
 */
static int32_t grow(const crn_model *model, crn_state *state, uint32_t number, const place *at,
                    int32_t pressure_Pa, int32_t length_m_q30)
{
    const crn_balloon_model *balloon = &model->balloon;
    crn_balloon_ball *ball = &state->words.balloon.balls[number];
    const int32_t folded = balloon->radius_m_q30[0];
    int32_t wanted = crn_balloon_free_radius(balloon, pressure_Pa);
    int32_t grown = ball->radius_m_q30 < wanted
                        ? crn_clamp(wanted, 0, ball->radius_m_q30 + GROW_M_Q30)
                        : crn_clamp(wanted, ball->radius_m_q30 - GROW_M_Q30, INT32_MAX);
    crn_vec3 centre = carried(model, state, ball, at), pair[2];
    directions(&at->along_q30, (state->words.tick & 1) != 0, pair);
    int32_t missing = -FELT_M_Q30;
    crn_lesion_section open;
    const crn_lesion_section *section = NULL;
    if (state->words.lesions.bits != 0 && model->lumen != NULL) {
        const crn_vec3 rest = at_rest(&centre, &at->give);
        const crn_vec3 reference = in_reference(model, state, &rest);
        section =
            crn_lesion_section_at(model->lumen, &state->words.lesions, &reference, &open) ? &open : NULL;
    }
    for (int d = 0; d < 2; d++) {
        int32_t here = fit_between(model, state, section, &at->give, &centre, &pair[d], grown);
        missing = here > missing ? here : missing;
    }
    ball->centre_m_q30 = centre;
    ball->radius_m_q30 = missing > 0 ? crn_clamp(grown - missing, folded, grown) : grown;
    int32_t left_Pa = pressure_Pa - crn_balloon_own_pressure(balloon, ball->radius_m_q30);
    const uint32_t bit = 1u << number, confines = missing > -CLOSE_M_Q30 ? bit : 0;
    uint32_t *bits = state->words.balloon.confined_bits;
    bits[state->words.tick & 1] = (bits[state->words.tick & 1] & ~bit) | confines;
    bool is_confined = ((bits[0] | bits[1]) & bit) != 0 && left_Pa > 0;
    ball->wall_N_q22 = is_confined ? wall_force(left_Pa, ball->radius_m_q30, length_m_q30) : 0;
    return is_confined ? left_Pa : 0;
}

static void fold(const crn_model *model, crn_balloon_state *words, uint32_t number, const place *at)
{
    words->confined_bits[0] &= ~(1u << number);
    words->confined_bits[1] &= ~(1u << number);
    words->balls[number] =
        (crn_balloon_ball){at->point_m_q30, at->is_free ? model->balloon.radius_m_q30[0] : 0, 0};
}

/* Adds to the matrix the spring that ties a ball of the balloon to the tools' centreline. The spring's
 * stiffness is divided between the two nodes beside the ball. The code leaves out the matrix entries that
 * couple the two nodes; without these entries the spring in the matrix is at least as stiff as the exact
 * spring. */
static void tie(const crn_model *model, crn_state *state, const place *at)
{
    const int32_t stiffness = STIFFNESS_N_m << model->stiffness_exponent;
    const int32_t second = crn_scale_q30(stiffness, at->share_q30), parts[2] = {stiffness - second, second};
    for (uint32_t n = 0; n < 2; n++) {
        crn_work *work = &state->scratch.nodes[at->node + n];
        work->tied += parts[n];
    }
}

void crn_balloon_find(const crn_model *model, crn_state *state, int32_t inflator_Pa)
{
    const crn_balloon_model *balloon = &model->balloon;
    crn_balloon_state *words = &state->words.balloon;
    if (balloon->ball_count == 0) {
        return;
    }
    int32_t pressure = crn_clamp(inflator_Pa, 0, CRN_PRESSURE_MAX_Pa);
    if (pressure > balloon->burst_Pa) {
        words->bits |= CRN_BALLOON_BURST;
    }
    words->pressure_Pa = (words->bits & CRN_BALLOON_BURST) != 0 ? 0 : pressure;
    uint32_t node = 0;
    for (uint32_t j = 0; j < balloon->ball_count; j++) {
        crn_balloon_ball *ball = &words->balls[j];
        place at = place_of(model, state, j, node);
        node = at.node;
        state->scratch.press_Pa[j] = 0;
        if (!at.is_free || (words->pressure_Pa == 0 && ball->radius_m_q30 <= balloon->radius_m_q30[0])) {
            fold(model, words, j, &at);
            continue;
        }
        if (ball->radius_m_q30 < balloon->radius_m_q30[0]) {
            /* it leaves the inserter or the outer tool now, and lies on the line */
            fold(model, words, j, &at);
        }
        bool is_end = j == 0 || j + 1 == balloon->ball_count;
        state->scratch.press_Pa[j] = grow(model, state, j, &at, words->pressure_Pa,
                                          is_end ? balloon->spacing_m_q30 / 2 : balloon->spacing_m_q30);
        tie(model, state, &at);
    }
}

/* --- forces --------------------------------------------------------------------------------------------- */

static bool is_tied(const crn_model *model, const crn_state *state, uint32_t ball, const place *at)
{
    return at->is_free && (state->words.balloon.balls[ball].radius_m_q30 > model->balloon.radius_m_q30[0] ||
                           state->words.balloon.pressure_Pa > 0);
}

void crn_balloon_forces(const crn_model *model, crn_state *state)
{
    uint32_t node = 0;
    for (uint32_t j = 0; j < model->balloon.ball_count; j++) {
        place at = place_of(model, state, j, node);
        node = at.node;
        if (!is_tied(model, state, j, &at)) {
            continue;
        }
        crn_vec3 miss = crn_vec3_sub(state->words.balloon.balls[j].centre_m_q30, at.point_m_q30);
        for (int k = 0; k < 3; k++) {
            /* Q30 m times N/m -> Q22 N; limited in the same way as contact forces */
            int64_t pull = ((int64_t)miss.v[k] * STIFFNESS_N_m) >> 8;
            int32_t force = crn_clamp(crn_sat32(pull), -BALL_MAX_N_Q22, BALL_MAX_N_Q22);
            int32_t second = crn_scale_q30(force, at.share_q30);
            crn_work *work = &state->scratch.nodes[at.node];
            work[0].force_N_q22.v[k] = crn_add_sat(work[0].force_N_q22.v[k], force - second);
            work[1].force_N_q22.v[k] = crn_add_sat(work[1].force_N_q22.v[k], second);
        }
    }
}

/* Returns N dr/ds, the axial force with which the wall pushes the balloon where the balloon's radius changes.
 * The slope dr/ds is the central difference between the neighbouring balls. A positive force points towards
 * the user's hand. */
static int32_t taper_force(const crn_model *model, const crn_state *state, uint32_t j)
{
    const crn_balloon_ball *balls = state->words.balloon.balls;
    const uint32_t last = model->balloon.ball_count - 1;
    const uint32_t before = j > 0 ? j - 1 : 0, after = j < last ? j + 1 : last;
    int32_t wider = balls[after].radius_m_q30 - balls[before].radius_m_q30;
    int32_t slope_q28 = crn_quotient(wider, (int32_t)(after - before) * model->balloon.spacing_m_q30, 28);
    slope_q28 = crn_clamp(slope_q28, -(1 << 28), 1 << 28); /* 45 degrees */
    return crn_scale_q30(balls[j].wall_N_q22, slope_q28) * 4;
}

/* Moves a ball of the balloon along the tools' centreline until the force on the ball no longer exceeds the
 * friction of the wall. */
static void slip(const crn_model *model, crn_state *state, uint32_t j, const place *at)
{
    crn_balloon_ball *ball = &state->words.balloon.balls[j];
    const crn_work *work = &state->scratch.nodes[at->node];
    crn_vec3 way; /* from the ball's centre to the line after the solve */
    for (int k = 0; k < 3; k++) {
        int32_t a = work[0].solution_m_q33.v[k], b = work[1].solution_m_q33.v[k];
        int32_t moved = (a + crn_scale_q30(b - a, at->share_q30)) >> 3;
        way.v[k] = at->point_m_q30.v[k] + moved - ball->centre_m_q30.v[k];
    }
    int32_t along = crn_vec3_dot_unit(&way, &at->along_q30);
    crn_vec3 across = {{way.v[0] - crn_scale_q30(along, at->along_q30.v[0]),
                        way.v[1] - crn_scale_q30(along, at->along_q30.v[1]),
                        way.v[2] - crn_scale_q30(along, at->along_q30.v[2])}};
    int32_t off;
    (void)crn_vec3_normalise(across, across, &off);
    int64_t pressed = (int64_t)ball->wall_N_q22 + (((int64_t)off * STIFFNESS_N_m) >> 8);
    int32_t holds = crn_scale_q30(crn_sat32(pressed), state->line.nodes[at->node].static_q30);
    int32_t taper = taper_force(model, state, j);
    int64_t pull = (((int64_t)along * STIFFNESS_N_m) >> 8) + taper;
    int64_t excess = pull > holds ? pull - holds : (pull < -(int64_t)holds ? pull + holds : 0);
    /* Q22 N / (N/m) -> Q30 m */
    int32_t slipped = crn_clamp(crn_scale_q30(crn_sat32(excess), BY_STIFFNESS_Q30), -SLIP_M_Q30, SLIP_M_Q30);
    for (int k = 0; k < 3; k++) {
        ball->centre_m_q30.v[k] += crn_scale_q30(slipped, at->along_q30.v[k]);
    }
    if (model->tool_count > 1) {
        int32_t *axial = &state->scratch.axial_N_q22[model->balloon.tool];
        int64_t drag = -(((int64_t)(along - slipped) * STIFFNESS_N_m) >> 8);
        *axial = crn_add_sat(*axial, crn_sat32(drag));
    }
}

void crn_balloon_finish(const crn_model *model, crn_state *state, crn_output *output)
{
    const crn_balloon_state *words = &state->words.balloon;
    uint32_t node = 0;
    int64_t sum = 0;
    output->balloon_bits = words->bits;
    output->balloon_Pa = words->pressure_Pa;
    output->balloon_radius_max_m_q30 = 0;
    output->balloon_radius_min_m_q30 = 0;
    for (uint32_t j = 0; j < model->balloon.ball_count; j++) {
        place at = place_of(model, state, j, node);
        node = at.node;
        if (is_tied(model, state, j, &at)) {
            slip(model, state, j, &at);
        }
        int32_t radius = radius_of(model, &words->balls[j]);
        bool is_first = j == 0;
        output->balloon_radius_max_m_q30 =
            is_first || radius > output->balloon_radius_max_m_q30 ? radius : output->balloon_radius_max_m_q30;
        output->balloon_radius_min_m_q30 =
            is_first || radius < output->balloon_radius_min_m_q30 ? radius : output->balloon_radius_min_m_q30;
        sum += words->balls[j].wall_N_q22;
    }
    output->balloon_wall_N_q22 = crn_sat32(sum);
}

uint32_t crn_state_balloon(const crn_model *model, const crn_state *state,
                           int32_t radii_m_q30[CRN_BALLOON_BALL_MAX], int32_t *arc_m_q30,
                           int32_t *spacing_m_q30)
{
    const crn_balloon_model *balloon = &model->balloon;
    *arc_m_q30 =
        balloon->ball_count > 0 ? state->line.offset_m_q30[balloon->tool] + balloon->distal_m_q30 : 0;
    *spacing_m_q30 = balloon->spacing_m_q30;
    for (uint32_t j = 0; j < balloon->ball_count; j++) {
        radii_m_q30[j] = radius_of(model, &state->words.balloon.balls[j]);
    }
    return balloon->ball_count;
}

/* --- a restored state ----------------------------------------------------------------------------------- */

bool crn_balloon_is_valid(uint32_t ball_count, const crn_balloon_state *balloon)
{
    const int32_t radius_max_m_q30 = 1 << 24;
    if (balloon->bits > CRN_BALLOON_BURST || balloon->pressure_Pa < 0 ||
        balloon->pressure_Pa > CRN_PRESSURE_MAX_Pa) {
        return false;
    }
    if (((balloon->confined_bits[0] | balloon->confined_bits[1]) >> ball_count) != 0) {
        return false;
    }
    if (ball_count == 0 && (balloon->bits != 0 || balloon->pressure_Pa != 0)) {
        return false;
    }
    for (uint32_t j = 0; j < CRN_BALLOON_BALL_MAX; j++) {
        const crn_balloon_ball *ball = &balloon->balls[j];
        int32_t most = j < ball_count ? INT32_MAX : 0;
        bool fits = ball->radius_m_q30 >= 0 &&
                    ball->radius_m_q30 <= (most > radius_max_m_q30 ? radius_max_m_q30 : most) &&
                    ball->wall_N_q22 >= 0 &&
                    ball->wall_N_q22 <= (most > BALL_MAX_N_Q22 ? BALL_MAX_N_Q22 : most);
        for (int k = 0; k < 3; k++) {
            int32_t place_max = most > CRN_POSITION_MAX_M_Q30 ? CRN_POSITION_MAX_M_Q30 : most;
            fits = fits && ball->centre_m_q30.v[k] <= place_max && ball->centre_m_q30.v[k] >= -place_max;
        }
        if (!fits) {
            return false;
        }
    }
    return true;
}
