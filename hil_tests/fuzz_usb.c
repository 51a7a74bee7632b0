/* This fuzz target connects the device to a host and a USB bus that behave arbitrarily. The input is a list
 * of operations on the token mailbox, so that the fuzzer reaches every state:
 *
 *   op u8 modulo 12:
 *    0 a setup packet as it is: 8 bytes            6 a millisecond passes, times u8 modulo 64
 *    1 a control transfer: 8 bytes of setup, then  7 the app transmits: length u8 x 32
 *      as much data as it announces, at most 64    8 reset, address 5, configuration 1: bit 0 of u8 is the speed
 *    2 OUT token: endpoint u8, flags u8, length    9 power-up again: bit 0 of u8 is high speed
 *      u8 x 4, one byte that fills it             10 raw words into the host's half: place u8, word u32
 *    3 IN token: endpoint u8, flags u8            11 a standard request of one byte each: request, value high and
 *    4 a change of the bus: u8 modulo 6              low, index, to whom
 *    5 the device polls, times u8 modulo 32
 *
 * After every operation, the internal data of the device's USB stack must be consistent. At the end of each
 * input, a host must be able to enumerate the device again and use it. The fuzz target reads at most 128
 * operations from an input, so that one input does not take too long. */
#include <stdlib.h>
#include <string.h>

#include "hil_tests/usb/usb_rig.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count);
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

enum { OPERATIONS_MAX = 128 };

typedef struct input {
    const uint8_t *bytes;
    size_t left;
} input;

static uint8_t take(input *in)
{
    if (in->left == 0) return 0;
    in->left--;
    return *in->bytes++;
}

static usb_rig rig;
static uint8_t data[1024];

static void require(bool condition)
{
    if (!condition) abort();
}

static void token(crn_mailbox_token kind, uint8_t endpoint, uint32_t flags, uint32_t count)
{
    crn_mailbox_reply reply;
    uint32_t in_bytes;
    uint8_t in[CRN_MAILBOX_DATA_MAX];
    usb_result result =
        usb_host_token(&rig.host, kind, endpoint, flags, data, count, &reply, in, sizeof in, &in_bytes);
    require(result == USB_OK); /* served within the polls of a host's patience, and by the rules */
}

static void control(input *in)
{
    uint8_t setup[8];
    for (int i = 0; i < 8; i++) setup[i] = take(in);
    setup[7] = 0;
    usb_request request = {setup[0], setup[1], (uint16_t)(setup[2] | setup[3] << 8),
                           (uint16_t)(setup[4] | setup[5] << 8), setup[6]};
    uint32_t count;
    if (!(request.type & 0x80))
        for (int i = 0; i < request.length && i < 64; i++) data[i] = take(in);
    usb_result result = usb_host_control(&rig.host, &request, data, &count);
    require(result != USB_DEAD && result != USB_BROKEN);
    if (result == USB_OK && request.type == 0 && request.request == 5)
        rig.host.address = (uint8_t)request.value;
}

static void standard(input *in)
{
    uint8_t request = take(in), high = take(in), low = take(in), index = take(in), type = take(in);
    uint32_t count;
    const usb_request standard = {type, request, (uint16_t)(high << 8 | low), index, 255};
    const usb_request without = {type, request, (uint16_t)(high << 8 | low), index, 0};
    usb_result result = usb_host_control(&rig.host, type & 0x80 ? &standard : &without, data, &count);
    require(result != USB_DEAD && result != USB_BROKEN);
}

static void raw(input *in)
{
    uint32_t place = take(in) % (sizeof(crn_mailbox_host_half) / 4);
    uint32_t word = 0;
    for (int i = 0; i < 4; i++) word |= (uint32_t)take(in) << (8 * i);
    memcpy((uint8_t *)&rig.mailbox.host + 4 * place, &word, 4);
    usb_rig_settle(&rig);
}

static void operate(input *in)
{
    static const crn_mailbox_bus buses[] = {CRN_MAILBOX_UNPLUGGED,  CRN_MAILBOX_RESET_FULL,
                                            CRN_MAILBOX_RESET_HIGH, CRN_MAILBOX_SUSPENDED,
                                            CRN_MAILBOX_RESUMED,    (crn_mailbox_bus)77};
    const uint8_t op = take(in) % 12;
    uint8_t first = 0, second = 0;
    if (op == 2 || op == 3) first = take(in), second = take(in);
    if (op >= 4 && op <= 9) first = take(in);
    switch (op) {
    case 0:
        for (int i = 0; i < 8; i++) data[i] = take(in);
        token(CRN_MAILBOX_SETUP, 0, 0, 8);
        break;
    case 1:
        control(in);
        break;
    case 2: {
        uint32_t count = 4u * take(in);
        memset(data, take(in), count);
        token(CRN_MAILBOX_OUT, first, second, count);
        break;
    }
    case 3:
        token(CRN_MAILBOX_IN, first, second, 0);
        break;
    case 4:
        require(usb_host_bus(&rig.host, buses[first % 6]) == USB_OK);
        break;
    case 5:
        for (int i = 0; i < first % 32; i++) crn_usb_poll(&rig.usb);
        break;
    case 6:
        for (int i = 0; i < first % 64; i++) usb_rig_tick(&rig);
        break;
    case 7:
        memset(data, first | 1, sizeof data);
        crn_usb_transmit(&rig.usb, data, 4u * first);
        break;
    case 8:
        usb_rig_configure(&rig, first & 1);
        break;
    case 9:
        usb_rig_reboot(&rig, first & 1);
        break;
    case 10:
        raw(in);
        break;
    default:
        standard(in);
        break;
    }
}

static void check_books(void)
{
    const crn_usb *usb = &rig.usb;
    require(usb->queue_count <= usb->config.queue_bytes && usb->queue_begin < usb->config.queue_bytes);
    require(usb->sending <= usb->queue_count);
    require(usb->held_begin <= usb->held_end && usb->held_end <= sizeof usb->stream_out);
    require(usb->configuration <= 1 && usb->address <= 127);
    require((usb->link == CRN_USB_DETACHED) == (usb->configuration == 0));
    require(rig.frames_lost == 0); /* no reply was ever refused: requests are held back instead */
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++)
        require(!(usb->is_armed[pipe] && usb->is_halted[pipe]));
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count)
{
    input in = {bytes, count};
    usb_rig_open(&rig, true);
    rig.host.naks_max = 2;
    for (int i = 0; i < OPERATIONS_MAX && in.left > 0; i++) {
        operate(&in);
        check_books();
    }
    for (int i = 0; i <= CRN_USB_OFF_MAX_ms && !usb_host_sees_device(&rig.host); i++) usb_rig_tick(&rig);
    require(usb_rig_configure(&rig, true) == USB_OK);
    return 0;
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    static const uint8_t seeds[][32] = {
        {8, 1, 11, 6, 2, 0, 0, 0x80, 11, 6, 15, 0, 0, 0x80, 11, 6, 0x22, 0, 0, 0x81},
        {8, 1, 1, 0xc0, 0x20, 0, 0, 7, 0, 178, 0, 1, 0x40, 0x21, 20, 0, 0, 0, 0, 0, 5, 3, 6, 25},
        {8, 0, 6, 1, 3, 1, 0, 3, 1, 2, 3, 1, 0, 2, 2, 0, 128, 1, 2, 2, 1, 3, 0, 5, 9},
        {8, 1, 1, 0x21, 9, 19, 3, 0, 0, 25, 0, 19, 0xe8, 3, 0, 0, 1, 1, 0, 0},
        {8, 1, 1, 0x21, 9, 2, 2, 0, 0, 12, 0, 2, 1, 1, 0, 0, 0, 0, 0},
        {8, 1, 1, 2, 3, 0, 0, 0x82, 0, 0, 0, 7, 200, 5, 8, 1, 2, 1, 0, 0, 0x82, 0, 0, 0, 3, 2, 0},
        {4, 2, 11, 5, 0, 5, 0, 0, 4, 3, 4, 4, 4, 0, 8, 0, 9, 1, 8, 1},
        {8, 1, 7, 255, 7, 255, 7, 255, 3, 2, 0, 3, 2, 1, 3, 2, 2, 2, 2, 0, 128, 0},
    };
    if (capacity < sizeof seeds[0] || index >= sizeof seeds / sizeof seeds[0]) return 0;
    memcpy(bytes, seeds[index], sizeof seeds[0]);
    return sizeof seeds[0];
}
