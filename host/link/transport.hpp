// A Transport carries bytes between the host and a device. USB, QEMU and the sim port (the firmware in this
// process) each implement this interface for the class Link.
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
    // Sends all bytes to the device, or throws LinkError.
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    // Returns the number of bytes received, at most bytes.size(); the result is 0 when no bytes arrive within
    // the transport's time limit.
    virtual std::size_t read(std::span<std::uint8_t> bytes) = 0;
    // Advances the device's time where the host controls that time (sim port); a real device has its own
    // clock.
    virtual void pass_time_ms(std::uint32_t milliseconds) = 0;
    // Returns the name of the device in messages to the user, such as "the rig 'RIG-0001'".
    virtual std::string name() const { return "the device"; }
    // Returns false if the device computes only as fast as this machine allows (sim port, emulator); a slow
    // answer is then not the device's fault.
    virtual bool has_own_clock() const { return true; }
};

} // namespace crn
