// Saves and restores the X-ray room: motors, dose, pedals, beam and runs.
#include "host/room/room.hpp"
#include <algorithm>
#include <iterator>

namespace crn
{

namespace
{

constexpr double kerma_max = 1e12;

void archive_carm(StateArchive &state, CArm &carm)
{
    for (double *angle_deg : {&carm.primary_deg, &carm.secondary_deg}) state.real(*angle_deg, -180.0, 180.0);
    state.reals({carm.isocentre_m.data(), 3}, -10.0, 10.0);
    for (double *length_m : {&carm.source_detector_m, &carm.source_isocentre_m, &carm.field_m})
        state.real(*length_m, 0.01, 10.0);
}

void archive_technique(StateArchive &state, XrayTechnique &technique)
{
    state.real(technique.tube_voltage_kV, 20.0, 200.0);
    state.real(technique.tube_current_mA, 0.0, 1e4);
    state.real(technique.pulse_ms, 0.0, 1e4);
    state.real(technique.copper_mm, 0.0, 10.0);
    state.real(technique.focal_spot_mm, 0.0, 10.0);
}

void archive_dose(StateArchive &state, Dose &dose)
{
    state.integer(dose.pulses);
    state.real(dose.air_kerma_uGy, 0.0, kerma_max);
    state.real(dose.kap_Gy_cm2, 0.0, kerma_max);
    state.integer(dose.beam_ticks);
}

// An archive with a pulse or frame rate that no command can set is refused.
template <class Rate, std::size_t count>
void archive_rate(StateArchive &state, Rate &rate, const std::int32_t (&rates)[count])
{
    state.integer(rate);
    if (state.restores())
        state.require(std::find(std::begin(rates), std::end(rates), rate) != std::end(rates));
}

} // namespace

void Gantry::archive(StateArchive &state)
{
    constexpr double spare = 1.0; // motors may pass their limits by less
    for (std::size_t i = 0; i < pose_.size(); ++i) {
        const AxisLimits &limits = gantry_limits()[i];
        for (double *value : {&pose_[i], &target_[i]})
            state.real(*value, limits.low - spare, limits.high + spare);
        state.real(speed_[i], -2.0 * limits.speed, 2.0 * limits.speed);
    }
    state.flag(is_blocked_);
    state.flag(is_halting_);
}

void DoseMeter::archive(StateArchive &state)
{
    state.list(irradiations_, [&](Irradiation &one) {
        state.choice(one.kind, RunKind::dsa);
        state.integer<int>(one.run, 0, 1'000'000);
        state.integer(one.tick_begin);
        state.integer(one.tick_end);
        state.real(one.pulses_per_s, 0.0, 100.0);
        archive_carm(state, one.carm);
        for (double *value : {&one.tube_voltage_kV, &one.tube_current_mA, &one.pulse_ms})
            state.real(*value, 0.0, 1e4);
        archive_dose(state, one.dose);
    });
    state.flag(is_on_);
    if (state.restores()) state.require(!is_on_ || !irradiations_.empty());
    archive_dose(state, total_);
    state.integer(fluoro_ticks_);
    state.integer(reminders_seen_);
    state.real(kerma_rate_mGy_min_, 0.0, kerma_max);
    constexpr int alerts = static_cast<int>(std::size(dose_alert_levels_Gy));
    state.integer<int>(alerts_passed_, 0, alerts);
    state.optional(unseen_, [&](int &alert) { state.integer<int>(alert, 0, alerts - 1); });
}

void Room::archive(StateArchive &state, std::uint32_t now)
{
    if (state.restores()) events_.clear();
    gantry_.archive(state);
    dose_.archive(state);
    state.list(runs_, [&](RoomRun &run) {
        state.integer<int>(run.number, 1, 1'000'000);
        state.choice(run.kind, RunKind::dsa);
        state.real(run.pulses_per_s, 0.0, 100.0);
        state.integer(run.frames);
    });
    state.list(queue_, [&](Queued &one) {
        state.integer(one.tick);
        archive_command(state, one.command);
    });
    state.integer<std::int64_t>(tick_, -1, now);
    archive_settings(state);
    archive_beam(state);
    state.list(refusals_, [&](Refusal &one) { archive_refusal(state, one); });
    // The saved time of a future event must not be before the present tick, because the room would otherwise
    // have to make up for the missed ticks.
    if (state.restores() && !state.is_refused()) state.require(next_tick() >= now);
}

void Room::archive_settings(StateArchive &state)
{
    state.integer<std::int32_t>(field_um_, field_min_um, field_max_um);
    for (std::int32_t *width : {&blade_width_permille_, &blade_height_permille_})
        state.integer<std::int32_t>(*width, blade_min_permille, blade_max_permille);
    for (bool *flag : {&is_round_, &follows_tip_, &was_blocked_, &is_fluoro_down_, &is_fluoro_armed_,
                       &is_acquire_down_, &is_acquire_armed_, &is_acquire_waiting_, &is_underexposed_})
        state.flag(*flag);
    state.choice(program_, RunKind::dsa);
    archive_rate(state, fluoro_centihertz_, fluoro_rates_centihertz);
    archive_rate(state, cine_centihertz_, cine_rates_centihertz);
    archive_rate(state, dsa_centihertz_, dsa_rates_centihertz);
    archive_technique(state, technique_);
    state.text(notice_.text);
    state.integer<std::int64_t>(notice_.from, -1, UINT32_MAX);
}

void Room::archive_beam(StateArchive &state)
{
    state.flag(beam_.is_on);
    state.choice(beam_.kind, RunKind::dsa);
    state.flag(beam_.is_acquired);
    state.integer(beam_.tick_begin);
    state.integer<std::int64_t>(beam_.rate_centihertz, beam_.is_on ? 1 : 0, 100'000);
    state.integer(beam_.index);
    state.optional(beam_.locked, [&](XrayTechnique &technique) { archive_technique(state, technique); });
    state.flag(is_pulse_due_);
    state.flag(is_run_made_);
    if (state.restores()) {
        state.require(!is_run_made_ || !runs_.empty());
        state.require(!beam_.is_on || !dose_.irradiations().empty());
    }
    state.list(passed_, [&](std::uint32_t &tick) { state.integer(tick); });
    state.real(passed_pulses_per_s_, 0.0, 100.0);
}

} // namespace crn
