// Reads a world. The arrays are the world's own memory; the first request after a change fills them.
#include "host/library/world.hpp"
#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include <cmath>

namespace crn::library
{

namespace
{

float phase(std::uint32_t phase32)
{
    return static_cast<float>(phase32 * 0x1p-32);
}

// The exact positions are returned as three numbers per node.
static_assert(sizeof(crn_wire_node_position) == 3 * sizeof(std::int32_t));

} // namespace

void World::forget_views()
{
    has_nodes_ = has_contacts_ = false;
}

void World::follow_line()
{
    const crn_wire_nodes &shape = link_.nodes();
    if (shape.line_count == 0) return;
    LineNumbers line(shape.line, shape.line + shape.line_count);
    if (line == line_now_) return;
    line_now_ = std::move(line);
    tools_now_ = tools_on(settings_.tools, line_now_);
}

const crn_wire_nodes &World::nodes()
{
    if (has_nodes_) return link_.nodes();
    const crn_wire_nodes &nodes = link_.read_nodes();
    follow_line();
    frame_ = wire_frame(nodes, link_.node_table(), tools_now_);
    positions_m_.clear();
    arcs_m_.clear();
    radii_m_.clear();
    tip_arcs_m_.clear();
    inserted_m_.clear();
    for (const WireNode &node : frame_.nodes) {
        for (int axis = 0; axis < 3; axis++)
            positions_m_.push_back(static_cast<float>(node.position_m[axis]));
        arcs_m_.push_back(static_cast<float>(node.arc_m));
        radii_m_.push_back(static_cast<float>(node.radius_m));
    }
    for (const double arc_m : frame_.tip_arc_m) tip_arcs_m_.push_back(static_cast<float>(arc_m));
    tip_arcs_m_.resize(positions());
    for (std::uint16_t k = 0; k < nodes.inserted_m_q30_count; k++)
        inserted_m_.push_back(static_cast<float>(units::metres(nodes.inserted_m_q30[k])));
    inserted_m_.resize(positions());
    has_nodes_ = true;
    return nodes;
}

const WireFrame &World::frame()
{
    settle();
    nodes();
    return frame_;
}

void World::read(cournand_pose &pose)
{
    const crn_wire_nodes &shape = nodes();
    pose.tick = tick();
    pose.node_count = static_cast<std::uint32_t>(arcs_m_.size());
    pose.position_count = static_cast<std::uint32_t>(positions());
    pose.positions_q30 = &shape.positions[0].x_m_q30;
    pose.positions_m = positions_m_.data();
    pose.arcs_m = arcs_m_.data();
    pose.radii_m = radii_m_.data();
    pose.tip_arcs_m = tip_arcs_m_.data();
    pose.inserted_m = inserted_m_.data();
}

void World::read(cournand_reading &reading)
{
    const crn_wire_nodes &shape = nodes();
    reading.tick = tick();
    reading.position_count = static_cast<std::uint32_t>(positions());
    reading.contact_count = state_.contact_count;
    reading.fault_bits = state_.core_fault_bits;
    for (std::size_t k = 0; k < positions(); k++) {
        reading.line[k] = line_now_[k];
        reading.inserted_m[k] = inserted_m_[k];
        if (k >= state_.tools_count) continue;
        reading.force_N[k] = static_cast<float>(units::newtons(state_.tools[k].handle_axial_N_q22));
        reading.torque_N_m[k] =
            static_cast<float>(units::newton_metres(state_.tools[k].handle_torque_N_m_q24));
    }
    reading.penetration_m = static_cast<float>(units::metres(state_.penetration_max_m_q30));
    reading.length_error = static_cast<float>(units::ratio(state_.strain_max_q30));
    reading.wall_force_peak_N = static_cast<float>(wall_peak_N_);
    reading.wall_force_N = static_cast<float>(wall_N_);
    reading.heart_phase = phase(shape.heart_phase32);
    reading.breath_phase = phase(shape.breath_phase32);
    reading.balloon_kPa = state_.balloon_kPa;
    reading.balloon_diameter_max_m = state_.balloon_diameter_max_um * 1e-6f;
    reading.balloon_diameter_min_m = state_.balloon_diameter_min_um * 1e-6f;
    reading.balloon_wall_N = state_.balloon_wall_mN * 1e-3f;
    reading.balloon_has_burst = state_.balloon_bits & 1u;
    reading.exchange = state_.exchange;
    reading.is_out_of_range = out_of_range_tick_.has_value();
    reading.out_of_range_tick = out_of_range_tick_.value_or(0);
}

void World::read(cournand_contacts &contacts)
{
    if (!has_contacts_) {
        const crn_wire_contacts &found = link_.read_contacts();
        contact_nodes_.clear();
        forces_N_.clear();
        for (std::uint16_t i = 0; i < found.contacts_count; i++) {
            const crn_wire_contact &one = found.contacts[i];
            contact_nodes_.push_back(one.node);
            for (const std::int32_t force : {one.force_x_N_q22, one.force_y_N_q22, one.force_z_N_q22})
                forces_N_.push_back(static_cast<float>(units::newtons(force)));
        }
        has_contacts_ = true;
    }
    contacts.tick = tick();
    contacts.count = static_cast<std::uint32_t>(contact_nodes_.size());
    contacts.nodes = contact_nodes_.data();
    contacts.forces_N = forces_N_.data();
}

void World::read(std::uint32_t position, cournand_place &place)
{
    require(position < positions(), "the position is not on the line");
    nodes();
    place.vessel = -1;
    place.name = "";
    const std::vector<TipPlace> tips = scene().tips().at(frame_);
    if (position >= tips.size()) return;
    const TipPlace &tip = tips[position];
    for (int axis = 0; axis < 3; axis++) place.tip_m[axis] = tip.at_m[axis];
    if (!tip.is_known) return;
    place.vessel = static_cast<std::int32_t>(tip.place.vessel);
    place.name = scene().tips().map().vessels()[tip.place.vessel].name.c_str();
    place.along_m = tip.place.along_m;
    place.inside_m = tip.inside_m;
    place.radii = tip.place.radii;
}

void World::moved(std::span<const double> rest_m, std::span<double> now_m)
{
    const std::optional<Motion> &motion = scene().anatomy().motion;
    nodes();
    const MotionMoment moment{frame_.heart_phase32, frame_.breath_phase32};
    for (std::size_t i = 0; i < rest_m.size(); i += 3) {
        const Eigen::Vector3d rest(rest_m[i], rest_m[i + 1], rest_m[i + 2]);
        const Eigen::Vector3d now = motion ? motion->push(rest, moment) : rest;
        for (std::size_t axis = 0; axis < 3; axis++) now_m[i + axis] = now[static_cast<Eigen::Index>(axis)];
    }
}

std::uint64_t World::hash()
{
    return link_.read_hash64().hash;
}

std::size_t World::read(std::span<cournand_fault> faults)
{
    const crn_wire_fault_log log = link_.read_fault_log();
    for (std::size_t i = 0; i < std::min<std::size_t>(faults.size(), log.entries_count); i++) {
        const crn_wire_fault_entry &entry = log.entries[i];
        faults[i] = {entry.code,
                     entry.tick_first,
                     entry.tick_last,
                     entry.count,
                     entry.value1,
                     entry.value2,
                     crn_wire_fault_text(entry.code),
                     crn_wire_fault_remedy(entry.code)};
    }
    return log.entries_count;
}

void World::read(cournand_patient_reading &reading)
{
    Patient &patient = need_patient();
    settle();
    const PatientStents *stents = patient.stents();
    reading.stents_loaded = stents ? static_cast<std::uint32_t>(stents->loaded()) : 0;
    reading.injected_ml = patient.contrast().injected_ml();
    reading.injection_flow_ml_per_s = patient.contrast().flow_ml_s();
    reading.pressure_mmHg = patient.catheter_pressure().pressure_mmHg();
    reading.heart_rate_per_min = patient.monitor().rate_per_min();
    stage_text_ = stents ? stents->stage_text() : "";
    reading.stent_stage = stage_text_.c_str();
    reading.notice = patient.notice().text.c_str();
}

} // namespace crn::library
