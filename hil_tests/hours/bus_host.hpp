// The host's side of the bus, as a host's controller and drivers are: it configures the device, polls its
// state reports, keeps the bytes of the stream until a program reads them, and sends a program's bytes.
#pragma once
#include "shared/wire/hid.h"
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace hours
{

struct BusHostState; // usb_host is C

class BusHost
{
  public:
    // `poll` lets the device look at the bus once; returns false if the device is too late. `begin` begins a
    // wait.
    BusHost(void *mailbox, std::function<bool()> poll, std::function<void()> begin);
    ~BusHost();
    BusHost(const BusHost &) = delete;
    BusHost &operator=(const BusHost &) = delete;

    void plug();   // reset at high speed, address, configuration; throws std::runtime_error
    void unplug(); // what was not read yet is gone
    bool is_plugged() const { return is_plugged_; }

    std::optional<crn_hid_state> poll_report();      // nothing: the device had none
    bool poll_stream();                              // one packet into the buffer; false: the device had none
    bool send(std::span<const std::uint8_t> packet); // false: the device took nothing, try again
    std::size_t read(std::span<std::uint8_t> bytes); // of the buffer
    bool has_bytes() const { return begin_ < incoming_.size(); }

    static constexpr std::size_t packet_bytes = 512, mailbox_bytes = 0x10000;

  private:
    std::function<bool()> poll_;
    std::function<void()> begin_wait_;
    std::unique_ptr<BusHostState> state_;
    bool is_plugged_ = false;
    std::vector<std::uint8_t> incoming_;
    std::size_t begin_ = 0;
};

} // namespace hours
