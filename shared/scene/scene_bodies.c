/* This file checks the BODY sections of a file and gives access to the bodies. */
#include "shared/scene/scene_check.h"

crn_scene_body_view crn_scene_body(const crn_scene *scene, uint32_t index)
{
    const uint8_t *section = scene->bytes + crn_scene_section_span(scene->bytes, 1 + index).offset;
    crn_scene_body_view body;
    body.name = (const char *)section;
    body.material = body.name + CRN_SCENE_BODY_NAME_BYTES;
    body.parent = crn_scene_i32(section + 48);
    body.moves = (crn_scene_u32(section + 60) & CRN_SCENE_BODY_MOVES) != 0;
    body.is_trabecular = (crn_scene_u32(section + 60) & CRN_SCENE_BODY_TRABECULAE) != 0;
    body.vertex_count = crn_scene_u32(section + 52);
    body.triangle_count = crn_scene_u32(section + 56);
    body.vertices_um = section + CRN_SCENE_BODY_HEADER_BYTES;
    body.triangles = body.vertices_um + 12 * (size_t)body.vertex_count;
    body.breath_um = (crn_scene_u32(section + 60) & CRN_SCENE_BODY_BREATHES) != 0
                         ? body.triangles + 12 * (size_t)body.triangle_count
                         : NULL;
    return body;
}

static crn_scene_status check_vertices(crn_scene_check *check, size_t where, uint32_t vertex_count)
{
    for (size_t i = 0; i < 3 * (size_t)vertex_count; i++) {
        int32_t coordinate = crn_scene_i32(check->bytes + where + 4 * i);
        if (coordinate > CRN_SCENE_BODY_REACH_um || coordinate < -CRN_SCENE_BODY_REACH_um)
            return crn_scene_fault_at(check, CRN_SCENE_BODY_VERTEX, where + 4 * i);
    }
    return CRN_SCENE_OK;
}

static crn_scene_status check_triangles(crn_scene_check *check, size_t where, uint32_t count,
                                        uint32_t vertex_count)
{
    for (size_t i = 0; i < count; i++) {
        size_t at = where + 12 * i;
        uint32_t a = crn_scene_u32(check->bytes + at), b = crn_scene_u32(check->bytes + at + 4);
        uint32_t c = crn_scene_u32(check->bytes + at + 8);
        if (a >= vertex_count || b >= vertex_count || c >= vertex_count || a == b || b == c || c == a)
            return crn_scene_fault_at(check, CRN_SCENE_BODY_TRIANGLE, at);
    }
    return CRN_SCENE_OK;
}

/* Checks that a full breath leaves every vertex within the reach of bodies. */
static crn_scene_status check_breath(crn_scene_check *check, size_t vertices_at, size_t breath_at,
                                     uint32_t vertex_count)
{
    for (size_t i = 0; i < 3 * (size_t)vertex_count; i++) {
        const int32_t way = (int16_t)crn_scene_u16(check->bytes + breath_at + 2 * i);
        const int32_t inhaled = crn_scene_i32(check->bytes + vertices_at + 4 * i) + way;
        if (inhaled > CRN_SCENE_BODY_REACH_um || inhaled < -CRN_SCENE_BODY_REACH_um)
            return crn_scene_fault_at(check, CRN_SCENE_BODY_VERTEX, breath_at + 2 * i);
    }
    return CRN_SCENE_OK;
}

static crn_scene_status check_body(crn_scene_check *check, uint32_t index, uint32_t body_count,
                                   uint64_t *triangles_before)
{
    crn_scene_span span = crn_scene_section_span(check->bytes, 1 + index);
    if (span.size < CRN_SCENE_BODY_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    crn_scene_status status = crn_scene_check_text(check, span.offset, CRN_SCENE_BODY_NAME_BYTES);
    if (status != CRN_SCENE_OK) return status;
    status = crn_scene_check_text(check, span.offset + CRN_SCENE_BODY_NAME_BYTES, CRN_SCENE_MATERIAL_BYTES);
    if (status != CRN_SCENE_OK) return status;
    int32_t parent = crn_scene_i32(header + 48);
    uint32_t vertices = crn_scene_u32(header + 52), triangles = crn_scene_u32(header + 56);
    const uint32_t flags = crn_scene_u32(header + 60), motion = flags & ~(uint32_t)CRN_SCENE_BODY_TRABECULAE;
    const bool breathes = motion == CRN_SCENE_BODY_BREATHES && check->minor >= 9;
    if ((motion > CRN_SCENE_BODY_MOVES && !breathes) || (flags != motion && check->minor < 10))
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, span.offset + 60);
    if (parent < -1 || parent >= (int32_t)body_count)
        return crn_scene_fault_at(check, CRN_SCENE_BODY_PARENT, span.offset + 48);
    *triangles_before += triangles;
    if (triangles == 0 || *triangles_before > CRN_SCENE_TRIANGLE_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_BODY_SIZE, span.offset + 56);
    const uint64_t breath_bytes = breathes ? (uint64_t)CRN_SCENE_BODY_BREATH_BYTES * vertices : 0;
    if (span.size != CRN_SCENE_BODY_HEADER_BYTES + 12 * ((uint64_t)vertices + triangles) + breath_bytes)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset + 52);
    size_t first = span.offset + CRN_SCENE_BODY_HEADER_BYTES;
    status = check_vertices(check, first, vertices);
    if (status != CRN_SCENE_OK) return status;
    const size_t triangles_at = first + 12 * (size_t)vertices;
    status = check_triangles(check, triangles_at, triangles, vertices);
    if (status != CRN_SCENE_OK || !breathes) return status;
    return check_breath(check, first, triangles_at + 12 * (size_t)triangles, vertices);
}

/* Returns whether the path from a body through its parents (the bodies that surround it) ends in the
 * surrounding air. A path that ends in air has at most body_count steps. */
static bool parents_end(const crn_scene_check *check, uint32_t index, uint32_t body_count)
{
    int32_t at = (int32_t)index;
    for (uint32_t steps = 0; steps <= body_count; steps++) {
        if (at < 0) return true;
        at = crn_scene_i32(check->bytes + crn_scene_section_span(check->bytes, 1 + (uint32_t)at).offset + 48);
    }
    return false;
}

crn_scene_status crn_scene_check_bodies(crn_scene_check *check, uint32_t body_count)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < body_count; i++) {
        crn_scene_status status = check_body(check, i, body_count, &triangles);
        if (status != CRN_SCENE_OK) return status;
    }
    for (uint32_t i = 0; i < body_count; i++) {
        size_t where = crn_scene_section_span(check->bytes, 1 + i).offset + 48;
        if (!parents_end(check, i, body_count))
            return crn_scene_fault_at(check, CRN_SCENE_BODY_PARENT, where);
    }
    return CRN_SCENE_OK;
}
