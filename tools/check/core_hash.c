/* Runs the simulation core through the scenes of core_scenes.c and prints hashes of the core's state. The
 * program must print the same lines with every compiler, optimisation level and machine
 * (tools/check/tests/test_compilers.sh, tools/check/matrix.py). To show where the results of two machines
 * begin to differ, the program can also print a hash per tick and subsystem, or every word of the state in
 * one tick.
 *
 * The program is freestanding and has static memory only, so it runs on a Cortex-M7 without an operating
 * system as well as on a PC. */
#include "firmware/core/rod_block.h"
#include "tools/check/console.h"
#include "tools/check/core_scenes.h"

enum { TICKS_PER_LINE = 500, NONE = 0x7fffffff };

static crn_model model;
static crn_state state;

/* --- what of the state belongs to which part of a tick, in the order of core_step.c
 * --------------------------------- */

typedef struct part {
    const char *name;
    size_t offset; /* of a member of crn_node_state or crn_work */
    uint32_t words;
    bool in_scratch;
} part;

#define OF_STATE(name, member)                                                                               \
    {                                                                                                        \
        name, offsetof(crn_node_state, member), sizeof(((crn_node_state *)0)->member) / 4, false             \
    }
#define OF_WORK(name, member)                                                                                \
    {                                                                                                        \
        name, offsetof(crn_work, member), sizeof(((crn_work *)0)->member) / 4, true                          \
    }
static const part parts[] = {
    OF_WORK("feed", position_m_q30),    OF_WORK("stretch", strain_q30),      OF_WORK("twist", torque_N_m_q30),
    OF_WORK("contact", touching),       OF_WORK("contact", depth_m_q30),     OF_WORK("force", force_N_q22),
    OF_WORK("solve", u.f.w_q29),        OF_WORK("solve", solution_m_q33),    OF_STATE("angle", angle_turn32),
    OF_STATE("friction", contact),      OF_STATE("friction", bristle_m_q33), OF_STATE("motion", step_m_q33),
    OF_STATE("motion", position_m_q30),
};
enum { PART_COUNT = sizeof parts / sizeof parts[0] };

static uint32_t *words_of(const part *p, uint32_t node)
{
    unsigned char *base = p->in_scratch ? (unsigned char *)&state.scratch.nodes[node]
                                        : (unsigned char *)&state.words.nodes[node];
    return (uint32_t *)(base + p->offset);
}

static bool same(const char *a, const char *b)
{
    while (*a != '\0' && *a == *b) a++, b++;
    return *a == *b;
}

/* Returns the FNV-1a hash of one part of the state (such as twist or friction) over all free nodes. */
static uint32_t hash_part(const part *p, uint32_t hash)
{
    for (uint32_t i = 0; i < state.words.free_count; i++) {
        const uint32_t *words = words_of(p, i);
        for (uint32_t k = 0; k < p->words; k++) hash = (hash ^ words[k]) * 16777619u;
    }
    return hash;
}

/* --- text
 * -------------------------------------------------------------------------------------------------------- */

static void write_hex(uint64_t value, int digits)
{
    char text[17];
    for (int i = 0; i < digits; i++) text[i] = "0123456789abcdef"[value >> (4 * (digits - 1 - i)) & 15u];
    text[digits] = '\0';
    console_write(text);
}

static void write_decimal(int32_t value)
{
    char text[12];
    int at = 11;
    uint32_t rest = value < 0 ? 0u - (uint32_t)value : (uint32_t)value;
    text[at] = '\0';
    do {
        text[--at] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest != 0);
    if (value < 0) text[--at] = '-';
    console_write(&text[at]);
}

static void write_field(const char *name, int32_t value)
{
    console_write(name);
    write_decimal(value);
}

/* Writes one line of text per tick, in the form `trace SCENE TICK feed=HASH stretch=HASH ...`. */
static void write_trace(const core_scene *scene, uint32_t tick)
{
    console_write("trace ");
    console_write(scene->name);
    write_field(" ", (int32_t)tick);
    for (uint32_t p = 0; p < PART_COUNT; p++) {
        uint32_t hash = hash_part(&parts[p], 2166136261u);
        while (p + 1 < PART_COUNT && same(parts[p].name, parts[p + 1].name))
            hash = hash_part(&parts[++p], hash);
        console_write(" ");
        console_write(parts[p].name);
        console_write("=");
        write_hex(hash, 8);
    }
    console_write("\n");
}

/* Writes one line of text per node and part of the state, in the form `node SCENE TICK PART NODE WORDS`. */
static void write_nodes(const core_scene *scene, uint32_t tick)
{
    for (uint32_t p = 0; p < PART_COUNT; p++) {
        for (uint32_t i = 0; i < state.words.free_count; i++) {
            console_write("node ");
            console_write(scene->name);
            write_field(" ", (int32_t)tick);
            console_write(" ");
            console_write(parts[p].name);
            write_field(" ", (int32_t)i);
            for (uint32_t k = 0; k < parts[p].words; k++) {
                console_write(" ");
                write_hex(words_of(&parts[p], i)[k], 8);
            }
            console_write("\n");
        }
    }
}

static void write_hash(const core_scene *scene, const crn_output *output)
{
    console_write(scene->name);
    write_field(" tick ", (int32_t)output->tick);
    console_write(" hash ");
    write_hex(crn_state_hash64(&state), 16);
    console_write(" lanes ");
    write_hex(output->hash_lane[0], 8);
    console_write(" ");
    write_hex(output->hash_lane[1], 8);
    console_write("\n");
}

/* --- random rows of the matrix --- */

enum { ROWS = 4000 };

/* Returns a random number below 2^bits in magnitude, by the generator of Knuth's MMIX. */
static int32_t random_below(uint64_t *random, uint32_t bits)
{
    *random = *random * 6364136223846793005u + 1442695040888963407u;
    const int32_t size = (int32_t)(*random >> 33) % ((int32_t)1 << bits);
    return *random >> 32 & 1 ? size : -size;
}

static void fill(uint64_t *random, uint32_t bits, int32_t *numbers, int count)
{
    for (int k = 0; k < count; k++) numbers[k] = random_below(random, bits);
}

/* Makes what a row receives. Its diagonal block is positive definite, with entries of 2^(27 - small). Every
 * fourth row has forces up to their limit. */
static void make_row(uint64_t *random, uint32_t small, crn_factor *last, crn_row *row)
{
    const uint32_t force_bits = *random >> 40 & 3 ? 26 : 30;
    fill(random, 29, last->w_q29, 9);
    fill(random, force_bits, row->r, 3);
    fill(random, force_bits, row->r_before, 3);
    fill(random, 23 - small, row->t, 9);
    fill(random, 24 - small, row->rest.m, 6);
    for (int k = 0; k < 9; k++) row->v_q29[k] = last->w_q29[3 * (k % 3) + k / 3];
    for (int k = 0; k < 6; k += k == 0 ? 3 : 2) row->rest.m[k] += 1 << (27 - small);
    row->second = random_below(random, 22 - small);
    row->second_before = random_below(random, 22 - small);
    row->diagonal = random_below(random, 22 - small);
    row->minus_second8 = -8 * random_below(random, 20 - small);
    row->geometric = 1 << (23 - small);
    row->spring4 = 1 << (29 - small);
    row->force_exponent = 11 + small % 14;
}

/* Makes the wall of every second row; some walls are not round. */
static void make_wall(uint64_t *random, uint32_t small, crn_work *wall)
{
    fill(random, 30, wall->normal_q30.v, 3);
    fill(random, 30, wall->around_q30.v, 3);
    wall->wall_normal = 1 << (23 - small);
    wall->wall_friction = 1 << (22 - small);
    wall->wall_round = (*random >> 40 & 3) != 0 ? 1 << (22 - small) : 0;
    wall->touching = *random >> 42 & 1;
}

static uint32_t hash_words(uint32_t hash, const int32_t *words, int count)
{
    for (int k = 0; k < count; k++) hash = (hash ^ (uint32_t)words[k]) * 16777619u;
    return hash;
}

/* Substitutes back through random blocks, many of which give sums beyond every limit. Returns a hash of the
 * results. */
static uint32_t hash_substituted(uint64_t *random, uint32_t hash)
{
    state.words.free_count = CRN_NODE_MAX - 4;
    for (uint32_t i = 0; i < state.words.free_count; i++) {
        crn_work *work = &state.scratch.nodes[i];
        const uint32_t bits = 22 + i % 9;
        fill(random, bits, work->u.f.w_q29, 9);
        fill(random, bits < 29 ? bits : 29, work->u.f.p_q29.m, 6);
        fill(random, i % 3 == 0 ? 20 : 29, work->solution_m_q33.v, 3);
    }
    crn_rod_substitute(&state);
    for (uint32_t i = 0; i < state.words.free_count; i++)
        hash = hash_words(hash, state.scratch.nodes[i].solution_m_q33.v, 3);
    return hash;
}

/* Eliminates random rows, which differ from those of a wire, and writes a hash of all results. On a
 * Cortex-M7, this compares the assembly of the elimination with its C code on the other machines. */
static void write_rows(void)
{
    uint64_t random = 1;
    uint32_t hash = 2166136261u;
    int32_t limited = 0;
    for (uint32_t i = 0; i < ROWS; i++) {
        crn_factor last, factor;
        crn_vec3 tangent, force, solution;
        crn_row row = {.factor = &factor,
                       .last = &last,
                       .p_before = &last.p_q29,
                       .tangent_q30 = &tangent,
                       .force_N_q22 = &force,
                       .solution_m_q33 = &solution};
        fill(&random, 30, tangent.v, 3);
        fill(&random, 27, force.v, 3);
        fill(&random, 29, last.p_q29.m, 6);
        make_row(&random, i % 20, &last, &row);
        static crn_work wall;
        if (i & 1) {
            make_wall(&random, i % 20, &wall);
            row.wall = &wall;
        }
        crn_row_factor(&row);
        limited += crn_row_force(&row);
        hash = hash_words(hash, row.rest.m, 6);
        hash = hash_words(hash, row.t, 9);
        hash = hash_words(hash, row.v_q29, 9);
        hash = hash_words(hash, row.inverse, 6);
        hash = hash_words(hash, (const int32_t *)&row.exponent, 1);
        hash = hash_words(hash, row.r, 3);
        hash = hash_words(hash, row.r_before, 3);
        hash = hash_words(hash, solution.v, 3);
        hash = hash_words(hash, factor.w_q29, 9);
        hash = hash_words(hash, factor.p_q29.m, 6);
    }
    for (int i = 0; i < 20; i++) hash = hash_substituted(&random, hash);
    write_field("rows ", ROWS);
    write_field(" limited ", limited);
    console_write(" hash ");
    write_hex(hash, 8);
    console_write("\n");
}

/* --- the program
 * --------------------------------------------------------------------------------------------------- */

typedef struct options {
    bool trace;
    uint32_t variant, nodes_tick, flip_tick, flip_node;
    const char *flip_part, *scene; /* NULL: every scene */
} options;

/* Flips the lowest bit of one word of the state, as a faulty machine might do, and also the lowest bit of the
 * node position that depends on that word. */
static void flip(const options *o, uint32_t tick)
{
    for (uint32_t p = 0; p < PART_COUNT && tick == o->flip_tick; p++) {
        if (same(parts[p].name, o->flip_part)) {
            *words_of(&parts[p], o->flip_node) ^= 1u;
            state.words.nodes[o->flip_node].position_m_q30.v[0] ^= 16;
            return;
        }
    }
}

static bool run(uint32_t scene, const options *o)
{
    const core_scene *s = &core_scenes[scene];
    if (!core_scene_start(scene, &model, &state)) {
        console_write("core_hash: the core refuses a scene\n");
        return false;
    }
    uint32_t contacts = 0, solved_twice = 0, faults = 0;
    for (uint32_t tick = 1; tick <= s->ticks; tick++) {
        crn_output output = {0};
        crn_input input = core_scene_hand(scene, tick, o->variant);
        crn_step(&model, &state, &input, &output);
        flip(o, tick);
        contacts = output.contact_count > contacts ? output.contact_count : contacts;
        solved_twice += output.solve_count - 1u;
        faults = output.fault_bits;
        if (o->trace) write_trace(s, tick);
        if (tick == o->nodes_tick) write_nodes(s, tick);
        if (!o->trace && o->nodes_tick == NONE && tick % TICKS_PER_LINE == 0) write_hash(s, &output);
    }
    console_write(s->name);
    write_field(" contacts_max ", (int32_t)contacts);
    write_field(" solved_twice ", (int32_t)solved_twice);
    write_field(" faults ", (int32_t)faults);
    console_write("\n");
    return true;
}

static uint32_t number(const char *text)
{
    uint32_t value = 0;
    while (*text >= '0' && *text <= '9') value = value * 10 + (uint32_t)(*text++ - '0');
    return value;
}

static bool read_options(int argc, char **argv, options *o)
{
    int i = 1;
    while (i < argc) {
        int left = argc - i;
        if (same(argv[i], "trace")) {
            o->trace = true;
            i += 1;
        } else if (same(argv[i], "scene") && left >= 2) {
            o->scene = argv[i + 1];
            i += 2;
        } else if (same(argv[i], "nodes") && left >= 2) {
            o->nodes_tick = number(argv[i + 1]);
            i += 2;
        } else if (same(argv[i], "variant") && left >= 2) {
            o->variant = number(argv[i + 1]);
            i += 2;
        } else if (same(argv[i], "flip") && left >= 4) {
            o->flip_tick = number(argv[i + 1]);
            o->flip_part = argv[i + 2];
            o->flip_node = number(argv[i + 3]);
            i += 4;
        } else {
            return false;
        }
    }
    return o->flip_node < CRN_NODE_MAX;
}

int main(int argc, char **argv)
{
    options o = {.nodes_tick = NONE, .flip_tick = NONE};
    if (!read_options(argc, argv, &o)) {
        console_write(
            "usage: core_hash [scene NAME] [trace] [nodes TICK] [variant N] [flip TICK PART NODE]\n");
        return 2;
    }
    for (uint32_t scene = 0; scene < CORE_SCENE_COUNT; scene++) {
        bool wanted = o.scene == NULL || same(o.scene, core_scenes[scene].name);
        if (wanted && !run(scene, &o)) return 1;
    }
    if (o.scene == NULL && !o.trace && o.nodes_tick == NONE) write_rows();
    return 0;
}
