#include "host/room/dose.hpp"
#include <algorithm>
#include <iterator>

namespace crn
{
namespace
{

constexpr int alert_count = static_cast<int>(std::size(dose_alert_levels_Gy));

void add_pulse(Dose &dose, double air_kerma_uGy, double kap_Gy_cm2)
{
    dose.pulses++;
    dose.air_kerma_uGy += air_kerma_uGy;
    dose.kap_Gy_cm2 += kap_Gy_cm2;
}

} // namespace

void DoseMeter::begin(const Irradiation &irradiation)
{
    irradiations_.push_back(irradiation);
    is_on_ = true;
}

void DoseMeter::add(std::uint32_t tick, double air_kerma_uGy, double kap_Gy_cm2)
{
    if (!is_on_) return;
    Irradiation &present = irradiations_.back();
    present.tick_end = tick;
    add_pulse(present.dose, air_kerma_uGy, kap_Gy_cm2);
    add_pulse(total_, air_kerma_uGy, kap_Gy_cm2);
    kerma_rate_mGy_min_ = air_kerma_uGy * 1e-3 * present.pulses_per_s * 60.0;
    while (alerts_passed_ < alert_count && total_.air_kerma_uGy >= dose_alert_levels_Gy[alerts_passed_] * 1e6)
        unseen_ = alerts_passed_++;
}

void DoseMeter::note_pulse(const CArm &carm, double tube_voltage_kV, double tube_current_mA, double pulse_ms)
{
    if (!is_on_) return;
    Irradiation &present = irradiations_.back();
    if (present.dose.pulses == 0) present.carm = carm;
    present.tube_voltage_kV = tube_voltage_kV;
    present.tube_current_mA = tube_current_mA;
    present.pulse_ms = pulse_ms;
}

void DoseMeter::pass_tick()
{
    if (!is_on_) return;
    irradiations_.back().dose.beam_ticks++;
    total_.beam_ticks++;
    if (irradiations_.back().kind == RunKind::fluoro) fluoro_ticks_++;
}

void DoseMeter::acknowledge()
{
    unseen_.reset();
    reminders_seen_ = fluoro_reminders();
}

void DoseMeter::end(std::uint32_t tick, int kept_as_run)
{
    if (!is_on_) return;
    is_on_ = false;
    kerma_rate_mGy_min_ = 0.0;
    irradiations_.back().tick_end = tick;
    irradiations_.back().run = kept_as_run;
    if (irradiations_.back().dose.pulses == 0) irradiations_.pop_back();
}

} // namespace crn
