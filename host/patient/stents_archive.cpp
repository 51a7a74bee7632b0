// Saves and restores the stents of a session. The walls of stents are not saved, but are made again from the
// scene's vessels.
#include "host/patient/stents.hpp"
#include <algorithm>
#include <stdexcept>

namespace crn
{

namespace
{

constexpr double far_mm = 1e4;

void archive_ring(StateArchive &state, crn_wire_strut &ring)
{
    constexpr std::int32_t far_um = 1'900'000;
    state.integer<std::uint8_t>(ring.number, 0, struts_max);
    state.integer<std::uint8_t>(ring.joined, 0, 1);
    for (std::int32_t *place_um : {&ring.x_um, &ring.y_um, &ring.z_um})
        state.integer<std::int32_t>(*place_um, -far_um, far_um);
    state.integer<std::uint16_t>(ring.inside_um, 0, 20'000);
    state.integer<std::uint16_t>(ring.thickness_um, 0, 1000);
    // The radius of a ring in the core is at least that which ring_of() computes; the radius 0 removes a
    // ring.
    if (state.restores())
        state.require(ring.inside_um == 0 || (ring.inside_um >= 200 && ring.thickness_um >= 10));
}

} // namespace

void PatientStents::archive(StateArchive &state, const std::vector<Instrument> &tools)
{
    if (state.restores()) take_tools(tools);
    state.real(inserted_m_, -10.0, 10.0);
    state.index(loaded_, shelf_.size() + 1);
    archive_walls(state);
    archive_stents(state);
    state.list(taken_out_, [&](Taken &one) {
        state.text(one.name);
        state.real(one.diameter_mm, 0.0, far_mm);
        state.real(one.length_mm, 0.0, far_mm);
        state.integer(one.loaded_tick);
    });
    state.integer(next_look_);
    if (state.restores()) state.require(stents_.size() > 0 || next_look_ == UINT32_MAX);
    state.integer(seen_.tick);
    state.integer(seen_.heart_phase32);
    state.integer(seen_.breath_phase32);
    state.list(seen_.lesions_open, [&](double &share) { state.real(share, 0.0, 4.0); });
    archive_core(state);
    state.list(refusals_, [&](std::string &why) { state.text(why); });
}

// A wall that already exists is used again, because making a wall takes long.
void PatientStents::archive_walls(StateArchive &state)
{
    std::vector<std::size_t> branches;
    for (const Vessel &vessel : walls_) branches.push_back(vessel.branch);
    state.list(branches, [&](std::size_t &branch) { state.index(branch, vessels_.branches.size()); });
    if (!state.restores() || state.is_refused()) return;
    std::vector<Vessel> kept = std::move(walls_);
    walls_.clear();
    for (const std::size_t branch : branches) {
        const auto same = std::find_if(kept.begin(), kept.end(),
                                       [&](const Vessel &one) { return one.wall && one.branch == branch; });
        if (same != kept.end()) {
            walls_.push_back(std::move(*same));
            continue;
        }
        try {
            state.require(vessel_of(branch) + 1 == walls_.size()); // no branch is named twice
        } catch (const std::invalid_argument &) {
            state.require(false); // a branch that ends before its own ostium
        }
        if (state.is_refused()) return;
    }
}

void PatientStents::archive_stents(StateArchive &state)
{
    state.list(stories_, [&](Story &story) { archive_story(state, story); });
    if (state.is_refused()) return;
    std::vector<Stent> restored;
    for (std::size_t i = 0; i < stories_.size() && !state.is_refused(); ++i) {
        std::vector<std::uint8_t> bytes;
        if (!state.restores()) bytes = stents_[i].snapshot();
        state.bytes(bytes);
        if (!state.restores() || state.is_refused()) continue;
        const Story &story = stories_[i];
        Stent &stent = restored.emplace_back(shelf_[story.shelf], story.mount_mm);
        const std::size_t triangles = story.vessel ? walls_[*story.vessel].wall->wall().triangle_count() : 0;
        state.require(stent.restore(bytes) && stent.fits(triangles));
        state.require(!stent.is_on_balloon() || i + 1 == stories_.size());
    }
    if (state.restores() && !state.is_refused()) stents_ = Stents(std::move(restored));
}

void PatientStents::archive_story(StateArchive &state, Story &story)
{
    state.index(story.shelf, loaded_);
    state.real(story.mount_mm, -far_mm, far_mm);
    state.integer(story.loaded_tick);
    for (std::optional<std::uint32_t> *tick : {&story.opened_tick, &story.released_tick})
        state.optional(*tick, [&](std::uint32_t &at) { state.integer(at); });
    state.optional(story.vessel, [&](std::size_t &vessel) { state.index(vessel, walls_.size()); });
}

// Saves or restores the rings and openings that the core has, and the orders that it has not received yet.
void PatientStents::archive_core(StateArchive &state)
{
    for (std::vector<std::uint32_t> &known : known_256_)
        for (std::uint32_t &open_256 : known) state.integer<std::uint32_t>(open_256, 0, UINT16_MAX);
    for (crn_wire_strut &ring : known_struts_) archive_ring(state, ring);
    std::vector<crn_wire_order> waiting(orders_.waiting().begin(), orders_.waiting().end());
    state.list(waiting, [&](crn_wire_order &order) { archive_order(state, order); });
    if (!state.restores() || state.is_refused()) return;
    orders_.clear();
    for (const crn_wire_order &order : waiting) orders_.add(order);
}

void PatientStents::archive_order(StateArchive &state, crn_wire_order &order) const
{
    bool is_strut = order.kind == CRN_WIRE_KIND_strut;
    state.flag(is_strut);
    if (is_strut) {
        crn_wire_strut ring = state.restores() ? crn_wire_strut{} : order.strut;
        archive_ring(state, ring);
        if (state.restores()) state.require(ring.number >= 1);
        order = crn_wire_order_of_strut(ring);
        return;
    }
    crn_wire_scaffold hold = state.restores() ? crn_wire_scaffold{} : order.scaffold;
    state.integer<std::uint8_t>(hold.lesion, 1, UINT8_MAX);
    state.integer(hold.first);
    state.integer(hold.last);
    state.integer<std::uint16_t>(hold.open_q15, 0, 32768);
    if (state.restores())
        state.require(hold.lesion <= stations_.size() && hold.first <= hold.last &&
                      hold.last < stations_[hold.lesion - 1u].count);
    order = crn_wire_order_of_scaffold(hold);
}

} // namespace crn
