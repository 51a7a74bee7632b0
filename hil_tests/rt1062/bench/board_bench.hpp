// A test bench (hil_tests/cases/bench.hpp) whose device is the board's image on the emulated chip, with the
// rig at its pins and a high-speed USB host on its bus. Time is the chip's own: eight microframes make a
// millisecond of the rig.
#pragma once
#include "hil_tests/cases/bench.hpp"
#include "hil_tests/rt1062/bench/rig_pins.hpp"
#include <string>

namespace hil
{

class BoardBench final : public Bench, private crn::Transport
{
  public:
    BoardBench(const PlantSettings &settings, const std::string &image);
    ~BoardBench() override;
    crn::Transport &pipe() override { return *this; }
    rt_engine &engine() { return *engine_; }
    RigPins &pins() { return pins_; }
    // Puts bytes into the stream to the device, and takes those that have come from it; no time passes.
    bool push(std::span<const std::uint8_t> bytes);
    std::size_t take(std::span<std::uint8_t> bytes);
    // Throws with the model's report if a wait was never answered, or if there are findings.
    void check_report();
    // Throws if the processor has locked up, with the model's words.
    void check_trouble() const;

  protected:
    crn_port_outputs edge(const crn_port_inputs &inputs) override;
    void hold(bool held) override { is_held_ = held; }
    void pass_frozen_ms() override;
    crn_port_outputs restart() override;

  private:
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override { advance(milliseconds); }
    bool has_own_clock() const override { return false; }
    std::string name() const override { return "the emulated board"; }

    void open();
    void check_life();
    void run_microframe();

    rt_chip *chip_ = nullptr;
    rt_engine *engine_ = nullptr;
    rt_stream *stream_ = nullptr;
    RigPins pins_;
    std::uint32_t microframe_ = 0; // of the present millisecond
    bool is_held_ = false, has_restarted_ = false;
};

class BoardLevel final : public Level
{
  public:
    explicit BoardLevel(const std::string &image) : image_(image) {}
    const char *name() const override { return "RT"; }
    std::unique_ptr<Bench> make(const PlantSettings &settings) override;
    bool has_jumping_encoders() const override { return false; }

  private:
    std::string image_;
};

} // namespace hil
