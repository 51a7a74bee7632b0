// The module cournand._core contains the scenes and the tools, and converts error statuses into exceptions.
// The public classes are in host/python/cournand; the classes of this module take checked arguments and
// return tuples.
#include "host/python/module/module.hpp"
#include <cstring>
#include <nanobind/stl/pair.h>

namespace cournand_python
{

namespace
{

Scene *open_scene(const std::optional<std::string> &path, const std::optional<std::string> &bodies)
{
    cournand_scene *scene = nullptr;
    unlocked([&] {
        return cournand_scene_open(path ? path->c_str() : nullptr, bodies ? bodies->c_str() : nullptr,
                                   &scene);
    });
    return new Scene(scene);
}

nb::tuple describe_scene(const Scene &scene)
{
    auto info = sized<cournand_scene_info>();
    check(cournand_scene_describe(scene.get(), &info));
    return nb::make_tuple(std::string(info.name), info.crc32, tuple_of(info.entry_m, 3),
                          tuple_of(info.direction, 3), info.start_m, info.vessel_count, info.moves != 0);
}

nb::tuple vessel_of(nb::handle_t<Scene> self, std::uint32_t number)
{
    auto vessel = sized<cournand_vessel>();
    check(cournand_scene_vessel(nb::cast<const Scene &>(self).get(), number, &vessel));
    return nb::make_tuple(std::string(vessel.name), vessel.parent,
                          view(vessel.points_m, {vessel.point_count, 4}, self), vessel.length_m);
}

std::uint32_t find_vessel(const Scene &scene, const std::string &name)
{
    std::uint32_t number = 0;
    check(cournand_scene_find_vessel(scene.get(), name.c_str(), &number));
    return number;
}

Tool *open_tool(const std::string &path)
{
    cournand_tool *tool = nullptr;
    unlocked([&] { return cournand_tool_open(path.c_str(), &tool); });
    return new Tool(tool);
}

nb::tuple describe_tool(const Tool &tool)
{
    auto info = sized<cournand_tool_info>();
    check(cournand_tool_describe(tool.get(), &info));
    return nb::make_tuple(std::string(info.name), info.is_catheter != 0, info.length_m, info.radius_max_m,
                          info.has_balloon != 0);
}

std::vector<double> markers_of(const Tool &tool)
{
    std::size_t count = 0;
    check(cournand_tool_markers(tool.get(), nullptr, 0, &count));
    std::vector<double> arcs_m(count);
    check(cournand_tool_markers(tool.get(), arcs_m.data(), count, &count));
    return arcs_m;
}

Tool *scaled_tool(const Tool &tool, double bend, double twist, double mass, double friction, double curvature)
{
    auto scales = sized<cournand_tool_scales>();
    scales.bend_stiffness = bend;
    scales.twist_stiffness = twist;
    scales.mass = mass;
    scales.friction = friction;
    scales.rest_curvature = curvature;
    cournand_tool *made = nullptr;
    check(cournand_tool_scaled(tool.get(), &scales, &made));
    return new Tool(made);
}

// The exception class is looked up when it is needed, so that the module keeps no references to Python
// objects.
void raise(const std::exception_ptr &thrown, void *)
{
    try {
        std::rethrow_exception(thrown);
    } catch (const StatusError &error) {
        const nb::module_ errors = nb::module_::import_("cournand.errors");
        nb::object kind = errors.attr("of_status")(static_cast<int>(error.status));
        // A text may quote bytes of a path or of a file that are not valid UTF-8.
        const char *text = error.what();
        const auto decoded =
            nb::steal(PyUnicode_DecodeUTF8(text, static_cast<Py_ssize_t>(std::strlen(text)), "replace"));
        if (!decoded.is_valid()) return;
        if (error.script.empty()) return PyErr_SetObject(kind.ptr(), decoded.ptr());
        kind = errors.attr("ScriptError");
        const auto file = nb::steal(PyUnicode_DecodeFSDefault(error.script.c_str()));
        if (!file.is_valid()) return;
        const nb::object made = kind(decoded, file, error.line, error.column);
        PyErr_SetObject(kind.ptr(), made.ptr());
    }
}

} // namespace

} // namespace cournand_python

NB_MODULE(_core, module)
{
    using namespace cournand_python;
    module.doc() = "The C library of Cournand. Use the classes of the package `cournand` instead.";
    nb::register_exception_translator(raise);
    module.def("version", [] { return std::string(cournand_version_text()); });
    module.def("core_version", &cournand_core_version);
    module.def("status_name", [](int status) {
        return std::string(cournand_status_name(static_cast<cournand_status>(status)));
    });
    nb::class_<Scene>(module, "Scene")
        .def(nb::new_(&open_scene), nb::arg("path").none(), nb::arg("bodies").none())
        .def("describe", &describe_scene)
        .def("vessel", &vessel_of)
        .def("find_vessel", &find_vessel);
    nb::class_<Tool>(module, "Tool")
        .def(nb::new_(&open_tool), nb::arg("path"))
        .def("describe", &describe_tool)
        .def("markers", &markers_of)
        .def("scaled", &scaled_tool);
    add_worlds(module);
    add_recordings(module);
    add_plays(module);
    add_pictures(module);
    add_batches(module);
    add_encoders(module);
}
