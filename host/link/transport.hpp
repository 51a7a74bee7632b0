// A pipe of bytes to a device. USB, QEMU and the sim port all look like this to Link.
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
    // All bytes leave, or it throws LinkError.
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    // What has come in, at most bytes.size(); 0 when nothing comes within the transport's time limit.
    virtual std::size_t read(std::span<std::uint8_t> bytes) = 0;
    // Let device time pass where the host owns it (sim port); real devices have their own clock.
    virtual void pass_time_ms(std::uint32_t milliseconds) = 0;
    // How messages to the user call it: "the rig 'RIG-0001'".
    virtual std::string name() const { return "the device"; }
    // False: it computes as fast as this machine lets it (sim port, emulator), so a slow answer is not its
    // fault.
    virtual bool has_own_clock() const { return true; }
};

} // namespace crn
