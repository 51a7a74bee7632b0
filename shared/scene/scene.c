/* Checking a scene container, in the order header, section table, sections: scene.h. */
#include "shared/scene/scene.h"
#include "shared/scene/scene_check.h"
#include "shared/wire/wire_frame.h"

#include <string.h>

uint16_t seld_scene_u16(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] | bytes[1] << 8);
}

uint32_t seld_scene_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

int32_t seld_scene_i32(const uint8_t *bytes)
{
    uint32_t word = seld_scene_u32(bytes);
    return word <= INT32_MAX ? (int32_t)word : -(int32_t)(UINT32_MAX - word) - 1;
}

seld_scene_status seld_scene_fault_at(seld_scene_check *check, seld_scene_status status, size_t where)
{
    check->where = (uint32_t)where;
    return status;
}

#define TRY(call)                                                                                            \
    do {                                                                                                     \
        seld_scene_status status_of_call = (call);                                                           \
        if (status_of_call != SELD_SCENE_OK) return status_of_call;                                          \
    } while (0)

static bool is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static const uint8_t magic[8] = {'S', 'E', 'L', 'D', 'S', 'C', 'N', 0};

/* Version before CRC: what a newer version protects by its CRC is not ours to know. */
static seld_scene_status check_version(seld_scene_check *check)
{
    const uint8_t *b = check->bytes;
    if (check->size == 0) return seld_scene_fault_at(check, SELD_SCENE_TRUNCATED, 0); /* bytes may be NULL */
    if (check->size < sizeof magic || memcmp(b, magic, sizeof magic) != 0) {
        bool begins = check->size < sizeof magic && memcmp(b, magic, check->size) == 0;
        return seld_scene_fault_at(check, begins ? SELD_SCENE_TRUNCATED : SELD_SCENE_MAGIC, 0);
    }
    if (check->size < SELD_SCENE_HEADER_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_TRUNCATED, check->size);
    uint16_t major = seld_scene_u16(b + 8), minor = seld_scene_u16(b + 10);
    if (major > SELD_SCENE_MAJOR || (major == SELD_SCENE_MAJOR && minor > SELD_SCENE_MINOR))
        return seld_scene_fault_at(check, SELD_SCENE_NEWER, 8);
    if (major < SELD_SCENE_MAJOR) return seld_scene_fault_at(check, SELD_SCENE_OLDER, 8);
    check->minor = minor;
    return SELD_SCENE_OK;
}

static seld_scene_status check_size(seld_scene_check *check)
{
    const uint8_t *b = check->bytes;
    uint32_t kind = seld_scene_u32(b + 12), total = seld_scene_u32(b + 16);
    if (kind != SELD_SCENE_KIND_SCENE && kind != SELD_SCENE_KIND_BODIES)
        return seld_scene_fault_at(check, SELD_SCENE_KIND, 12);
    check->kind = (seld_scene_kind)kind;
    uint32_t limit = kind == SELD_SCENE_KIND_SCENE ? SELD_SCENE_BYTES_MAX : SELD_SCENE_BODIES_BYTES_MAX;
    if (total > limit) return seld_scene_fault_at(check, SELD_SCENE_OVERSIZED, 16);
    if (check->size < total) return seld_scene_fault_at(check, SELD_SCENE_TRUNCATED, check->size);
    if (check->size > total) return seld_scene_fault_at(check, SELD_SCENE_TRAILING, total);
    return SELD_SCENE_OK;
}

static seld_scene_status check_header(seld_scene_check *check)
{
    const uint8_t *b = check->bytes;
    TRY(check_version(check));
    TRY(check_size(check));
    check->section_count = seld_scene_u32(b + 20);
    bool is_scene = check->kind == SELD_SCENE_KIND_SCENE;
    if (is_scene ? check->section_count < 3 || check->section_count > 6
                 : check->section_count < 2 || check->section_count > 4 + SELD_SCENE_BODY_MAX)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_COUNT, 20);
    check->table_end = SELD_SCENE_HEADER_BYTES + check->section_count * SELD_SCENE_TABLE_ROW_BYTES;
    if (check->size < check->table_end) return seld_scene_fault_at(check, SELD_SCENE_SECTION_PLACE, 20);
    const bool has_partner =
        !is_scene && seld_scene_section_span(b, check->section_count - 1).type == SELD_SCENE_PARTNER;
    check->content_count = check->section_count - (has_partner ? 1u : 0u);
    static const uint8_t no_crc[4] = {0, 0, 0, 0};
    uint32_t crc = seld_wire_crc32(0, b, 24);
    crc = seld_wire_crc32(crc, no_crc, sizeof no_crc);
    crc = seld_wire_crc32(crc, b + 28, check->table_end - 28);
    if (crc != seld_scene_u32(b + 24)) return seld_scene_fault_at(check, SELD_SCENE_HEADER_CRC, 24);
    if (seld_scene_u32(b + 28) != 0) return seld_scene_fault_at(check, SELD_SCENE_RESERVED, 28);
    return SELD_SCENE_OK;
}

/* --- section table --- */
seld_scene_span seld_scene_section_span(const uint8_t *bytes, uint32_t index)
{
    const uint8_t *row = bytes + SELD_SCENE_HEADER_BYTES + (size_t)index * SELD_SCENE_TABLE_ROW_BYTES;
    seld_scene_span span = {seld_scene_u32(row), seld_scene_u32(row + 4), seld_scene_u32(row + 8)};
    return span;
}

/* A body file ends with its bodies, or with one tree behind them, or with that tree's lesions behind it; and behind all of
 * these may be what names its scene. */
static bool section_type_fits(const seld_scene_check *check, uint32_t index, uint32_t type)
{
    static const uint32_t scene_types[5] = {SELD_SCENE_META, SELD_SCENE_ENTRY, SELD_SCENE_LUMEN,
                                            SELD_SCENE_MOTION, SELD_SCENE_BREATH};
    if (check->kind == SELD_SCENE_KIND_SCENE && index >= 3 && index == check->section_count - 1 &&
        type == SELD_SCENE_PLAQUES)
        return true;
    if (check->kind == SELD_SCENE_KIND_SCENE) return index < 5 && type == scene_types[index];
    if (index == 0) return type == SELD_SCENE_META;
    if (index == check->content_count) return index >= 2; /* PARTNER, behind something */
    const uint32_t left = check->content_count - 1 - index;
    if (left == 0 && type == SELD_SCENE_LESIONS)
        return seld_scene_section_span(check->bytes, index - 1).type == SELD_SCENE_TREE;
    if (type == SELD_SCENE_TREE)
        return left == 0 ||
               (left == 1 && seld_scene_section_span(check->bytes, index + 1).type == SELD_SCENE_LESIONS);
    return type == SELD_SCENE_BODY && index <= SELD_SCENE_BODY_MAX;
}

static seld_scene_status check_zeros(seld_scene_check *check, size_t from, size_t to)
{
    for (size_t i = from; i < to; i++) {
        if (check->bytes[i] != 0) return seld_scene_fault_at(check, SELD_SCENE_RESERVED, i);
    }
    return SELD_SCENE_OK;
}

/* One section: type, place right behind the one before (padded with zeros), CRC. */
static seld_scene_status check_section(seld_scene_check *check, uint32_t index, size_t *end)
{
    size_t row = SELD_SCENE_HEADER_BYTES + (size_t)index * SELD_SCENE_TABLE_ROW_BYTES;
    seld_scene_span span = seld_scene_section_span(check->bytes, index);
    if (!section_type_fits(check, index, span.type))
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_TYPE, row);
    size_t begin = (*end + SELD_SCENE_ALIGNMENT - 1) & ~(size_t)(SELD_SCENE_ALIGNMENT - 1);
    if (span.offset != begin || begin > check->size || span.size > check->size - begin)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_PLACE, row + 4);
    TRY(check_zeros(check, *end, begin));
    if (seld_wire_crc32(0, check->bytes + begin, span.size) != seld_scene_u32(check->bytes + row + 12))
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_CRC, begin);
    *end = begin + span.size;
    return SELD_SCENE_OK;
}

static seld_scene_status check_table(seld_scene_check *check)
{
    size_t end = check->table_end;
    for (uint32_t i = 0; i < check->section_count; i++) TRY(check_section(check, i, &end));
    size_t total = (end + SELD_SCENE_ALIGNMENT - 1) & ~(size_t)(SELD_SCENE_ALIGNMENT - 1);
    if (total != check->size) return seld_scene_fault_at(check, SELD_SCENE_SECTION_PLACE, end);
    return check_zeros(check, end, total);
}

/* --- sections --- */
seld_scene_status seld_scene_check_text(seld_scene_check *check, size_t where, size_t capacity)
{
    const uint8_t *text = check->bytes + where;
    size_t length = 0;
    while (length < capacity && text[length] != 0) {
        if (text[length] < 0x20 || text[length] == 0x7f)
            return seld_scene_fault_at(check, SELD_SCENE_TEXT, where + length);
        length++;
    }
    if (length == capacity) return seld_scene_fault_at(check, SELD_SCENE_TEXT, where);
    for (size_t i = length; i < capacity; i++) {
        if (text[i] != 0) return seld_scene_fault_at(check, SELD_SCENE_TEXT, where + i);
    }
    return SELD_SCENE_OK;
}

static seld_scene_status check_meta(seld_scene_check *check, seld_scene_span span, seld_scene *scene)
{
    if (span.size != SELD_SCENE_META_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    TRY(seld_scene_check_text(check, span.offset, SELD_SCENE_NAME_BYTES));
    TRY(seld_scene_check_text(check, span.offset + SELD_SCENE_NAME_BYTES, SELD_SCENE_SOURCE_BYTES));
    scene->name = (const char *)check->bytes + span.offset;
    scene->source = scene->name + SELD_SCENE_NAME_BYTES;
    return SELD_SCENE_OK;
}

static seld_scene_status check_entry(seld_scene_check *check, seld_scene_span span, seld_scene *scene)
{
    if (span.size != SELD_SCENE_ENTRY_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    const int64_t one_q60 = (int64_t)1 << 60,
                  tolerance_q60 = (int64_t)1 << 41; /* 2^-19: 1e-6 of the length */
    uint64_t square_q60 = 0;
    for (int k = 0; k < 3; k++) {
        int32_t position = seld_scene_i32(check->bytes + span.offset + 4 * k);
        int32_t direction = seld_scene_i32(check->bytes + span.offset + 12 + 4 * k);
        if (position > SELD_SCENE_ENTRY_REACH_Q30 || position < -SELD_SCENE_ENTRY_REACH_Q30)
            return seld_scene_fault_at(check, SELD_SCENE_ENTRY_POSITION, span.offset + (size_t)(4 * k));
        scene->entry_position_m_q30[k] = position;
        scene->entry_direction_q30[k] = direction;
        square_q60 += (uint64_t)((int64_t)direction * direction);
    }
    if (square_q60 > (uint64_t)(one_q60 + tolerance_q60) || square_q60 < (uint64_t)(one_q60 - tolerance_q60))
        return seld_scene_fault_at(check, SELD_SCENE_ENTRY_DIRECTION, span.offset + 12);
    return SELD_SCENE_OK;
}

/* Any size and CRC-32 will do: whether they are those of a scene is for whoever has that scene to say. */
static seld_scene_status check_partner(seld_scene_check *check, seld_scene *scene)
{
    if (check->content_count == check->section_count) return SELD_SCENE_OK;
    const seld_scene_span span = seld_scene_section_span(check->bytes, check->content_count);
    if (span.size != SELD_SCENE_PARTNER_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    scene->has_partner = true;
    scene->partner_bytes = seld_scene_u32(check->bytes + span.offset);
    scene->partner_crc32 = seld_scene_u32(check->bytes + span.offset + 4);
    return SELD_SCENE_OK;
}

static seld_scene_status check_body_file(seld_scene_check *check, seld_scene *scene)
{
    seld_scene_span last = seld_scene_section_span(check->bytes, check->content_count - 1), lesions = last;
    scene->body_count = check->content_count - 1;
    TRY(check_partner(check, scene));
    if (lesions.type == SELD_SCENE_LESIONS) {
        scene->body_count--;
        scene->lesions = check->bytes + lesions.offset;
        last = seld_scene_section_span(check->bytes, check->content_count - 2);
    }
    if (last.type == SELD_SCENE_TREE) {
        scene->body_count--;
        scene->tree = check->bytes + last.offset;
        TRY(seld_scene_check_tree(check, last, &scene->branch_count));
    }
    if (scene->lesions != NULL) TRY(seld_scene_check_lesions(check, lesions, scene, &scene->lesion_count));
    return seld_scene_check_bodies(check, scene->body_count);
}

static seld_scene_status check_scene(seld_scene_check *check, seld_scene *scene)
{
    TRY(check_meta(check, seld_scene_section_span(check->bytes, 0), scene));
    if (check->kind == SELD_SCENE_KIND_BODIES) return check_body_file(check, scene);
    TRY(check_entry(check, seld_scene_section_span(check->bytes, 1), scene));
    TRY(seld_scene_check_lumen(check, seld_scene_section_span(check->bytes, 2), &scene->lumen));
    const seld_scene_span last = seld_scene_section_span(check->bytes, check->section_count - 1);
    if (last.type == SELD_SCENE_PLAQUES) {
        scene->plaques = check->bytes + last.offset;
        TRY(seld_scene_check_plaques(check, last, &scene->plaque_count));
    }
    const uint32_t moving = check->section_count - 3 - (last.type == SELD_SCENE_PLAQUES ? 1u : 0u);
    scene->has_motion = moving > 0;
    scene->has_breath = moving > 1;
    if (scene->has_motion)
        TRY(seld_scene_check_motion(check, seld_scene_section_span(check->bytes, 3), &scene->motion));
    if (scene->has_breath)
        TRY(seld_scene_check_motion(check, seld_scene_section_span(check->bytes, 4), &scene->breath));
    return SELD_SCENE_OK;
}

seld_scene_status seld_scene_open(const uint8_t *bytes, size_t size, seld_scene *scene, uint32_t *where_byte)
{
    seld_scene_check check = {.bytes = bytes, .size = size, .kind = SELD_SCENE_KIND_SCENE};
    seld_scene found;
    memset(&found, 0, sizeof found);
    seld_scene_status status = SELD_SCENE_OK;
    if (((uintptr_t)bytes & (SELD_SCENE_ADDRESS_MULTIPLE - 1)) != 0) status = SELD_SCENE_UNALIGNED;
    if (!is_little_endian()) status = SELD_SCENE_BYTE_ORDER;
    if (status == SELD_SCENE_OK) status = check_header(&check);
    if (status == SELD_SCENE_OK) status = check_table(&check);
    if (status == SELD_SCENE_OK) status = check_scene(&check, &found);
    if (where_byte != NULL) *where_byte = status == SELD_SCENE_OK ? 0 : check.where;
    if (status != SELD_SCENE_OK) return status;
    found.kind = check.kind;
    found.bytes = bytes;
    found.hash = seld_scene_u32(bytes + 24);
    *scene = found;
    return SELD_SCENE_OK;
}
