// The image's USB side, token by token: it enumerates, takes its configuration, and answers HELLO through the bulk pair.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <unistd.h>

#include "hil_tests/l1/emulator.hpp"
#include "shared/wire/wire_frame.h"

#define _Static_assert static_assert // of the C headers below
extern "C" {
#include "hil_tests/usb/usb_host.h"
#include <cmocka.h>
}
#undef _Static_assert

namespace
{

constexpr std::uint8_t stream = 2; // number of the bulk pair's endpoints
constexpr int looks_max = 200000;  // some 10 s

struct Patience {
    int looks = 0;
};

bool wait_a_little(void *context)
{
    auto *patience = static_cast<Patience *>(context);
    usleep(50);
    return ++patience->looks < looks_max;
}

void begin_wait(void *context)
{
    static_cast<Patience *>(context)->looks = 0;
}

void expect(usb_result result, const char *what)
{
    if (result != USB_OK) fail_msg("%s: %s", what, usb_result_name(result));
}

void the_image_answers_hello_over_usb(void **)
{
    hil::EmulatorOptions options;
    options.icount_shift = 0;
    options.serial = "AN500-0042";
    hil::Emulator emulator(options);
    Patience patience;
    usb_host host{};
    host.mailbox = reinterpret_cast<seld_mailbox *>(emulator.memory());
    host.wait = wait_a_little;
    host.begin_wait = begin_wait;
    host.context = &patience;
    host.packet_bytes = 64;
    host.naks_max = 20000;
    assert_true(usb_host_sees_device(&host));
    expect(usb_host_bus(&host, SELD_MAILBOX_RESET_HIGH), "reset of the bus");
    std::uint8_t descriptor[64];
    std::uint32_t count = 0;
    const usb_request get_device = {0x80, 6, 0x0100, 0, 18}, address = {0, 5, 5, 0, 0},
                      configure = {0, 9, 1, 0, 0}, get_serial = {0x80, 6, 0x0303, 0x0409, 64};
    expect(usb_host_control(&host, &get_device, descriptor, &count), "device descriptor");
    assert_int_equal(count, 18);
    expect(usb_host_control(&host, &address, nullptr, &count), "SET_ADDRESS");
    host.address = 5;
    expect(usb_host_control(&host, &get_serial, descriptor, &count), "serial number");
    assert_int_equal(count, 2 + 2 * options.serial.size());
    for (std::size_t i = 0; i < options.serial.size(); i++)
        assert_int_equal(descriptor[2 + 2 * i], options.serial[i]);
    expect(usb_host_control(&host, &configure, nullptr, &count), "SET_CONFIGURATION");

    const seld_wire_hello hello = {SELD_WIRE_PROTOCOL_MAJOR, SELD_WIRE_PROTOCOL_MINOR,
                                   seld_wire_schema_hash()};
    std::uint8_t payload[64], frame[256];
    seld_wire_writer writer = seld_wire_writer_make(payload, sizeof payload);
    assert_true(seld_wire_put_hello(&writer, &hello));
    const seld_wire_header header = {1, 0, SELD_WIRE_TYPE_hello};
    const std::size_t bytes = seld_wire_frame_encode(&header, payload, writer.length, frame, sizeof frame);
    expect(usb_host_out(&host, stream, 512, frame, static_cast<std::uint32_t>(bytes)), "HELLO");
    static seld_wire_decoder decoder;
    seld_wire_decoder_init(&decoder);
    for (int packets = 0; packets < 8; packets++) {
        std::uint8_t packet[512];
        expect(usb_host_packet_in(&host, stream, packet, sizeof packet, &count), "answer to HELLO");
        for (std::uint32_t i = 0; i < count; i++) {
            if (seld_wire_decoder_push(&decoder, packet[i]) != SELD_WIRE_FRAME) continue;
            assert_int_equal(decoder.header.type, SELD_WIRE_TYPE_hello_reply);
            seld_wire_hello_reply reply;
            assert_true(seld_wire_decode_hello_reply(decoder.payload, decoder.payload_bytes, &reply));
            assert_int_equal(reply.accepted, 1);
            return;
        }
    }
    fail_msg("no answer to HELLO in 8 packets");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(the_image_answers_hello_over_usb)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
