/* This header declares Cournand's C library, which provides scenes, worlds (simulated sessions), snapshots,
 * pictures with labels, and recordings. The header is for C11 and C++.
 *
 *   cournand_scene *scene;
 *   cournand_tool *tool;
 *   cournand_world *world;
 *   cournand_scene_open("aorta.scene", NULL, &scene);
 *   cournand_tool_open("j_wire.toml", &tool);
 *   cournand_world_create(scene, &tool, 1, NULL, &world);
 *   float push_and_turn[COURNAND_ACTION_FLOATS] = {0.03f};       30 mm/s
 *   cournand_world_move(world, push_and_turn, 133);              133 ticks of 1 ms
 *
 * STATUS. Every function that can fail returns a status; 0 means success. If a call is refused, it has
 * changed nothing, and cournand_error_text() returns a text that names the problem, its place and the remedy.
 * No function ends the program, prints text, or throws an exception.
 *
 * HANDLES are numbers in the form of pointers. Each kind of handle has its own function that frees it. A
 * scene, a tool or a recording may be freed while a world that uses it still exists. A freed handle, NULL, or
 * a handle of another kind is refused (COURNAND_BAD_HANDLE). The library cannot check memory that the caller
 * passes; it must be valid.
 *
 * STRUCTS whose first member is `struct_bytes` can get more members in a later version. Set `struct_bytes`
 * before the call, in C by `cournand_pose pose = {.struct_bytes = sizeof pose};` and in C++ by `cournand_pose
 * pose = {}; pose.struct_bytes = sizeof pose;`. A struct that is larger than the library's version of the
 * struct is accepted if its additional bytes are zero.
 *
 * VIEWS. The pointers in cournand_pose, cournand_contacts and cournand_picture refer to memory of the
 * library; nothing is copied. The pointers in a pose or in contacts stay valid until the next call that
 * changes the same world (move, advance, replay, restore, free). The pointers in a picture stay valid until
 * the next picture of the same renderer. A pointer that is no longer valid still refers to allocated memory
 * until its handle is freed, but the numbers there change; a renderer keeps its memory while its pictures
 * have one size. Texts stay valid until their handle is freed.
 *
 * THREADS. Scenes, tools and recordings do not change, and any number of threads may use them. Only one
 * thread at a time may use a world or a renderer; a call is refused while another thread is inside a call
 * with the same object (COURNAND_BUSY). Different worlds can run in parallel, and their results are equal bit
 * for bit with any number of threads. The library starts threads only in cournand_pool_create().
 *
 * UNITS are m, s, N, N m, rad, kPa and mg/ml. The patient frame has +x to the patient's left, +y to the head
 * and +z to the front. Tools are numbered from the innermost to the outermost; node 0 of their common shape
 * is the leading tip. One tick is 1 ms. */
#ifndef COURNAND_H
#define COURNAND_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define COURNAND_API __attribute__((visibility("default")))
#else
#define COURNAND_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header. A higher minor version may add functions, and members of structs; only a higher
 * major version may remove or change them. */
#define COURNAND_VERSION_MAJOR 0
#define COURNAND_VERSION_MINOR 1
#define COURNAND_VERSION_PATCH 0

/* --- status -----------------------------------------------------------------------------------------------
 */

typedef enum cournand_status {
    COURNAND_OK = 0,
    COURNAND_BAD_ARGUMENT, /* NULL, not a number, out of its range, or a struct of a wrong size */
    COURNAND_BAD_HANDLE,   /* NULL, freed, or of another kind */
    COURNAND_BAD_STATE,    /* not possible now */
    COURNAND_BUSY,         /* another thread is inside the same world, renderer or pool */
    COURNAND_BAD_FILE,     /* a file cannot be read or written, or its content is wrong */
    COURNAND_REFUSED,      /* the simulated device or patient refuses the request */
    COURNAND_BAD_SNAPSHOT, /* damaged, of another version, or of a world with another set-up */
    COURNAND_DIFFERENT,    /* a replay differs from its recording */
    COURNAND_NO_MEMORY,
    COURNAND_INTERNAL, /* a fault of the library; please report it with the text */
} cournand_status;

enum {
    COURNAND_POSITIONS_MAX = 3, /* tools on the line at once */
    COURNAND_TOOLS_MAX = 8,     /* tools of a world, on the line and beside it */
    COURNAND_STENTS_MAX = 8,
    COURNAND_ORDERS_MAX = 4,     /* of one tick, at most one of each kind */
    COURNAND_ACTION_FLOATS = 8,  /* of cournand_world_move */
    COURNAND_TICKS_MAX = 600000, /* of one call: ten minutes */
    COURNAND_THREADS_MAX = 256,
};

/* Returns the name of a status, such as "BAD_HANDLE". Unknown numbers give "UNKNOWN". */
COURNAND_API const char *cournand_status_name(cournand_status status);

/* Returns the text of the last refusal in this thread, which names the problem, its place and the remedy.
 * Returns "" if no call of this thread was refused yet. The text stays valid until the next refusal in this
 * thread. */
COURNAND_API const char *cournand_error_text(void);

/* Holds the place in a file that the last refusal in this thread names. `line` and `column` count from 1; 0
 * means the whole file, or the whole line. If the refusal names no file, `file` is "". */
typedef struct cournand_error_place {
    uint32_t struct_bytes;
    uint32_t line, column;
    uint32_t reserved;
    const char *file; /* valid until the next refusal in this thread */
} cournand_error_place;
COURNAND_API cournand_status cournand_error_where(cournand_error_place *place);

/* The next two functions return the library's version, as a text such as "0.1.0" and as the number major *
 * 1000000 + minor * 1000 + patch. */
COURNAND_API const char *cournand_version_text(void);
COURNAND_API uint32_t cournand_version(void);

/* Returns the version of the core. Two cores with equal versions compute equal results from equal inputs, bit
 * for bit, and each can replay the other's recordings. */
COURNAND_API uint32_t cournand_core_version(void);

/* --- scenes -----------------------------------------------------------------------------------------------
 */

typedef struct cournand_scene cournand_scene;

/* Opens a scene file that `bake` has made, with its bodies (the meshes for pictures). `scene_path` is NULL or
 * "" for free space without vessels. If `bodies_path` is NULL, the library uses the file X.bodies beside
 * X.scene, if there is one. Without bodies, the scene has no vessel names, and its pictures show only the
 * tools, in air. Status: BAD_FILE. */
COURNAND_API cournand_status cournand_scene_open(const char *scene_path, const char *bodies_path,
                                                 cournand_scene **scene);
COURNAND_API cournand_status cournand_scene_free(cournand_scene *scene);

typedef struct cournand_scene_info {
    uint32_t struct_bytes;
    uint32_t crc32;      /* of the scene's file; 0: free space */
    const char *name;    /* valid until the scene is freed */
    double entry_m[3];   /* centre of the introducer's opening */
    double direction[3]; /* unit vector into the vessel */
    double start_m; /* length of the tools beyond the opening at tick 0, unless the world states another */
    uint32_t vessel_count; /* 0: the vessels are not known */
    uint32_t moves;        /* 1: heart or breath move the vessels */
} cournand_scene_info;
COURNAND_API cournand_status cournand_scene_describe(const cournand_scene *scene, cournand_scene_info *info);

/* Describes a vessel. The vessel's centreline has `point_count` rows with x, y, z and the radius of the
 * lumen, in m. The rows of the centreline are a contiguous array, float [n][4], in the direction of the blood
 * flow and in the reference pose (heart and breath at rest). */
typedef struct cournand_vessel {
    uint32_t struct_bytes;
    int32_t parent;   /* number of an earlier vessel; -1: the root */
    const char *name; /* name and points are valid until the scene is freed */
    const float *points_m;
    uint32_t point_count;
    uint32_t reserved;
    double length_m;
} cournand_vessel;
/* `vessel` is the number of a vessel, 0 .. vessel_count - 1. */
COURNAND_API cournand_status cournand_scene_vessel(const cournand_scene *scene, uint32_t vessel,
                                                   cournand_vessel *description);
/* Finds a vessel by its name; upper and lower case, spaces and the word "artery" make no difference. Status:
 * BAD_ARGUMENT with a suggestion. */
COURNAND_API cournand_status cournand_scene_find_vessel(const cournand_scene *scene, const char *name,
                                                        uint32_t *vessel);

/* --- tools ------------------------------------------------------------------------------------------------
 */

typedef struct cournand_tool cournand_tool;

/* Opens an instrument file (docs/instruments.md): "j_wire.toml", or "j_wire.toml:PRESET". Status: BAD_FILE.
 */
COURNAND_API cournand_status cournand_tool_open(const char *path, cournand_tool **tool);
COURNAND_API cournand_status cournand_tool_free(cournand_tool *tool);

typedef struct cournand_tool_info {
    uint32_t struct_bytes;
    uint32_t is_catheter; /* 1: it has a lumen */
    const char *name;     /* valid until the tool is freed */
    double length_m;
    double radius_max_m; /* outer radius at its widest point, balloon folded */
    uint32_t has_balloon;
    uint32_t reserved;
} cournand_tool_info;
COURNAND_API cournand_status cournand_tool_describe(const cournand_tool *tool, cournand_tool_info *info);

/* Writes the positions of the tool's first `capacity` radiopaque marker bands to `arcs_m` (distances of their
 * centres from the tip in m, in ascending order), and the number of all bands to `count`. `arcs_m` may be
 * NULL if `capacity` is 0. */
COURNAND_API cournand_status cournand_tool_markers(const cournand_tool *tool, double *arcs_m, size_t capacity,
                                                   size_t *count);

/* Holds factors for a tool's properties, 0.1 .. 10 each; the factor 1 changes nothing. */
typedef struct cournand_tool_scales {
    uint32_t struct_bytes;
    uint32_t reserved;
    double bend_stiffness, twist_stiffness, mass, friction;
    double rest_curvature; /* of a preformed tip; may be negative, -10 .. 10 */
} cournand_tool_scales;
/* Makes a tool with scaled properties from another tool, for domain randomisation. A scaled value outside the
 * core's range is refused when a world is created. */
COURNAND_API cournand_status cournand_tool_scaled(const cournand_tool *tool,
                                                  const cournand_tool_scales *scales, cournand_tool **scaled);

/* --- worlds -----------------------------------------------------------------------------------------------
 */

typedef struct cournand_world cournand_world;

enum {
    COURNAND_WITH_PATIENT = 1, /* blood flow, contrast medium and stents */
};

typedef struct cournand_world_options {
    uint32_t struct_bytes;
    uint32_t flags; /* COURNAND_WITH_PATIENT */
    /* Holds, for each position of the line (the nested tools) from the innermost, the number of its tool in
     * `tools`, from 1, or 0 if the position has no tool. If line_count is 0, all tools are in the line, and
     * there may be at most three tools. */
    uint32_t line_count;
    uint32_t line[COURNAND_POSITIONS_MAX];
    /* Holds, for the tool at each position, its length beyond the introducer's opening at tick 0, which is 0
     * .. 2 m. If a length is NaN, or if inserted_count is 0, the scene's start length is used. */
    uint32_t inserted_count;
    float inserted_m[COURNAND_POSITIONS_MAX];
    /* The number of ticks between two samples of the wall forces for cournand_reading::wall_force_peak_N, 1
     * .. 1000; 0 switches the samples off. */
    uint32_t contact_ticks;
    uint32_t stent_count; /* stents that the patient may get, in this order; needs COURNAND_WITH_PATIENT */
    const char *const *stents; /* paths of stent files (docs/stent.md) */
} cournand_world_options;

/* Makes a world (a simulated session) at tick 0. `tools` contains tool_count handles, 1 ..
 * COURNAND_TOOLS_MAX, from the innermost tool to the outermost. `options` may be NULL, which stands for the
 * defaults. Equal scenes, tools and options give worlds that are equal bit for bit. If tools do not fit into
 * each other, the status is REFUSED, and the text names these tools. */
COURNAND_API cournand_status cournand_world_create(const cournand_scene *scene, cournand_tool *const *tools,
                                                   size_t tool_count, const cournand_world_options *options,
                                                   cournand_world **world);
COURNAND_API cournand_status cournand_world_free(cournand_world *world);

/* Returns the text of the last refused call with this world, whichever thread made the call. The text stays
 * valid until the next call with this world. */
COURNAND_API const char *cournand_world_error_text(const cournand_world *world);

/* Moves the hands at constant speeds for `ticks` ticks (1 .. COURNAND_TICKS_MAX). `action` is a float array
 * of COURNAND_ACTION_FLOATS entries. The first three entries of `action` are the pushing speeds of the hands
 * at positions 0, 1 and 2 in m/s (-1 .. 1, + into the patient). The next three entries of `action` are the
 * turning speeds in rad/s (-100 .. 100, + right-handed about the direction of insertion). The seventh entry
 * of `action` is the pressure of the inflator in kPa (0 .. 4000), and the eighth is 0. If the line has no
 * tool at a position, the entries of this position must be zero. Hands hold their tools rigidly. */
COURNAND_API cournand_status cournand_world_move(cournand_world *world, const float *action, uint32_t ticks);

/* Holds an order to the core: an event that happens in one tick, other than the motion of the hands. `values`
 * holds the values that docs/wire.md lists for this kind of order, in the same sequence; all other values are
 * 0. */
typedef enum cournand_order_kind {
    COURNAND_ORDER_RHYTHM = 1,   /* action, value: heart rate, premature beat, breath (docs/heart.md) */
    COURNAND_ORDER_SCAFFOLD = 2, /* lesion, first, last, open_q15 */
    COURNAND_ORDER_STRUT = 3,    /* number, joined, x_um, y_um, z_um, inside_um, thickness_um */
    COURNAND_ORDER_EXCHANGE =
        4, /* position, tool: takes tools off the line and puts others on (docs/session.md) */
} cournand_order_kind;
typedef struct cournand_order {
    uint32_t kind;
    int32_t values[7];
} cournand_order;

/* Requests an order for the core's next tick; a second order of the same kind waits for the tick after that.
 * The core first tries the order on a copy of its state. If the core refuses the order, the status is
 * REFUSED, and the text gives the core's reason. */
COURNAND_API cournand_status cournand_world_order(cournand_world *world, const cournand_order *order);

/* Holds the exact input of one tick, in 168 bytes without padding. The positions of the hands are int32
 * counts since tick 0. */
typedef struct cournand_input {
    int32_t push_um[COURNAND_POSITIONS_MAX];     /* + into the patient */
    int32_t turn_counts[COURNAND_POSITIONS_MAX]; /* 65536 per turn */
    int32_t inflator_kPa;                        /* 0 .. 4000 */
    uint32_t buttons;                            /* bit 0: X-ray pedal, 1: cine pedal; at most 255 */
    uint32_t order_count;
    uint32_t reserved;
    cournand_order orders[COURNAND_ORDERS_MAX];
} cournand_input;

/* Advances the world by one tick per input; there are 1 .. COURNAND_TICKS_MAX inputs. From one tick to the
 * next a hand moves by at most 5 mm and a quarter turn. The inputs of a recording lead to the state hash of
 * that recording. */
COURNAND_API cournand_status cournand_world_advance(cournand_world *world, const cournand_input *inputs,
                                                    size_t input_count);

/* Describes the common shape of the tools. The arrays of nodes are contiguous and have node_count rows. Node
 * 0 is at the leading tip, and the last node is the first one inside the introducer. */
typedef struct cournand_pose {
    uint32_t struct_bytes;
    uint32_t tick;
    uint32_t node_count;          /* 2 .. 384 */
    uint32_t position_count;      /* positions of the line, 1 .. 3 */
    const int32_t *positions_q30; /* int32 [n][3] in 2^-30 m: the exact state */
    const float *positions_m;     /* float [n][3] */
    const float *arcs_m;          /* float [n]: rest arc length from the leading tip */
    const float *radii_m;         /* float [n]: outer radius of the outermost tool there */
    const float *tip_arcs_m; /* float [position_count]: arc length of each tool's tip from the leading tip */
    const float *inserted_m; /* float [position_count]: length beyond the introducer's opening */
} cournand_pose;
COURNAND_API cournand_status cournand_world_pose(cournand_world *world, cournand_pose *pose);

/* Holds the values that were measured after the last tick. Before the first tick, all values except lengths
 * and phases are 0. */
typedef struct cournand_reading {
    uint32_t struct_bytes;
    uint32_t tick;
    uint32_t position_count;
    uint32_t contact_count;                /* nodes in contact with the wall */
    uint32_t line[COURNAND_POSITIONS_MAX]; /* number of the tool at each position, from 1; 0: free */
    uint32_t
        fault_bits; /* sticky: 1 saturated, 2 hand too fast, 4 step capped, 8 end of the tool, 16 outside */
    float inserted_m[COURNAND_POSITIONS_MAX];
    float force_N[COURNAND_POSITIONS_MAX];    /* on the hand, + pushes back out */
    float torque_N_m[COURNAND_POSITIONS_MAX]; /* on the hand, + opposes positive rotation */
    float penetration_m;                      /* of the deepest contact */
    float length_error;                       /* relative, of the part beyond the introducer */
    float
        wall_force_peak_N; /* largest sum of all contact forces in the samples of the last move or advance */
    float wall_force_N;    /* the same in the last sample; both 0 without contact_ticks */
    float heart_phase, breath_phase; /* 0 .. 1 of the cycle */
    float balloon_kPa, balloon_diameter_max_m, balloon_diameter_min_m, balloon_wall_N;
    uint32_t balloon_has_burst;
    uint32_t exchange; /* answer to an exchange in the last tick: 0 none, 1 done, else docs/faults.md */
    uint32_t
        is_out_of_range; /* 1: physics left its valid range; results since out_of_range_tick are not valid */
    uint32_t out_of_range_tick;
} cournand_reading;
COURNAND_API cournand_status cournand_world_read(cournand_world *world, cournand_reading *reading);

/* Holds the present forces of the wall on the nodes, in `count` rows. */
typedef struct cournand_contacts {
    uint32_t struct_bytes;
    uint32_t tick;
    uint32_t count;
    uint32_t reserved;
    const uint32_t *nodes; /* uint32 [count], ascending */
    const float *forces_N; /* float [count][3]: normal force and friction */
} cournand_contacts;
COURNAND_API cournand_status cournand_world_contacts(cournand_world *world, cournand_contacts *contacts);

/* Describes where the tip of the tool at a position is. */
typedef struct cournand_place {
    uint32_t struct_bytes;
    int32_t vessel;   /* -1: not known: no vessels, or the position is free */
    const char *name; /* of the vessel, "" if not known; valid until the world is freed */
    double tip_m[3];
    double along_m;  /* from the vessel's beginning */
    double inside_m; /* along the way from the introducer, beyond the vessel's ostium */
    double radii;    /* distance from the centreline in radii of the lumen; above 1: outside */
} cournand_place;
COURNAND_API cournand_status cournand_world_tip(cournand_world *world, uint32_t position,
                                                cournand_place *place);

/* Returns where points of the tissue are now. `rest_m` has `count` rows of x, y, z in the reference pose
 * (heart and breath at rest), such as points of a vessel's centreline. `now_m` receives as many rows; it may
 * be `rest_m` itself. In a scene that does not move, the points stay. Status: BAD_ARGUMENT if a number is not
 * finite; nothing is written then. */
COURNAND_API cournand_status cournand_world_moved(cournand_world *world, const double *rest_m, size_t count,
                                                  double *now_m);

/* Returns the full hash of the core's state (FNV-1a), as `cournand run` prints it. */
COURNAND_API cournand_status cournand_world_hash(cournand_world *world, uint64_t *hash);

/* Describes a fault that the device has counted. The texts of a fault stay valid as long as the program runs.
 */
typedef struct cournand_fault {
    uint32_t code; /* docs/faults.md */
    uint32_t tick_first, tick_last, count;
    int32_t value1, value2;
    const char *text, *remedy;
} cournand_fault;
/* Writes the first `capacity` faults to `faults`, and the number of all faults to `count`. */
COURNAND_API cournand_status cournand_world_faults(cournand_world *world, cournand_fault *faults,
                                                   size_t capacity, size_t *count);

/* --- the patient: worlds with COURNAND_WITH_PATIENT
 * --------------------------------------------------------- */

/* Injects contrast medium from the next tick on: 0 .. 200 ml at 0.001 .. 50 ml/s; 0 ml ends an injection.
 * `position` is the position of the tool through which the medium is injected; -1 selects the outermost tool
 * that has a lumen. `iodine` is the strength of the medium, 10 .. 350 mg/ml. Status: REFUSED with the reason.
 */
COURNAND_API cournand_status cournand_world_inject(cournand_world *world, double volume_ml,
                                                   double flow_ml_per_s, int32_t position,
                                                   double iodine_mg_per_ml);
/* Mounts the next stent from the list in the world's options on the balloon in use.
 */
COURNAND_API cournand_status cournand_world_load_stent(cournand_world *world);

typedef struct cournand_patient_reading {
    uint32_t struct_bytes;
    uint32_t stents_loaded;
    double injected_ml;
    double injection_flow_ml_per_s;
    double pressure_mmHg; /* at the catheter's tip if one lies in the vessels, else in the aorta */
    double heart_rate_per_min;
    const char *stent_stage; /* of the last loaded stent, "" for none; valid until the next call */
    const char *notice; /* the last refusal of syringe and stents, "" for none; valid until the next call */
} cournand_patient_reading;
COURNAND_API cournand_status cournand_world_read_patient(cournand_world *world,
                                                         cournand_patient_reading *reading);

/* --- snapshots
 * ---------------------------------------------------------------------------------------------- */

/* Returns the size of a snapshot of this world now. All snapshots of a world without a patient have the same
 * size, about 37 kB. With a patient, the size changes from tick to tick (docs/library.md), so ask before
 * every cournand_world_save(). */
COURNAND_API cournand_status cournand_world_snapshot_bytes(cournand_world *world, size_t *bytes);
/* Writes a snapshot, which contains its version and a checksum, to `bytes`; `capacity` must be at least the
 * size of the snapshot. */
COURNAND_API cournand_status cournand_world_save(cournand_world *world, void *bytes, size_t capacity);
/* Sets the world to the state in a snapshot. The snapshot may come from any world with the same scene, tools
 * and options, also from another process or machine; with a patient, that machine must have the same byte
 * order. The restored world continues, bit for bit, as the saved world did, and reads the same values,
 * including the wall forces. Snapshots of version 1, which lack the wall forces, are refused. The status is
 * BAD_SNAPSHOT if the snapshot is refused, and BAD_STATE if the world is writing a recording. */
COURNAND_API cournand_status cournand_world_restore(cournand_world *world, const void *bytes, size_t count);

/* --- many worlds
 * -------------------------------------------------------------------------------------------- */

typedef struct cournand_pool cournand_pool;

/* Makes a pool of `threads` threads, 1 .. COURNAND_THREADS_MAX. One of them is the calling thread, so the
 * function starts `threads` - 1 threads. After a fork() the child cannot use its parent's pool (BAD_STATE).
 */
COURNAND_API cournand_status cournand_pool_create(uint32_t threads, cournand_pool **pool);
COURNAND_API cournand_status cournand_pool_free(cournand_pool *pool);

/* Moves `count` different worlds in parallel, each as cournand_world_move() does. `actions` is float
 * [count][COURNAND_ACTION_FLOATS], contiguous. `statuses` is NULL, or int32 [count], which receives the
 * status of each world. Returns OK if every world has moved. If a handle, an action or `ticks` is refused, or
 * if another thread is using one of the worlds, no world moves. If one world fails while it moves, the other
 * worlds have moved. Both return the first status that is not OK. */
COURNAND_API cournand_status cournand_pool_move(cournand_pool *pool, cournand_world *const *worlds,
                                                size_t count, const float *actions, uint32_t ticks,
                                                int32_t *statuses);

/* Does what cournand_pool_move() does, and calls work(context, i) in the same thread as soon as world i has
 * moved, for example to read or to render it. The function `work` is not called for a world that fails. The
 * function `work` may call the library, but not with this pool. */
COURNAND_API cournand_status cournand_pool_step(cournand_pool *pool, cournand_world *const *worlds,
                                                size_t count, const float *actions, uint32_t ticks,
                                                void (*work)(void *context, size_t index), void *context,
                                                int32_t *statuses);

/* Calls work(context, i) once for every i below count, in parallel and in any order; returns when all calls
 * are done. The function `work` may call the library, but not with this pool. */
COURNAND_API cournand_status cournand_pool_run(cournand_pool *pool, size_t count,
                                               void (*work)(void *context, size_t index), void *context);

/* --- pictures
 * ----------------------------------------------------------------------------------------------- */

typedef struct cournand_renderer cournand_renderer;

/* Makes a renderer for worlds of this scene. While the renderer renders, it uses `threads` threads, 1 .. 16;
 * the pictures do not depend on this number. */
COURNAND_API cournand_status cournand_renderer_create(const cournand_scene *scene, uint32_t threads,
                                                      cournand_renderer **renderer);
COURNAND_API cournand_status cournand_renderer_free(cournand_renderer *renderer);

enum {
    COURNAND_VIEW_LABELS = 1, /* also the label image */
    COURNAND_VIEW_NO_NOISE = 2,
    COURNAND_VIEW_NO_SCATTER = 4,
    COURNAND_VIEW_SEQUENCE = 8,     /* exposure and lag follow the renderer's last picture */
    COURNAND_VIEW_LABELS_ONLY = 16, /* no picture: only the label image */
};

/* Describes the geometry and the beam of one picture. Members that are 0 stand for their defaults, except for
 * the angles and the isocentre. */
typedef struct cournand_view {
    uint32_t struct_bytes;
    uint32_t flags;
    double primary_deg;        /* + LAO, - RAO: -120 .. 120 */
    double secondary_deg;      /* + cranial, - caudal: -50 .. 50 */
    double isocentre_m[3];     /* point of the patient at the isocentre, each -1.9 .. 1.9 */
    double source_detector_m;  /* 0.9 .. 1.3; 0: 1.05 */
    double source_isocentre_m; /* 0.6 .. 0.85; 0: 0.75 */
    double field_m;            /* width of the square field at the detector, 0.1 .. 0.45; 0: 0.32 */
    double dose_nGy;           /* at the detector per picture, 1 .. 10000; 0: 40 */
    uint32_t size;             /* pixels along each edge: a multiple of 16, 64 .. 2048; 0: 512 */
    uint32_t reserved;
    uint64_t seed; /* of the noise */
} cournand_view;

/* Bits of the label image. A pixel can have several. A tool, stent or balloon marks a pixel if at least one
 * of nine rays through the pixel meets it. Contrast medium marks a pixel if the mean path through the medium
 * corresponds to at least 1/32 mm of undiluted medium. */
enum {
    COURNAND_LABEL_TOOL_0 = 1, /* the tool at position 0, and 2 and 4 for positions 1 and 2 */
    COURNAND_LABEL_TOOL_1 = 2,
    COURNAND_LABEL_TOOL_2 = 4,
    COURNAND_LABEL_MEDIUM = 8, /* contrast medium in a vessel */
    COURNAND_LABEL_STENT = 16,
    COURNAND_LABEL_BALLOON = 32, /* the medium in a balloon */
};

/* Holds a picture of size x size pixels. The rows of pixels are contiguous, and row 0 is the top row. */
typedef struct cournand_picture {
    uint32_t struct_bytes;
    uint32_t size;
    uint32_t tick;
    uint32_t is_underexposed;
    const uint8_t *grey;   /* uint8 [size][size]: on the screen; NULL with LABELS_ONLY */
    const uint16_t *raw;   /* uint16 [size][size]: of the detector, 0 .. 16383, in proportion to the dose */
    const uint8_t *labels; /* uint8 [size][size]: COURNAND_LABEL_*; NULL without labels */
    double tube_voltage_kV, tube_current_mA, pulse_ms;
    double air_kerma_uGy; /* at the reference point */
    double kap_Gy_cm2;
} cournand_picture;

/* Renders the present state of the world. Equal worlds, views and seeds give pictures that are equal bit for
 * bit. */
COURNAND_API cournand_status cournand_render(cournand_renderer *renderer, cournand_world *world,
                                             const cournand_view *view, cournand_picture *picture);

/* Returns the projection of a view as a matrix P, double [3][4], row by row. P (x, y, z, 1), with x, y and z
 * in m, is (u w, v w, w), where u is the column and v the row in pixels; pixel centres have fractions of
 * .5. */
COURNAND_API cournand_status cournand_view_matrix(const cournand_view *view, double matrix[12]);

/* --- recordings
 * ---------------------------------------------------------------------------------------------- */

/* Begins a recording of the world as a file for `cournand replay`. The world must be at tick 0. The file gets
 * its name only when cournand_world_end_recording() has completed it. `session` is a text that describes who
 * or what controls the session; it is stored in the file. */
COURNAND_API cournand_status cournand_world_record(cournand_world *world, const char *path,
                                                   const char *session);
COURNAND_API cournand_status cournand_world_end_recording(cournand_world *world);

typedef struct cournand_recording cournand_recording;

/* Reads a recording that `cournand run`, `cournand view` or this library has made. Status: BAD_FILE. */
COURNAND_API cournand_status cournand_recording_open(const char *path, cournand_recording **recording);
COURNAND_API cournand_status cournand_recording_free(cournand_recording *recording);

typedef struct cournand_recording_info {
    uint32_t struct_bytes;
    uint32_t core_version;
    uint32_t tick_count;
    uint32_t is_complete; /* 0: it was cut off; it is whole up to tick_count */
    uint32_t tool_count, position_count;
    uint32_t scene_crc32; /* 0: free space */
    uint32_t reserved;
    const char *scene_path, *session; /* valid until the recording is freed */
    uint64_t last_hash;               /* the last recorded full hash, and its tick; 0: none */
    uint32_t last_hash_tick;
    uint32_t reserved2;
} cournand_recording_info;
COURNAND_API cournand_status cournand_recording_describe(const cournand_recording *recording,
                                                         cournand_recording_info *info);

/* Copies the inputs of the ticks first .. first + count - 1 to `inputs`; ticks are counted from 0. */
COURNAND_API cournand_status cournand_recording_inputs(const cournand_recording *recording, uint32_t first,
                                                       uint32_t count, cournand_input *inputs);

/* Makes a world at tick 0 with the recording's tools, line, entry and stents. `scene` must be the scene of
 * the recording, that is, its file must have the same size and checksum. `flags` as in the options. */
COURNAND_API cournand_status cournand_recording_world(const cournand_recording *recording,
                                                      const cournand_scene *scene, uint32_t flags,
                                                      cournand_world **world);

/* Replays the recording up to `tick` in a world from cournand_recording_world(), and compares every tick with
 * the recording. `tick` must not be before the world's own tick. If the world has no patient, the replay
 * starts from the last recorded snapshot between the world's own tick and `tick`. If a tick differs, the
 * status is DIFFERENT, and the world stays at the first tick that differs. */
COURNAND_API cournand_status cournand_world_replay(cournand_world *world, const cournand_recording *recording,
                                                   uint32_t tick);

#ifdef __cplusplus
}
#endif

#endif
