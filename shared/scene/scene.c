/* This file checks a scene container (scene.h): first the header, then the section table, then the sections.
 */
#include "shared/scene/scene.h"
#include "shared/scene/scene_check.h"
#include "shared/wire/wire_frame.h"

#include <string.h>

uint16_t crn_scene_u16(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] | bytes[1] << 8);
}

uint32_t crn_scene_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

int32_t crn_scene_i32(const uint8_t *bytes)
{
    uint32_t word = crn_scene_u32(bytes);
    return word <= INT32_MAX ? (int32_t)word : -(int32_t)(UINT32_MAX - word) - 1;
}

crn_scene_status crn_scene_fault_at(crn_scene_check *check, crn_scene_status status, size_t where)
{
    check->where = (uint32_t)where;
    return status;
}

#define TRY(call)                                                                                            \
    do {                                                                                                     \
        crn_scene_status status_of_call = (call);                                                            \
        if (status_of_call != CRN_SCENE_OK) return status_of_call;                                           \
    } while (0)

static bool is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static const uint8_t magic[8] = {'C', 'R', 'N', '-', 'S', 'C', 'N', 0};
/* Scenes that were made before the project was renamed begin with the mark `earlier_magic`; apart from this
 * mark, old and new scenes have the same format. */
static const uint8_t earlier_magic[8] = {0x53, 0x45, 0x4c, 0x44, 'S', 'C', 'N', 0};

/* Returns true also for a file that is shorter than the mark at a scene's beginning, if all bytes of the file
 * equal the first bytes of the mark. */
static bool begins_as_a_scene(const uint8_t *bytes, size_t size)
{
    const size_t there = size < sizeof magic ? size : sizeof magic;
    return memcmp(bytes, magic, there) == 0 || memcmp(bytes, earlier_magic, there) == 0;
}

/* The version is checked before the CRC, because this reader cannot know what a newer version protects by its
 * CRC. */
static crn_scene_status check_version(crn_scene_check *check)
{
    const uint8_t *b = check->bytes;
    if (check->size == 0) return crn_scene_fault_at(check, CRN_SCENE_TRUNCATED, 0); /* bytes may be NULL */
    if (!begins_as_a_scene(b, check->size)) return crn_scene_fault_at(check, CRN_SCENE_MAGIC, 0);
    if (check->size < sizeof magic) return crn_scene_fault_at(check, CRN_SCENE_TRUNCATED, 0);
    if (check->size < CRN_SCENE_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_TRUNCATED, check->size);
    uint16_t major = crn_scene_u16(b + 8), minor = crn_scene_u16(b + 10);
    if (major > CRN_SCENE_MAJOR || (major == CRN_SCENE_MAJOR && minor > CRN_SCENE_MINOR))
        return crn_scene_fault_at(check, CRN_SCENE_NEWER, 8);
    if (major < CRN_SCENE_MAJOR) return crn_scene_fault_at(check, CRN_SCENE_OLDER, 8);
    check->minor = minor;
    return CRN_SCENE_OK;
}

static crn_scene_status check_size(crn_scene_check *check)
{
    const uint8_t *b = check->bytes;
    uint32_t kind = crn_scene_u32(b + 12), total = crn_scene_u32(b + 16);
    if (kind != CRN_SCENE_KIND_SCENE && kind != CRN_SCENE_KIND_BODIES)
        return crn_scene_fault_at(check, CRN_SCENE_KIND, 12);
    check->kind = (crn_scene_kind)kind;
    uint32_t limit = kind == CRN_SCENE_KIND_SCENE ? CRN_SCENE_BYTES_MAX : CRN_SCENE_BODIES_BYTES_MAX;
    if (total > limit) return crn_scene_fault_at(check, CRN_SCENE_OVERSIZED, 16);
    if (check->size < total) return crn_scene_fault_at(check, CRN_SCENE_TRUNCATED, check->size);
    if (check->size > total) return crn_scene_fault_at(check, CRN_SCENE_TRAILING, total);
    return CRN_SCENE_OK;
}

static crn_scene_status check_header(crn_scene_check *check)
{
    const uint8_t *b = check->bytes;
    TRY(check_version(check));
    TRY(check_size(check));
    check->section_count = crn_scene_u32(b + 20);
    bool is_scene = check->kind == CRN_SCENE_KIND_SCENE;
    if (is_scene ? check->section_count < 3 || check->section_count > 7
                 : check->section_count < 2 || check->section_count > 4 + CRN_SCENE_BODY_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_COUNT, 20);
    check->table_end = CRN_SCENE_HEADER_BYTES + check->section_count * CRN_SCENE_TABLE_ROW_BYTES;
    if (check->size < check->table_end) return crn_scene_fault_at(check, CRN_SCENE_SECTION_PLACE, 20);
    const bool has_partner =
        !is_scene && crn_scene_section_span(b, check->section_count - 1).type == CRN_SCENE_PARTNER;
    check->content_count = check->section_count - (has_partner ? 1u : 0u);
    static const uint8_t no_crc[4] = {0, 0, 0, 0};
    uint32_t crc = crn_wire_crc32(0, b, 24);
    crc = crn_wire_crc32(crc, no_crc, sizeof no_crc);
    crc = crn_wire_crc32(crc, b + 28, check->table_end - 28);
    if (crc != crn_scene_u32(b + 24)) return crn_scene_fault_at(check, CRN_SCENE_HEADER_CRC, 24);
    if (crn_scene_u32(b + 28) != 0) return crn_scene_fault_at(check, CRN_SCENE_RESERVED, 28);
    return CRN_SCENE_OK;
}

/* --- section table --- */
crn_scene_span crn_scene_section_span(const uint8_t *bytes, uint32_t index)
{
    const uint8_t *row = bytes + CRN_SCENE_HEADER_BYTES + (size_t)index * CRN_SCENE_TABLE_ROW_BYTES;
    crn_scene_span span = {crn_scene_u32(row), crn_scene_u32(row + 4), crn_scene_u32(row + 8)};
    return span;
}

/* A body file ends with its bodies, or with a vessel tree after the bodies. The small vessels of this tree
 * and its lesions may follow. After the bodies, the tree and its parts, one more section may follow, which
 * names the scene to which the body file belongs. */
static bool section_type_fits(const crn_scene_check *check, uint32_t index, uint32_t type)
{
    static const uint32_t scene_types[5] = {CRN_SCENE_META, CRN_SCENE_ENTRY, CRN_SCENE_LUMEN,
                                            CRN_SCENE_MOTION, CRN_SCENE_BREATH};
    const bool is_last = index == check->section_count - 1;
    if (check->kind == CRN_SCENE_KIND_SCENE && index >= 3 && is_last && type == CRN_SCENE_WALLS) return true;
    if (check->kind == CRN_SCENE_KIND_SCENE && index >= 3 && type == CRN_SCENE_PLAQUES)
        return is_last || (index == check->section_count - 2 &&
                           crn_scene_section_span(check->bytes, index + 1).type == CRN_SCENE_WALLS);
    if (check->kind == CRN_SCENE_KIND_SCENE) return index < 5 && type == scene_types[index];
    if (index == 0) return type == CRN_SCENE_META;
    if (index == check->content_count) return index >= 2; /* PARTNER, behind something */
    const uint32_t left = check->content_count - 1 - index;
    const uint32_t before = crn_scene_section_span(check->bytes, index - 1).type;
    if (type == CRN_SCENE_LESIONS)
        return left == 0 && (before == CRN_SCENE_TREE || before == CRN_SCENE_SMALL);
    const uint32_t after =
        left > 0 ? crn_scene_section_span(check->bytes, index + 1).type : CRN_SCENE_LESIONS;
    if (type == CRN_SCENE_SMALL) return after == CRN_SCENE_LESIONS && before == CRN_SCENE_TREE;
    if (type == CRN_SCENE_TREE) return after == CRN_SCENE_LESIONS || after == CRN_SCENE_SMALL;
    return type == CRN_SCENE_BODY && index <= CRN_SCENE_BODY_MAX;
}

static crn_scene_status check_zeros(crn_scene_check *check, size_t from, size_t to)
{
    for (size_t i = from; i < to; i++) {
        if (check->bytes[i] != 0) return crn_scene_fault_at(check, CRN_SCENE_RESERVED, i);
    }
    return CRN_SCENE_OK;
}

/* Checks one section: type, position right behind the one before (padded with zeros), CRC. */
static crn_scene_status check_section(crn_scene_check *check, uint32_t index, size_t *end)
{
    size_t row = CRN_SCENE_HEADER_BYTES + (size_t)index * CRN_SCENE_TABLE_ROW_BYTES;
    crn_scene_span span = crn_scene_section_span(check->bytes, index);
    if (!section_type_fits(check, index, span.type))
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_TYPE, row);
    size_t begin = (*end + CRN_SCENE_ALIGNMENT - 1) & ~(size_t)(CRN_SCENE_ALIGNMENT - 1);
    if (span.offset != begin || begin > check->size || span.size > check->size - begin)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_PLACE, row + 4);
    TRY(check_zeros(check, *end, begin));
    if (crn_wire_crc32(0, check->bytes + begin, span.size) != crn_scene_u32(check->bytes + row + 12))
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_CRC, begin);
    *end = begin + span.size;
    return CRN_SCENE_OK;
}

static crn_scene_status check_table(crn_scene_check *check)
{
    size_t end = check->table_end;
    for (uint32_t i = 0; i < check->section_count; i++) TRY(check_section(check, i, &end));
    size_t total = (end + CRN_SCENE_ALIGNMENT - 1) & ~(size_t)(CRN_SCENE_ALIGNMENT - 1);
    if (total != check->size) return crn_scene_fault_at(check, CRN_SCENE_SECTION_PLACE, end);
    return check_zeros(check, end, total);
}

/* --- sections --- */
crn_scene_status crn_scene_check_text(crn_scene_check *check, size_t where, size_t capacity)
{
    const uint8_t *text = check->bytes + where;
    size_t length = 0;
    while (length < capacity && text[length] != 0) {
        if (text[length] < 0x20 || text[length] == 0x7f)
            return crn_scene_fault_at(check, CRN_SCENE_TEXT, where + length);
        length++;
    }
    if (length == capacity) return crn_scene_fault_at(check, CRN_SCENE_TEXT, where);
    for (size_t i = length; i < capacity; i++) {
        if (text[i] != 0) return crn_scene_fault_at(check, CRN_SCENE_TEXT, where + i);
    }
    return CRN_SCENE_OK;
}

static crn_scene_status check_meta(crn_scene_check *check, crn_scene_span span, crn_scene *scene)
{
    if (span.size != CRN_SCENE_META_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    TRY(crn_scene_check_text(check, span.offset, CRN_SCENE_NAME_BYTES));
    TRY(crn_scene_check_text(check, span.offset + CRN_SCENE_NAME_BYTES, CRN_SCENE_SOURCE_BYTES));
    scene->name = (const char *)check->bytes + span.offset;
    scene->source = scene->name + CRN_SCENE_NAME_BYTES;
    return CRN_SCENE_OK;
}

static crn_scene_status check_entry(crn_scene_check *check, crn_scene_span span, crn_scene *scene)
{
    const bool has_start = check->minor >= 6 && span.size == CRN_SCENE_ENTRY_START_BYTES;
    if (span.size != CRN_SCENE_ENTRY_BYTES && !has_start)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const int64_t one_q60 = (int64_t)1 << 60,
                  tolerance_q60 = (int64_t)1 << 41; /* 2^-19: 1e-6 of the length */
    uint64_t square_q60 = 0;
    for (int k = 0; k < 3; k++) {
        int32_t position = crn_scene_i32(check->bytes + span.offset + 4 * k);
        int32_t direction = crn_scene_i32(check->bytes + span.offset + 12 + 4 * k);
        if (position > CRN_SCENE_ENTRY_REACH_Q30 || position < -CRN_SCENE_ENTRY_REACH_Q30)
            return crn_scene_fault_at(check, CRN_SCENE_ENTRY_POSITION, span.offset + (size_t)(4 * k));
        scene->entry_position_m_q30[k] = position;
        scene->entry_direction_q30[k] = direction;
        square_q60 += (uint64_t)((int64_t)direction * direction);
    }
    if (square_q60 > (uint64_t)(one_q60 + tolerance_q60) || square_q60 < (uint64_t)(one_q60 - tolerance_q60))
        return crn_scene_fault_at(check, CRN_SCENE_ENTRY_DIRECTION, span.offset + 12);
    if (!has_start) return CRN_SCENE_OK;
    scene->entry_start_um = crn_scene_u32(check->bytes + span.offset + CRN_SCENE_ENTRY_BYTES);
    if (scene->entry_start_um == 0 || scene->entry_start_um > CRN_SCENE_ENTRY_START_MAX_um)
        return crn_scene_fault_at(check, CRN_SCENE_ENTRY_START, span.offset + CRN_SCENE_ENTRY_BYTES);
    return CRN_SCENE_OK;
}

/* The check accepts any size and CRC-32 of the named scene, because only a program that has this scene can
 * compare them. */
static crn_scene_status check_partner(crn_scene_check *check, crn_scene *scene)
{
    if (check->content_count == check->section_count) return CRN_SCENE_OK;
    const crn_scene_span span = crn_scene_section_span(check->bytes, check->content_count);
    if (span.size != CRN_SCENE_PARTNER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    scene->has_partner = true;
    scene->partner_bytes = crn_scene_u32(check->bytes + span.offset);
    scene->partner_crc32 = crn_scene_u32(check->bytes + span.offset + 4);
    return CRN_SCENE_OK;
}

static crn_scene_status check_body_file(crn_scene_check *check, crn_scene *scene)
{
    crn_scene_span last = crn_scene_section_span(check->bytes, check->content_count - 1), lesions = last;
    crn_scene_span small = last;
    scene->body_count = check->content_count - 1;
    TRY(check_partner(check, scene));
    if (lesions.type == CRN_SCENE_LESIONS) {
        scene->lesions = check->bytes + lesions.offset;
        last = small = crn_scene_section_span(check->bytes, --scene->body_count);
    }
    if (small.type == CRN_SCENE_SMALL) {
        scene->small = check->bytes + small.offset;
        last = crn_scene_section_span(check->bytes, --scene->body_count);
    }
    if (last.type == CRN_SCENE_TREE) {
        scene->body_count--;
        scene->tree = check->bytes + last.offset;
        TRY(crn_scene_check_tree(check, last, &scene->branch_count));
    }
    if (scene->small != NULL) TRY(crn_scene_check_small(check, small, scene, &scene->small_count));
    if (scene->lesions != NULL) TRY(crn_scene_check_lesions(check, lesions, scene, &scene->lesion_count));
    return crn_scene_check_bodies(check, scene->body_count);
}

static crn_scene_status check_scene(crn_scene_check *check, crn_scene *scene)
{
    TRY(check_meta(check, crn_scene_section_span(check->bytes, 0), scene));
    if (check->kind == CRN_SCENE_KIND_BODIES) return check_body_file(check, scene);
    TRY(check_entry(check, crn_scene_section_span(check->bytes, 1), scene));
    TRY(crn_scene_check_lumen(check, crn_scene_section_span(check->bytes, 2), &scene->lumen));
    uint32_t left = check->section_count - 3;
    crn_scene_span last = crn_scene_section_span(check->bytes, 2 + left);
    if (last.type == CRN_SCENE_WALLS) {
        TRY(crn_scene_check_walls(check, last, scene));
        last = crn_scene_section_span(check->bytes, 2 + --left);
    }
    if (last.type == CRN_SCENE_PLAQUES) {
        scene->plaques = check->bytes + last.offset;
        TRY(crn_scene_check_plaques(check, last, &scene->plaque_count));
        left--;
    }
    const uint32_t moving = left;
    scene->has_motion = moving > 0;
    scene->has_breath = moving > 1;
    if (scene->has_motion)
        TRY(crn_scene_check_motion(check, crn_scene_section_span(check->bytes, 3), &scene->motion));
    if (scene->has_breath)
        TRY(crn_scene_check_motion(check, crn_scene_section_span(check->bytes, 4), &scene->breath));
    return CRN_SCENE_OK;
}

/* Requirement: SR-20 */
crn_scene_status crn_scene_open(const uint8_t *bytes, size_t size, crn_scene *scene, uint32_t *where_byte)
{
    crn_scene_check check = {.bytes = bytes, .size = size, .kind = CRN_SCENE_KIND_SCENE};
    crn_scene found;
    memset(&found, 0, sizeof found);
    crn_scene_status status = CRN_SCENE_OK;
    if (((uintptr_t)bytes & (CRN_SCENE_ADDRESS_MULTIPLE - 1)) != 0) status = CRN_SCENE_UNALIGNED;
    if (!is_little_endian()) status = CRN_SCENE_BYTE_ORDER;
    if (status == CRN_SCENE_OK) status = check_header(&check);
    if (status == CRN_SCENE_OK) status = check_table(&check);
    if (status == CRN_SCENE_OK) status = check_scene(&check, &found);
    if (where_byte != NULL) *where_byte = status == CRN_SCENE_OK ? 0 : check.where;
    if (status != CRN_SCENE_OK) return status;
    found.kind = check.kind;
    found.bytes = bytes;
    found.hash = crn_scene_u32(bytes + 24);
    *scene = found;
    return CRN_SCENE_OK;
}
