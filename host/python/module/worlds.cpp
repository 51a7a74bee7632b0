// Worlds. The arrays are views of the library's memory, which stays at the same address while the world
// exists.
#include "host/python/module/module.hpp"
#include <cmath>
#include <limits>

namespace cournand_python
{

namespace
{

using Self = nb::handle_t<World>;
using Numbers = std::vector<double>;

cournand_world *of(nb::handle self)
{
    return nb::cast<const World &>(self).get();
}

World *create(const Scene &scene, const nb::list &tools, const std::vector<std::uint32_t> &line,
              const Numbers &inserted_m, bool has_patient, std::uint32_t contact_ticks,
              const std::vector<std::string> &stents)
{
    auto options = sized<cournand_world_options>();
    options.flags = has_patient ? COURNAND_WITH_PATIENT : 0;
    options.line_count = static_cast<std::uint32_t>(line.size());
    for (std::size_t k = 0; k < line.size() && k < COURNAND_POSITIONS_MAX; k++) options.line[k] = line[k];
    options.inserted_count = static_cast<std::uint32_t>(inserted_m.size());
    for (std::size_t k = 0; k < inserted_m.size() && k < COURNAND_POSITIONS_MAX; k++)
        options.inserted_m[k] = static_cast<float>(inserted_m[k]);
    options.contact_ticks = contact_ticks;
    std::vector<const char *> paths;
    for (const std::string &path : stents) paths.push_back(path.c_str());
    options.stent_count = static_cast<std::uint32_t>(paths.size());
    options.stents = paths.data();
    std::vector<cournand_tool *> handles;
    for (const nb::handle tool : tools) handles.push_back(nb::cast<const Tool &>(tool).get());
    cournand_world *world = nullptr;
    unlocked(
        [&] { return cournand_world_create(scene.get(), handles.data(), handles.size(), &options, &world); });
    return new World(world);
}

void move(const World &world, const Numbers &action, std::uint32_t ticks)
{
    if (action.size() != COURNAND_ACTION_FLOATS) throw nb::value_error("an action has 8 numbers");
    float floats[COURNAND_ACTION_FLOATS];
    for (std::size_t i = 0; i < action.size(); i++) floats[i] = static_cast<float>(action[i]);
    unlocked([&] { return cournand_world_move(world.get(), floats, ticks); });
}

using Inputs =
    nb::ndarray<const std::uint8_t, nb::shape<-1, sizeof(cournand_input)>, nb::c_contig, nb::device::cpu>;

void advance(const World &world, const Inputs &inputs)
{
    // The bytes of a NumPy array may begin at any address, also at one that is not aligned.
    std::vector<cournand_input> copies(inputs.shape(0));
    if (!copies.empty()) std::memcpy(copies.data(), inputs.data(), copies.size() * sizeof(cournand_input));
    unlocked([&] { return cournand_world_advance(world.get(), copies.data(), copies.size()); });
}

void order(const World &world, std::uint32_t kind, const std::vector<std::int32_t> &values)
{
    cournand_order given{kind, {}};
    if (values.size() > std::size(given.values)) throw nb::value_error("an order has at most 7 values");
    std::copy(values.begin(), values.end(), given.values);
    unlocked([&] { return cournand_world_order(world.get(), &given); });
}

nb::tuple pose(Self self)
{
    auto pose = sized<cournand_pose>();
    check(cournand_world_pose(of(self), &pose));
    const std::size_t n = pose.node_count, k = pose.position_count;
    return nb::make_tuple(pose.tick, view(pose.positions_m, {n, 3}, self), view(pose.arcs_m, {n}, self),
                          view(pose.radii_m, {n}, self), view(pose.tip_arcs_m, {k}, self),
                          view(pose.inserted_m, {k}, self), view(pose.positions_q30, {n, 3}, self));
}

nb::tuple contacts(Self self)
{
    auto contacts = sized<cournand_contacts>();
    check(cournand_world_contacts(of(self), &contacts));
    return nb::make_tuple(contacts.tick, view(contacts.nodes, {contacts.count}, self),
                          view(contacts.forces_N, {contacts.count, 3}, self));
}

nb::tuple read(const World &world)
{
    auto r = sized<cournand_reading>();
    check(cournand_world_read(world.get(), &r));
    const std::size_t k = r.position_count;
    nb::list list;
    list.append(r.tick);
    list.append(r.contact_count);
    list.append(r.fault_bits);
    list.append(tuple_of(r.line, k));
    list.append(tuple_of(r.inserted_m, k));
    list.append(tuple_of(r.force_N, k));
    list.append(tuple_of(r.torque_N_m, k));
    for (const float number :
         {r.penetration_m, r.length_error, r.wall_force_N, r.wall_force_peak_N, r.heart_phase, r.breath_phase,
          r.balloon_kPa, r.balloon_diameter_max_m, r.balloon_diameter_min_m, r.balloon_wall_N})
        list.append(number);
    list.append(r.balloon_has_burst != 0);
    list.append(r.exchange);
    list.append(r.is_out_of_range ? nb::int_(r.out_of_range_tick) : nb::object(nb::none()));
    return nb::tuple(list);
}

nb::tuple tip(const World &world, std::uint32_t position)
{
    auto place = sized<cournand_place>();
    check(cournand_world_tip(world.get(), position, &place));
    return nb::make_tuple(std::string(place.name), place.vessel, tuple_of(place.tip_m, 3), place.along_m,
                          place.inside_m, place.radii);
}

// Moves points in place; `points_m` belongs to the caller alone, so no other thread writes to it meanwhile.
using Points = nb::ndarray<double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

void move_points(const World &world, const Points &points_m)
{
    unlocked([&] {
        return cournand_world_moved(world.get(), points_m.data(), points_m.shape(0), points_m.data());
    });
}

std::uint64_t hash(const World &world)
{
    std::uint64_t value = 0;
    check(cournand_world_hash(world.get(), &value));
    return value;
}

nb::list faults(const World &world)
{
    cournand_fault faults[64];
    std::size_t count = 0;
    check(cournand_world_faults(world.get(), faults, std::size(faults), &count));
    nb::list list;
    for (std::size_t i = 0; i < std::min(count, std::size(faults)); i++) {
        const cournand_fault &f = faults[i];
        list.append(nb::make_tuple(f.code, f.tick_first, f.tick_last, f.count, f.value1, f.value2,
                                   std::string(f.text), std::string(f.remedy)));
    }
    return list;
}

void inject(const World &world, double ml, double ml_per_s, std::int32_t position, double iodine)
{
    check(cournand_world_inject(world.get(), ml, ml_per_s, position, iodine));
}

nb::tuple read_patient(const World &world)
{
    auto r = sized<cournand_patient_reading>();
    unlocked([&] { return cournand_world_read_patient(world.get(), &r); });
    return nb::make_tuple(r.stents_loaded, r.injected_ml, r.injection_flow_ml_per_s, r.pressure_mmHg,
                          r.heart_rate_per_min, std::string(r.stent_stage), std::string(r.notice));
}

nb::bytes save(const World &world)
{
    std::size_t count = 0;
    check(cournand_world_snapshot_bytes(world.get(), &count));
    std::vector<std::uint8_t> bytes(count);
    check(cournand_world_save(world.get(), bytes.data(), bytes.size()));
    return nb::bytes(bytes.data(), bytes.size());
}

void restore(const World &world, const nb::bytes &snapshot)
{
    check(cournand_world_restore(world.get(), snapshot.data(), snapshot.size()));
}

} // namespace

void add_worlds(nb::module_ &module)
{
    nb::class_<World>(module, "World")
        .def(nb::new_(&create))
        .def("move", &move)
        .def("advance", &advance)
        .def("order", &order)
        .def("pose", &pose)
        .def("contacts", &contacts)
        .def("read", &read)
        .def("tip", &tip)
        .def("move_points", &move_points)
        .def("hash", &hash)
        .def("faults", &faults)
        .def("inject", &inject)
        .def("load_stent", [](const World &w) { check(cournand_world_load_stent(w.get())); })
        .def("read_patient", &read_patient)
        .def("save", &save)
        .def("restore", &restore)
        .def("record",
             [](const World &w, const std::string &path, const std::string &session) {
                 unlocked([&] { return cournand_world_record(w.get(), path.c_str(), session.c_str()); });
             })
        .def("end_recording",
             [](const World &w) { unlocked([&] { return cournand_world_end_recording(w.get()); }); })
        .def("replay", [](const World &w, const Recording &recording, std::uint32_t tick) {
            unlocked([&] { return cournand_world_replay(w.get(), recording.get(), tick); });
        });
}

} // namespace cournand_python
