// At test level 0 the device's application is a library in this process, where it runs alternately with the
// simulated rig.
#pragma once
#include "firmware/port/sim/sim.h"
#include "hil_tests/cases/bench.hpp"

namespace hil
{

class SimBench final : public Bench, private crn::Transport
{
  public:
    explicit SimBench(const PlantSettings &settings);
    ~SimBench() override;
    crn::Transport &pipe() override { return *this; }
    // From now on the device has the processor of a board (crn_sim_set_tick_cycles).
    void set_tick_cycles(std::uint32_t cycles) { crn_sim_set_tick_cycles(sim_, cycles); }

  protected:
    crn_port_outputs edge(const crn_port_inputs &inputs) override;
    void hold(bool) override {} // the device gets no time meanwhile
    void pass_frozen_ms() override;
    crn_port_outputs restart() override;

  private:
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override;

    crn_sim *sim_;
    bool has_restarted_ = false;
};

class SimLevel final : public Level
{
  public:
    const char *name() const override { return "L0"; }
    std::unique_ptr<Bench> make(const PlantSettings &settings) override
    {
        return std::make_unique<SimBench>(settings);
    }
};

} // namespace hil
