/* Near memory (near.h, docs/near.md): its layout, and the copying of what is missing. */
#include "firmware/core/near/near.h"

enum {
    CANDIDATES = 8, /* slots among which the one used longest ago makes room */
    SLOTS_MIN = 96, /* bricks that a line of tools may touch within a tick */
    SLOTS_MAX = 1024,
    /* Nodes of the lattice for every two bricks: the shipped sessions read at most 197 bricks and 399 nodes
     * within a tick, and return to others within a beat. */
    NODES_PER_TWO = 5,
    NUMBERS_MAX = UINT16_MAX, /* entries and bricks have numbers of 16 bits */
    BRICKS_MAX = 0x7fff - CRN_NEAR_ENTRY_FIRST_BRICK - SLOTS_MAX,
    NEVER = UINT16_MAX / 2, /* age of what was never used */
    SLOT_BYTES = CRN_NEAR_BRICK_BYTES + sizeof(crn_near_slot),
    NODE_BYTES = 2 * CRN_NEAR_NODE_NUMBERS + sizeof(crn_near_node),
    PADDING_BYTES = 5 * CRN_NEAR_ALIGNMENT, /* of the parts behind those that are copied as a whole */
};

static uint32_t padded(uint32_t bytes)
{
    return (bytes + CRN_NEAR_ALIGNMENT - 1u) & ~(CRN_NEAR_ALIGNMENT - 1u);
}

/* --- how much a scene needs --- */

typedef struct near_range {
    uint32_t first, end;
} near_range;

/* The columns of a line of the coarse index outside of which all entries are OUTSIDE. */
static near_range used_columns(const uint16_t *entries, uint32_t count)
{
    near_range range = {0, count};
    while (range.end > 0 && entries[range.end - 1] == CRN_NEAR_ENTRY_OUTSIDE) range.end--;
    while (range.first < range.end && entries[range.first] == CRN_NEAR_ENTRY_OUTSIDE) range.first++;
    return range;
}

static uint32_t entries_of(const crn_near_scene *scene)
{
    uint32_t count = scene->child_count;
    for (uint32_t line = 0; line < scene->lines; line++) {
        const near_range range = used_columns(scene->index + (size_t)line * scene->columns, scene->columns);
        count += range.end - range.first;
    }
    return count;
}

uint32_t crn_near_bytes_min(const crn_near_scene *scene)
{
    const uint32_t entries = entries_of(scene);
    if (entries > NUMBERS_MAX || scene->brick_count > BRICKS_MAX) {
        return UINT32_MAX;
    }
    uint32_t bytes = padded(sizeof(crn_near)) + padded((scene->lines + 1) * (uint32_t)sizeof(crn_near_span)) +
                     padded(entries * (uint32_t)sizeof(uint16_t));
    for (uint32_t i = 0; i < scene->whole_count; i++) bytes += padded(scene->whole[i].bytes);
    bytes += PADDING_BYTES + SLOTS_MIN * SLOT_BYTES;
    return scene->rows == NULL ? bytes
                               : bytes + CRN_NEAR_LISTS * (uint32_t)sizeof(uint16_t) +
                                     SLOTS_MIN * NODES_PER_TWO / 2 * NODE_BYTES;
}

/* --- layout --- */

/* The memory that is not given away yet. */
typedef struct near_rest {
    uint8_t *next;
    uint32_t bytes;
} near_rest;

static void *take(near_rest *rest, uint32_t bytes)
{
    void *part = rest->next;
    rest->next += padded(bytes);
    rest->bytes -= padded(bytes);
    return part;
}

static const void *copy_whole(near_rest *rest, const crn_near_whole *whole)
{
    uint8_t *to = take(rest, whole->bytes);
    const uint8_t *from = whole->part;
    for (uint32_t i = 0; i < whole->bytes; i++) to[i] = from[i];
    return to;
}

static void copy_index(crn_near *near, const crn_near_scene *scene, crn_near_span *spans)
{
    uint32_t at = 0;
    for (uint32_t line = 0; line < scene->lines; line++) {
        const uint16_t *entries = scene->index + (size_t)line * scene->columns;
        const near_range range = used_columns(entries, scene->columns);
        spans[line] = (crn_near_span){(uint16_t)at, (uint16_t)range.first};
        for (uint32_t i = range.first; i < range.end; i++) near->entries[at++] = entries[i];
    }
    spans[scene->lines] = (crn_near_span){(uint16_t)at, 0};
    near->child_begin = at;
    for (uint32_t i = 0; i < scene->child_count; i++) near->entries[at++] = scene->children[i];
}

static void begin_nodes(crn_near *near, near_rest *rest, uint32_t count)
{
    near->node_count = count;
    near->nodes = take(rest, count * (uint32_t)sizeof(crn_near_node));
    near->numbers = take(rest, count * 2 * CRN_NEAR_NODE_NUMBERS);
    for (uint32_t i = 0; i < CRN_NEAR_LISTS; i++) near->lists[i] = 0;
    for (uint32_t i = 0; i < count; i++) near->nodes[i] = (crn_near_node){0, 0, 0};
}

static void begin_bricks(crn_near *near, near_rest *rest, uint32_t count)
{
    near->slot_count = count;
    near->slots = take(rest, count * (uint32_t)sizeof(crn_near_slot));
    near->bricks = take(rest, count * CRN_NEAR_BRICK_BYTES);
    for (uint32_t i = 0; i < count; i++) near->slots[i] = (crn_near_slot){0, 0, 0, 0};
}

static uint32_t at_most_slots(uint32_t count)
{
    return count < SLOTS_MAX ? count : SLOTS_MAX;
}

crn_near *crn_near_begin(void *memory, uint32_t bytes, const crn_near_scene *scene)
{
    near_rest rest = {memory, bytes};
    crn_near *near = take(&rest, sizeof *near);
    *near = (crn_near){
        .tick = NEVER, .brick_count = scene->brick_count, .samples = scene->samples, .rows = scene->rows};
    crn_near_span *spans = take(&rest, (scene->lines + 1) * (uint32_t)sizeof *spans);
    near->spans = spans;
    near->entries = take(&rest, entries_of(scene) * (uint32_t)sizeof *near->entries);
    copy_index(near, scene, spans);
    for (uint32_t i = 0; i < scene->whole_count; i++) near->whole[i] = copy_whole(&rest, &scene->whole[i]);
    if (scene->rows == NULL) {
        begin_bricks(near, &rest, at_most_slots((rest.bytes - PADDING_BYTES) / SLOT_BYTES));
        return near;
    }
    near->lists = take(&rest, CRN_NEAR_LISTS * (uint32_t)sizeof *near->lists);
    const uint32_t pairs =
        at_most_slots((rest.bytes - PADDING_BYTES) / (2 * SLOT_BYTES + NODES_PER_TWO * NODE_BYTES));
    begin_nodes(near, &rest, pairs * NODES_PER_TWO);
    begin_bricks(near, &rest, at_most_slots(2 * pairs));
    return near;
}

/* --- copying what is missing --- */

static uint32_t age_of(const crn_near *near, uint16_t used)
{
    return (near->tick - used) & UINT16_MAX;
}

/* Makes room for a brick: of the next few slots, the one used longest ago. The entry that led to it gets the
 * scene's number again. */
static uint32_t free_slot(crn_near *near)
{
    uint32_t oldest = near->slot_next, slot = near->slot_next;
    for (uint32_t i = 0; i < CANDIDATES; i++) {
        if (age_of(near, near->slots[slot].used) > age_of(near, near->slots[oldest].used)) {
            oldest = slot;
        }
        slot = slot + 1 < near->slot_count ? slot + 1 : 0;
    }
    near->slot_next = oldest + 1 < near->slot_count ? oldest + 1 : 0;
    const crn_near_slot *old = &near->slots[oldest];
    if (old->slices != 0) {
        near->entries[old->entry] = (uint16_t)(old->brick + CRN_NEAR_ENTRY_FIRST_BRICK);
    }
    return oldest;
}

static void copy_slice(int8_t *to, const int8_t *from)
{
    for (uint32_t i = 0; i < CRN_NEAR_SLICE_BYTES; i += 4) {
        __builtin_memcpy(to + i, from + i, 4);
    }
}

const int8_t *crn_near_copy_slices(crn_near *near, uint32_t at, uint32_t first_slice)
{
    const uint32_t brick_number = near->entries[at] - (uint32_t)CRN_NEAR_ENTRY_FIRST_BRICK;
    uint32_t number = brick_number - near->brick_count;
    if (brick_number < near->brick_count) {
        number = free_slot(near);
        near->slots[number] = (crn_near_slot){(uint16_t)at, (uint16_t)brick_number, 0, 0};
        near->entries[at] = (uint16_t)(near->brick_count + CRN_NEAR_ENTRY_FIRST_BRICK + number);
    }
    crn_near_slot *slot = &near->slots[number];
    int8_t *brick = near->bricks + (size_t)number * CRN_NEAR_BRICK_BYTES;
    const int8_t *samples = near->samples + (size_t)slot->brick * CRN_NEAR_BRICK_BYTES;
    for (uint32_t slice = first_slice; slice < first_slice + CRN_NEAR_SLICES_READ; slice++) {
        if ((slot->slices >> slice & 1u) == 0) {
            copy_slice(brick + slice * CRN_NEAR_SLICE_BYTES, samples + slice * CRN_NEAR_SLICE_BYTES);
            slot->slices |= (uint16_t)(1u << slice);
            near->slices_copied++;
        }
    }
    slot->used = (uint16_t)near->tick;
    return brick;
}

/* Makes room for a lattice node in the same way, and takes the old one out of its list. */
static uint32_t free_node(crn_near *near)
{
    uint32_t oldest = near->node_next, node = near->node_next;
    for (uint32_t i = 0; i < CANDIDATES; i++) {
        if (age_of(near, near->nodes[node].used) > age_of(near, near->nodes[oldest].used)) {
            oldest = node;
        }
        node = node + 1 < near->node_count ? node + 1 : 0;
    }
    near->node_next = oldest + 1 < near->node_count ? oldest + 1 : 0;
    const crn_near_node *old = &near->nodes[oldest];
    if (old->number != 0) {
        uint16_t *link = &near->lists[crn_near_list_of(old->number - 1)];
        while (*link != oldest + 1) link = &near->nodes[*link - 1].next;
        *link = old->next;
    }
    return oldest;
}

const int16_t *crn_near_copy_node(crn_near *near, uint32_t node)
{
    const uint32_t place = free_node(near);
    uint16_t *list = &near->lists[crn_near_list_of(node)];
    near->nodes[place] = (crn_near_node){node + 1, *list, (uint16_t)near->tick};
    *list = (uint16_t)(place + 1);
    int16_t *numbers = near->numbers + (size_t)place * CRN_NEAR_NODE_NUMBERS;
    const int16_t *from = near->rows + (size_t)node * CRN_NEAR_NODE_NUMBERS;
    for (uint32_t i = 0; i < CRN_NEAR_ROW; i++) {
        int16_t *to = numbers + CRN_NEAR_COMPONENTS * i;
        to[0] = from[i];
        to[1] = from[i + CRN_NEAR_ROW];
        to[2] = from[i + 2 * CRN_NEAR_ROW];
    }
    near->nodes_copied++;
    return numbers;
}
