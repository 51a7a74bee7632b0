// Predicts when the live monitor gets its next picture from the times of the last two pictures. If the GUI
// window began to draw a screen shortly before a picture arrives, only the following screen would show this
// picture. The GUI window therefore waits for a picture that is due.
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
    // Returns true if drawing a screen now would probably delay a picture; `screen` is the time that the
    // drawing takes. If a picture is late by more than a quarter of its period, the window no longer waits
    // for it.
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
