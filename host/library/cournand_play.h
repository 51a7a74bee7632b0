/* This header declares the part of Cournand's C library that plays session scripts (docs/session.md). Include
 * cournand.h before it; the rules for statuses, handles, structs and threads are stated there.
 *
 *   cournand_script *script;
 *   cournand_play *play;
 *   const char *json;
 *   cournand_script_open("demo.session", NULL, &script);
 *   cournand_play_create(script, scene, &tool, 1, NULL, &play);
 *   cournand_play_state state = {.struct_bytes = sizeof state};
 *   while (cournand_play_read(play, &state) == COURNAND_OK && !state.is_over)
 *       cournand_play_advance(play, 1000, COURNAND_PLAY_TO_PULSE);
 *   cournand_play_report(play, &json); */
#ifndef COURNAND_PLAY_H
#define COURNAND_PLAY_H

#ifndef COURNAND_H
#error "include cournand.h before cournand_play.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cournand_script cournand_script;

/* Reads a session script (docs/session.md). `hands` is NULL or "" for the hands of the script itself, or a
 * skill with a seed, such as "novice:7", as `cournand run --hands` takes it. The status is BAD_FILE for a
 * mistake in the script, and cournand_error_where() then returns its line and column. */
COURNAND_API cournand_status cournand_script_open(const char *path, const char *hands,
                                                  cournand_script **script);
COURNAND_API cournand_status cournand_script_free(cournand_script *script);

/* Holds what the `needs` statements of a script name: the scene, and the tools and stents in their order.
 * These are names such as "aorta" and "j_wire", and not paths; the caller chooses the files. */
typedef struct cournand_script_info {
    uint32_t struct_bytes;
    uint32_t statement_count;
    const char *path;  /* all texts are valid until the script is freed */
    const char *scene; /* "": the script names none, or free space */
    uint32_t tool_count, stent_count;
    const char *tools[COURNAND_TOOLS_MAX];
    const char *stents[COURNAND_STENTS_MAX];
} cournand_script_info;
COURNAND_API cournand_status cournand_script_describe(const cournand_script *script,
                                                      cournand_script_info *info);

/* A play is a session that a script leads in a world with a patient: hands that slip and steer, the X-ray
 * room, contrast medium, balloons, stents, and expectations. It computes what `cournand run` computes, bit
 * for bit. */
typedef struct cournand_play cournand_play;

typedef struct cournand_play_options {
    uint32_t struct_bytes;
    uint32_t stent_count;      /* stents that the script may load, in this order */
    const char *const *stents; /* paths of stent files */
    const char *record;        /* path of a recording for `cournand replay`; NULL or "": none */
} cournand_play_options;

/* Begins a play at tick 0. `tools` contains tool_count handles, 1 .. COURNAND_TOOLS_MAX, as in
 * cournand_world_create(). A script names a tool by the name of its file, without folder and ending.
 * `options` may be NULL. Script, scene and tools may be freed while the play exists. The status is BAD_FILE,
 * with a place in the script, if the script names a tool, a vessel or a stent that does not exist. */
COURNAND_API cournand_status cournand_play_create(const cournand_script *script, const cournand_scene *scene,
                                                  cournand_tool *const *tools, size_t tool_count,
                                                  const cournand_play_options *options, cournand_play **play);
/* Frees a play. If its script has not ended, the recording is kept as one that was cut off. Handles of its
 * world stay valid. */
COURNAND_API cournand_status cournand_play_free(cournand_play *play);

enum {
    COURNAND_PLAY_TO_PULSE = 1, /* stop at the next pulse of the X-ray room, if it comes before */
};

/* Advances the play by `ticks` ticks (1 .. COURNAND_TICKS_MAX), or to the end of its script if that comes
 * first. The ticks at which the calls stop change nothing in the session. An expectation that does not hold
 * is no error: it ends the script, and cournand_play_read() and the report state it. The status is BAD_STATE
 * when the script has ended before the call. */
COURNAND_API cournand_status cournand_play_advance(cournand_play *play, uint32_t ticks, uint32_t flags);

typedef struct cournand_play_state {
    uint32_t struct_bytes;
    uint32_t tick;
    uint32_t is_over;     /* 1: the script has ended, or an error has stopped it */
    uint32_t is_at_pulse; /* 1: the last call stopped at a pulse (COURNAND_PLAY_TO_PULSE) */
    uint32_t pulses;      /* of the X-ray room, up to now */
    uint32_t is_beam_on;
    uint32_t exit_status; /* at the end, of `cournand run`: 0 success, 1 failed or refused, 3 out of range */
    uint32_t reserved;
    const char *failures; /* lines "FILE:LINE: what failed", "" for none; valid until the next call */
} cournand_play_state;
COURNAND_API cournand_status cournand_play_read(cournand_play *play, cournand_play_state *state);

/* Returns a handle of the play's world, a new one in each call; free it with cournand_world_free(). The world
 * can be read and rendered at any tick, also after the end. It can be saved at ticks that are multiples of
 * 16, at pulses and at the end of the script. Every call that would change it is refused (BAD_STATE). */
COURNAND_API cournand_status cournand_play_world(cournand_play *play, cournand_world **world);

/* Makes another world with the set-up of the play's world, at tick 0. No script leads it, and it can restore
 * the snapshots of the play's world, for example to branch off from a script. */
COURNAND_API cournand_status cournand_play_new_world(cournand_play *play, cournand_world **world);

/* Sets the geometry of `view` to the C-arm and the field of the X-ray room now, and leaves the other members.
 */
COURNAND_API cournand_status cournand_play_view(cournand_play *play, cournand_view *view);

/* Returns the report of the session as JSON, with the bytes that `cournand run --json` writes for the same
 * paths. The text is valid until the play is freed. The status is BAD_STATE until the script has ended. */
COURNAND_API cournand_status cournand_play_report(cournand_play *play, const char **json);

#ifdef __cplusplus
}
#endif

#endif
