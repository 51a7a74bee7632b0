// At test level 1 the firmware image runs on an emulated Cortex-M7. The image and the simulated rig run
// alternately and use the same shared memory.
#pragma once
#include "hil_tests/cases/bench.hpp"
#include "host/link/emulated_transport.hpp"
#include "host/link/emulator.hpp"

namespace hil
{

class EmulatedBench final : public Bench
{
  public:
    EmulatedBench(const PlantSettings &settings, const crn::EmulatorOptions &options);
    crn::Transport &pipe() override { return pipe_; }
    crn::Emulator &emulator() { return emulator_; }

  protected:
    crn_port_outputs edge(const crn_port_inputs &inputs) override;
    void hold(bool held) override;
    crn_port_outputs restart() override;

  private:
    crn::Emulator emulator_;
    crn::EmulatedTransport pipe_;
};

class EmulatedLevel final : public Level
{
  public:
    // The caller must choose `icount_shift` so that the emulated processor is fast enough to finish the work
    // of each millisecond in time. If `icount_shift` is 0, the emulated processor executes 1,000 instructions
    // per us.
    explicit EmulatedLevel(int icount_shift = 0, const std::string &debugger = "")
        : options_{{}, icount_shift, {}, debugger}
    {
    }
    const char *name() const override { return "L1"; }
    std::unique_ptr<Bench> make(const PlantSettings &settings) override
    {
        return std::make_unique<EmulatedBench>(settings, options_);
    }

  private:
    crn::EmulatorOptions options_;
};

} // namespace hil
