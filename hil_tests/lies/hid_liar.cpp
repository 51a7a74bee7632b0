#include "hil_tests/lies/hid_liar.hpp"
#include "shared/wire/hid.h"
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <cwchar>
#include <hidapi/hidapi.h>
#include <thread>
#include <utility>
#include <vector>

namespace hil
{

namespace
{

using Report = std::vector<unsigned char>;

struct Mouth {
    Lie lie;
    std::function<void()> struck;
    bool has_struck = false;
    unsigned reads = 0;
    std::uint32_t tick = 0;
};
Mouth mouth;

void strike()
{
    if (!mouth.has_struck && mouth.struck) mouth.struck();
    mouth.has_struck = true;
}

bool tells(const char *lie)
{
    if (!mouth.lie.is(lie)) return false;
    strike();
    return true;
}

template <class Message>
Report report_of(std::uint8_t id, std::size_t bytes, const Message &message,
                 bool (*put)(crn_wire_writer *, const Message *))
{
    Report report(1 + bytes, id);
    crn_wire_writer writer = crn_wire_writer_make(report.data() + 1, bytes);
    put(&writer, &message);
    return report;
}

Report state_report()
{
    crn_hid_state state{};
    state.tick = mouth.tick;
    state.state = CRN_WIRE_STATE_READY;
    return report_of(CRN_HID_ID_state, CRN_HID_BYTES_state, state, crn_hid_put_state);
}

int hand_over(const Report &report, unsigned char *bytes, std::size_t capacity)
{
    const std::size_t count = std::min(capacity, report.size());
    std::copy_n(report.begin(), count, bytes);
    return static_cast<int>(count);
}

int read_report(hid_device_ *, unsigned char *bytes, std::size_t capacity, int milliseconds)
{
    const bool lies = ++mouth.reads >= mouth.lie.at;
    const auto pass = [](int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); };
    mouth.tick++;
    if (!lies) return pass(1), hand_over(state_report(), bytes, capacity);
    if (tells("hid.silent")) return pass(milliseconds), 0;
    if (tells("hid.busy_silence")) return 0;
    if (tells("hid.flood_short")) return hand_over(Report(3, CRN_HID_ID_state), bytes, capacity);
    if (tells("hid.flood_other_id")) return hand_over(Report(64, 0xee), bytes, capacity);
    if (tells("hid.flood_long")) return std::memset(bytes, 0xff, capacity), 100000;
    if (tells("hid.gone")) return -1;
    if (tells("hid.slow_ms")) pass(static_cast<int>(mouth.lie.value));
    pass(1);
    if (tells("hid.tick")) mouth.tick = mouth.lie.value;
    Report report = state_report();
    if (tells("hid.values"))
        std::fill(report.begin() + 1, report.end(), static_cast<unsigned char>(mouth.lie.value));
    return hand_over(report, bytes, capacity);
}

int feature(hid_device_ *, unsigned char *bytes, std::size_t capacity)
{
    const crn_hid_identity identity = {3, 0, crn_wire_schema_hash(), crn_hid_report_hash(), 1};
    Report report = report_of(CRN_HID_ID_identity, CRN_HID_BYTES_identity, identity, crn_hid_put_identity);
    if (tells("hid.identity_gone")) return -1;
    if (tells("hid.identity_short")) report.resize(3);
    if (tells("hid.identity_long")) return std::memset(bytes, 0xff, capacity), 100000;
    if (tells("hid.identity_id")) report[0] = 0x77;
    if (tells("hid.identity_hash")) report[20] ^= 1;
    return hand_over(report, bytes, capacity);
}

hid_device_info *enumerate(unsigned short, unsigned short)
{
    auto *one = new hid_device_info{};
    one->path = tells("hid.no_path") ? nullptr : strdup("/dev/hidraw0");
    one->serial_number = tells("hid.names") ? wcsdup(L"\x1b[2J\n\x202e") : wcsdup(L"LIAR-0001");
    return one;
}

void free_enumeration(hid_device_info *list)
{
    std::free(list->path);
    std::free(list->serial_number);
    delete list;
}

} // namespace

crn::HidApi lying_hid(const Lie &lie, std::function<void()> struck)
{
    mouth = {lie, std::move(struck)};
    crn::HidApi api;
    api.name = "fake";
    api.enumerate = enumerate;
    api.free_enumeration = free_enumeration;
    api.open_path = [](const char *) {
        return tells("hid.forbidden") ? nullptr : reinterpret_cast<hid_device_ *>(&mouth);
    };
    api.close = [](hid_device_ *) {};
    api.read_timeout = read_report;
    api.write = [](hid_device_ *, const unsigned char *, std::size_t count) {
        return static_cast<int>(count);
    };
    api.get_feature_report = feature;
    api.send_feature_report = [](hid_device_ *, const unsigned char *, std::size_t count) {
        return static_cast<int>(count);
    };
    api.error = [](hid_device_ *) -> const wchar_t * { return L"no such thing"; };
    return api;
}

} // namespace hil
