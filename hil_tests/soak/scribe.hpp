// Writes the statements of a session script and tracks the inserted length of each tool, if it can be
// predicted without simulation.
#pragma once
#include "hil_tests/soak/catalogue.hpp"
#include "hil_tests/soak/dice.hpp"
#include <string>
#include <vector>

namespace soak
{

class Scribe
{
  public:
    Scribe(const SoakScene &scene, std::vector<const SoakTool *> tools, Dice &dice);

    Dice &dice() { return dice_; }
    const SoakScene &scene() const { return scene_; }
    std::size_t tool_count() const { return tools_.size(); }
    const SoakTool &tool(std::size_t k) const { return *tools_[k]; }
    int inserted_mm(std::size_t k) const { return inserted_mm_[k]; }
    int depth_max_mm(std::size_t k) const; // the depth to which this tool is sent at most
    double seconds() const { return seconds_; }
    std::vector<std::string> take() { return std::move(lines_); }

    void say(const std::string &line) { lines_.push_back(line); }
    void begin(std::size_t k, int mm);
    void wait_ms(int ms);
    // The following functions add parts to the present statement, and the function `end` completes the
    // statement. The parts of a statement run at the same time, so a statement takes as long as its longest
    // part.
    void push(std::size_t k, int mm, int mm_s, int stroke_mm = 0); // negative: withdraw
    void push_together(int mm, int mm_s);
    void turn(std::size_t k, int deg, int deg_s);
    void push_until(std::size_t k, int mm, int mm_s);
    void end();
    void inflate(int bar, int bar_s); // 0: deflate
    bool is_inflated() const { return bar_ > 0; }

    int some_speed_mm_s();
    int some_turn_deg_s();

  private:
    void piece(const std::string &text, double seconds);

    const SoakScene &scene_;
    const std::vector<const SoakTool *> tools_;
    Dice &dice_;
    std::vector<std::string> lines_;
    std::vector<int> inserted_mm_;
    int bar_ = 0;
    double seconds_ = 0, statement_s_ = 0;
    std::string statement_;
};

} // namespace soak
