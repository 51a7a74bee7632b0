// Contains the functions of cournand.h for worlds (simulated sessions). Each function locks the world for its
// thread (with_world), and stores the text of a refusal in the world.
#include "host/library/recordings.hpp"
#include "host/library/renderer.hpp"

using namespace crn;
using namespace crn::library;

namespace
{

// Runs work(world) while no other thread can use the world.
template <class Work> cournand_status with_world(const cournand_world *handle, Work work) noexcept
{
    return guarded([&] {
        const std::shared_ptr<World> world = object_of(handle);
        const OneAtATime::Inside inside(world->door, "world");
        try {
            world->check_alive();
            work(*world);
        } catch (...) {
            const std::exception_ptr failure = std::current_exception();
            note_failure(COURNAND_INTERNAL);
            std::memcpy(world->error_text, last_text(), text_bytes);
            std::rethrow_exception(failure);
        }
    });
}

// Fills a struct of the caller with the world's values. The struct is checked first.
template <class Struct>
cournand_status read_world(const cournand_world *world, Struct *to, const char *name) noexcept
{
    return with_world(world, [&](World &from) {
        read_struct(to, name);
        Struct own{};
        from.read(own);
        write_struct(to, own, name);
    });
}

} // namespace

cournand_status cournand_world_create(const cournand_scene *scene, cournand_tool *const *tools,
                                      size_t tool_count, const cournand_world_options *options,
                                      cournand_world **world)
{
    return guarded([&] {
        auto in = object_of(scene);
        require(world != nullptr, "world is NULL: pass where the handle goes");
        require(tools != nullptr, "tools is NULL");
        require(tool_count >= 1 && tool_count <= COURNAND_TOOLS_MAX, "tool_count is not within 1 and 8");
        std::vector<Instrument> table;
        for (std::size_t i = 0; i < tool_count; i++) table.push_back(*object_of(tools[i]));
        *world = make_handle<cournand_world>(
            std::make_shared<World>(world_settings(std::move(in), std::move(table), options)));
    });
}

cournand_status cournand_world_free(cournand_world *world)
{
    return free_handle(world);
}

const char *cournand_world_error_text(const cournand_world *world)
{
    const char *text = "";
    guarded([&] { text = object_of(world)->error_text; });
    return text;
}

// --- advancing ---

cournand_status cournand_world_move(cournand_world *world, const float *action, uint32_t ticks)
{
    return with_world(world, [&](World &moved) {
        require(action != nullptr, "action is NULL");
        moved.move({action, COURNAND_ACTION_FLOATS}, ticks);
    });
}

cournand_status crn::library::check_move(const cournand_world *world, const float *action,
                                         std::uint32_t ticks) noexcept
{
    return with_world(world, [&](const World &moved) {
        moved.checked_speeds({action, COURNAND_ACTION_FLOATS}, ticks);
    });
}

cournand_status cournand_world_order(cournand_world *world, const cournand_order *order)
{
    return with_world(world, [&](World &ordered) {
        require(order != nullptr, "order is NULL");
        ordered.order(*order);
    });
}

cournand_status cournand_world_advance(cournand_world *world, const cournand_input *inputs,
                                       size_t input_count)
{
    return with_world(world, [&](World &advanced) {
        require(inputs != nullptr, "inputs is NULL");
        advanced.advance({inputs, input_count});
    });
}

// --- reading ---

cournand_status cournand_world_pose(cournand_world *world, cournand_pose *pose)
{
    return read_world(world, pose, "pose");
}

cournand_status cournand_world_read(cournand_world *world, cournand_reading *reading)
{
    return read_world(world, reading, "reading");
}

cournand_status cournand_world_contacts(cournand_world *world, cournand_contacts *contacts)
{
    return read_world(world, contacts, "contacts");
}

cournand_status cournand_world_read_patient(cournand_world *world, cournand_patient_reading *reading)
{
    return read_world(world, reading, "reading");
}

cournand_status cournand_world_tip(cournand_world *world, uint32_t position, cournand_place *place)
{
    return with_world(world, [&](World &from) {
        read_struct(place, "place");
        cournand_place own{};
        from.read(position, own);
        write_struct(place, own, "place");
    });
}

cournand_status cournand_world_moved(cournand_world *world, const double *rest_m, size_t count, double *now_m)
{
    return with_world(world, [&](World &from) {
        require(count == 0 || (rest_m != nullptr && now_m != nullptr), "rest_m or now_m is NULL");
        require(count <= 1u << 24, "count is above 16777216");
        for (size_t i = 0; i < 3 * count; i++)
            require(std::isfinite(rest_m[i]), "rest_m has a number that is not finite");
        from.moved({rest_m, 3 * count}, {now_m, 3 * count});
    });
}

cournand_status cournand_world_hash(cournand_world *world, uint64_t *hash)
{
    return with_world(world, [&](World &from) {
        require(hash != nullptr, "hash is NULL");
        *hash = from.hash();
    });
}

cournand_status cournand_world_faults(cournand_world *world, cournand_fault *faults, size_t capacity,
                                      size_t *count)
{
    return with_world(world, [&](World &from) {
        require(count != nullptr, "count is NULL");
        require(capacity == 0 || faults != nullptr, "faults is NULL");
        *count = from.read({faults, capacity});
    });
}

// --- the patient ---

cournand_status cournand_world_inject(cournand_world *world, double volume_ml, double flow_ml_per_s,
                                      int32_t position, double iodine_mg_per_ml)
{
    return with_world(world,
                      [&](World &of) { of.inject(volume_ml, flow_ml_per_s, position, iodine_mg_per_ml); });
}

cournand_status cournand_world_load_stent(cournand_world *world)
{
    return with_world(world, [](World &of) { of.load_stent(); });
}

// --- snapshots ---

cournand_status cournand_world_snapshot_bytes(cournand_world *world, size_t *bytes)
{
    return with_world(world, [&](World &measured) {
        require(bytes != nullptr, "bytes is NULL");
        *bytes = measured.snapshot_bytes();
    });
}

cournand_status cournand_world_save(cournand_world *world, void *bytes, size_t capacity)
{
    return with_world(world, [&](World &saved) {
        require(bytes != nullptr, "bytes is NULL");
        saved.save({static_cast<std::uint8_t *>(bytes), capacity});
    });
}

cournand_status cournand_world_restore(cournand_world *world, const void *bytes, size_t count)
{
    return with_world(world, [&](World &restored) {
        require(bytes != nullptr, "bytes is NULL");
        restored.restore({static_cast<const std::uint8_t *>(bytes), count});
    });
}

// --- pictures and recordings ---

cournand_status cournand_render(cournand_renderer *renderer, cournand_world *world, const cournand_view *view,
                                cournand_picture *picture)
{
    return with_world(world, [&](World &seen) {
        const auto by = object_of(renderer);
        const OneAtATime::Inside inside(by->door, "renderer");
        read_struct(picture, "picture");
        cournand_picture own{};
        by->render(seen, read_struct(view, "view"), own);
        write_struct(picture, own, "picture");
    });
}

cournand_status cournand_world_record(cournand_world *world, const char *path, const char *session)
{
    return with_world(world, [&](World &recorded) {
        require(path != nullptr && session != nullptr, "path or session is NULL");
        recorded.record(path, session);
    });
}

cournand_status cournand_world_end_recording(cournand_world *world)
{
    return with_world(world, [](World &recorded) { recorded.end_recording(); });
}

cournand_status cournand_world_replay(cournand_world *world, const cournand_recording *recording,
                                      uint32_t tick)
{
    return with_world(world, [&](World &replayed) { replayed.replay(object_of(recording), tick); });
}
