// Recordings: their descriptions, their inputs as arrays of bytes, and worlds that can replay them.
#include "host/python/module/module.hpp"
#include <cstring>

namespace cournand_python
{

namespace
{

static_assert(sizeof(cournand_input) == 168, "the dtype in cournand/recording.py has this size");

Recording *open(const std::string &path)
{
    cournand_recording *recording = nullptr;
    unlocked([&] { return cournand_recording_open(path.c_str(), &recording); });
    return new Recording(recording);
}

nb::tuple describe(const Recording &recording)
{
    auto info = sized<cournand_recording_info>();
    check(cournand_recording_describe(recording.get(), &info));
    return nb::make_tuple(info.tick_count, info.is_complete != 0, info.core_version, info.tool_count,
                          info.position_count, info.scene_crc32, std::string(info.scene_path),
                          std::string(info.session), info.last_hash, info.last_hash_tick);
}

void inputs(
    const Recording &recording, std::uint32_t first,
    nb::ndarray<std::uint8_t, nb::shape<-1, sizeof(cournand_input)>, nb::c_contig, nb::device::cpu> into)
{
    std::vector<cournand_input> copies(into.shape(0));
    check(cournand_recording_inputs(recording.get(), first, static_cast<std::uint32_t>(copies.size()),
                                    copies.data()));
    if (!copies.empty()) std::memcpy(into.data(), copies.data(), copies.size() * sizeof(cournand_input));
}

World *world(const Recording &recording, const Scene &scene, bool has_patient)
{
    cournand_world *made = nullptr;
    unlocked([&] {
        return cournand_recording_world(recording.get(), scene.get(), has_patient ? COURNAND_WITH_PATIENT : 0,
                                        &made);
    });
    return new World(made);
}

} // namespace

void add_recordings(nb::module_ &module)
{
    nb::class_<Recording>(module, "Recording")
        .def(nb::new_(&open), nb::arg("path"))
        .def("describe", &describe)
        .def("inputs", &inputs)
        .def("world", &world);
}

} // namespace cournand_python
