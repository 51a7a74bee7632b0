// Computes the oxygen saturation that the finger sensor of a patient shows (SpO2). While the patient
// breathes, the saturation is 98 %. While the breath is held, the saturation stays at 98 % for 20 s, because
// the lungs store oxygen and the blood needs time to reach the finger. If the breath is held for longer than
// 20 s, the saturation falls faster and faster, to 90 % after 70 s. When the patient breathes again, the
// saturation recovers five times as fast as it fell. The saturation values are assumptions for a healthy
// adult who breathes air.
#pragma once
#include <algorithm>
#include <cstdint>

namespace crn
{

class Oximeter
{
  public:
    static constexpr double resting_pct = 98.0, low_pct = 90.0, least_pct = 50.0;

    // Receives the state of the patient at a tick of 1 ms; a tick before the last one begins a new session.
    void look(std::uint32_t tick, bool holds_breath)
    {
        if (tick < tick_) *this = Oximeter();
        const double passed_s = (tick - tick_) * 1e-3;
        tick_ = tick;
        apnoea_s_ =
            std::clamp(apnoea_s_ + (holds_breath ? passed_s : -recovery * passed_s), 0.0, apnoea_max_s);
    }
    double saturation_pct() const
    {
        const double late = std::max(apnoea_s_ - delay_s, 0.0) / (low_s - delay_s);
        return std::max(resting_pct - (resting_pct - low_pct) * late * late, least_pct);
    }

  private:
    static constexpr double delay_s = 20.0, low_s = 70.0, recovery = 5.0, apnoea_max_s = 200.0;
    std::uint32_t tick_ = 0;
    double apnoea_s_ = 0.0;
};

} // namespace crn
