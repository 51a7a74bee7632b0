// A machine with rigs on USB and without either: the functions of libusb that host/link calls, over devices
// in this process.
//
// Each rig is the sim port (the real firmware) behind a bulk pair; tests pull cables, take rights away and
// let devices lie. Transfers complete in libusb_handle_events, on whichever thread calls it, as with the
// library. Linked instead of libusb.
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
    int read_status = 0;                  // libusb_transfer_status of the next read that has bytes, once
    std::uint64_t unplug_after_bytes = 0; // of OUT data; 0: never
    std::uint64_t out_bytes = 0;
    std::uint32_t in_bytes_max = 512; // a read gives at most so many: a short packet ends a transfer
    std::size_t flood_bytes = 0;      // given before what the firmware says: byte n is 7 n
    std::size_t flood_given = 0;
    std::function<void(std::vector<std::uint8_t> &)> spoil; // what is read, before the host sees it
    // A device that is not the sim alone: bytes that it takes, and up to so many that it gives.
    std::function<void(std::span<const std::uint8_t>)> take;
    std::function<std::size_t(std::span<std::uint8_t>)> give;
    bool answers_control = true; // false: requests for its strings time out
    int opens = 0;               // handles that are open now
    bool is_claimed = false;
};

void reset();                           // no rigs; hot plug is told
Rig &add(const std::string &serial);    // powered up and plugged
void unplug(const std::string &serial); // the device goes on without a host
void plug(const std::string &serial);
void set_hotplug(bool is_told);
void change(const std::function<void()> &what); // a rig's fields, while a transport runs
std::size_t transfers(); // alive; handles, contexts and transfers have to be 0 at a test's end
std::size_t contexts();

} // namespace fake_usb
