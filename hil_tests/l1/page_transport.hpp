// Bytes to and from the emulated device through the rings of the rig page.
// May include: emulator, host/link/transport.hpp. Called by: emulated_bench, the program hil.
#pragma once
#include "hil_tests/l1/emulator.hpp"
#include "host/link/transport.hpp"
#include <functional>

namespace hil
{

class PageTransport final : public seld::Transport
{
  public:
    // `pass_time` makes milliseconds; without it pass_time_ms() does nothing.
    explicit PageTransport(Emulator &emulator, std::function<void(std::uint32_t)> pass_time = {});

    void write(std::span<const std::uint8_t> bytes) override;
    // 0 when the device has worked off everything it was given and said everything it had to say.
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override;

  private:
    void check_life();

    Emulator &emulator_;
    std::function<void(std::uint32_t)> pass_time_;
    std::uint32_t boot_count_;
};

} // namespace hil
