// Predicts when the next picture of the live monitor comes, from the times of the last two. A screen that is
// begun shortly before a picture would show it only with the screen after, so the window waits for it
// instead.
#pragma once
#include <chrono>

namespace crn
{

class PictureRhythm
{
  public:
    using Time = std::chrono::steady_clock::time_point;
    using Duration = std::chrono::steady_clock::duration;

    void picture_came(Time when)
    {
        period_ = when - last_;
        last_ = when;
    }
    // Returns true if a screen that is begun now and takes this long would probably delay a picture. A
    // picture that is late by a quarter of its period is not waited for any longer.
    bool is_picture_near(Time now, Duration screen) const
    {
        if (period_ > period_max) return false;
        const Time next = last_ + period_;
        return now + screen > next && now < next + period_ / 4;
    }

  private:
    static constexpr Duration period_max =
        std::chrono::milliseconds(150); // 7.5 pictures per second are steady
    Time last_{};
    Duration period_ = period_max * 2;
};

} // namespace crn
