/* Checking and reading BODY sections. */
#include "shared/scene/scene_check.h"

seld_scene_body_view seld_scene_body(const seld_scene *scene, uint32_t index)
{
    const uint8_t *section = scene->bytes + seld_scene_section_span(scene->bytes, 1 + index).offset;
    seld_scene_body_view body;
    body.name = (const char *)section;
    body.material = body.name + SELD_SCENE_BODY_NAME_BYTES;
    body.parent = seld_scene_i32(section + 48);
    body.moves = (seld_scene_u32(section + 60) & SELD_SCENE_BODY_MOVES) != 0;
    body.vertex_count = seld_scene_u32(section + 52);
    body.triangle_count = seld_scene_u32(section + 56);
    body.vertices_um = section + SELD_SCENE_BODY_HEADER_BYTES;
    body.triangles = body.vertices_um + 12 * (size_t)body.vertex_count;
    return body;
}

static seld_scene_status check_vertices(seld_scene_check *check, size_t where, uint32_t vertex_count)
{
    for (size_t i = 0; i < 3 * (size_t)vertex_count; i++) {
        int32_t coordinate = seld_scene_i32(check->bytes + where + 4 * i);
        if (coordinate > SELD_SCENE_BODY_REACH_um || coordinate < -SELD_SCENE_BODY_REACH_um)
            return seld_scene_fault_at(check, SELD_SCENE_BODY_VERTEX, where + 4 * i);
    }
    return SELD_SCENE_OK;
}

static seld_scene_status check_triangles(seld_scene_check *check, size_t where, uint32_t count,
                                         uint32_t vertex_count)
{
    for (size_t i = 0; i < count; i++) {
        size_t at = where + 12 * i;
        uint32_t a = seld_scene_u32(check->bytes + at), b = seld_scene_u32(check->bytes + at + 4);
        uint32_t c = seld_scene_u32(check->bytes + at + 8);
        if (a >= vertex_count || b >= vertex_count || c >= vertex_count || a == b || b == c || c == a)
            return seld_scene_fault_at(check, SELD_SCENE_BODY_TRIANGLE, at);
    }
    return SELD_SCENE_OK;
}

static seld_scene_status check_body(seld_scene_check *check, uint32_t index, uint32_t body_count,
                                    uint64_t *triangles_before)
{
    seld_scene_span span = seld_scene_section_span(check->bytes, 1 + index);
    if (span.size < SELD_SCENE_BODY_HEADER_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    seld_scene_status status = seld_scene_check_text(check, span.offset, SELD_SCENE_BODY_NAME_BYTES);
    if (status != SELD_SCENE_OK) return status;
    status =
        seld_scene_check_text(check, span.offset + SELD_SCENE_BODY_NAME_BYTES, SELD_SCENE_MATERIAL_BYTES);
    if (status != SELD_SCENE_OK) return status;
    int32_t parent = seld_scene_i32(header + 48);
    uint32_t vertices = seld_scene_u32(header + 52), triangles = seld_scene_u32(header + 56);
    if (seld_scene_u32(header + 60) > SELD_SCENE_BODY_MOVES)
        return seld_scene_fault_at(check, SELD_SCENE_RESERVED, span.offset + 60);
    if (parent < -1 || parent >= (int32_t)body_count)
        return seld_scene_fault_at(check, SELD_SCENE_BODY_PARENT, span.offset + 48);
    *triangles_before += triangles;
    if (triangles == 0 || *triangles_before > SELD_SCENE_TRIANGLE_MAX)
        return seld_scene_fault_at(check, SELD_SCENE_BODY_SIZE, span.offset + 56);
    if (span.size != SELD_SCENE_BODY_HEADER_BYTES + 12 * ((uint64_t)vertices + triangles))
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset + 52);
    size_t first = span.offset + SELD_SCENE_BODY_HEADER_BYTES;
    status = check_vertices(check, first, vertices);
    if (status != SELD_SCENE_OK) return status;
    return check_triangles(check, first + 12 * (size_t)vertices, triangles, vertices);
}

/* Does the way from a body through its parents end in air? It has at most body_count steps when it does. */
static bool parents_end(const seld_scene_check *check, uint32_t index, uint32_t body_count)
{
    int32_t at = (int32_t)index;
    for (uint32_t steps = 0; steps <= body_count; steps++) {
        if (at < 0) return true;
        at = seld_scene_i32(check->bytes + seld_scene_section_span(check->bytes, 1 + (uint32_t)at).offset +
                            48);
    }
    return false;
}

seld_scene_status seld_scene_check_bodies(seld_scene_check *check, uint32_t body_count)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < body_count; i++) {
        seld_scene_status status = check_body(check, i, body_count, &triangles);
        if (status != SELD_SCENE_OK) return status;
    }
    for (uint32_t i = 0; i < body_count; i++) {
        size_t where = seld_scene_section_span(check->bytes, 1 + i).offset + 48;
        if (!parents_end(check, i, body_count))
            return seld_scene_fault_at(check, SELD_SCENE_BODY_PARENT, where);
    }
    return SELD_SCENE_OK;
}
