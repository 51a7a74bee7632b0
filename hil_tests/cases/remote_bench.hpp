// At levels 2 and 3 the device runs in an emulator in another process (hil_rig), and the host reaches the
// device through the host's real USB code. The simulated rig (class Plant) runs in this process.
//
// The plant makes time. The device receives all bytes that the host has written before the next millisecond
// begins. The device's messages reach the host complete and in order, but a little later.
#pragma once
#include "hil_tests/cases/bench.hpp"
#include "hil_tests/l1/bench_server.hpp"
#include "host/link/usb_transport.hpp"

namespace hil
{

// Connects to the program hil_rig, either through the program's bench socket or, in a guest system, through
// the port of a virtual serial line.
class BenchChannel
{
  public:
    explicit BenchChannel(const std::string &path); // throws std::runtime_error
    ~BenchChannel();
    BenchChannel(const BenchChannel &) = delete;
    BenchChannel &operator=(const BenchChannel &) = delete;
    // Throws std::runtime_error if the other end of the pipe no longer exists, or if an error occurred at the
    // other end; in the second case the exception has that error's message.
    BenchAnswer ask(BenchOrder order, const crn_port_inputs &inputs = {}, std::uint32_t milliseconds = 0);

  private:
    int file_;
};

class RemoteBench final : public Bench, private crn::Transport
{
  public:
    RemoteBench(const PlantSettings &settings, BenchChannel &channel, const std::string &serial);
    crn::Transport &pipe() override { return *this; }
    bool pull_cable(std::uint32_t bytes, std::uint32_t away_ms) override;

  protected:
    crn_port_outputs edge(const crn_port_inputs &inputs) override;
    void hold(bool held) override;
    crn_port_outputs restart() override;

  private:
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override;
    crn::UsbTransport &usb();

    BenchChannel &channel_;
    std::string serial_;
    std::unique_ptr<crn::UsbTransport> usb_;
    bool has_answered_ = false;
};

// The test level of this class uses a real rig, or a program that replaces the real rig. The test level of a
// real rig has no simulated rig (class Plant), so only test cases that work without a simulated rig can run.
class MetalLevel final : public Level
{
  public:
    explicit MetalLevel(const std::string &serial) : serial_(serial) {}
    const char *name() const override { return "rig"; }
    std::unique_ptr<Bench> make(const PlantSettings &settings) override;

  private:
    std::string serial_;
};

class RemoteLevel final : public Level
{
  public:
    RemoteLevel(const std::string &name, const std::string &channel, const std::string &serial)
        : name_(name), path_(channel), serial_(serial)
    {
    }
    const char *name() const override { return name_.c_str(); }
    std::unique_ptr<Bench> make(const PlantSettings &settings) override;

  private:
    std::string name_, path_, serial_;
    std::unique_ptr<BenchChannel> channel_;
};

} // namespace hil
