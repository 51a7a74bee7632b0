// Sessions by script: scripts with the files that they name, and plays.
#include "host/python/module/module.hpp"
#include <cstring>

namespace cournand_python
{

namespace
{

// Checks a call that reads a script: a mistake in the script carries its place.
void check_script(cournand_status status)
{
    if (status == COURNAND_OK) return;
    StatusError error(status, cournand_error_text());
    auto place = sized<cournand_error_place>();
    if (status == COURNAND_BAD_FILE && cournand_error_where(&place) == COURNAND_OK) {
        error.script = place.file;
        error.line = place.line;
        error.column = place.column;
    }
    throw error;
}

Script *open_script(const std::string &path, const std::string &hands)
{
    cournand_script *script = nullptr;
    {
        const nb::gil_scoped_release release;
        check_script(cournand_script_open(path.c_str(), hands.c_str(), &script));
    }
    return new Script(script);
}

std::vector<std::string> texts(const char *const *first, std::size_t count)
{
    return {first, first + count};
}

nb::tuple describe(const Script &script)
{
    auto info = sized<cournand_script_info>();
    check(cournand_script_describe(script.get(), &info));
    return nb::make_tuple(std::string(info.path), std::string(info.scene), texts(info.tools, info.tool_count),
                          texts(info.stents, info.stent_count), info.statement_count);
}

Play *create(const Script &script, const Scene &scene, const nb::list &tools,
             const std::vector<std::string> &stents, const std::string &record)
{
    auto options = sized<cournand_play_options>();
    std::vector<const char *> paths;
    for (const std::string &path : stents) paths.push_back(path.c_str());
    options.stent_count = static_cast<std::uint32_t>(paths.size());
    options.stents = paths.data();
    options.record = record.c_str();
    std::vector<cournand_tool *> handles;
    for (const nb::handle tool : tools) handles.push_back(nb::cast<const Tool &>(tool).get());
    cournand_play *play = nullptr;
    {
        const nb::gil_scoped_release release;
        check_script(
            cournand_play_create(script.get(), scene.get(), handles.data(), handles.size(), &options, &play));
    }
    return new Play(play);
}

nb::tuple read(const Play &play)
{
    auto state = sized<cournand_play_state>();
    check(cournand_play_read(play.get(), &state));
    const std::string failures = state.failures;
    return nb::make_tuple(state.tick, state.is_over != 0, state.is_at_pulse != 0, state.is_beam_on != 0,
                          state.pulses, state.exit_status, nb::bytes(failures.data(), failures.size()));
}

void advance(const Play &play, std::uint32_t ticks, bool to_pulse)
{
    unlocked([&] { return cournand_play_advance(play.get(), ticks, to_pulse ? COURNAND_PLAY_TO_PULSE : 0); });
}

World *world_of(const Play &play)
{
    cournand_world *world = nullptr;
    check(cournand_play_world(play.get(), &world));
    return new World(world);
}

World *new_world(const Play &play)
{
    cournand_world *world = nullptr;
    unlocked([&] { return cournand_play_new_world(play.get(), &world); });
    return new World(world);
}

nb::tuple view_of(const Play &play)
{
    auto view = sized<cournand_view>();
    check(cournand_play_view(play.get(), &view));
    return nb::make_tuple(view.primary_deg, view.secondary_deg, tuple_of(view.isocentre_m, 3),
                          view.source_detector_m, view.source_isocentre_m, view.field_m);
}

nb::bytes report(const Play &play)
{
    const char *json = nullptr;
    check(cournand_play_report(play.get(), &json));
    return nb::bytes(json, std::strlen(json));
}

} // namespace

void add_plays(nb::module_ &module)
{
    nb::class_<Script>(module, "Script")
        .def(nb::new_(&open_script), nb::arg("path"), nb::arg("hands"))
        .def("describe", &describe);
    nb::class_<Play>(module, "Play")
        .def(nb::new_(&create))
        .def("read", &read)
        .def("advance", &advance)
        .def("world", &world_of)
        .def("new_world", &new_world)
        .def("view", &view_of)
        .def("report", &report);
}

} // namespace cournand_python
