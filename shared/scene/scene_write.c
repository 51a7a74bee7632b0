/* Laying out a scene container: scene_write.h. */
#include "shared/scene/scene_write.h"
#include "shared/wire/wire_frame.h"

#include <string.h>

void seld_scene_put_u16(uint8_t *bytes, uint16_t value)
{
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

void seld_scene_put_u32(uint8_t *bytes, uint32_t value)
{
    seld_wire_put_u32_at(bytes, value);
}

static uint64_t padded(uint64_t bytes)
{
    return (bytes + SELD_SCENE_ALIGNMENT - 1) & ~(uint64_t)(SELD_SCENE_ALIGNMENT - 1);
}

size_t seld_scene_write_bytes(const seld_scene_part *parts, uint32_t part_count)
{
    uint64_t total = SELD_SCENE_HEADER_BYTES + (uint64_t)part_count * SELD_SCENE_TABLE_ROW_BYTES;
    for (uint32_t i = 0; i < part_count; i++) {
        total = padded(total) + parts[i].size;
        if (total > INT32_MAX) return 0;
    }
    return (size_t)padded(total);
}

/* The oldest version that knows this part. */
static uint16_t minor_of_part(const seld_scene_part *part)
{
    if (part->type == SELD_SCENE_PARTNER) return 5;
    if (part->type == SELD_SCENE_MOTION || part->type == SELD_SCENE_BREATH) return 4;
    if (part->type == SELD_SCENE_PLAQUES) return 3;
    if (part->type == SELD_SCENE_LESIONS) return 2;
    if (part->type == SELD_SCENE_TREE) return 1;
    bool moves = part->type == SELD_SCENE_BODY && part->size >= SELD_SCENE_BODY_HEADER_BYTES &&
                 seld_scene_u32(part->bytes + SELD_SCENE_BODY_HEADER_BYTES - 4) != 0;
    return moves ? 1 : 0;
}

/* Files without lesions, motion and tree are as they were. */
static uint16_t minor_of(const seld_scene_part *parts, uint32_t part_count)
{
    uint16_t minor = 0;
    for (uint32_t i = 0; i < part_count; i++)
        minor = minor_of_part(&parts[i]) > minor ? minor_of_part(&parts[i]) : minor;
    return minor;
}

size_t seld_scene_write(seld_scene_kind kind, const seld_scene_part *parts, uint32_t part_count,
                        uint8_t *file, size_t capacity)
{
    static const uint8_t magic[8] = {'S', 'E', 'L', 'D', 'S', 'C', 'N', 0};
    size_t total = seld_scene_write_bytes(parts, part_count);
    if (total == 0 || total > capacity) return 0;
    memset(file, 0, total);
    memcpy(file, magic, sizeof magic);
    seld_scene_put_u16(file + 8, SELD_SCENE_MAJOR);
    seld_scene_put_u16(file + 10, minor_of(parts, part_count));
    seld_scene_put_u32(file + 12, (uint32_t)kind);
    seld_scene_put_u32(file + 16, (uint32_t)total);
    seld_scene_put_u32(file + 20, part_count);
    size_t table_end = SELD_SCENE_HEADER_BYTES + (size_t)part_count * SELD_SCENE_TABLE_ROW_BYTES,
           end = table_end;
    for (uint32_t i = 0; i < part_count; i++) {
        uint8_t *row = file + SELD_SCENE_HEADER_BYTES + (size_t)i * SELD_SCENE_TABLE_ROW_BYTES;
        end = (size_t)padded(end);
        if (parts[i].size > 0) memcpy(file + end, parts[i].bytes, parts[i].size);
        seld_scene_put_u32(row, (uint32_t)parts[i].type);
        seld_scene_put_u32(row + 4, (uint32_t)end);
        seld_scene_put_u32(row + 8, (uint32_t)parts[i].size);
        seld_scene_put_u32(row + 12, seld_wire_crc32(0, file + end, parts[i].size));
        end += parts[i].size;
    }
    seld_scene_put_u32(file + 24, seld_wire_crc32(0, file, table_end));
    return total;
}
