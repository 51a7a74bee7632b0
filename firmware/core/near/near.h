/* Near memory: memory beside the processor that holds the parts of a scene which the tools touch, because the
 * scene itself lies in a large and slow memory. docs/near.md describes it, with measured figures.
 *
 * The core asks for two kinds of parts, and gets an address at which they can be read:
 *
 *     crn_near_brick()   the coefficients of a brick of the distance field
 *     crn_near_rows()    the coefficients of one node of the heartbeat's lattice
 *
 * A part that near memory lacks is copied from the scene, in place of one that was not used for long. The
 * index of the field and some small parts are copied as a whole when a scene is set up. What near memory
 * holds changes no result: copies have the scene's numbers, and no state depends on whether a part was there.
 *
 * The caller owns the memory. This folder knows neither the core nor a board: crn_lumen_near_begin() of
 * motion.h joins it to a lumen, and without it the core reads the scene in place. */
#ifndef CRN_NEAR_H
#define CRN_NEAR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    CRN_NEAR_ALIGNMENT = 32, /* of the memory: a line of the cache */
    CRN_NEAR_BRICK_BYTES = 1000,
    CRN_NEAR_SLICES = 10, /* of a brick, in the order of z; each is copied when it is first read */
    CRN_NEAR_SLICE_BYTES = CRN_NEAR_BRICK_BYTES / CRN_NEAR_SLICES,
    CRN_NEAR_SLICES_READ = 3, /* by a sample */
    CRN_NEAR_ROW = 26,        /* coefficients of a component of a lattice node */
    CRN_NEAR_COMPONENTS = 3,  /* of a lattice node */
    CRN_NEAR_NODE_NUMBERS = CRN_NEAR_ROW * CRN_NEAR_COMPONENTS,
    CRN_NEAR_LISTS = 1024,      /* of lattice nodes, by a hash of their numbers */
    CRN_NEAR_ENTRY_OUTSIDE = 0, /* entries of the index (lumen.h) */
    CRN_NEAR_ENTRY_FIRST_BRICK = 2,
    CRN_NEAR_WHOLE_MAX = 5,
};

/* A part that is copied as a whole. */
typedef struct crn_near_whole {
    const void *part;
    uint32_t bytes;
} crn_near_whole;

/* Where the parts of a scene lie. */
typedef struct crn_near_scene {
    const uint16_t *index; /* `lines` times `columns` entries */
    uint32_t columns, lines;
    const uint16_t *children; /* entries, too */
    uint32_t child_count;
    const int8_t *samples; /* CRN_NEAR_BRICK_BYTES of each brick */
    uint32_t brick_count;
    const int16_t *rows; /* CRN_NEAR_ROW numbers of each component of each node; NULL: the vessel is still */
    uint32_t whole_count;
    crn_near_whole whole[CRN_NEAR_WHOLE_MAX];
} crn_near_scene;

/* The entries of one line of the coarse index, from the first that is not OUTSIDE to the last. */
typedef struct crn_near_span {
    uint16_t begin; /* in `entries`; the next span's is the end */
    uint16_t column;
} crn_near_span;

/* A place for a brick. */
typedef struct crn_near_slot {
    uint16_t entry;  /* the entry of the index that leads here */
    uint16_t brick;  /* its number in the scene */
    uint16_t slices; /* bit k: slice k is here */
    uint16_t used;   /* the last tick that read it, 16 bits */
} crn_near_slot;

/* A place for a lattice node. */
typedef struct crn_near_node {
    uint32_t number; /* in the scene, plus one; 0: none is here */
    uint16_t next;   /* the next place in the list of nodes with the same hash, plus one; 0: the last */
    uint16_t used;   /* the last tick that read it, 16 bits */
} crn_near_node;

typedef struct crn_near {
    uint32_t tick;
    const crn_near_span *spans; /* of all lines of the coarse index, and one more for the end of the last */
    /* The coarse index by spans, then the children. Entries are those of the scene, except that brick_count +
     * CRN_NEAR_ENTRY_FIRST_BRICK + k stands for the brick in slot k. */
    uint16_t *entries;
    uint32_t child_begin;
    crn_near_slot *slots;
    uint32_t slot_count, slot_next; /* slot_next: where the next search for a slot begins */
    uint32_t brick_count;           /* of the scene */
    int8_t *bricks;                 /* CRN_NEAR_BRICK_BYTES of each slot */
    uint16_t *lists;                /* CRN_NEAR_LISTS: the first place of each list, plus one */
    crn_near_node *nodes;
    uint32_t node_count, node_next;       /* as for slots */
    int16_t *numbers;                     /* CRN_NEAR_NODE_NUMBERS of each node */
    uint32_t slices_copied, nodes_copied; /* since the scene was set up */
    const int8_t *samples;                /* of the scene */
    const int16_t *rows;                  /* of the scene */
    const void *whole[CRN_NEAR_WHOLE_MAX];
} crn_near;

/* Returns how many bytes of near memory a scene needs at least: for its index, for the parts that are copied
 * as a whole, and for the bricks and nodes that a line of tools reads in a tick. Reads the whole index, so it
 * is for set-up only. Returns UINT32_MAX if no memory suffices, because the index has too many entries. */
uint32_t crn_near_bytes_min(const crn_near_scene *scene);

/* Prepares near memory for a scene; the structure lies at the memory's begin. `memory` is a multiple of
 * CRN_NEAR_ALIGNMENT, and `bytes` should be crn_near_bytes_min() at least; the more, the more parts are held.
 * Whatever the memory held before is lost. */
crn_near *crn_near_begin(void *memory, uint32_t bytes, const crn_near_scene *scene);

/* Copies what is missing; for the two functions below. */
const int8_t *crn_near_copy_slices(crn_near *near, uint32_t at, uint32_t first_slice);
const int16_t *crn_near_copy_node(crn_near *near, uint32_t node);

/* Returns the brick to which entry `at` leads. CRN_NEAR_SLICES_READ of its slices can be read, from
 * `first_slice` on. */
static inline const int8_t *crn_near_brick(crn_near *near, uint32_t at, uint32_t first_slice)
{
    const uint32_t number = near->entries[at] - (uint32_t)CRN_NEAR_ENTRY_FIRST_BRICK - near->brick_count;
    if (number < near->slot_count) {
        crn_near_slot *slot = &near->slots[number];
        if ((~(uint32_t)slot->slices >> first_slice & 7u) == 0) {
            slot->used = (uint16_t)near->tick;
            return near->bricks + (size_t)number * CRN_NEAR_BRICK_BYTES;
        }
    }
    return crn_near_copy_slices(near, at, first_slice);
}

/* Returns the number that the scene gives to the brick of an entry. */
static inline uint32_t crn_near_brick_number(const crn_near *near, uint32_t entry)
{
    const uint32_t number = entry - (uint32_t)CRN_NEAR_ENTRY_FIRST_BRICK;
    const uint32_t slot = number - near->brick_count;
    return slot < near->slot_count ? near->slots[slot].brick : number;
}

/* Returns the list of a lattice node. Neighbours along each axis are in different lists. */
static inline uint32_t crn_near_list_of(uint32_t node)
{
    return (node ^ node >> 5 ^ node >> 10) % CRN_NEAR_LISTS;
}

/* Returns the coefficients of a lattice node: CRN_NEAR_COMPONENTS for each of CRN_NEAR_ROW keyframes. In the
 * scene it is the other way round; so the nine numbers that a tick reads lie together, in one or two lines of
 * the cache. */
static inline const int16_t *crn_near_rows(crn_near *near, uint32_t node)
{
    uint32_t at = near->lists[crn_near_list_of(node)];
    while (at != 0) {
        crn_near_node *here = &near->nodes[at - 1];
        if (here->number == node + 1) {
            here->used = (uint16_t)near->tick;
            return near->numbers + (size_t)(at - 1) * CRN_NEAR_NODE_NUMBERS;
        }
        at = here->next;
    }
    return crn_near_copy_node(near, node);
}

#endif
