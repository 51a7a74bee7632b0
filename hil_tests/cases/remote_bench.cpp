#include "hil_tests/cases/remote_bench.hpp"
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <libusb-1.0/libusb.h>
#include <stdexcept>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace hil
{

namespace
{

constexpr std::uint32_t settle_ms =
    3; // of wall-clock time: by then the device's messages have usually arrived
constexpr std::uint32_t return_limit_ms = 20000; // for a device that restarts

constexpr unsigned request_limit_ms = 2000;
constexpr int opens_max = 50;
constexpr useconds_t retry_us = 50000;

int open_channel(const std::string &path)
{
    if (!std::filesystem::is_socket(path)) return open(path.c_str(), O_RDWR | O_CLOEXEC);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const int file = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (file >= 0 && connect(file, reinterpret_cast<sockaddr *>(&address), sizeof address) != 0) {
        close(file);
        return -1;
    }
    return file;
}

template <class Move, class Byte> void move_all(Move move, int file, Byte *bytes, std::size_t count)
{
    while (count > 0) {
        const ssize_t moved = move(file, bytes, count);
        if (moved <= 0) throw std::runtime_error("the bench is gone: " + std::string(std::strerror(errno)));
        bytes += moved;
        count -= static_cast<std::size_t>(moved);
    }
}

} // namespace

BenchChannel::BenchChannel(const std::string &path) : file_(open_channel(path))
{
    if (file_ < 0)
        throw std::runtime_error(path + ": " + std::strerror(errno) +
                                 ". Remedy: run it beside hil_rig (docs/hil.md)");
}

BenchChannel::~BenchChannel()
{
    close(file_);
}

BenchAnswer BenchChannel::ask(BenchOrder order, const crn_port_inputs &inputs, std::uint32_t milliseconds)
{
    const BenchRequest request = {order, milliseconds, inputs};
    BenchAnswer answer;
    move_all(::write, file_, reinterpret_cast<const char *>(&request), sizeof request);
    move_all(::read, file_, reinterpret_cast<char *>(&answer), sizeof answer);
    answer.trouble[sizeof answer.trouble - 1] = '\0';
    if (answer.trouble[0] != '\0') throw std::runtime_error(answer.trouble);
    return answer;
}

RemoteBench::RemoteBench(const PlantSettings &settings, BenchChannel &channel, const std::string &serial)
    : Bench(settings), channel_(channel), serial_(serial)
{
    channel_.ask(BenchOrder::power_on);
}

crn_port_outputs RemoteBench::edge(const crn_port_inputs &inputs)
{
    return channel_.ask(BenchOrder::edge, inputs, static_cast<std::uint32_t>(plant().milliseconds())).outputs;
}

void RemoteBench::hold(bool held)
{
    channel_.ask(held ? BenchOrder::hold : BenchOrder::release);
}

crn_port_outputs RemoteBench::restart()
{
    return channel_.ask(BenchOrder::power_cycle).outputs;
}

// The vendor request 0x21 of docs/usb.md makes the device disconnect itself.
bool RemoteBench::pull_cable(std::uint32_t bytes, std::uint32_t away_ms)
{
    constexpr std::uint8_t to_device = 0x40, unplug = 0x21;
    constexpr std::uint32_t packet_bytes = 512;
    const crn::UsbContext context = crn::usb_context();
    const crn::UsbHandle handle = crn::usb_open(context.get(), serial_);
    const int result = libusb_control_transfer(
        handle.get(), to_device, unplug, static_cast<std::uint16_t>(away_ms),
        static_cast<std::uint16_t>(bytes / packet_bytes + 1), nullptr, 0, request_limit_ms);
    if (result < 0) throw std::runtime_error(crn::usb_trouble(result, "the request to leave the bus"));
    return true;
}

// If the device has disappeared, an earlier call has already reported this error, so the present call
// searches for the device again.
crn::UsbTransport &RemoteBench::usb()
{
    if (usb_) return *usb_;
    if (!crn::UsbWatch().wait_for(serial_, return_limit_ms, [] { return false; }))
        throw crn::LinkError("the device does not come to the bus");
    usb_ = std::make_unique<crn::UsbTransport>(serial_);
    has_answered_ = false;
    return *usb_;
}

// The bus may still list a device that has just been switched off. The host therefore searches again for a
// device that has not answered yet.
void RemoteBench::write(std::span<const std::uint8_t> bytes)
{
    for (int attempt = 0;; attempt++) {
        try {
            usb().write(bytes);
            usb().flush();
            return;
        } catch (const crn::LinkError &) {
            const bool was_known = usb_ && has_answered_;
            usb_.reset();
            if (was_known || attempt == opens_max) throw;
            usleep(retry_us);
        }
    }
}

std::size_t RemoteBench::read(std::span<std::uint8_t> bytes)
{
    try {
        const std::size_t count = usb().read(bytes);
        has_answered_ = has_answered_ || count > 1; // a stream begins with one byte
        return count;
    } catch (const crn::LinkError &) {
        usb_.reset();
        throw;
    }
}

void RemoteBench::pass_time_ms(std::uint32_t milliseconds)
{
    advance(milliseconds);
    if (usb_) usb_->pass_time_ms(settle_ms);
}

namespace
{

class MetalBench final : public Bench
{
  public:
    MetalBench(const PlantSettings &settings, const std::string &serial) : Bench(settings), usb_(serial) {}
    crn::Transport &pipe() override { return usb_; }

  protected:
    [[noreturn]] static void refuse() { throw std::runtime_error("a rig of metal has no plant to lead"); }
    crn_port_outputs edge(const crn_port_inputs &) override { refuse(); }
    void hold(bool) override { refuse(); }
    crn_port_outputs restart() override { refuse(); }

  private:
    crn::UsbTransport usb_;
};

} // namespace

// Clears all state and messages that the previous session left behind.
std::unique_ptr<Bench> MetalLevel::make(const PlantSettings &settings)
{
    auto bench = std::make_unique<MetalBench>(settings, serial_);
    crn::Link link(bench->pipe());
    link.hello();
    if (link.read_status().state != CRN_WIRE_STATE_READY) link.reset();
    return bench;
}

std::unique_ptr<Bench> RemoteLevel::make(const PlantSettings &settings)
{
    if (!channel_) channel_ = std::make_unique<BenchChannel>(path_);
    return std::make_unique<RemoteBench>(settings, *channel_, serial_);
}

} // namespace hil
