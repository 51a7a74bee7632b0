/* This file initialises, saves, restores, hashes and reads the core's state, which consists of 32-bit words.
 *
 * Nodes with numbers above free_count + 2 are inside the introducer sheath, and their values follow from the
 * other words of the state. The values of the nodes inside the introducer sheath are zero in a saved state
 * and are not hashed. */
#include "firmware/core/balloon.h"
#include "firmware/core/lesion.h"

enum {
    HEADER_WORDS = offsetof(crn_state_words, nodes) / 4,
    RINGS_WORD = offsetof(crn_state_words, struts.rings) / 4,
    RING_WORDS = sizeof(crn_strut_ring) / 4,
    EXCHANGE_WORD = offsetof(crn_state_words, exchange) / 4,
    EXCHANGE_WORDS = sizeof(crn_exchange_state) / 4,
    SET_WORD = offsetof(crn_state_words, set) / 4,
    SET_WORDS = sizeof(crn_set_state) / 4,
    WALL_WORD = offsetof(crn_state_words, wall) / 4,
    GIVE_WORDS = sizeof(crn_wall_give) / 4,
    NODE_WORDS = sizeof(crn_node_state) / 4,
    STATE_WORDS = sizeof(crn_state_words) / 4,
    INSIDE_KEPT = 3,
};
_Static_assert(sizeof(crn_state_words) == 4 * (HEADER_WORDS + (size_t)NODE_WORDS * CRN_ARRAY_NODES),
               "the state is 32-bit words without padding");

size_t crn_model_size(void)
{
    return sizeof(crn_model);
}

size_t crn_state_size(void)
{
    return sizeof(crn_state);
}

size_t crn_state_bytes(void)
{
    return sizeof(crn_state_words);
}

static size_t live_words(const crn_state_words *words)
{
    return HEADER_WORDS + (size_t)NODE_WORDS * (words->free_count + INSIDE_KEPT);
}

static int32_t inserted_q30(uint32_t um)
{
    uint32_t bounded_um = um > 1900000u ? 1900000u : um;
    return (int32_t)crn_divide_u64((uint64_t)bounded_um << 30, 1000000u);
}

/* Sets the inserted lengths of the tools; each length is limited by its tool, and the longest is at least the
 * minimum of the simulation. */
static void place_tools(const crn_model *model, crn_state_words *words, const uint32_t *inserted_um)
{
    const int32_t least = crn_least_inserted(model);
    uint32_t longest = 0;
    for (uint32_t k = 0; k < model->tool_count; k++) {
        int32_t inserted = inserted_q30(inserted_um[k]);
        int32_t most = crn_tool_on(model, k)->inserted_max_m_q30;
        words->exchange.line[k] = model->line[k];
        words->tools[k].inserted_m_q30 = inserted > most ? most : inserted;
        if (model->line[k] == 0) {
            words->tools[k].inserted_m_q30 = CRN_WITHDRAWN_M_Q30;
        }
        longest = words->tools[k].inserted_m_q30 > words->tools[longest].inserted_m_q30 ? k : longest;
    }
    if (words->tools[longest].inserted_m_q30 < least) {
        words->tools[longest].inserted_m_q30 = least;
    }
    for (uint32_t k = 0; k < model->tool_count; k++) {
        words->tools[k].hand_offset_m_q30 = words->tools[k].inserted_m_q30;
    }
}

void crn_state_init(const crn_model *model, crn_state *state, const uint32_t *inserted_um)
{
    unsigned char *bytes = (unsigned char *)state;
    for (size_t i = 0; i < sizeof *state; i++) {
        bytes[i] = 0;
    }
    crn_state_words *words = &state->words;
    crn_rhythm_init(&words->rhythm);
    place_tools(model, words, inserted_um);
    words->line_compliance_m_N_q40 = UINT32_MAX; /* nothing seen yet: the compliance of the whole line */
    int32_t inserted = crn_lead_inserted(model, words);
    while (model->mesh[words->free_count].arc_m_q30 < inserted) {
        words->free_count++;
    }
    for (uint32_t i = 0; i < words->free_count + INSIDE_KEPT; i++) {
        crn_node_state *node = &words->nodes[i];
        int32_t beyond = inserted - model->mesh[i].arc_m_q30;
        for (int k = 0; k < 3; k++) {
            int32_t direction = model->entry.direction_q30.v[k];
            int32_t position = crn_add_sat(model->entry.position_m_q30.v[k], crn_mul_q30(beyond, direction));
            node->position_m_q30.v[k] = crn_clamp(position, -CRN_POSITION_MAX_M_Q30, CRN_POSITION_MAX_M_Q30);
            node->tangent_q30.v[k] = -direction;
        }
    }
    crn_line_update(model, state);
}

void crn_state_save(const crn_state *state, uint8_t *bytes)
{
    const uint32_t *words = (const uint32_t *)&state->words;
    size_t live = live_words(&state->words);
    for (size_t i = 0; i < STATE_WORDS; i++) {
        uint32_t word = i < live ? words[i] : 0;
        for (int k = 0; k < 4; k++) {
            bytes[4 * i + (size_t)k] = (uint8_t)(word >> (8 * k));
        }
    }
}

static uint32_t word_at(const uint8_t *bytes, size_t i)
{
    const uint8_t *b = bytes + 4 * i;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* --- checks of a restored state ------------------------------------------------------------------------- */

/* Checks the length of a tangent against the bounds that a tick keeps. For an edge whose |w|^2 is 1 + 2e, a
 * tick computes the tangent w p(e), where p is the series of 1 / sqrt(1 + 2e) up to e^3 (rod_force.c). For
 * |e| <= 1/8, the square of the tangent's length is (1 + 2e) p(e)^2, which is at most 1 and at least 1
 * - 2.39e-3 (at e = -1/8). For |e| > 1/8, a root makes the tangent a unit vector to 1e-8. Inside the sheath,
 * the tangent is the direction of insertion, the square of whose length may differ from 1 by 2^-19
 * (core_check.c). A shorter tangent than these cannot break a bound of a tick, because each tick computes the
 * tangents anew before it uses them in a product that must not overflow. */
static bool is_tangent(const crn_vec3 *a)
{
    for (int k = 0; k < 3; k++) {
        if (a->v[k] > CRN_ONE_Q30 + (1 << 20) || a->v[k] < -CRN_ONE_Q30 - (1 << 20)) {
            return false;
        }
    }
    const int64_t longer_q60 = (int64_t)1 << 42, shorter_q60 = (int64_t)5 << 49; /* 2^-18 and 2.44e-3 */
    int64_t error_q60 = crn_vec3_dot64(*a, *a) - ((int64_t)1 << 60);
    return error_q60 <= longer_q60 && error_q60 >= -shorter_q60;
}

static bool is_small(const crn_vec3 *a, int32_t most)
{
    for (int k = 0; k < 3; k++) {
        if (a->v[k] > most || a->v[k] < -most) {
            return false;
        }
    }
    return true;
}

static bool within(int32_t value, int32_t most)
{
    return value >= -most && value <= most;
}

/* Checks that the values of a node stay within the bounds that the arithmetic of a tick guarantees. A tick
 * moves a node by at most 3.1 mm, and the check allows 3.9 mm. The check allows a friction displacement
 * (bristle) of 62 mm, and a turn of a tool by half a radian per tick. */
static bool node_is_valid(const crn_node_state *node)
{
    enum { STEP_MAX_M_Q33 = 1 << 25, BRISTLE_MAX_M_Q33 = 1 << 29, TURN_MAX_Q30 = 1 << 29 };
    bool turns = true;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        turns = turns && within(node->spin_q30[k], TURN_MAX_Q30);
    }
    return turns && is_tangent(&node->tangent_q30) && is_small(&node->step_m_q33, STEP_MAX_M_Q33) &&
           is_small(&node->bristle_m_q33, BRISTLE_MAX_M_Q33) &&
           is_small(&node->position_m_q30, CRN_POSITION_MAX_M_Q30) && node->contact <= CRN_CONTACT_CREEPS;
}

/* No edge may be longer than twice its unstretched length, because the computation of a tick never produces a
 * longer edge. */
static bool edge_is_valid(const crn_model *model, const crn_node_state *node, uint32_t i)
{
    const int64_t most = 2 * (int64_t)model->mesh[i].length_m_q30; /* below 2^25 */
    int64_t square = 0;
    for (int k = 0; k < 3; k++) {
        int64_t apart = (int64_t)node[1].position_m_q30.v[k] - node->position_m_q30.v[k];
        if (apart > most || apart < -most) {
            return false;
        }
        square += apart * apart;
    }
    return square <= most * most;
}

/* Nodes in the introducer sheath must lie on the sheath's axis, where place_inside() of rod_feed.c puts them.
 * A node in the introducer sheath may lie off the sheath's axis only by a rounding error of the last tick. */
static bool held_is_valid(const crn_model *model, const crn_node_state *node, int32_t beyond_m_q30)
{
    enum { ROUNDING = 16 };
    for (int k = 0; k < 3; k++) {
        int64_t there = (int64_t)model->entry.position_m_q30.v[k] +
                        crn_mul_q30(beyond_m_q30, model->entry.direction_q30.v[k]);
        int64_t miss = node->position_m_q30.v[k] - there;
        if (miss > ROUNDING || miss < -ROUNDING) {
            return false;
        }
    }
    return true;
}

static bool tools_are_valid(const crn_model *model, const crn_state_words *words)
{
    const crn_tool_state none = {0, 0, 0, 0, 0, 0, 0};
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_tool_state *tool = &words->tools[k];
        if (k >= model->tool_count) {
            if (tool->inserted_m_q30 != none.inserted_m_q30 || tool->hand_offset_m_q30 != 0 ||
                tool->base_turn32 != 0 || tool->handle_axial_N_q22 != 0 || tool->slide_grip_m_q33 != 0 ||
                tool->slide_share_q30 != 0 || tool->tip_axial_N_q22 != 0) {
                return false;
            }
        } else if (tool->inserted_m_q30 < CRN_WITHDRAWN_M_Q30 ||
                   tool->inserted_m_q30 > crn_exchange_inserted_max(model, words, k) ||
                   tool->slide_share_q30 > CRN_ONE_Q30 || tool->slide_share_q30 < -CRN_ONE_Q30 ||
                   tool->tip_axial_N_q22 > CRN_TENSION_MAX_N_Q22 ||
                   tool->tip_axial_N_q22 < -CRN_TENSION_MAX_N_Q22) {
            return false;
        }
    }
    return true;
}

static bool words_are_valid(const crn_model *model, const crn_state_words *words)
{
    uint32_t na = words->free_count;
    if (na < 4 || na + INSIDE_KEPT > model->node_count || !crn_exchange_is_valid(model, words) ||
        !crn_set_is_valid(model, words) || !crn_wall_is_valid(model, &words->wall) ||
        !tools_are_valid(model, words) || !crn_rhythm_is_valid(&words->rhythm) ||
        !crn_balloon_is_valid(crn_exchange_balls(model, words), &words->balloon) ||
        !crn_lesion_is_valid(model->lumen, &words->lesions) || !crn_struts_are_valid(&words->struts)) {
        return false;
    }
    int32_t inserted = crn_lead_inserted(model, words);
    if (model->mesh[na - 1].arc_m_q30 >= inserted || model->mesh[na].arc_m_q30 < inserted) {
        return false;
    }
    if (words->has_missed > 1 || words->release_q30 < 0 || words->release_q30 > CRN_ONE_Q30 ||
        words->release_q30 % CRN_RELEASE_STEP_Q30 != 0) {
        return false;
    }
    for (uint32_t i = 0; i < na + INSIDE_KEPT; i++) {
        if (!node_is_valid(&words->nodes[i])) {
            return false;
        }
        if (i + 1 < na + INSIDE_KEPT && !edge_is_valid(model, &words->nodes[i], i)) {
            return false;
        }
        if (i >= na && !held_is_valid(model, &words->nodes[i], inserted - model->mesh[i].arc_m_q30)) {
            return false;
        }
    }
    const uint32_t *all = (const uint32_t *)words;
    for (size_t i = live_words(words); i < STATE_WORDS; i++) {
        if (all[i] != 0) {
            return false; /* nodes in the inserter follow from the other words */
        }
    }
    return true;
}

bool crn_state_restore(crn_model *model, crn_state *state, const uint8_t *bytes)
{
    crn_state_words *copy = &state->scratch.incoming; /* the scratch is dead between ticks */
    uint32_t *copied = (uint32_t *)copy;
    for (size_t i = 0; i < STATE_WORDS; i++) {
        copied[i] = word_at(bytes, i);
    }
    if (!words_are_valid(model, copy)) {
        return false;
    }
    state->words = *copy;
    for (uint32_t i = 0; i < CRN_ARRAY_NODES; i++) {
        state->voxels[i].number_and_depth = 0;
    }
    crn_exchange_take_line(model, &state->words);
    state->line.count = 0;
    crn_line_update(model, state);
    return true;
}

/* --- hashes --------------------------------------------------------------------------------------------- */

/* Names the ranges of the state's words over which a hash is computed. Strut rings that do not exist are left
 * out of the hash, and their words are 0 (`used` gives the number of rings). The numbers of the nested tools
 * are part of the hash only after the first exchange of tools, and the ways of the walls only while a wall is
 * displaced. */
typedef struct hashed_range {
    size_t first, end;
} hashed_range;

enum { RANGES = 5 };

static void hashed_words(const crn_state_words *words, hashed_range ranges[RANGES])
{
    const size_t exchanged = words->exchange.count != 0 ? EXCHANGE_WORDS : 0;
    ranges[0] = (hashed_range){0, RINGS_WORD + (size_t)RING_WORDS * words->struts.used};
    ranges[1] = (hashed_range){EXCHANGE_WORD, EXCHANGE_WORD + exchanged};
    ranges[2] = (hashed_range){SET_WORD, SET_WORD + (words->set.used_bits != 0 ? (size_t)SET_WORDS : 0)};
    ranges[3] = (hashed_range){
        WALL_WORD, WALL_WORD + (words->wall.used != 0 ? 1 + (size_t)GIVE_WORDS * words->wall.used : 0)};
    ranges[4] = (hashed_range){HEADER_WORDS, live_words(words)};
}

/* The hash lanes are two 32-bit polynomials, one over the even words and one over the odd words: the sum of
 * word[i] m^(n-i) with the odd FNV prime m. The polynomials over the even and the odd words cost two
 * operations per word and are computed in every tick. Each step of the hash is a one-to-one function of the
 * running sum and of the word, so a single wrong word is always detected. */
enum { ABREAST = 16 }; /* words of a block that has a sum of its own for each word */
typedef uint32_t four_sums __attribute__((vector_size(16)));

/* Adds all whole blocks of words to the two polynomials, and returns the number of words added. Two running
 * sums would wait for each product. Sixteen sums, each over every 16th word with the prime m^8, do not wait
 * for each other, and a vector instruction computes several of them. */
static inline size_t add_blocks(const uint32_t *words, size_t count, uint32_t lane[2])
{
    const uint32_t prime = 16777619u, to_2 = prime * prime, to_4 = to_2 * to_2, to_8 = to_4 * to_4;
    four_sums a = {0}, b = {0}, c = {0}, d = {0, 0, lane[0], lane[1]};
    size_t i = 0;
    for (; i + ABREAST <= count; i += ABREAST) {
        four_sums next[4];
        __builtin_memcpy(next, words + i, sizeof next);
        a = a * to_8 + next[0];
        b = b * to_8 + next[1];
        c = c * to_8 + next[2];
        d = d * to_8 + next[3];
    }
    if (i > 0) {
        const four_sums sums[4] = {a, b, c, d};
        lane[0] = lane[1] = 0;
        for (size_t k = 0; k < ABREAST; k += 2) {
            lane[0] = lane[0] * prime + sums[k / 4][k % 4];
            lane[1] = lane[1] * prime + sums[k / 4][k % 4 + 1];
        }
    }
    return i;
}

#if CRN_HIGH_WORDS_BY_DSP
/* Adds four words to the two polynomials. One instruction reads all of them. */
static inline const uint32_t *add_four(const uint32_t *words, uint32_t prime, uint32_t *even, uint32_t *odd)
{
    __asm__("ldm %0!, {r4, r5, r6, r8}\n mla %1, %1, %3, r4\n mla %2, %2, %3, r5\n"
            "mla %1, %1, %3, r6\n mla %2, %2, %3, r8"
            : "+&r"(words), "+&r"(*even), "+&r"(*odd)
            : "r"(prime)
            : "r4", "r5", "r6", "r8", "memory");
    return words;
}
#else
static inline const uint32_t *add_four(const uint32_t *words, uint32_t prime, uint32_t *even, uint32_t *odd)
{
    *even = (*even * prime + words[0]) * prime + words[2];
    *odd = (*odd * prime + words[1]) * prime + words[3];
    return words + 4;
}
#endif

static inline void add_to_lanes(const uint32_t *words, size_t count, uint32_t lane[2])
{
    /* A Cortex-M7 has too few registers for so many sums. */
    const uint32_t prime = 16777619u;
    const size_t begin = sizeof(void *) > 4 ? add_blocks(words, count, lane) : 0;
    const uint32_t *at = words + begin, *end = words + count;
    uint32_t even = lane[0], odd = lane[1];
    for (size_t left = (count - begin) / 8; left > 0; left--) {
        at = add_four(at, prime, &even, &odd);
        at = add_four(at, prime, &even, &odd);
    }
    while (at < end) {
        even = even * prime + *at++;
    }
    lane[0] = even;
    lane[1] = odd;
}

void crn_state_hash_lanes(const crn_state *state, uint32_t lane[2])
{
    const uint32_t *words = (const uint32_t *)&state->words;
    hashed_range ranges[RANGES];
    hashed_words(&state->words, ranges);
    uint32_t sums[2] = {2166136261u, 3405691582u};
    add_to_lanes(words, ranges[0].end, sums);
    for (int r = 1; r < RANGES; r++) {
        if (ranges[r].end > ranges[r].first) {
            add_to_lanes(words + ranges[r].first, ranges[r].end - ranges[r].first, sums);
        }
    }
    lane[0] = sums[0] ^ (sums[0] >> 15);
    lane[1] = sums[1] ^ (sums[1] >> 15);
}

/* Requirement: SR-23 */
uint64_t crn_state_hash64(const crn_state *state)
{
    const uint64_t prime = 1099511628211u,
                   prime_to_4 = prime * prime * prime * prime; /* modulo 2^64, as defined */
    const uint32_t *words = (const uint32_t *)&state->words;
    hashed_range ranges[RANGES];
    hashed_words(&state->words, ranges);
    uint64_t hash = 14695981039346656037u;
    for (int r = 0; r < RANGES; r++) {
        for (size_t i = ranges[r].first; i < ranges[r].end; i++) {
            if (words[i] == 0) { /* common: bristles without contact, absent tools */
                hash *= prime_to_4;
                continue;
            }
            for (int k = 0; k < 4; k++) {
                hash = (hash ^ ((words[i] >> (8 * k)) & 255u)) * prime;
            }
        }
    }
    return hash;
}

/* --- reading -------------------------------------------------------------------------------------------- */

uint32_t crn_model_tool_count(const crn_model *model)
{
    return model->tool_count;
}

uint32_t crn_state_tool_at(const crn_state *state, uint32_t position)
{
    return position < CRN_TOOL_MAX ? state->words.exchange.line[position] : 0;
}

uint32_t crn_state_node_count(const crn_model *model)
{
    return model->node_count;
}

uint32_t crn_state_free_count(const crn_state *state)
{
    return state->words.free_count;
}

crn_vec3 crn_state_position(const crn_state *state, uint32_t node)
{
    return state->words.nodes[node].position_m_q30;
}

int32_t crn_model_edge_length(const crn_model *model, uint32_t edge)
{
    return model->mesh[edge].length_m_q30;
}

int32_t crn_model_arc(const crn_model *model, uint32_t node)
{
    return model->mesh[node].arc_m_q30;
}

int32_t crn_state_radius(const crn_state *state, uint32_t node)
{
    return state->line.nodes[node].radius_m_q30;
}

int32_t crn_state_inserted(const crn_state *state, uint32_t tool)
{
    return state->words.tools[tool].inserted_m_q30;
}

int32_t crn_state_depth(const crn_model *model, const crn_state *state)
{
    int32_t deepest = INT32_MIN;
    for (uint32_t i = 0; model->lumen != NULL && i < state->words.free_count; i++) {
        const crn_lumen_sample wall = crn_wall_sample_at_node(model, state, i);
        int32_t depth = crn_add_sat(wall.distance_m_q30, state->line.nodes[i].radius_m_q30);
        deepest = depth > deepest ? depth : deepest;
    }
    return deepest;
}

uint32_t crn_state_tick(const crn_state *state)
{
    return state->words.tick;
}

const crn_rhythm *crn_state_rhythm(const crn_state *state)
{
    return &state->words.rhythm;
}
