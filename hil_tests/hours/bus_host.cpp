#include "hil_tests/hours/bus_host.hpp"
#include <algorithm>
#include <stdexcept>
#include <string>

#define _Static_assert static_assert // for the C headers below
extern "C" {
#include "hil_tests/usb/usb_host.h"
}
#undef _Static_assert

namespace hours
{

namespace
{

constexpr std::uint8_t status = 1, stream = 2, address = 5; // endpoints of usb_table.def
constexpr std::uint32_t naks_of_control = 1000, naks_of_poll = 1;
constexpr std::size_t kept_bytes = 1 << 20;

void expect(usb_result result, const char *what)
{
    if (result != USB_OK) throw std::runtime_error(std::string(what) + ": " + usb_result_name(result));
}

} // namespace

static_assert(BusHost::mailbox_bytes == CRN_MAILBOX_BYTES);

struct BusHostState {
    usb_host host{};
};

BusHost::BusHost(void *mailbox, std::function<bool()> poll, std::function<void()> begin)
    : poll_(std::move(poll)), begin_wait_(std::move(begin)), state_(std::make_unique<BusHostState>())
{
    usb_host &host = state_->host;
    host.mailbox = static_cast<crn_mailbox *>(mailbox);
    host.context = this;
    host.wait = [](void *context) { return static_cast<BusHost *>(context)->poll_(); };
    host.begin_wait = [](void *context) { static_cast<BusHost *>(context)->begin_wait_(); };
    host.packet_bytes = 64;
    host.naks_max = naks_of_poll;
    incoming_.reserve(kept_bytes);
}

BusHost::~BusHost() = default;

void BusHost::plug()
{
    usb_host &host = state_->host;
    const usb_request set_address = {0, 5, address, 0, 0}, configure = {0, 9, 1, 0, 0};
    std::uint32_t count = 0;
    host.naks_max = naks_of_control;
    expect(usb_host_bus(&host, CRN_MAILBOX_RESET_HIGH), "reset of the bus");
    expect(usb_host_control(&host, &set_address, nullptr, &count), "SET_ADDRESS");
    host.address = address;
    expect(usb_host_control(&host, &configure, nullptr, &count), "SET_CONFIGURATION");
    host.naks_max = naks_of_poll;
    incoming_.clear();
    begin_ = 0;
    is_plugged_ = true;
}

void BusHost::unplug()
{
    expect(usb_host_bus(&state_->host, CRN_MAILBOX_UNPLUGGED), "unplugging");
    incoming_.clear();
    begin_ = 0;
    is_plugged_ = false;
}

std::optional<crn_hid_state> BusHost::poll_report()
{
    std::uint8_t report[64];
    std::uint32_t count = 0;
    const usb_result result = usb_host_packet_in(&state_->host, status, report, sizeof report, &count);
    if (result == USB_NAKED) return std::nullopt;
    expect(result, "a state report");
    crn_hid_state state{};
    if (report[0] != CRN_HID_ID_state || !crn_hid_decode_state(report + 1, count - 1, &state))
        throw std::runtime_error("a state report does not have its form");
    return state;
}

bool BusHost::poll_stream()
{
    std::uint8_t packet[packet_bytes];
    std::uint32_t count = 0;
    const usb_result result = usb_host_packet_in(&state_->host, stream, packet, sizeof packet, &count);
    if (result == USB_NAKED) return false;
    expect(result, "the stream to the host");
    if (incoming_.size() + count > kept_bytes) throw std::runtime_error("the host's program reads nothing");
    incoming_.insert(incoming_.end(), packet, packet + count);
    return true;
}

bool BusHost::send(std::span<const std::uint8_t> packet)
{
    const usb_result result =
        usb_host_packet_out(&state_->host, stream, packet.data(), static_cast<std::uint32_t>(packet.size()));
    if (result == USB_NAKED) return false;
    expect(result, "the stream to the device");
    return true;
}

std::size_t BusHost::read(std::span<std::uint8_t> bytes)
{
    const std::size_t count = std::min(bytes.size(), incoming_.size() - begin_);
    std::copy_n(incoming_.begin() + static_cast<std::ptrdiff_t>(begin_), count, bytes.begin());
    begin_ += count;
    if (begin_ == incoming_.size()) {
        incoming_.clear();
        begin_ = 0;
    }
    return count;
}

} // namespace hours
