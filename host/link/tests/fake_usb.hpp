// Simulates a machine with USB rigs, without hardware: it provides the functions of libusb that host/link
// calls, for simulated devices in this process.
//
// Each simulated rig is the sim port, which contains the real firmware, behind a pair of bulk endpoints.
// Tests can unplug cables, remove permissions and make devices send false replies. As with the real library,
// transfers finish inside libusb_handle_events, on whichever thread calls this function. Tests link this
// simulated library instead of libusb.
#pragma once
#include "firmware/port/sim/sim.h"
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace fake_usb
{

struct Rig {
    std::string serial;
    crn_sim *sim = nullptr;
    bool is_plugged = true;
    int open_error = 0, claim_error = 0;
    bool has_stream = true; // its descriptors name the bulk pair
    bool takes_bytes = true, gives_bytes = true;
    int read_status = 0; // libusb_transfer_status of the next read that has bytes; applies once
    std::uint64_t unplug_after_bytes = 0; // of OUT data; 0: never
    std::uint64_t out_bytes = 0;
    std::uint32_t in_bytes_max = 512; // largest size of a read: a short packet ends a transfer
    std::size_t flood_bytes = 0;      // sent before the firmware's bytes: byte n is 7 n
    std::size_t flood_given = 0;
    std::function<void(std::vector<std::uint8_t> &)> spoil; // changes the bytes before the host reads them
    // Two functions can replace the firmware of the simulated rig: `take` receives the host's bytes, and
    // `give` returns a limited number of bytes to the host.
    std::function<void(std::span<const std::uint8_t>)> take;
    std::function<std::size_t(std::span<std::uint8_t>)> give;
    bool answers_control = true; // false: requests for its strings time out
    int opens = 0;               // handles that are open now
    bool is_claimed = false;
};

void reset();                           // removes all rigs; hot plug events are delivered
Rig &add(const std::string &serial);    // powered and plugged in
void unplug(const std::string &serial); // the device continues without a host
void plug(const std::string &serial);
void set_hotplug(bool is_told);
void change(const std::function<void()> &what); // changes a rig's fields while a transport runs
std::size_t transfers(); // number alive; handles, contexts and transfers must be 0 at a test's end
std::size_t contexts();

} // namespace fake_usb
