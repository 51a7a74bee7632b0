/* This file writes a scene container: its header, section table and sections (scene_write.h). */
#include "shared/scene/scene_write.h"
#include "shared/wire/wire_frame.h"

#include <string.h>

void crn_scene_put_u16(uint8_t *bytes, uint16_t value)
{
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

void crn_scene_put_u32(uint8_t *bytes, uint32_t value)
{
    crn_wire_put_u32_at(bytes, value);
}

static uint64_t padded(uint64_t bytes)
{
    return (bytes + CRN_SCENE_ALIGNMENT - 1) & ~(uint64_t)(CRN_SCENE_ALIGNMENT - 1);
}

size_t crn_scene_write_bytes(const crn_scene_part *parts, uint32_t part_count)
{
    uint64_t total = CRN_SCENE_HEADER_BYTES + (uint64_t)part_count * CRN_SCENE_TABLE_ROW_BYTES;
    for (uint32_t i = 0; i < part_count; i++) {
        total = padded(total) + parts[i].size;
        if (total > INT32_MAX) return 0;
    }
    return (size_t)padded(total);
}

static bool has_joining_vessel(const crn_scene_part *small)
{
    const uint32_t count = small->size < CRN_SCENE_TREE_HEADER_BYTES ? 0 : crn_scene_u32(small->bytes);
    for (uint32_t i = 0; i < count; i++) {
        const size_t at = CRN_SCENE_TREE_HEADER_BYTES + (size_t)i * CRN_SCENE_BRANCH_BYTES;
        if (at + CRN_SCENE_BRANCH_BYTES > small->size) return false;
        if ((crn_scene_u32(small->bytes + at + CRN_SCENE_BRANCH_BYTES - 8) & CRN_SCENE_BRANCH_JOINS) != 0)
            return true;
    }
    return false;
}

/* Returns the first minor version of the scene format that can contain the given section. */
static uint16_t minor_of_part(const crn_scene_part *part)
{
    if (part->type == CRN_SCENE_WALLS) return 11;
    if (part->type == CRN_SCENE_SMALL) return has_joining_vessel(part) ? 8 : 7;
    if (part->type == CRN_SCENE_ENTRY && part->size == CRN_SCENE_ENTRY_START_BYTES) return 6;
    if (part->type == CRN_SCENE_PARTNER) return 5;
    if (part->type == CRN_SCENE_MOTION || part->type == CRN_SCENE_BREATH) return 4;
    if (part->type == CRN_SCENE_PLAQUES) return 3;
    if (part->type == CRN_SCENE_LESIONS) return 2;
    if (part->type == CRN_SCENE_TREE) return 1;
    if (part->type != CRN_SCENE_BODY || part->size < CRN_SCENE_BODY_HEADER_BYTES) return 0;
    const uint32_t flags = crn_scene_u32(part->bytes + CRN_SCENE_BODY_HEADER_BYTES - 4);
    if ((flags & CRN_SCENE_BODY_TRABECULAE) != 0) return 10;
    if (flags == CRN_SCENE_BODY_BREATHES) return 9;
    return flags != 0 ? 1 : 0;
}

/* A file without start length, lesions, motion and tree keeps the version number from before these parts
 * existed. */
static uint16_t minor_of(const crn_scene_part *parts, uint32_t part_count)
{
    uint16_t minor = 0;
    for (uint32_t i = 0; i < part_count; i++)
        minor = minor_of_part(&parts[i]) > minor ? minor_of_part(&parts[i]) : minor;
    return minor;
}

size_t crn_scene_write(crn_scene_kind kind, const crn_scene_part *parts, uint32_t part_count, uint8_t *file,
                       size_t capacity)
{
    static const uint8_t magic[8] = {'C', 'R', 'N', '-', 'S', 'C', 'N', 0};
    size_t total = crn_scene_write_bytes(parts, part_count);
    if (total == 0 || total > capacity) return 0;
    memset(file, 0, total);
    memcpy(file, magic, sizeof magic);
    crn_scene_put_u16(file + 8, CRN_SCENE_MAJOR);
    crn_scene_put_u16(file + 10, minor_of(parts, part_count));
    crn_scene_put_u32(file + 12, (uint32_t)kind);
    crn_scene_put_u32(file + 16, (uint32_t)total);
    crn_scene_put_u32(file + 20, part_count);
    size_t table_end = CRN_SCENE_HEADER_BYTES + (size_t)part_count * CRN_SCENE_TABLE_ROW_BYTES,
           end = table_end;
    for (uint32_t i = 0; i < part_count; i++) {
        uint8_t *row = file + CRN_SCENE_HEADER_BYTES + (size_t)i * CRN_SCENE_TABLE_ROW_BYTES;
        end = (size_t)padded(end);
        if (parts[i].size > 0) memcpy(file + end, parts[i].bytes, parts[i].size);
        crn_scene_put_u32(row, (uint32_t)parts[i].type);
        crn_scene_put_u32(row + 4, (uint32_t)end);
        crn_scene_put_u32(row + 8, (uint32_t)parts[i].size);
        crn_scene_put_u32(row + 12, crn_wire_crc32(0, file + end, parts[i].size));
        end += parts[i].size;
    }
    crn_scene_put_u32(file + 24, crn_wire_crc32(0, file, table_end));
    return total;
}
