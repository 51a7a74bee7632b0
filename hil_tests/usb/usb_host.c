/* Implements a USB host controller, which communicates through the token mailbox. */
#include "hil_tests/usb/usb_host.h"

#include <string.h>

enum { TRIES = 3, SETUP_BYTES = 8 };

const char *usb_result_name(usb_result result)
{
    static const char *const names[] = {"ok",        "stalled",      "only NAK",
                                        "no answer", "mailbox dead", "rule broken"};
    return names[result];
}

static bool waits(usb_host *host)
{
    return host->wait(host->context);
}

bool usb_host_sees_device(const usb_host *host)
{
    const crn_mailbox_device_half *device = &host->mailbox->device;
    return crn_mailbox_read(&device->magic) == CRN_MAILBOX_MAGIC &&
           crn_mailbox_read(&device->version) == CRN_MAILBOX_VERSION &&
           crn_mailbox_read(&device->attached) == 1;
}

usb_result usb_host_bus(usb_host *host, crn_mailbox_bus state)
{
    crn_mailbox *mailbox = host->mailbox;
    const uint32_t number = crn_mailbox_read(&mailbox->host.bus) + 1;
    if (state != CRN_MAILBOX_SUSPENDED && state != CRN_MAILBOX_RESUMED) {
        host->address = 0;
        host->packet_bytes = 64;
        host->boot_count = crn_mailbox_read(&mailbox->device.boot_count);
        memset(host->toggle_in, 0, sizeof host->toggle_in);
        memset(host->toggle_out, 0, sizeof host->toggle_out);
    }
    crn_mailbox_write(&mailbox->host.bus_state, state);
    crn_mailbox_write(&mailbox->host.bus, number);
    host->begin_wait(host->context);
    while (crn_mailbox_read(&mailbox->device.bus_done) != number)
        if (!waits(host)) return USB_DEAD;
    return USB_OK;
}

usb_result usb_host_token(usb_host *host, crn_mailbox_token kind, uint8_t endpoint, uint32_t flags,
                          const uint8_t *out, uint32_t out_bytes, crn_mailbox_reply *reply, uint8_t *in,
                          uint32_t capacity, uint32_t *in_bytes)
{
    crn_mailbox *mailbox = host->mailbox;
    const uint32_t number = crn_mailbox_read(&mailbox->host.token) + 1;
    if (out_bytes <= CRN_MAILBOX_DATA_MAX && out_bytes > 0) memcpy(mailbox->host_data, out, out_bytes);
    crn_mailbox_write(&mailbox->host.token_kind, kind);
    crn_mailbox_write(&mailbox->host.token_flags, flags);
    crn_mailbox_write(&mailbox->host.token_address, host->address);
    crn_mailbox_write(&mailbox->host.token_endpoint, endpoint);
    crn_mailbox_write(&mailbox->host.token_bytes, out_bytes);
    crn_mailbox_write(&mailbox->host.token, number);
    host->begin_wait(host->context);
    while (crn_mailbox_read(&mailbox->device.token_done) != number)
        if (!waits(host)) return USB_DEAD;
    const uint32_t answer = crn_mailbox_read(&mailbox->device.reply);
    *in_bytes = crn_mailbox_read(&mailbox->device.reply_bytes);
    *reply = (crn_mailbox_reply)answer;
    const bool is_data = answer == CRN_MAILBOX_REPLY_DATA0 || answer == CRN_MAILBOX_REPLY_DATA1;
    if (answer > CRN_MAILBOX_REPLY_DATA1 || (is_data && kind != CRN_MAILBOX_IN)) return USB_BROKEN;
    if (!is_data) *in_bytes = 0;
    if (*in_bytes > capacity || *in_bytes > CRN_MAILBOX_DATA_MAX) return USB_BROKEN;
    if (*in_bytes > 0) memcpy(in, mailbox->device_data, *in_bytes);
    return USB_OK;
}

/* Converts the device's reply to a packet into a result; USB_OK means that the packet succeeded. After
 * USB_NAKED and USB_SILENT the host may send the same packet again. */
static usb_result judge(crn_mailbox_reply reply)
{
    switch (reply) {
    case CRN_MAILBOX_SILENCE:
        return USB_SILENT;
    case CRN_MAILBOX_NAK:
        return USB_NAKED;
    case CRN_MAILBOX_STALL:
        return USB_STALLED;
    default:
        return USB_OK;
    }
}

/* Counts a failed attempt to send a packet; returns false if the host may not try again. */
static bool try_again(usb_host *host, usb_result result, uint32_t *naks, uint32_t *silences)
{
    if (result == USB_NAKED) {
        host->naks++;
        host->begin_wait(host->context);
        return ++*naks < host->naks_max && waits(host);
    }
    return result == USB_SILENT && ++*silences < TRIES;
}

static bool is_lost(uint32_t every, uint32_t *count)
{
    return every != 0 && ++*count % every == 0;
}

static usb_result packet_out(usb_host *host, crn_mailbox_token kind, uint8_t endpoint, const uint8_t *bytes,
                             uint32_t count)
{
    uint32_t naks = 0, silences = 0;
    for (;;) {
        crn_mailbox_reply reply;
        uint32_t none;
        const uint32_t flags = kind == CRN_MAILBOX_OUT && host->toggle_out[endpoint] ? CRN_MAILBOX_DATA1 : 0;
        usb_result result = usb_host_token(host, kind, endpoint, flags, bytes, count, &reply, NULL, 0, &none);
        if (result != USB_OK) return result;
        result = judge(reply);
        if (result == USB_OK && kind == CRN_MAILBOX_OUT && is_lost(host->lose_out, &host->count_out)) {
            host->repeats++; /* the device's ACK did not come: the same packet is sent again */
            continue;
        }
        if (result == USB_OK) {
            host->toggle_out[endpoint] = !host->toggle_out[endpoint];
            return USB_OK;
        }
        if (!try_again(host, result, &naks, &silences)) return result;
    }
}

usb_result usb_host_packet_out(usb_host *host, uint8_t endpoint, const uint8_t *bytes, uint32_t count)
{
    return packet_out(host, CRN_MAILBOX_OUT, endpoint, bytes, count);
}

usb_result usb_host_packet_in(usb_host *host, uint8_t endpoint, uint8_t *bytes, uint32_t capacity,
                              uint32_t *count)
{
    uint32_t naks = 0, silences = 0;
    for (;;) {
        crn_mailbox_reply reply;
        const bool lost = is_lost(host->lose_in, &host->count_in);
        usb_result result = usb_host_token(host, CRN_MAILBOX_IN, endpoint, lost ? CRN_MAILBOX_LOST_ACK : 0,
                                           NULL, 0, &reply, bytes, capacity, count);
        if (result != USB_OK) return result;
        result = judge(reply);
        if (result == USB_OK) {
            if (lost) {
                host->repeats++; /* the host's ACK does not arrive; the device must repeat the packet with the
                                    same toggle */
                continue;
            }
            if ((reply == CRN_MAILBOX_REPLY_DATA1) != host->toggle_in[endpoint]) return USB_BROKEN;
            host->toggle_in[endpoint] = !host->toggle_in[endpoint];
            return USB_OK;
        }
        if (!try_again(host, result, &naks, &silences)) return result;
    }
}

usb_result usb_host_in(usb_host *host, uint8_t endpoint, uint16_t packet_bytes, uint8_t *bytes,
                       uint32_t capacity, uint32_t *count)
{
    *count = 0;
    while (*count < capacity) {
        uint8_t packet[CRN_MAILBOX_DATA_MAX];
        uint32_t packet_count = 0;
        usb_result result = usb_host_packet_in(host, endpoint, packet, packet_bytes, &packet_count);
        if (result != USB_OK) return result;
        if (packet_count > capacity - *count) return USB_BROKEN; /* babble: more than was requested */
        memcpy(bytes + *count, packet, packet_count);
        *count += packet_count;
        if (packet_count < packet_bytes) break;
    }
    return USB_OK;
}

usb_result usb_host_out(usb_host *host, uint8_t endpoint, uint16_t packet_bytes, const uint8_t *bytes,
                        uint32_t count)
{
    uint32_t done = 0;
    do {
        uint32_t packet = count - done < packet_bytes ? count - done : packet_bytes;
        usb_result result = usb_host_packet_out(host, endpoint, bytes + done, packet);
        if (result != USB_OK) return result;
        done += packet;
    } while (done < count);
    return USB_OK;
}

usb_result usb_host_control(usb_host *host, const usb_request *request, uint8_t *bytes, uint32_t *count)
{
    const uint8_t setup[SETUP_BYTES] = {
        request->type,
        request->request,
        (uint8_t)request->value,
        (uint8_t)(request->value >> 8),
        (uint8_t)request->index,
        (uint8_t)(request->index >> 8),
        (uint8_t)request->length,
        (uint8_t)(request->length >> 8),
    };
    uint8_t nothing;
    uint32_t none;
    *count = 0;
    usb_result result = packet_out(host, CRN_MAILBOX_SETUP, 0, setup, SETUP_BYTES);
    if (result != USB_OK) return result;
    host->toggle_in[0] = host->toggle_out[0] = true;
    const bool to_host = (request->type & 0x80) != 0 && request->length > 0;
    if (to_host)
        result = usb_host_in(host, 0, host->packet_bytes, bytes, request->length, count);
    else if (request->length > 0)
        result = usb_host_out(host, 0, host->packet_bytes, bytes, request->length);
    if (result != USB_OK) return result;
    host->toggle_in[0] = host->toggle_out[0] = true;
    if (to_host) return usb_host_packet_out(host, 0, NULL, 0);
    return usb_host_packet_in(host, 0, &nothing, 0, &none);
}

usb_result usb_host_clear_halt(usb_host *host, uint8_t endpoint_address)
{
    const usb_request clear = {0x02, 1, 0, endpoint_address, 0};
    uint32_t none;
    usb_result result = usb_host_control(host, &clear, NULL, &none);
    if (result != USB_OK) return result;
    bool *toggles = endpoint_address & 0x80 ? host->toggle_in : host->toggle_out;
    toggles[endpoint_address & 0x0f] = false;
    return USB_OK;
}
