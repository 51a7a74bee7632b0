/* Defines the simulated scenes that core_hash.c runs; core_scenes.h states their purpose.
 *
 * In the scene "tube" a J wire enters a square tube, 8 mm wide and 120 mm long. The wire touches the walls,
 * is turned, is pushed against the end wall until it buckles, and is pulled back.
 *
 *      entry -> ================================|   y = 120 mm
 *               8 mm                            |
 *               ================================|
 *
 * In the scene "fine" a stiff uniform wire is pushed, pulled and turned as fast as the core allows, so that
 * it reaches the core's limits. The tube of the scene "fine" has the same shape as that of the scene "tube"
 * but is 4 mm wide, and its distance field has finer voxels.
 *
 * In the scene "air" a floppy wire with a curved resting shape hangs in free space and is turned.
 *
 * In the scene "coaxial" the J wire lies inside two nested, curved catheters in the tube. Each of the three
 * tips is ahead of the other two at some time, and each tool slides and turns against the others.
 *
 * In the scene "beating" the J wire lies in a tube whose middle moves to and fro by 3.6 mm with the
 * heartbeat, and also with breathing. In the scene "beating", every kind of command for the heart (such as a
 * change of rate) occurs once.
 *
 * In the scene "balloon" a wire lies in a balloon catheter in the 4 mm wide tube. The balloon is inflated
 * until it fills the tube and opens a lesion. The catheter is pulled while the balloon is inflated, and
 * pushed after the balloon is deflated. Later in the scene "balloon" a scaffold (stent) holds the lesion
 * open, and at the end the balloon bursts.
 *
 * In the scene "stented" the J wire moves to and fro in the beating tube, through and beside a stent that
 * touches no wall. Later in the scene "stented" the stent is widened, and then half of its rings are
 * removed. */
#include "tools/check/core_scenes.h"

enum { TUBE, FINE, AIR, COAXIAL, BEATING, BALLOON, STENTED };
enum {
    BRICKS_X = 3,
    BRICKS_Y = 20,
    BRICKS_Z = 3,
    COARSE_COUNT = BRICKS_X * BRICKS_Y * BRICKS_Z,
    FINE_COUNT = 8 * COARSE_COUNT,
    SAMPLE_EDGE = 10,
    HALF_VOXEL = 16, /* a voxel is 32 units of a coefficient */
    TUBE_HALF_WIDTH = 4 * 32 + 3,
    FINE_HALF_WIDTH = 2 * 32 + 5,
    TUBE_LENGTH = 123 * 32,
    NODES_X = 6, /* 8 voxels apart, along the tube's axis from its entry on */
    NODES_Y = 15,
    NODES_Z = 6,
    LESION_STATIONS = 17, /* a voxel apart */
    LESION_BEGIN = 43,    /* voxels along the tube */
    NODE_NUMBERS = 3 * CRN_MOTION_ROW,
};

const core_scene core_scenes[CORE_SCENE_COUNT] = {{"tube", 4000},    {"fine", 1500},    {"air", 1000},
                                                  {"coaxial", 3000}, {"beating", 3500}, {"balloon", 3000},
                                                  {"stented", 4500}};

/* The memory block holds the distance field of the scene's tube. Only one scene exists at a time, and
 * core_scene_start fills the same memory again for each scene. */
static struct {
    crn_lumen lumen;
    uint16_t index[COARSE_COUNT];
    uint16_t children[FINE_COUNT];
    int8_t samples[FINE_COUNT * CRN_LUMEN_BRICK_SAMPLES];
    crn_motion motion;
    int16_t rows[NODES_X * NODES_Y * NODES_Z * NODE_NUMBERS];
    int16_t inhaled[NODES_X * NODES_Y * NODES_Z * 3];
    crn_lesion lesion;
    crn_lesion_station stations[LESION_STATIONS];
} field;

static int32_t largest(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static int32_t size_of(int32_t a)
{
    return a < 0 ? -a : a;
}

/* Returns the signed distance from a point to the tube's wall, in 1/32 of a coarse voxel, as the largest of
 * the signed distances from the five walls. */
static int32_t tube_distance(int32_t x, int32_t y, int32_t z, int32_t half_width)
{
    return largest(largest(size_of(x), size_of(z)) - half_width, y - TUBE_LENGTH);
}

/* Fills a brick (a small block of voxels) with distances. The position of the brick's lowest corner is given
 * in 1/32 of a coarse voxel, and the brick's voxels are 2^level times finer than coarse voxels. */
static void fill_brick(int8_t *samples, const int32_t corner[3], unsigned level, int32_t half_width)
{
    for (int32_t i = 0; i < CRN_LUMEN_BRICK_SAMPLES; i++) {
        const int32_t place[3] = {i % SAMPLE_EDGE, i / SAMPLE_EDGE % SAMPLE_EDGE,
                                  i / (SAMPLE_EDGE * SAMPLE_EDGE)};
        int32_t point[3];
        for (int k = 0; k < 3; k++) point[k] = corner[k] + ((place[k] - 1) * 32 + HALF_VOXEL) / (1 << level);
        int32_t distance = tube_distance(point[0], point[1], point[2], half_width) * (1 << level);
        samples[i] = (int8_t)(distance > 127 ? 127 : (distance < -127 ? -127 : distance));
    }
}

static void coarse_corner(int32_t brick, int32_t corner[3])
{
    const int32_t edge = CRN_LUMEN_BRICK_EDGE * 32;
    corner[0] = brick % BRICKS_X * edge - BRICKS_X * edge / 2;
    corner[1] = brick / BRICKS_X % BRICKS_Y * edge;
    corner[2] = brick / (BRICKS_X * BRICKS_Y) * edge - BRICKS_Z * edge / 2;
}

static void fill_coarse(void)
{
    for (int32_t brick = 0; brick < COARSE_COUNT; brick++) {
        int32_t corner[3];
        coarse_corner(brick, corner);
        fill_brick(&field.samples[brick * CRN_LUMEN_BRICK_SAMPLES], corner, 0, TUBE_HALF_WIDTH);
        field.index[brick] = (uint16_t)(brick + CRN_LUMEN_ENTRY_FIRST_BRICK);
    }
}

static void fill_fine(void)
{
    for (int32_t fine = 0; fine < FINE_COUNT; fine++) {
        int32_t corner[3];
        coarse_corner(fine / 8, corner);
        for (int k = 0; k < 3; k++) corner[k] += (fine >> k & 1) * CRN_LUMEN_BRICK_EDGE * 16;
        fill_brick(&field.samples[fine * CRN_LUMEN_BRICK_SAMPLES], corner, 1, FINE_HALF_WIDTH);
        field.children[fine] = (uint16_t)(fine + CRN_LUMEN_ENTRY_FIRST_BRICK);
        field.index[fine / 8] = (uint16_t)(CRN_LUMEN_ENTRY_REFINED | fine / 8);
    }
}

/* Fills one table row with the displacements of a lattice node over one cycle. The displacement is a parabola
 * over time, with a peak of `reach` units in mid-cycle. */
static void fill_row(int16_t *row, int32_t reach)
{
    for (int32_t i = 0; i < CRN_MOTION_KEYFRAMES + 2; i++) {
        int32_t key = (i + CRN_MOTION_KEYFRAMES - 1) % CRN_MOTION_KEYFRAMES;
        row[i] = (int16_t)(reach * key * (CRN_MOTION_KEYFRAMES - key) / 144);
    }
}

/* Makes a motion of the tube that is largest in the tube's middle and zero at the boundary of the motion
 * lattice. */
static const crn_motion *make_motion(void)
{
    for (int32_t node = 0; node < NODES_X * NODES_Y * NODES_Z; node++) {
        const int32_t x = node % NODES_X, y = node / NODES_X % NODES_Y, z = node / (NODES_X * NODES_Y);
        const bool is_edge =
            x == 0 || y == 0 || z == 0 || x == NODES_X - 1 || y == NODES_Y - 1 || z == NODES_Z - 1;
        const int32_t share = is_edge ? 0 : y * (NODES_Y - 1 - y); /* up to 49 */
        int16_t *rows = &field.rows[node * NODE_NUMBERS];
        fill_row(rows, share * 38);
        fill_row(rows + CRN_MOTION_ROW, share * 9);
        fill_row(rows + 2 * CRN_MOTION_ROW, share * (x - 2) * -10);
        field.inhaled[3 * node] = (int16_t)(share * 5);
        field.inhaled[3 * node + 1] = (int16_t)(share * -12);
    }
    const int32_t spacing = 1 << 23;
    const crn_lattice lattice = {
        .origin_m_q30 = {-5 * spacing / 2, spacing, -5 * spacing / 2},
        .count_xyz = {NODES_X, NODES_Y, NODES_Z},
        .spacing_log2_q30 = 23,
    };
    field.motion = (crn_motion){lattice, field.rows, lattice, field.inhaled, NULL};
    return &field.motion;
}

/* Makes a lesion of 16 mm length whose wall a balloon can push outwards by 0.6 mm on one side. */
static const crn_lesion *make_lesion(void)
{
    const int32_t voxel = 1 << CRN_LUMEN_VOXEL_LOG2_Q30, radius = FINE_HALF_WIDTH * (voxel / 32);
    for (int32_t i = 0; i < LESION_STATIONS; i++) {
        const int32_t depth = i * (LESION_STATIONS - 1 - i) * (voxel / 128), y = (LESION_BEGIN + i) * voxel;
        field.stations[i] = (crn_lesion_station){.healthy_m_q30 = {depth / 4, y, 0},
                                                 .healthy_radius_m_q30 = radius + depth,
                                                 .channel_m_q30 = {0, y, 0},
                                                 .channel_radius_m_q30 = radius,
                                                 .along_q30 = {0, CRN_ONE_Q30, 0}};
    }
    field.lesion = (crn_lesion){
        .low_m_q30 = {-8 * voxel, LESION_BEGIN * voxel, -8 * voxel},
        .high_m_q30 = {8 * voxel, (LESION_BEGIN + LESION_STATIONS) * voxel, 8 * voxel},
        .chord_q30 = {0, CRN_ONE_Q30, 0},
        .stretch_q28 = 1 << 28,
        .spacing_log2_q30 = CRN_LUMEN_VOXEL_LOG2_Q30,
        .station_count = LESION_STATIONS,
        .yield_Pa = 200000,
        .full_Pa = 300000,
        .recoil_q30 = CRN_ONE_Q30 / 3,
        .pace_q30 = CRN_ONE_Q30 / 150,
        .stations = field.stations,
    };
    return &field.lesion;
}

static const crn_lumen *make_lumen(uint32_t scene)
{
    if (scene == AIR) return NULL;
    const bool is_fine = scene == FINE || scene == BALLOON;
    if (is_fine) {
        fill_fine();
    } else {
        fill_coarse();
    }
    const int32_t brick_edge = (int32_t)CRN_LUMEN_BRICK_EDGE << CRN_LUMEN_VOXEL_LOG2_Q30;
    field.lumen = (crn_lumen){
        .origin_m_q30 = {-BRICKS_X * brick_edge / 2, 0, -BRICKS_Z * brick_edge / 2},
        .brick_count_xyz = {BRICKS_X, BRICKS_Y, BRICKS_Z},
        .child_row_count = is_fine ? COARSE_COUNT : 0,
        .brick_count = is_fine ? FINE_COUNT : COARSE_COUNT,
        .index = field.index,
        .children = field.children,
        .samples = field.samples,
        .motion = scene == BEATING || scene == STENTED ? make_motion() : NULL,
        .lesion_count = scene == BALLOON ? 1 : 0,
        .lesions = scene == BALLOON ? make_lesion() : NULL,
    };
    return &field.lumen;
}

/* Makes a J wire with a floppy curved tip of 15 mm and a transition to a shaft at 60 mm. */
static crn_instrument make_j_wire(uint32_t shaft_nN_m2)
{
    const crn_knot tip = {.arc_um = 0,
                          .bend_stiffness_nN_m2 = 10000,
                          .twist_stiffness_nN_m2 = 10000,
                          .mass_mg_per_m = 4000,
                          .radius_outer_um = 445,
                          .friction_kinetic_milli = 100,
                          .friction_static_milli = 120,
                          .rest_curvature1_per_m_milli = 150000};
    crn_knot bend_end = tip;
    bend_end.arc_um = 15000;
    crn_knot straight = bend_end;
    straight.rest_curvature1_per_m_milli = 0;
    crn_knot shaft = straight;
    shaft.arc_um = 60000;
    shaft.bend_stiffness_nN_m2 = shaft_nN_m2;
    shaft.twist_stiffness_nN_m2 = shaft_nN_m2;
    crn_knot end = shaft;
    end.arc_um = 400000;
    crn_instrument wire = {.knot_count = 5,
                           .knots = {tip, bend_end, straight, shaft, end},
                           .axial_stiffness_max_N = 3000,
                           .element_tip_um = 1000,
                           .element_shaft_um = 3000,
                           .element_fine_um = 40000};
    return wire;
}

/* Makes a wire with a bending stiffness of 4.9e-3 N m^2 from end to end, like the stiffest wire on the
 * market. */
static crn_instrument make_stiff_wire(void)
{
    const crn_knot tip = {.arc_um = 0,
                          .bend_stiffness_nN_m2 = 4900000,
                          .twist_stiffness_nN_m2 = 3800000,
                          .mass_mg_per_m = 5000,
                          .radius_outer_um = 445,
                          .friction_kinetic_milli = 200,
                          .friction_static_milli = 300,
                          .rest_curvature1_per_m_milli = 2000};
    crn_knot end = tip;
    end.arc_um = 300000;
    crn_instrument wire = {.knot_count = 2,
                           .knots = {tip, end},
                           .axial_stiffness_max_N = 3000,
                           .element_tip_um = 3000,
                           .element_shaft_um = 3000,
                           .element_fine_um = 0};
    return wire;
}

/* Makes a catheter with a bent end of 30 mm on a straight shaft. */
static crn_instrument make_catheter(uint32_t bend_nN_m2, uint32_t radius_um, int32_t curve_per_m_milli)
{
    const crn_knot tip = {.arc_um = 0,
                          .bend_stiffness_nN_m2 = bend_nN_m2 / 2,
                          .twist_stiffness_nN_m2 = bend_nN_m2,
                          .mass_mg_per_m = 3000,
                          .radius_outer_um = radius_um,
                          .radius_inner_um = radius_um - 250,
                          .friction_kinetic_milli = 80,
                          .friction_static_milli = 100,
                          .rest_curvature1_per_m_milli = curve_per_m_milli,
                          .rest_curvature2_per_m_milli = curve_per_m_milli / 3};
    crn_knot bend_end = tip;
    bend_end.arc_um = 30000;
    crn_knot straight = bend_end;
    straight.bend_stiffness_nN_m2 = bend_nN_m2;
    straight.rest_curvature1_per_m_milli = straight.rest_curvature2_per_m_milli = 0;
    crn_knot end = straight;
    end.arc_um = 380000;
    crn_instrument catheter = {.knot_count = 4,
                               .knots = {tip, bend_end, straight, end},
                               .lumen_friction_milli = 50,
                               .axial_stiffness_max_N = 3000,
                               .element_tip_um = 1000,
                               .element_shaft_um = 3000,
                               .element_fine_um = 40000};
    return catheter;
}

/* Makes a catheter with a balloon. The balloon is 20 mm long, 5 mm wide at a pressure of 8 bar, and ends 8 mm
 * behind the catheter's tip. */
static crn_instrument make_balloon_catheter(void)
{
    crn_instrument catheter = make_catheter(50000, 750, 0);
    catheter.balloon = (crn_balloon){.point_count = 3,
                                     .distal_um = 8000,
                                     .proximal_um = 28000,
                                     .burst_kPa = 1800,
                                     .pressure_kPa = {600, 800, 1400},
                                     .diameter_um = {4900, 5000, 5300}};
    return catheter;
}

bool core_scene_start(uint32_t scene, crn_model *model, crn_state *state)
{
    const uint32_t inserted_um[CORE_SCENE_COUNT][CRN_TOOL_MAX] = {
        {40000}, {60000}, {200000}, {60000, 30000, 10000}, {40000}, {90000, 60000}, {40000}};
    const crn_entry entry = {.position_m_q30 = {{0, 8 << 20, 0}},
                             .direction_q30 = {{0, CRN_ONE_Q30, 0}},
                             .blood_kg_m3 = CRN_BLOOD_kg_m3};
    const crn_instrument tools[CRN_TOOL_MAX] = {
        scene == FINE ? make_stiff_wire()
                      : make_j_wire(scene == TUBE || scene == BEATING || scene == STENTED ? 500000 : 20000),
        scene == BALLOON ? make_balloon_catheter() : make_catheter(300000, 800, 40000),
        make_catheter(600000, 1100, -20000)};
    uint32_t tool_count = scene == COAXIAL ? CRN_TOOL_MAX : (scene == BALLOON ? 2 : 1);
    crn_build_place place;
    if (crn_model_build(model, tools, tool_count, make_lumen(scene), &entry, &place) != CRN_BUILD_OK)
        return false;
    crn_state_init(model, state, inserted_um[scene]);
    return true;
}

/* Returns a motion of the user's hand that advances by `step` per tick while turning, and then goes back at
 * half this speed. */
static crn_input forward_and_back(uint32_t tick, uint32_t forward_ticks, int32_t step_m_q30, uint32_t turn32)
{
    uint32_t forward = tick < forward_ticks ? tick : forward_ticks;
    crn_input input = {
        .hands[0] = {(int32_t)forward * step_m_q30 - (int32_t)(tick - forward) * (step_m_q30 / 2),
                     forward * turn32},
    };
    return input;
}

/* Moves tool number k to and fro at 0.1 m/s and turns it meanwhile; the period and the phase of the motion
 * differ between tools. */
static crn_input every_tool(uint32_t tick, uint32_t variant)
{
    crn_input input = {0};
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        uint32_t period = 1000 + 400 * k;
        uint32_t phase = tick % (2 * period);
        uint32_t place = phase < period ? phase : 2 * period - phase;
        input.hands[k].feed_m_q30 = (int32_t)place * 107374;
        input.hands[k].turn32 = (k == 1 ? 0u - place : place) * (8589935u + variant);
    }
    return input;
}

/* Returns the command for the beating heart and for breathing at the given tick. */
static crn_rhythm_order order_at(uint32_t tick)
{
    switch (tick) {
    case 1:
        return (crn_rhythm_order){CRN_RHYTHM_HEART_RATE, 110};
    case 2:
        return (crn_rhythm_order){CRN_RHYTHM_VARIABILITY, 60};
    case 700:
        return (crn_rhythm_order){CRN_RHYTHM_PREMATURE, 550};
    case 1500:
        return (crn_rhythm_order){CRN_RHYTHM_ASYSTOLE, 1};
    case 2500:
        return (crn_rhythm_order){CRN_RHYTHM_ASYSTOLE, 0};
    case 2600:
        return (crn_rhythm_order){CRN_RHYTHM_BREATH_RATE, 20};
    case 2700:
        return (crn_rhythm_order){CRN_RHYTHM_BREATH_HOLD, 1};
    default:
        return (crn_rhythm_order){CRN_RHYTHM_KEEP, 0};
    }
}

/* The balloon's pressure rises to 12 bar and falls again, twice, and then rises beyond the burst pressure.
 * While the balloon's pressure changes, the catheter moves back and forth by 5 mm.
 */
static crn_input inflated(uint32_t tick, uint32_t variant)
{
    const uint32_t phase = tick % 1200, pulled = phase < 400 ? 0 : (phase < 650 ? phase - 400 : 250);
    const uint32_t pushed = phase < 950 ? 0 : phase - 950;
    crn_input input = {.hands[1] = {((int32_t)pushed - (int32_t)pulled) * 21475, tick * (variant + 1000u)}};
    const bool is_up = phase >= 50 && phase < 700;
    if (tick == 1500) input.scaffold = (crn_scaffold){0, 4, 12, CRN_ONE_Q30 / 10 * 9};
    input.inflator_Pa = is_up ? (int32_t)(phase < 350 ? phase - 50 : 300) * (tick < 2400 ? 4000 : 7000) : 0;
    return input;
}

/* Commands the core to place twelve rings of a stent, one ring per tick. The rings are first 4.8 mm and later
 * 6 mm wide; then the last six rings are removed. */
static crn_strut_order strut_at(uint32_t tick)
{
    enum { RINGS = 12, WIDENED = 1850, TAKEN = 3600 };
    for (uint32_t i = 0; i < RINGS; i++) {
        const uint32_t inside_um = tick == 1 + i ? 2400 : (tick == WIDENED + i ? 3000 : 0);
        if (tick == TAKEN + i && i >= RINGS / 2) return (crn_strut_order){.number = 30 + i};
        if (inside_um == 0) continue;
        return (crn_strut_order){
            30 + i, {100 * (int32_t)i, 55000 + 2000 * (int32_t)i, -900}, inside_um, 80, i + 1 < RINGS};
    }
    return (crn_strut_order){.number = 0};
}

/* Moves the wire 45 mm to and fro while turning it; each stroke begins at a different angle of rotation. */
static crn_input through_struts(uint32_t tick, uint32_t variant)
{
    const uint32_t phase = tick % 1800, place = phase < 900 ? phase : 1800 - phase;
    crn_input input = {.hands[0] = {(int32_t)place * 53687, tick * (2717987u + variant)}};
    input.strut = strut_at(tick);
    return input;
}

crn_input core_scene_hand(uint32_t scene, uint32_t tick, uint32_t variant)
{
    if (scene == FINE) { /* 0.5 m/s and 3 turns per second, to and fro every quarter of a second */
        uint32_t phase = tick % 500;
        uint32_t place = phase < 250 ? phase : 500 - phase;
        crn_input input = {.hands[0] = {(int32_t)place * 536871, place * (12884902u + variant)}};
        return input;
    }
    if (scene == COAXIAL) return every_tool(tick, variant);
    if (scene == BALLOON) return inflated(tick, variant);
    if (scene == STENTED) return through_struts(tick, variant);
    if (scene == AIR) return forward_and_back(tick, 600, 107374, 8589935u + variant);
    if (scene == BEATING) {
        crn_input input = forward_and_back(tick, 1200, 64425, 1717987u + variant);
        input.rhythm = order_at(tick);
        return input;
    }
    return forward_and_back(tick, 2500, 64425, 1717987u + variant); /* 60 mm/s, 0.4 turns per second */
}
