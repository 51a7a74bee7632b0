#include "hil_tests/soak/scribe.hpp"
#include "hil_tests/soak/draw.hpp"
#include "host/script/tool.hpp"
#include <algorithm>
#include <cstdlib>

namespace soak
{

namespace
{

constexpr double ramp_s = 0.2, regrasp_s = 0.35;
constexpr int spare_mm = 50; // of a tool's length remain in the hand

std::string number(int value)
{
    return std::to_string(value);
}

} // namespace

Scribe::Scribe(const SoakScene &scene, std::vector<const SoakTool *> tools, Dice &dice)
    : scene_(scene), tools_(std::move(tools)), dice_(dice), inserted_mm_(tools_.size(), 20)
{
}

int Scribe::depth_max_mm(std::size_t k) const
{
    return std::min(scene_.depth_max_mm, tools_[k]->length_mm() - spare_mm);
}

void Scribe::begin(std::size_t k, int mm)
{
    inserted_mm_[k] = mm;
    lines_.push_back("begin " + crn::tool_name(k) + " inserted " + number(mm) + " mm");
}

void Scribe::wait_ms(int ms)
{
    lines_.push_back("wait " + number(ms) + " ms");
    seconds_ += ms * 1e-3;
}

void Scribe::piece(const std::string &text, double seconds)
{
    statement_ += (statement_.empty() ? "" : " while ") + text;
    statement_s_ = std::max(statement_s_, seconds);
}

void Scribe::end()
{
    lines_.push_back(statement_);
    seconds_ += statement_s_;
    statement_.clear();
    statement_s_ = 0;
}

void Scribe::push(std::size_t k, int mm, int mm_s, int stroke_mm)
{
    std::string text = (mm < 0 ? "withdraw " : "advance ") + crn::tool_name(k) + " " + number(std::abs(mm)) +
                       " mm at " + number(mm_s) + " mm/s";
    double seconds = std::abs(mm) / static_cast<double>(mm_s) + ramp_s;
    if (stroke_mm > 0) {
        text += " in strokes of " + number(stroke_mm) + " mm";
        seconds += regrasp_s * (std::abs(mm) / stroke_mm);
    }
    inserted_mm_[k] = std::clamp(inserted_mm_[k] + mm, 0, tools_[k]->length_mm());
    piece(text, seconds);
}

void Scribe::push_together(int mm, int mm_s)
{
    piece((mm < 0 ? "withdraw together " : "advance together ") + number(std::abs(mm)) + " mm at " +
              number(mm_s) + " mm/s",
          std::abs(mm) / static_cast<double>(mm_s) + ramp_s);
    for (std::size_t k = 0; k < tools_.size(); k++)
        inserted_mm_[k] = std::clamp(inserted_mm_[k] + mm, 0, tools_[k]->length_mm());
}

void Scribe::turn(std::size_t k, int deg, int deg_s)
{
    piece("rotate " + crn::tool_name(k) + " " + number(deg) + " deg at " + number(deg_s) + " deg/s",
          std::abs(deg) / static_cast<double>(deg_s) + ramp_s);
}

void Scribe::push_until(std::size_t k, int mm, int mm_s)
{
    const int way_mm = mm - inserted_mm_[k];
    if (way_mm == 0) return piece("rotate " + crn::tool_name(k) + " 0 deg", ramp_s);
    piece((way_mm < 0 ? "withdraw " : "advance ") + crn::tool_name(k) + " until inserted " + number(mm) +
              " mm at " + number(mm_s) + " mm/s",
          std::abs(way_mm) / static_cast<double>(mm_s) + ramp_s);
    inserted_mm_[k] = mm;
}

void Scribe::inflate(int bar, int bar_s)
{
    lines_.push_back(bar > 0 ? "inflate to " + number(bar) + " bar at " + number(bar_s) + " bar/s"
                             : "deflate at " + number(bar_s) + " bar/s");
    seconds_ += std::abs(bar - bar_) / static_cast<double>(bar_s);
    bar_ = bar;
}

// Returns a random speed of a hand: most speeds are moderate, some are high, and one in eight is the highest
// possible speed.
int Scribe::some_speed_mm_s()
{
    switch (dice_.weighted({25, 45, 18, 12})) {
    case 0:
        return dice_.between(3, 25);
    case 1:
        return dice_.between(25, 100);
    case 2:
        return dice_.between(100, speed_max_mm_s);
    default:
        return speed_max_mm_s;
    }
}

int Scribe::some_turn_deg_s()
{
    return dice_.chance(20) ? turn_max_deg_s : dice_.between(20, turn_max_deg_s);
}

} // namespace soak
