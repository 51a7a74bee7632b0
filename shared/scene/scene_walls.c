/* This file checks the WALLS section of a scene, which states how the vessel's walls give way: a header, the
 * laws, and one byte for each coarse brick of the lumen's lattice with the number of its law, 0 for a rigid
 * wall. Every number of a law must be within the range for which the core's arithmetic is proved to be
 * correct (firmware/core/lumen.h). */
#include "shared/scene/scene_check.h"

enum { BED_AT = 0, RADIAL_AT = 4, RELAX_AT = 8, CARRY_AT = 12, WAY_AT = 16, WIDEN_AT = 20, RESERVED_AT = 24 };

static bool is_zero_or_between(uint32_t value, uint32_t low, uint32_t high)
{
    return value == 0 || (value >= low && value <= high);
}

static bool law_is_good(const uint8_t *law)
{
    const uint32_t relax_ms = crn_scene_u32(law + RELAX_AT);
    return is_zero_or_between(crn_scene_u32(law + BED_AT), CRN_SCENE_WALL_BED_MIN_N_m2,
                              CRN_SCENE_WALL_STIFFNESS_MAX_N_m2) &&
           is_zero_or_between(crn_scene_u32(law + RADIAL_AT), CRN_SCENE_WALL_RADIAL_MIN_N_m2,
                              CRN_SCENE_WALL_STIFFNESS_MAX_N_m2) &&
           relax_ms >= CRN_SCENE_WALL_RELAX_MIN_ms && relax_ms <= CRN_SCENE_WALL_RELAX_MAX_ms &&
           crn_scene_u32(law + CARRY_AT) <= CRN_SCENE_WALL_CARRY_MAX_um &&
           crn_scene_u32(law + WAY_AT) <= CRN_SCENE_WALL_WAY_MAX_um &&
           crn_scene_u32(law + WIDEN_AT) <= CRN_SCENE_WALL_WIDEN_MAX_um &&
           crn_scene_u32(law + RESERVED_AT) == 0 && crn_scene_u32(law + RESERVED_AT + 4) == 0;
}

crn_scene_status crn_scene_check_walls(crn_scene_check *check, crn_scene_span span, crn_scene *scene)
{
    if (check->minor < 11) return crn_scene_fault_at(check, CRN_SCENE_SECTION_TYPE, span.offset);
    if (span.size < CRN_SCENE_WALLS_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    const uint32_t laws = crn_scene_u32(header);
    if (laws == 0 || laws > CRN_SCENE_WALL_LAW_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_WALL, span.offset);
    for (size_t i = 4; i < CRN_SCENE_WALLS_HEADER_BYTES; i += 4) {
        if (crn_scene_u32(header + i) != 0)
            return crn_scene_fault_at(check, CRN_SCENE_RESERVED, span.offset + i);
    }
    const uint16_t *n = scene->lumen.brick_count_xyz;
    const uint64_t bricks = (uint64_t)n[0] * n[1] * n[2];
    const size_t bytes_at = CRN_SCENE_WALLS_HEADER_BYTES + (size_t)laws * CRN_SCENE_WALL_LAW_BYTES;
    if (span.size != bytes_at + bricks) return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    for (uint32_t i = 0; i < laws; i++) {
        const size_t at = CRN_SCENE_WALLS_HEADER_BYTES + (size_t)i * CRN_SCENE_WALL_LAW_BYTES;
        if (!law_is_good(header + at)) return crn_scene_fault_at(check, CRN_SCENE_WALL, span.offset + at);
    }
    for (size_t i = bytes_at; i < span.size; i++) {
        if (header[i] > laws) return crn_scene_fault_at(check, CRN_SCENE_WALL, span.offset + i);
    }
    scene->wall_law_count = laws;
    scene->wall_laws = header + CRN_SCENE_WALLS_HEADER_BYTES;
    scene->wall_law_of_brick = header + bytes_at;
    return CRN_SCENE_OK;
}
