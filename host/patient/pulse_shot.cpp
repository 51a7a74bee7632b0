#include "host/patient/pulse_shot.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/pushed_vessels.hpp"
#include <iterator>
#include <stdexcept>

namespace crn
{

RadiopaqueInstrument instrument_look(const Instrument &instrument)
{
    RadiopaqueInstrument look;
    for (const InstrumentLayer &layer : instrument.layers) {
        const std::optional<Material> material = material_from_name(layer.material);
        if (!material) {
            throw std::runtime_error("instrument '" + instrument.name + "': unknown X-ray material '" +
                                     layer.material + "'; known: " + material_names());
        }
        look.sections.push_back(
            {layer.arc_begin_m, layer.arc_end_m, *material, layer.fill, layer.radius_share});
    }
    for (std::uint16_t i = 0; i < instrument.table.knots_count; i++) {
        const crn_wire_knot &knot = instrument.table.knots[i];
        look.radii.push_back({knot.arc_um * 1e-6, knot.radius_outer_um * 1e-6, knot.radius_inner_um * 1e-6});
    }
    return look;
}

std::vector<RadiopaqueInstrument> looks_on(std::span<const RadiopaqueInstrument> table,
                                           std::span<const std::uint8_t> line)
{
    return entries_on(table, line);
}

void PulseShot::own()
{
    vertices_um_.clear();
    for (MovedBody &body : bodies) {
        vertices_um_.emplace_back(body.vertices_um.begin(), body.vertices_um.end());
        body.vertices_um = vertices_um_.back(); // moving a vector does not move its elements
    }
}

// A picture shows the tools, the medium in the vessels and in the balloon, and the struts of stents.
PulseShot shot_of(Patient &patient, const WireFrame &shape, std::uint32_t tick, double iodine_mg_per_ml)
{
    PulseShot shot;
    shot.line = patient.line();
    shot.shape = shape;
    shot.shape.tick = tick;
    WireFrame rest = at_rest(shot.shape);
    patient.contrast().colour(rest);
    for (std::size_t i = 0; i < rest.nodes.size(); i++)
        shot.shape.nodes[i].contrast_mg_per_ml = rest.nodes[i].contrast_mg_per_ml;
    shot.curves = balloon_filling(shot.shape, patient.tools(), iodine_mg_per_ml);
    const std::size_t balloon = shot.curves.size();
    if (PatientStents *stents = patient.stents()) {
        std::vector<SweptCurve> struts = stents->curves_at(rest);
        shot.curves.insert(shot.curves.end(), std::make_move_iterator(struts.begin()),
                           std::make_move_iterator(struts.end()));
    }
    const std::vector<SweptCurve> &medium = patient.contrast().curves();
    shot.curves.insert(shot.curves.end(), medium.begin(), medium.end());
    PushedVessels(shot.shape).push(std::span(shot.curves).subspan(balloon));
    const std::span<const MovedBody> bodies = patient.bodies_at(shot.shape);
    shot.bodies.assign(bodies.begin(), bodies.end());
    return shot;
}

} // namespace crn
