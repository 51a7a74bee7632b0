#include "host/python/module/pictures.hpp"
#include <nanobind/stl/array.h>

namespace cournand_python
{

namespace
{

cournand_renderer *create(const Scene &scene, std::uint32_t threads)
{
    cournand_renderer *renderer = nullptr;
    unlocked([&] { return cournand_renderer_create(scene.get(), threads, &renderer); });
    return renderer;
}

// In the library, the size 0 stands for the usual size; a Python caller must always state the size.
std::uint32_t stated(std::uint32_t size)
{
    if (size == 0)
        throw StatusError(COURNAND_BAD_ARGUMENT, "size is 0, not a multiple of 16 within 64 and 2048");
    return size;
}

template <class Number> nb::object picture_view(const Number *pixels, std::size_t size, nb::handle owner)
{
    if (pixels == nullptr) return nb::none();
    return view(pixels, {size, size}, owner);
}

nb::tuple render(nb::handle_t<Renderer> self, const World &world, const ViewNumbers &numbers,
                 std::uint32_t flags, std::uint64_t seed)
{
    const Renderer &renderer = nb::cast<const Renderer &>(self);
    const cournand_view view = make_view(numbers, renderer.size(), flags, seed);
    auto picture = sized<cournand_picture>();
    unlocked([&] { return cournand_render(renderer.get(), world.get(), &view, &picture); });
    return nb::make_tuple(picture.tick, picture_view(picture.grey, picture.size, self),
                          picture_view(picture.raw, picture.size, self),
                          picture_view(picture.labels, picture.size, self), picture.is_underexposed != 0,
                          picture.tube_voltage_kV, picture.tube_current_mA, picture.pulse_ms,
                          picture.air_kerma_uGy, picture.kap_Gy_cm2);
}

nb::tuple matrix(const ViewNumbers &numbers, std::uint32_t size)
{
    double entries[12];
    const cournand_view view = make_view(numbers, stated(size), 0, 0);
    check(cournand_view_matrix(&view, entries));
    return tuple_of(entries, 12);
}

} // namespace

Renderer::Renderer(const Scene &scene, std::uint32_t size, std::uint32_t threads)
    : size_(stated(size)), handle_(create(scene, threads))
{
    double entries[12]; // refuses a wrong size now, not at the first picture
    const cournand_view view = make_view({}, size, 0, 0);
    check(cournand_view_matrix(&view, entries));
}

cournand_view make_view(const ViewNumbers &numbers, std::uint32_t size, std::uint32_t flags,
                        std::uint64_t seed)
{
    auto view = sized<cournand_view>();
    view.flags = flags;
    view.primary_deg = numbers[0];
    view.secondary_deg = numbers[1];
    for (int axis = 0; axis < 3; axis++) view.isocentre_m[axis] = numbers[2 + axis];
    view.source_detector_m = numbers[5];
    view.source_isocentre_m = numbers[6];
    view.field_m = numbers[7];
    view.dose_nGy = numbers[8];
    view.size = size;
    view.seed = seed;
    return view;
}

void add_pictures(nb::module_ &module)
{
    nb::class_<Renderer>(module, "Renderer")
        .def(nb::init<const Scene &, std::uint32_t, std::uint32_t>())
        .def("render", &render);
    module.def("view_matrix", &matrix);
}

} // namespace cournand_python
