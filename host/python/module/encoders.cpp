// Gives Python the encoders of pictures and the counts of label images.
#include "host/python/module/module.hpp"
#include "host/python/module/streams.hpp"
#include <nanobind/stl/array.h>

namespace cournand_python
{

namespace
{

using Colours = nb::ndarray<const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;

// An array of pixels has two dimensions, and a third of length 3 for colours. A PNG file has at least one
// pixel, and the stream of its pixels must be shorter than 2^31 bytes.
template <class Pixels> Image image_of(const Pixels &pixels)
{
    constexpr std::size_t most = std::size_t{1} << 30;
    if (pixels.shape(0) == 0 || pixels.shape(1) == 0 || pixels.size() > most / pixels.itemsize())
        throw nb::value_error("a PNG file needs at least one pixel, and at most 2^30 bytes of pixels");
    return {reinterpret_cast<const std::uint8_t *>(pixels.data()), pixels.shape(0), pixels.shape(1),
            pixels.itemsize() * (pixels.ndim() == 3 ? 3 : 1)};
}

template <class Pixels> nb::bytes stored(const Pixels &pixels)
{
    const Image picture = image_of(pixels);
    const std::size_t count = stored_png(picture, nullptr);
    const nb::object made = nb::steal(PyBytes_FromStringAndSize(nullptr, static_cast<Py_ssize_t>(count)));
    if (!made.is_valid()) throw nb::python_error();
    auto *to = reinterpret_cast<std::uint8_t *>(PyBytes_AsString(made.ptr()));
    {
        const nb::gil_scoped_release release;
        stored_png(picture, to);
    }
    return nb::borrow<nb::bytes>(made);
}

nb::bytes mask(const Given<std::uint8_t> &pixels)
{
    std::vector<std::uint8_t> made;
    {
        const nb::gil_scoped_release release;
        made = mask_png(image_of(pixels));
    }
    return nb::bytes(made.data(), made.size());
}

std::array<std::uint64_t, 8> bits_of(const Given<std::uint8_t> &pixels)
{
    return count_bits(pixels.data(), pixels.shape(0) * pixels.shape(1));
}

} // namespace

void add_encoders(nb::module_ &module)
{
    module.def("stored_png", &stored<Given<std::uint8_t>>);
    module.def("stored_png", &stored<Given<std::uint16_t>>);
    module.def("stored_colour_png", &stored<Colours>);
    module.def("mask_png", &mask);
    module.def("count_bits", &bits_of);
}

} // namespace cournand_python
