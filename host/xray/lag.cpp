// Balances trapped and released signal.
#include "host/xray/lag.hpp"
#include "host/xray/float_math.hpp"

namespace crn
{

float lag_released_share(std::uint32_t elapsed_ms)
{
    const float half_times =
        static_cast<float>(elapsed_ms < 100000u ? elapsed_ms : 100000u) / lag_half_time_ms;
    return 1.0f - exp2_negative(half_times);
}

void lag_row(float released_share, int size, float *trapped, float *signal)
{
    for (int x = 0; x < size; ++x) {
        const float caught = lag_trapped_share * signal[x], released = released_share * trapped[x];
        signal[x] = signal[x] - caught + released;
        trapped[x] = trapped[x] - released + caught;
    }
}

} // namespace crn
