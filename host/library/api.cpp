// Contains the functions of cournand.h for scenes, tools, recordings, pools and renderers. Each function
// checks its pointers and handles, and does its work inside guarded(). The functions of cournand.h for worlds
// (simulated sessions) are in api_world.cpp.
#include "host/library/pool.hpp"
#include "host/library/recordings.hpp"
#include "host/library/renderer.hpp"
#include "host/session/witness.hpp"
#include "shared/version.h"
#include <algorithm>

using namespace crn;
using namespace crn::library;

namespace
{

// Keeps the statuses of many worlds, and the texts of their refusals; the library keeps a text only for the
// thread of the refused call.
struct Outcomes {
    explicit Outcomes(std::size_t count) : statuses(count, COURNAND_OK), texts(count) {}
    void take(std::size_t i, cournand_status status) noexcept
    {
        statuses[i] = status;
        if (status == COURNAND_OK) return;
        try {
            texts[i] = last_text();
        } catch (const std::bad_alloc &) { // the status tells enough
        }
    }
    void throw_first() const
    {
        for (std::size_t i = 0; i < statuses.size(); i++)
            if (statuses[i] != COURNAND_OK)
                throw Refused(static_cast<cournand_status>(statuses[i]),
                              "world " + std::to_string(i) + ": " + texts[i]);
    }
    std::vector<std::int32_t> statuses;
    std::vector<std::string> texts;
};

} // namespace

const char *cournand_status_name(cournand_status status)
{
    static constexpr const char *names[] = {"OK",        "BAD_ARGUMENT", "BAD_HANDLE", "BAD_STATE",
                                            "BUSY",      "BAD_FILE",     "REFUSED",    "BAD_SNAPSHOT",
                                            "DIFFERENT", "NO_MEMORY",    "INTERNAL"};
    const auto number = static_cast<std::size_t>(status);
    return number < std::size(names) ? names[number] : "UNKNOWN";
}

const char *cournand_error_text(void)
{
    return last_text();
}

cournand_status cournand_error_where(cournand_error_place *place)
{
    const ErrorPlace last = last_place();
    return guarded([&] {
        const cournand_error_place own{0, last.line, last.column, 0, last.file};
        write_struct(place, own, "place");
    });
}

const char *cournand_version_text(void)
{
    return CRN_VERSION;
}

uint32_t cournand_version(void)
{
    return COURNAND_VERSION_MAJOR * 1000000u + COURNAND_VERSION_MINOR * 1000u + COURNAND_VERSION_PATCH;
}

uint32_t cournand_core_version(void)
{
    uint32_t version = 0;
    guarded([&] { version = own_core_version(); });
    return version;
}

// --- scenes ---

cournand_status cournand_scene_open(const char *scene_path, const char *bodies_path, cournand_scene **scene)
{
    return guarded([&] {
        require(scene != nullptr, "scene is NULL: pass where the handle goes");
        *scene = make_handle<cournand_scene>(std::make_shared<Scene>(
            std::string(scene_path ? scene_path : ""), std::string(bodies_path ? bodies_path : "")));
    });
}

cournand_status cournand_scene_free(cournand_scene *scene)
{
    return free_handle(scene);
}

cournand_status cournand_scene_describe(const cournand_scene *scene, cournand_scene_info *info)
{
    return guarded([&] {
        cournand_scene_info own{};
        object_of(scene)->describe(own);
        write_struct(info, own, "info");
    });
}

cournand_status cournand_scene_vessel(const cournand_scene *scene, uint32_t vessel,
                                      cournand_vessel *description)
{
    return guarded([&] {
        cournand_vessel own{};
        object_of(scene)->describe(vessel, own);
        write_struct(description, own, "description");
    });
}

cournand_status cournand_scene_find_vessel(const cournand_scene *scene, const char *name, uint32_t *vessel)
{
    return guarded([&] {
        const auto found_in = object_of(scene);
        require(name != nullptr && vessel != nullptr, "name or vessel is NULL");
        const VesselMap &map = found_in->tips().map();
        const std::optional<std::size_t> found = map.find(name);
        if (!found)
            throw Refused(COURNAND_BAD_ARGUMENT,
                          map.is_empty()
                              ? std::string("the scene has no vessels: open its bodies")
                              : "there is no vessel '" + std::string(name) + "'" + map.suggestion(name));
        *vessel = static_cast<std::uint32_t>(*found);
    });
}

// --- tools ---

cournand_status cournand_tool_open(const char *path, cournand_tool **tool)
{
    return guarded([&] {
        require(path != nullptr && tool != nullptr, "path or tool is NULL");
        *tool = make_handle<cournand_tool>(
            std::make_shared<NamedTool>(with_files([&] { return open_tool(path); })));
    });
}

cournand_status cournand_tool_free(cournand_tool *tool)
{
    return free_handle(tool);
}

cournand_status cournand_tool_describe(const cournand_tool *tool, cournand_tool_info *info)
{
    return guarded([&] {
        cournand_tool_info own{};
        describe(*object_of(tool), own);
        write_struct(info, own, "info");
    });
}

cournand_status cournand_tool_markers(const cournand_tool *tool, double *arcs_m, size_t capacity,
                                      size_t *count)
{
    return guarded([&] {
        const auto instrument = object_of(tool);
        require(count != nullptr && (arcs_m != nullptr || capacity == 0), "arcs_m or count is NULL");
        const std::vector<double> arcs = marker_arcs(*instrument);
        std::copy_n(arcs.begin(), std::min(capacity, arcs.size()), arcs_m);
        *count = arcs.size();
    });
}

cournand_status cournand_tool_scaled(const cournand_tool *tool, const cournand_tool_scales *scales,
                                     cournand_tool **made)
{
    return guarded([&] {
        const auto from = object_of(tool);
        require(made != nullptr, "scaled is NULL: pass where the handle goes");
        *made = make_handle<cournand_tool>(
            std::make_shared<NamedTool>(NamedTool{scaled(*from, read_struct(scales, "scales")), from->word}));
    });
}

// --- pools ---

cournand_status cournand_pool_create(uint32_t threads, cournand_pool **pool)
{
    return guarded([&] {
        require(pool != nullptr, "pool is NULL: pass where the handle goes");
        require(threads >= 1 && threads <= COURNAND_THREADS_MAX, "threads is not within 1 and 256");
        *pool = make_handle<cournand_pool>(std::make_shared<Pool>(threads));
    });
}

cournand_status cournand_pool_free(cournand_pool *pool)
{
    return free_handle(pool);
}

static void require_no_throw(bool has_thrown)
{
    if (has_thrown)
        throw Refused(COURNAND_BAD_ARGUMENT, "the function has thrown an exception: catch it there");
}

cournand_status cournand_pool_run(cournand_pool *pool, size_t count,
                                  void (*work)(void *context, size_t index), void *context)
{
    return guarded([&] {
        const auto with = object_of(pool);
        require(work != nullptr, "work is NULL");
        const OneAtATime::Inside inside(with->door, "pool");
        std::atomic<bool> has_thrown = false;
        with->run(count, [&](std::size_t index) {
            if (guarded([&] { work(context, index); }) != COURNAND_OK) has_thrown = true;
        });
        require_no_throw(has_thrown);
    });
}

cournand_status cournand_pool_move(cournand_pool *pool, cournand_world *const *worlds, size_t count,
                                   const float *actions, uint32_t ticks, int32_t *statuses)
{
    const auto nothing = [](void *, std::size_t) {};
    return cournand_pool_step(pool, worlds, count, actions, ticks, nothing, nullptr, statuses);
}

cournand_status cournand_pool_step(cournand_pool *pool, cournand_world *const *worlds, size_t count,
                                   const float *actions, uint32_t ticks,
                                   void (*work)(void *context, size_t index), void *context,
                                   int32_t *statuses)
{
    return guarded([&] {
        const auto with = object_of(pool);
        require(count <= 1000000, "count is above a million");
        require(count == 0 || (worlds != nullptr && actions != nullptr), "worlds or actions is NULL");
        require(work != nullptr, "work is NULL");
        std::vector<const cournand_world *> sorted(worlds, worlds + count);
        std::sort(sorted.begin(), sorted.end());
        require(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end(), "worlds has a world twice");
        const OneAtATime::Inside inside(with->door, "pool");
        Outcomes outcomes(count);
        const auto end = [&] {
            if (statuses) std::copy(outcomes.statuses.begin(), outcomes.statuses.end(), statuses);
            outcomes.throw_first();
        };
        const auto row = [&](std::size_t i) { return actions + i * COURNAND_ACTION_FLOATS; };
        for (std::size_t i = 0; i < count; i++) outcomes.take(i, check_move(worlds[i], row(i), ticks));
        end(); // before any world moves
        std::atomic<bool> has_thrown = false;
        with->run(count, [&](std::size_t i) {
            const cournand_status status = cournand_world_move(worlds[i], row(i), ticks);
            outcomes.take(i, status);
            if (status == COURNAND_OK && guarded([&] { work(context, i); }) != COURNAND_OK) has_thrown = true;
        });
        end();
        require_no_throw(has_thrown);
    });
}

// --- pictures ---

cournand_status cournand_renderer_create(const cournand_scene *scene, uint32_t threads,
                                         cournand_renderer **renderer)
{
    return guarded([&] {
        const auto of = object_of(scene);
        require(renderer != nullptr, "renderer is NULL: pass where the handle goes");
        require(threads >= 1 && threads <= 16, "threads is not within 1 and 16");
        *renderer = make_handle<cournand_renderer>(std::make_shared<Renderer>(of, threads));
    });
}

cournand_status cournand_renderer_free(cournand_renderer *renderer)
{
    return free_handle(renderer);
}

cournand_status cournand_view_matrix(const cournand_view *view, double matrix[12])
{
    return guarded([&] {
        require(matrix != nullptr, "matrix is NULL");
        write_matrix(read_struct(view, "view"), matrix);
    });
}

// --- recordings ---

cournand_status cournand_recording_open(const char *path, cournand_recording **recording)
{
    return guarded([&] {
        require(path != nullptr && recording != nullptr, "path or recording is NULL");
        *recording = make_handle<cournand_recording>(std::make_shared<Recording>(read_recording(path)));
    });
}

cournand_status cournand_recording_free(cournand_recording *recording)
{
    return free_handle(recording);
}

cournand_status cournand_recording_describe(const cournand_recording *recording,
                                            cournand_recording_info *info)
{
    return guarded([&] {
        cournand_recording_info own{};
        describe(*object_of(recording), own);
        write_struct(info, own, "info");
    });
}

cournand_status cournand_recording_inputs(const cournand_recording *recording, uint32_t first, uint32_t count,
                                          cournand_input *inputs)
{
    return guarded([&] {
        const auto from = object_of(recording);
        require(count == 0 || inputs != nullptr, "inputs is NULL");
        copy_inputs(*from, first, {inputs, count});
    });
}

cournand_status cournand_recording_world(const cournand_recording *recording, const cournand_scene *scene,
                                         uint32_t flags, cournand_world **world)
{
    return guarded([&] {
        const auto from = object_of(recording);
        auto in = object_of(scene);
        require(world != nullptr, "world is NULL: pass where the handle goes");
        *world =
            make_handle<cournand_world>(std::make_shared<World>(settings_of(*from, std::move(in), flags)));
    });
}
