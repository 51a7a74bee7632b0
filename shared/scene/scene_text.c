/* This file has one line of text for each status of the scene check, which says what is wrong and what to do.
 */
#include "shared/scene/scene.h"

const char *crn_scene_status_text(crn_scene_status status)
{
    static const char *const texts[CRN_SCENE_STATUS_COUNT] = {
        [CRN_SCENE_OK] = "the scene is good",
        [CRN_SCENE_UNALIGNED] = "the scene lies at an address that is no multiple of 4: align the buffer",
        [CRN_SCENE_BYTE_ORDER] =
            "scenes are little-endian and this processor is big-endian: run on another one",
        [CRN_SCENE_TRUNCATED] = "the file ends too early: copy or upload it again",
        [CRN_SCENE_TRAILING] = "bytes follow the end of the scene: copy or upload it again",
        [CRN_SCENE_OVERSIZED] = "larger than the limit: bake with a smaller lumen or a larger tolerance_mm",
        [CRN_SCENE_MAGIC] = "not a scene file: give a file written by bake",
        [CRN_SCENE_NEWER] = "written by a newer bake: update this program, or bake again with its own bake",
        [CRN_SCENE_OLDER] = "written by an older bake: bake it again",
        [CRN_SCENE_HEADER_CRC] = "header or section table is damaged: copy or bake it again",
        [CRN_SCENE_KIND] = "neither a scene nor a body file: bake it again",
        [CRN_SCENE_RESERVED] = "bytes that must be zero are not: bake it again",
        [CRN_SCENE_SECTION_COUNT] = "wrong number of sections: bake it again",
        [CRN_SCENE_SECTION_TYPE] = "a section does not belong in this file: bake it again",
        [CRN_SCENE_SECTION_PLACE] = "sections overlap, leave a gap or run past the end: bake it again",
        [CRN_SCENE_SECTION_SIZE] = "a section's size does not fit its contents: bake it again",
        [CRN_SCENE_SECTION_CRC] = "a section is damaged: copy or bake it again",
        [CRN_SCENE_TEXT] = "a name has no end or holds control characters: bake it again",
        [CRN_SCENE_ENTRY_POSITION] = "the entry lies farther than 1.9 m from the origin: move the scene",
        [CRN_SCENE_ENTRY_DIRECTION] = "the entry's direction is no unit vector: bake it again",
        [CRN_SCENE_LATTICE] =
            "the lumen's lattice is empty, over 512 bricks long or beyond 2 m: bake it again",
        [CRN_SCENE_CHILD_ROWS] = "the lumen's refinement table contradicts itself: bake it again",
        [CRN_SCENE_INDEX_BRICK] = "the lumen's index names a brick that is not there: bake it again",
        [CRN_SCENE_INDEX_ROW] = "the lumen's index names a refinement that is not there: bake it again",
        [CRN_SCENE_MOTION_LATTICE] =
            "the lattice of the vessel's motion is too large, too fine or beyond 2 m: bake it again",
        [CRN_SCENE_MOTION_VALUE] =
            "the vessel moves by more than 31 mm, or its motion is damaged: check the frames, bake it again",
        [CRN_SCENE_MOTION_STEEP] =
            "neighbouring places of the vessel move so differently that it would fold over: check the frames",
        [CRN_SCENE_MOTION_EDGE] = "the boundary of the vessel's motion does not stand still: bake it again",
        [CRN_SCENE_MOTION_OLDER] =
            "the vessel's motion is of an older format, breath and beat in one lattice: bake it again",
        [CRN_SCENE_BODY_PARENT] = "a body lies in one that is not there, or in itself: correct `inside`",
        [CRN_SCENE_BODY_SIZE] =
            "a body without triangles, or over 8 million triangles in all: simplify the meshes",
        [CRN_SCENE_BODY_VERTEX] = "a body reaches beyond 2 m: check its unit",
        [CRN_SCENE_BODY_TRIANGLE] = "a triangle names a vertex that is not there: bake it again",
        [CRN_SCENE_TREE_SIZE] = "the tree of vessels is empty or too large: bake it with fewer centrelines",
        [CRN_SCENE_TREE_BRANCH] =
            "a vessel leaves one that is not there, or feeds what is not known: bake it again",
        [CRN_SCENE_TREE_POINT] =
            "a vessel's point lies beyond 2 m or on the one before it, or its radius is none: bake it again",
        [CRN_SCENE_LESION_SIZE] = "the list of lesions is empty or too long: bake it with fewer lesions",
        [CRN_SCENE_LESION_PLACE] =
            "a lesion lies where no vessel is, or its healthy points are damaged: bake it again",
        [CRN_SCENE_ENTRY_START] =
            "the start length is 0 or beyond 500 mm: correct inserted_mm and bake it again",
        [CRN_SCENE_WALL] = "the walls that give way are damaged: bake it again",
        [CRN_SCENE_PLAQUE] = "a lesion that should give way is damaged or too large: bake it again",
    };
    return (unsigned)status < CRN_SCENE_STATUS_COUNT ? texts[status]
                                                     : "unknown scene status: update this program";
}
