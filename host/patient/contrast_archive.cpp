// Saves and restores the contrast medium of a session.
#include "host/patient/contrast.hpp"
#include <algorithm>

namespace crn
{

namespace
{

constexpr double flow_max_ml_s = 1e6, iodine_max_mg_per_ml = 1000.0, open_max = 4.0;

void archive_fluid(StateArchive &state, InjectedFluid &fluid)
{
    state.real(fluid.flow_ml_s, 0.0, flow_max_ml_s);
    state.real(fluid.iodine_mg_per_ml, 0.0, iodine_max_mg_per_ml);
}

} // namespace

void PatientContrast::archive(StateArchive &state, std::uint32_t now, const std::vector<Instrument> &tools,
                              const crn_wire_tick_state &last)
{
    if (state.restores()) {
        tools_ = tools;
        last_ = last;
    }
    archive_lesions(state);
    flow_.archive(state);
    archive_syringe(state);
    state.choice(state_, State::flows);
    state.integer<std::int64_t>(seen_tick_, -1, now);
    state.integer<std::uint32_t>(look_tick_, 0, now);
    state.integer(wake_tick_);
    state.list(new_holes_, [&](std::pair<std::size_t, WallHole> &one) {
        state.index(one.first, 1u << 20);
        archive_hole(state, one.second, flow_.cells().size());
    });
    state.list(new_flaps_, [&](std::pair<std::size_t, WallFlap> &one) {
        state.index(one.first, 1u << 20);
        archive_flap(state, one.second, flow_.cells().size());
    });
    state.real(pressure_share_, 0.0, 1.0);
    // Flowing medium is advanced at least every look_every_ticks; if more time has passed, catching up would
    // take long.
    if (state.restores() && state_ != State::idle) state.require(flow_.cells().size() > 0);
    if (state.restores() && state_ == State::flows)
        state.require(now - seen_tick_ <= std::int64_t{look_every_ticks} + 1);
    state.list(beats_, [&](Beat &beat) {
        state.integer(beat.tick);
        for (double *time_s : {&beat.phase.since_opening_s, &beat.phase.systole_s, &beat.phase.beat_s})
            state.real(*time_s, -1e6, 1e6);
        state.flag(beat.phase.is_beating);
    });
    archive_columns(state);
}

// The restored vessels get the shape of the saved vessels. Building the cells takes long, so they are built
// again only if the opening of a lesion differs from the saved one.
void PatientContrast::archive_lesions(StateArchive &state)
{
    const std::vector<double> before = flow_open_;
    for (std::vector<double> *open : {&flow_open_, &seen_open_})
        state.list(*open, [&](double &share) { state.real(share, 0.0, open_max); });
    if (state.restores() && !state.is_refused() && flow_open_ != before) reopen();
}

void PatientContrast::reopen()
{
    flow_ = ContrastFlow(vessels_);
    if (flow_open_.empty()) return;
    VesselTree opened = vessels_;
    opening_.open(vessels_, flow_open_, opened);
    flow_.reshape(opened, 0);
}

void PatientContrast::archive_syringe(StateArchive &state)
{
    injector_.archive(state);
    state.index(tool_, std::max<std::size_t>(tools_.size(), 1));
    state.real(iodine_mg_per_ml_, 1.0, iodine_max_mg_per_ml);
    archive_fluid(state, fluid_);
    state.list(given_, [&](Given &part) {
        state.integer(part.tick_begin);
        state.integer(part.tick_end);
        archive_fluid(state, part.fluid);
    });
    state.list(asked_, [&](Asked &one) {
        state.integer(one.tick);
        state.integer(one.number);
        state.index(one.tool, tools_.size());
        state.real(one.flow_ml_s, 1e-6, flow_max_ml_s);
        state.real(one.iodine_mg_per_ml, 1.0, iodine_max_mg_per_ml);
    });
    state.list(refusals_, [&](Refusal &one) { archive_refusal(state, one); });
}

void PatientContrast::archive_columns(StateArchive &state)
{
    state.index(stream_.cell, std::max<std::size_t>(flow_.cells().size(), 1));
    state.reals({stream_.tip_m.data(), 3}, -10.0, 10.0);
    state.real(stream_.share, 0.0, 1.0);
    state.real(stream_.strength, 0.0, 1.0);
    bool has_curves = !curves_.empty();
    state.flag(has_curves);
    state.integer(curves_at_.heart_phase32);
    state.integer(curves_at_.breath_phase32);
    state.real(curves_mg_per_ml_, 1.0, iodine_max_mg_per_ml);
    if (!state.restores() || state.is_refused()) return;
    curves_.clear();
    if (!has_curves) return;
    if (moved_.can_move()) flow_.place(moved_.at(curves_at_, opening_, flow_open_));
    make_curves();
}

} // namespace crn
