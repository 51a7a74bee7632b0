/* This file checks the MOTION and BREATH sections. Every number of the MOTION and BREATH sections must be
 * within the range for which the core's arithmetic is proved to be correct. The displacements of neighbouring
 * nodes must differ so little that the map is one-to-one for the wall of any heart. The nodes on the boundary
 * of a lattice must not move. */
#include "shared/scene/scene_check.h"

enum { COMPONENTS = 3, COPIES = 2 };

/* Describes the properties in which the lattices of heartbeat and breath differ. */
typedef struct lattice_rules {
    uint32_t keyframes; /* as stated in the header */
    uint32_t row;       /* numbers of a component */
    int32_t eighths;    /* eighths of a spacing by which neighbours may differ */
} lattice_rules;

static lattice_rules rules_of(uint32_t type)
{
    const lattice_rules beat = {CRN_SCENE_MOTION_KEYFRAMES, CRN_SCENE_MOTION_ROW, 5}, breath = {0, 1, 3};
    return type == CRN_SCENE_BREATH ? breath : beat;
}

static crn_scene_status check_header(crn_scene_check *check, const lattice_rules *rules,
                                     const uint8_t *header, size_t where)
{
    uint32_t log2 = crn_scene_u16(header + 18);
    if (log2 < CRN_SCENE_MOTION_SPACING_LOG2_MIN || log2 > CRN_SCENE_MOTION_SPACING_LOG2_MAX ||
        crn_scene_u16(header + 20) != rules->keyframes)
        return crn_scene_fault_at(check, CRN_SCENE_MOTION_LATTICE, where + 18);
    for (int k = 0; k < 3; k++) {
        uint32_t count = crn_scene_u16(header + 12 + 2 * k);
        if (count < 2 || count > CRN_SCENE_MOTION_COUNT_MAX)
            return crn_scene_fault_at(check, CRN_SCENE_MOTION_LATTICE, where + 12 + 2 * (size_t)k);
        int64_t end = crn_scene_i32(header + 4 * k) + ((int64_t)(count - 1) << log2);
        if (end > (int64_t)INT32_MAX + 1)
            return crn_scene_fault_at(check, CRN_SCENE_MOTION_LATTICE, where + 4 * (size_t)k);
    }
    if (crn_scene_u16(header + 22) != 0 || crn_scene_u32(header + 24) != 0 || crn_scene_u32(header + 28) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, where + 22);
    return CRN_SCENE_OK;
}

/* Checks one displacement component of one lattice node: the numbers must be in range, and the copies at the
 * row's ends must equal their originals. */
static bool row_is_valid(const lattice_rules *rules, const int16_t *row)
{
    for (uint32_t i = 0; i < rules->row; i++) {
        if (row[i] > CRN_SCENE_MOTION_VALUE_MAX || row[i] < -CRN_SCENE_MOTION_VALUE_MAX) return false;
    }
    for (uint32_t i = 0; rules->row > COPIES && i < COPIES; i++) {
        if (row[rules->row - COPIES + i] != row[i]) return false;
    }
    return true;
}

static bool is_steep(const int16_t *row, const int16_t *next, uint32_t count, int32_t most)
{
    for (uint32_t i = 0; i < count; i++) {
        int32_t apart = next[i] - row[i];
        if (apart > most || apart < -most) return true;
    }
    return false;
}

static bool is_still(const int16_t *node, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (node[i] != 0) return false;
    }
    return true;
}

/* Checks the lattice node at (x, y, z). The node's rows must be valid, its displacements must not differ too
 * much from those of its next neighbours, and a node on the boundary must not move. */
static crn_scene_status check_node(const lattice_rules *rules, const crn_scene_motion *motion,
                                   const uint32_t at[3])
{
    const uint32_t nx = motion->node_count_xyz[0], ny = motion->node_count_xyz[1];
    const size_t steps[3] = {1, nx, (size_t)nx * ny};
    const size_t node = at[0] + at[1] * steps[1] + at[2] * steps[2];
    const uint32_t row = rules->row, numbers = COMPONENTS * row;
    const int16_t *rows = motion->rows + node * numbers;
    const int32_t most = rules->eighths << (motion->spacing_log2_q30 - CRN_SCENE_MOTION_UNIT_LOG2_Q30 - 3);
    for (uint32_t k = 0; k < COMPONENTS; k++) {
        if (!row_is_valid(rules, rows + k * row)) return CRN_SCENE_MOTION_VALUE;
    }
    for (int axis = 0; axis < 3; axis++) {
        bool is_last = at[axis] + 1u == motion->node_count_xyz[axis];
        if ((at[axis] == 0 || is_last) && !is_still(rows, numbers)) return CRN_SCENE_MOTION_EDGE;
        if (!is_last && is_steep(rows, rows + steps[axis] * numbers, numbers, most))
            return CRN_SCENE_MOTION_STEEP;
    }
    return CRN_SCENE_OK;
}

crn_scene_status crn_scene_check_motion(crn_scene_check *check, crn_scene_span span, crn_scene_motion *motion)
{
    const lattice_rules rules = rules_of(span.type);
    if (check->minor < 4) return crn_scene_fault_at(check, CRN_SCENE_MOTION_OLDER, 10);
    if (span.size < CRN_SCENE_MOTION_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    crn_scene_status status = check_header(check, &rules, header, span.offset);
    if (status != CRN_SCENE_OK) return status;
    uint64_t nodes = 1;
    for (int k = 0; k < 3; k++) {
        motion->origin_m_q30[k] = crn_scene_i32(header + 4 * k);
        motion->node_count_xyz[k] = crn_scene_u16(header + 12 + 2 * k);
        nodes *= motion->node_count_xyz[k];
    }
    motion->spacing_log2_q30 = crn_scene_u16(header + 18);
    if (span.size != CRN_SCENE_MOTION_HEADER_BYTES + 2 * COMPONENTS * rules.row * nodes)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset + 12);
    /* The core reads the rows directly from the file, like the lumen's samples. */
    const size_t rows_at = span.offset + CRN_SCENE_MOTION_HEADER_BYTES;
    motion->rows = (const int16_t *)(const void *)(check->bytes + rows_at);
    size_t node = 0;
    for (uint32_t z = 0; z < motion->node_count_xyz[2]; z++) {
        for (uint32_t y = 0; y < motion->node_count_xyz[1]; y++) {
            for (uint32_t x = 0; x < motion->node_count_xyz[0]; x++, node++) {
                status = check_node(&rules, motion, (const uint32_t[3]){x, y, z});
                if (status != CRN_SCENE_OK)
                    return crn_scene_fault_at(check, status, rows_at + node * 2 * COMPONENTS * rules.row);
            }
        }
    }
    return CRN_SCENE_OK;
}
