#include "host/script/tip_places.hpp"
#include "host/model/wall_way.hpp"
#include "host/model/wire_place.hpp"
#include <stdexcept>

namespace crn
{

std::vector<TipPlace> TipPlaces::at(const WireFrame &wire) const
{
    std::vector<TipPlace> tips(wire.tip_arc_m.size());
    if (map_.is_empty() || wire.nodes.size() < 2) return tips;
    const MotionMoment moment{wire.heart_phase32, wire.breath_phase32};
    const auto pulled = [&](const Eigen::Vector3d &at_m) -> Eigen::Vector3d {
        return motion_ ? motion_->pull(at_m, moment) : at_m;
    };
    const WireFrame rest = at_rest(wire);
    const VesselPlace sheath = map_.at(pulled(rest.nodes.back().position_m));
    for (std::size_t k = 0; k < tips.size(); ++k) {
        TipPlace &tip = tips[k];
        tip.at_m = line_place_m(wire, wire.tip_arc_m[k]);
        tip.reference_m = pulled(line_place_m(rest, wire.tip_arc_m[k]));
        tip.place = map_.at(tip.reference_m);
        tip.vessel = map_.vessels()[tip.place.vessel].name;
        tip.sheath = sheath;
        tip.inside_m = map_.inside_m(tip.place, sheath);
        tip.is_known = true;
    }
    return tips;
}

std::unique_ptr<TipPlaces> read_tip_places(const std::string &bodies_path, const std::string &scene_path)
{
    Bodies bodies;
    std::string error;
    if (bodies_path.empty()) return std::make_unique<TipPlaces>(bodies.vessels, std::nullopt);
    if (!read_bodies_of(scene_path, bodies_path, bodies, error)) throw std::runtime_error(error);
    std::optional<Motion> motion = read_motion(scene_path, error);
    if (!error.empty()) throw std::runtime_error(error);
    return std::make_unique<TipPlaces>(bodies.vessels, std::move(motion));
}

} // namespace crn
