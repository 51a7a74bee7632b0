// Exchanges bytes with the emulated device through two ring buffers in the rig page, which is memory that the
// host shares with the device.
#pragma once
#include "host/link/emulator.hpp"
#include "host/link/transport.hpp"
#include <functional>

namespace crn
{

class EmulatedTransport final : public Transport
{
  public:
    // `pass_time` advances the clock of the emulated board by some milliseconds; without `pass_time`,
    // pass_time_ms() does nothing.
    explicit EmulatedTransport(Emulator &emulator, std::function<void(std::uint32_t)> pass_time = {});

    void write(std::span<const std::uint8_t> bytes) override;
    // Returns 0 only when the device has processed all its input and sent all its output.
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override;
    bool has_own_clock() const override { return false; }

  private:
    void check_life();

    Emulator &emulator_;
    std::function<void(std::uint32_t)> pass_time_;
    std::uint32_t boot_count_;
};

// Starts the device's firmware image in an emulator of its own, with healthy sensors and the user's hands at
// rest. pass_time_ms() advances the emulated time by milliseconds. Throws EmulatorError with the remedy when
// the firmware image or the emulator is missing.
class EmulatedDevice final : public Transport
{
  public:
    explicit EmulatedDevice(const EmulatorOptions &options);
    void write(std::span<const std::uint8_t> bytes) override { pipe_.write(bytes); }
    std::size_t read(std::span<std::uint8_t> bytes) override { return pipe_.read(bytes); }
    void pass_time_ms(std::uint32_t milliseconds) override;
    bool has_own_clock() const override { return false; }

  private:
    Emulator emulator_;
    EmulatedTransport pipe_;
};

} // namespace crn
