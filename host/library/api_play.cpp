// Contains the functions of cournand.h for sessions by script. A play and its world have one door, so only
// one thread at a time can be inside either of them.
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/library/play.hpp"
#include "host/script/hand_model.hpp"

using namespace crn;
using namespace crn::library;

namespace
{

std::string text_or_empty(const char *text)
{
    return text ? text : "";
}

template <class Work> cournand_status with_play(const cournand_play *handle, Work work) noexcept
{
    return guarded([&] {
        const std::shared_ptr<Play> play = object_of(handle);
        const OneAtATime::Inside inside(play->world()->door, "play");
        work(*play);
    });
}

PlaySettings play_settings(const cournand_scene *scene, cournand_tool *const *tools, std::size_t tool_count,
                           const cournand_play_options *given)
{
    PlaySettings settings{object_of(scene), {}, {}, {}};
    require(tool_count == 0 || tools != nullptr, "tools is NULL");
    require(tool_count >= 1 && tool_count <= COURNAND_TOOLS_MAX, "tool_count is not within 1 and 8");
    for (std::size_t i = 0; i < tool_count; i++) settings.tools.push_back(*object_of(tools[i]));
    if (!given) return settings;
    const cournand_play_options options = read_struct(given, "options");
    require(options.stent_count <= COURNAND_STENTS_MAX, "options: stent_count is above 8");
    require(options.stent_count == 0 || options.stents != nullptr, "options: stents is NULL");
    for (std::uint32_t i = 0; i < options.stent_count; i++) {
        require(options.stents[i] != nullptr, "options: a path of stents is NULL");
        settings.stents.emplace_back(options.stents[i]);
    }
    settings.record = text_or_empty(options.record);
    return settings;
}

// Refuses a recording that would replace a file which the play reads. A folder in which no file can be
// written is refused later, with the recording itself.
void check_recording(const Session &session, const PlaySettings &settings)
{
    if (settings.record.empty()) return;
    std::vector<NamedPath> inputs = {{"the script", session.file},
                                     {"the scene", settings.scene->file().path},
                                     {"the scene's bodies", settings.scene->bodies_path()}};
    for (const std::string &stent : settings.stents) inputs.push_back({"a stent", stent});
    try {
        check_outputs(inputs, {{"record", settings.record}});
    } catch (const UsageError &error) {
        throw Refused(COURNAND_BAD_ARGUMENT, error.what());
    } catch (const OutputError &) {
        return;
    }
}

} // namespace

cournand_status cournand_script_open(const char *path, const char *hands, cournand_script **script)
{
    return guarded(
        [&] {
            require(path != nullptr && script != nullptr, "path or script is NULL");
            Session session = read_session(path);
            if (const std::string word = text_or_empty(hands); !word.empty()) {
                try {
                    session = with_hands(session, read_hands(word));
                } catch (const std::runtime_error &error) {
                    throw Refused(COURNAND_BAD_ARGUMENT, error.what());
                }
            }
            *script = make_handle<cournand_script>(std::make_shared<Session>(std::move(session)));
        },
        COURNAND_BAD_FILE);
}

cournand_status cournand_script_free(cournand_script *script)
{
    return free_handle(script);
}

cournand_status cournand_script_describe(const cournand_script *script, cournand_script_info *info)
{
    return guarded([&] {
        cournand_script_info own{};
        describe(*object_of(script), own);
        write_struct(info, own, "info");
    });
}

cournand_status cournand_play_create(const cournand_script *script, const cournand_scene *scene,
                                     cournand_tool *const *tools, size_t tool_count,
                                     const cournand_play_options *options, cournand_play **play)
{
    return guarded([&] {
        const auto session = object_of(script);
        require(play != nullptr, "play is NULL: pass where the handle goes");
        PlaySettings settings = play_settings(scene, tools, tool_count, options);
        check_recording(*session, settings);
        *play = make_handle<cournand_play>(std::make_shared<Play>(*session, std::move(settings)));
    });
}

cournand_status cournand_play_free(cournand_play *play)
{
    return free_handle(play);
}

cournand_status cournand_play_world(cournand_play *play, cournand_world **world)
{
    return with_play(play, [&](const Play &of) {
        require(world != nullptr, "world is NULL: pass where the handle goes");
        *world = make_handle<cournand_world>(of.world());
    });
}

cournand_status cournand_play_new_world(cournand_play *play, cournand_world **world)
{
    return with_play(play, [&](const Play &of) {
        require(world != nullptr, "world is NULL: pass where the handle goes");
        *world = make_handle<cournand_world>(std::make_shared<World>(of.world()->settings()));
    });
}

cournand_status cournand_play_advance(cournand_play *play, uint32_t ticks, uint32_t flags)
{
    return with_play(play, [&](Play &advanced) {
        require((flags & ~std::uint32_t{COURNAND_PLAY_TO_PULSE}) == 0, "flags has an unknown bit");
        advanced.advance(ticks, (flags & COURNAND_PLAY_TO_PULSE) != 0);
    });
}

cournand_status cournand_play_read(cournand_play *play, cournand_play_state *state)
{
    return with_play(play, [&](const Play &from) {
        cournand_play_state own{};
        from.read(own);
        write_struct(state, own, "state");
    });
}

cournand_status cournand_play_view(cournand_play *play, cournand_view *view)
{
    return with_play(play, [&](const Play &from) {
        cournand_view own = read_struct(view, "view");
        from.read(own);
        write_struct(view, own, "view");
    });
}

cournand_status cournand_play_report(cournand_play *play, const char **json)
{
    return with_play(play, [&](const Play &from) {
        require(json != nullptr, "json is NULL: pass where the text goes");
        *json = from.report().c_str();
    });
}
