// UsbTransport is a Transport to a rig on USB. It uses the pair of bulk endpoints of docs/usb.md through
// libusb, with several transfers pending in each direction.
//
// A separate thread of the transport serves libusb. A read or write blocks its caller only for a limited
// time. Every wait ends when bytes arrive, the time limit is reached, the device disappears (DeviceLost), or
// after_interrupt_ms have passed since Ctrl-C. The destructor cancels all transfers and ends the thread. Only
// one thread at a time may call the functions of a transport.
#pragma once
#include "host/link/transport.hpp"
#include "host/link/usb_devices.hpp"
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

struct libusb_transfer;

namespace crn
{

struct UsbLimits {
    std::uint32_t read_ms = 2000;  // for a silent device: read() then returns 0
    std::uint32_t write_ms = 2000; // for a device that accepts nothing: write() then throws
};

class UsbTransport final : public Transport
{
  public:
    // An empty `serial` selects the only rig that is plugged in. Throws a LinkError with the remedy, and
    // DeviceLost when the rig is not plugged in.
    explicit UsbTransport(const std::string &serial = "", const UsbLimits &limits = {});
    ~UsbTransport() override;
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    // Sleeps. After this call and until the next write, read() returns the bytes received so far at once,
    // without waiting for more.
    void pass_time_ms(std::uint32_t milliseconds) override;
    std::string name() const override { return "the rig '" + serial_ + "'"; }
    // Waits until the device has accepted every byte that the host wrote.
    void flush();
    const std::string &serial() const { return serial_; } // as the device reports it

    static constexpr std::size_t transfer_bytes = 1 << 14;
    static constexpr std::size_t in_count = 8, out_count = 8;
    static constexpr std::uint32_t after_interrupt_ms = 200; // enough for a clean end with a rig that answers

  private:
    struct Slot {
        UsbTransport *owner = nullptr;
        libusb_transfer *transfer = nullptr;
        std::array<std::uint8_t, transfer_bytes> bytes;
        bool is_flying = false;
    };

    void find_stream();
    void begin_stream();
    void make_slots();
    void submit_reads(); // call with lock_ held
    void submit(Slot &slot);
    void serve();
    void end();
    void throw_failure() const;
    // Waits until `is_done`; returns false when it took too long, or longer than after_interrupt_ms since
    // Ctrl-C.
    bool wait(std::unique_lock<std::mutex> &hold, std::chrono::milliseconds limit,
              const std::function<bool()> &is_done);
    void on_read_done(Slot &slot);
    void on_write_done(Slot &slot);
    static void read_done(libusb_transfer *transfer) noexcept;
    static void write_done(libusb_transfer *transfer) noexcept;

    UsbLimits limits_;
    UsbContext context_;
    UsbHandle handle_;
    std::string serial_;
    int interface_ = -1;
    std::uint8_t in_ = 0, out_ = 0; // endpoint addresses
    bool takes_only_what_came_ = false;

    std::mutex lock_;
    std::condition_variable changed_;
    std::vector<std::uint8_t> ring_; // received bytes; fixed size, so that no callback allocates
    std::size_t ring_begin_ = 0, ring_count_ = 0;
    std::vector<std::unique_ptr<Slot>> reads_, writes_;
    int failure_ = 0; // libusb error of the first failed transfer
    bool is_ending_ = false;
    std::atomic<bool> is_over_ = false; // for the thread
    std::thread thread_;
};

} // namespace crn
