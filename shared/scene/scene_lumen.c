/* Checks the LUMEN section. The lumen's child rows, which refine bricks, form two ranks. Rows of the first
 * rank, which refine coarse bricks, come first and may refer to rows of the second rank; rows of the second
 * rank refer to no rows. Because child rows have only two ranks, the refinement of bricks always ends, and
 * the check needs no walk through the rows. */
#include "shared/scene/scene_check.h"

enum { OUTSIDE_AND_INSIDE = 2, REFINED = 0x8000 };

static crn_scene_status check_lattice(crn_scene_check *check, const uint8_t *header, size_t where)
{
    for (int k = 0; k < 3; k++) {
        uint32_t count = crn_scene_u16(header + 12 + 2 * k);
        if (count < 1 || count > CRN_SCENE_LATTICE_MAX)
            return crn_scene_fault_at(check, CRN_SCENE_LATTICE, where + 12 + 2 * (size_t)k);
        int64_t end = crn_scene_i32(header + 4 * k) + ((int64_t)count << CRN_SCENE_BRICK_LOG2_Q30);
        if (end > (int64_t)INT32_MAX + 1)
            return crn_scene_fault_at(check, CRN_SCENE_LATTICE, where + 4 * (size_t)k);
    }
    if (crn_scene_u16(header + 26) != 0 || crn_scene_u32(header + 28) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, where + 26);
    if (crn_scene_u16(header + 24) > crn_scene_u16(header + 18))
        return crn_scene_fault_at(check, CRN_SCENE_CHILD_ROWS, where + 24);
    return CRN_SCENE_OK;
}

/* The index entries from number first to first + count - 1 may refer to bricks below brick_count and to rows
 * from row_first to row_end - 1. */
static crn_scene_status check_entries(crn_scene_check *check, size_t first, size_t count,
                                      uint32_t brick_count, uint32_t row_first, uint32_t row_end)
{
    for (size_t i = 0; i < count; i++) {
        size_t where = first + 2 * i;
        uint32_t entry = crn_scene_u16(check->bytes + where);
        uint32_t row = entry & (REFINED - 1u);
        if (entry >= REFINED && (row < row_first || row >= row_end))
            return crn_scene_fault_at(check, CRN_SCENE_INDEX_ROW, where);
        if (entry < REFINED && entry >= OUTSIDE_AND_INSIDE && entry - OUTSIDE_AND_INSIDE >= brick_count)
            return crn_scene_fault_at(check, CRN_SCENE_INDEX_BRICK, where);
    }
    return CRN_SCENE_OK;
}

crn_scene_status crn_scene_check_lumen(crn_scene_check *check, crn_scene_span span, crn_scene_lumen *lumen)
{
    if (span.size < CRN_SCENE_LUMEN_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    crn_scene_status status = check_lattice(check, header, span.offset);
    if (status != CRN_SCENE_OK) return status;
    for (int k = 0; k < 3; k++) {
        lumen->origin_m_q30[k] = crn_scene_i32(header + 4 * k);
        lumen->brick_count_xyz[k] = crn_scene_u16(header + 12 + 2 * k);
    }
    lumen->child_row_count = crn_scene_u16(header + 18);
    lumen->brick_count = crn_scene_u32(header + 20);
    uint32_t row_first_rank = crn_scene_u16(header + 24), rows = lumen->child_row_count;
    uint64_t coarse =
        (uint64_t)lumen->brick_count_xyz[0] * lumen->brick_count_xyz[1] * lumen->brick_count_xyz[2];
    uint64_t children = CRN_SCENE_LUMEN_HEADER_BYTES + 2 * coarse, samples = children + 16 * (uint64_t)rows;
    if (span.size != samples + (uint64_t)lumen->brick_count * CRN_SCENE_BRICK_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset + 12);

    size_t index_at = span.offset + CRN_SCENE_LUMEN_HEADER_BYTES,
           children_at = span.offset + (size_t)children;
    status = check_entries(check, index_at, (size_t)coarse, lumen->brick_count, 0, row_first_rank);
    if (status != CRN_SCENE_OK) return status;
    status = check_entries(check, children_at, 8 * (size_t)row_first_rank, lumen->brick_count, row_first_rank,
                           rows);
    if (status != CRN_SCENE_OK) return status;
    status = check_entries(check, children_at + 16 * (size_t)row_first_rank,
                           8 * (size_t)(rows - row_first_rank), lumen->brick_count, 0, 0);
    if (status != CRN_SCENE_OK) return status;
    /* The core reads the LUMEN section directly from the file. The LUMEN section begins in the file at an
     * offset that is a multiple of 16, and the file lies in memory at an address that is a multiple of 4. */
    lumen->index = (const uint16_t *)(const void *)(check->bytes + index_at);
    lumen->children = (const uint16_t *)(const void *)(check->bytes + children_at);
    lumen->samples = (const int8_t *)(check->bytes + span.offset + samples);
    return CRN_SCENE_OK;
}
