// A Transport is a pipe of bytes to a device. USB, QEMU and the sim port all have this interface for Link.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace crn
{

class Transport
{
  public:
    virtual ~Transport() = default;
    // Sends all bytes, or throws LinkError.
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    // Returns the bytes received, at most bytes.size(); 0 when none come within the transport's time limit.
    virtual std::size_t read(std::span<std::uint8_t> bytes) = 0;
    // Lets device time pass where the host controls it (sim port); real devices have their own clock.
    virtual void pass_time_ms(std::uint32_t milliseconds) = 0;
    // The name in messages to the user: "the rig 'RIG-0001'".
    virtual std::string name() const { return "the device"; }
    // False if it computes as fast as this machine allows (sim port, emulator), so a slow answer is not its
    // fault.
    virtual bool has_own_clock() const { return true; }
};

} // namespace crn
