// The device's image in an emulated Cortex-M7, as a pipe of bytes for host/link. It prices what it computes
// while a pricer is set.
#pragma once
#include "host/link/transport.hpp"
#include "tools/chip/pricer.hpp"
#include <memory>

namespace chip
{

// The emulated processor with its pricer: it outlives the transports, which the host opens and closes.
class ChipDevice
{
  public:
    explicit ChipDevice(const std::string &image);
    std::unique_ptr<crn::Transport> open();
    Pricer &pricer() { return pricer_; }
    Processor &processor() { return processor_; }
    void price(bool is_on) { is_priced_ = is_on; }
    Observer *observer() { return is_priced_ ? &pricer_ : nullptr; }
    // Finds the parts of this scene in the slot that holds it.
    void find_scene(std::span<const std::uint8_t> scene);

  private:
    Processor processor_;
    std::map<std::uint32_t, Instruction> code_;
    Pricer pricer_;
    bool is_priced_ = false;
};

} // namespace chip
