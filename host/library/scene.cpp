#include "host/library/scene.hpp"
#include "host/model/units.hpp"

namespace crn::library
{

Scene::Scene(const std::string &scene_path, const std::string &bodies_path)
    : bodies_path_(bodies_path.empty() ? bodies_beside(scene_path) : bodies_path),
      file_(with_files([&] { return read_scene(scene_path); })),
      anatomy_(with_files([&] { return read_scene_anatomy(scene_path, bodies_path_); })),
      tips_(anatomy_.bodies.vessels, anatomy_.motion)
{
    collect_points();
}

const XrayScene &Scene::xray() const
{
    std::call_once(made_xray_, [&] {
        std::string error;
        if (!xray_.set_bodies(anatomy_.bodies, error))
            throw Refused(COURNAND_BAD_FILE, bodies_path_ + ": " + error);
    });
    return xray_;
}

// A vessel of the map may be only a part of its branch; its points are those of this part.
void Scene::collect_points()
{
    for (const MappedVessel &vessel : tips_.map().vessels()) {
        const VesselBranch &branch = anatomy_.bodies.vessels.branches[vessel.branch];
        std::vector<float> &points = points_m_.emplace_back();
        double along_m = 0.0;
        for (std::size_t i = 0; i < branch.points_m.size(); i++) {
            if (i > 0) along_m += (branch.points_m[i] - branch.points_m[i - 1]).norm();
            if (along_m < vessel.from_m - 1e-9 || along_m > vessel.to_m + 1e-9) continue;
            for (int axis = 0; axis < 3; axis++)
                points.push_back(static_cast<float>(branch.points_m[i][axis]));
            points.push_back(static_cast<float>(branch.radii_m[i]));
        }
    }
}

void Scene::describe(cournand_scene_info &info) const
{
    info.crc32 = file_.crc32;
    info.name = file_.name.c_str();
    const crn_wire_entry &entry = file_.entry;
    const Eigen::Vector3d at_m =
        units::metres(entry.position_x_m_q30, entry.position_y_m_q30, entry.position_z_m_q30);
    const std::int32_t direction[3] = {entry.direction_x_q30, entry.direction_y_q30, entry.direction_z_q30};
    for (int axis = 0; axis < 3; axis++) {
        info.entry_m[axis] = at_m[axis];
        info.direction[axis] = units::ratio(direction[axis]);
    }
    info.start_m = file_.start_um * 1e-6;
    info.vessel_count = static_cast<std::uint32_t>(points_m_.size());
    info.moves = anatomy_.motion.has_value();
}

void Scene::describe(std::uint32_t number, cournand_vessel &description) const
{
    if (number >= points_m_.size())
        throw Refused(COURNAND_BAD_ARGUMENT, "the scene has no vessel " + std::to_string(number) +
                                                 ": it has " + std::to_string(points_m_.size()));
    const MappedVessel &vessel = tips_.map().vessels()[number];
    description.parent = vessel.parent;
    description.name = vessel.name.c_str();
    description.points_m = points_m_[number].data();
    description.point_count = static_cast<std::uint32_t>(points_m_[number].size() / 4);
    description.length_m = vessel.length_m();
}

} // namespace crn::library
