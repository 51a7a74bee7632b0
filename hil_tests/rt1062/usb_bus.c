#include "hil_tests/rt1062/usb_bus.h"
#include <string.h>

enum { SETTLE_us = 200 }; /* in which the image sees what has changed */

static void set_attached(rt_bus *bus)
{
    uint32_t attached = rt_usb_is_attached(bus->chip);
    if (crn_mailbox_read(&bus->mailbox->device.attached) != attached)
        crn_mailbox_write(&bus->mailbox->device.attached, attached);
}

void rt_bus_start(rt_bus *bus, rt_chip *chip, crn_mailbox *mailbox)
{
    *bus = (rt_bus){.chip = chip, .mailbox = mailbox};
    rt_usb_plug(chip, true);
    crn_mailbox_start_device(mailbox, 1);
}

/* --- changes of the bus --- */
static void begin_change(rt_bus *bus, uint32_t state)
{
    rt_chip *chip = bus->chip;
    bus->change_until = chip->now + SETTLE_us * RT_INSTANTS_PER_us;
    if (state == CRN_MAILBOX_UNPLUGGED) {
        rt_usb_plug(chip, false);
    } else if (state == CRN_MAILBOX_RESET_FULL || state == CRN_MAILBOX_RESET_HIGH) {
        if (chip->usb.bus == RT_BUS_UNPLUGGED) rt_usb_plug(chip, true);
        rt_usb_bus_reset(chip, state == CRN_MAILBOX_RESET_HIGH);
        if (chip->usb.bus == RT_BUS_RESET) bus->change_until += chip->usb.bus_reset_until - chip->now;
    } else {
        rt_usb_suspend(chip, state == CRN_MAILBOX_SUSPENDED);
    }
}

static bool serve_change(rt_bus *bus)
{
    uint32_t number = crn_mailbox_read(&bus->mailbox->host.bus);
    if (number == crn_mailbox_read(&bus->mailbox->device.bus_done)) return false;
    if (bus->change_until == 0) begin_change(bus, crn_mailbox_read(&bus->mailbox->host.bus_state));
    if (bus->chip->now < bus->change_until) return true;
    bus->change_until = 0;
    crn_mailbox_write(&bus->mailbox->device.bus_done, number);
    return true;
}

/* --- tokens --- */
static bool read_token(const crn_mailbox *mailbox, rt_usb_packet *packet)
{
    const crn_mailbox_host_half *host = &mailbox->host;
    uint32_t kind = crn_mailbox_read(&host->token_kind), flags = crn_mailbox_read(&host->token_flags);
    uint32_t endpoint = crn_mailbox_read(&host->token_endpoint), bytes = crn_mailbox_read(&host->token_bytes);
    if (kind < CRN_MAILBOX_SETUP || kind > CRN_MAILBOX_IN || endpoint > 15 || bytes > CRN_MAILBOX_DATA_MAX)
        return false;
    packet->token = kind == CRN_MAILBOX_SETUP ? RT_TOKEN_SETUP
                    : kind == CRN_MAILBOX_OUT ? RT_TOKEN_OUT
                                              : RT_TOKEN_IN;
    packet->address = (uint8_t)crn_mailbox_read(&host->token_address);
    packet->endpoint = (uint8_t)endpoint;
    packet->is_data1 = (flags & CRN_MAILBOX_DATA1) != 0;
    packet->is_ack_lost = (flags & CRN_MAILBOX_LOST_ACK) != 0;
    packet->bytes = kind == CRN_MAILBOX_IN ? 0 : bytes;
    memcpy(packet->data, mailbox->host_data, packet->bytes);
    return true;
}

static crn_mailbox_reply reply_of(rt_usb_reply reply)
{
    static const crn_mailbox_reply replies[] = {
        [RT_USB_SILENCE] = CRN_MAILBOX_SILENCE,   [RT_USB_ACK] = CRN_MAILBOX_ACK,
        [RT_USB_NAK] = CRN_MAILBOX_NAK,           [RT_USB_STALL] = CRN_MAILBOX_STALL,
        [RT_USB_DATA0] = CRN_MAILBOX_REPLY_DATA0, [RT_USB_DATA1] = CRN_MAILBOX_REPLY_DATA1,
    };
    return replies[reply];
}

bool rt_bus_serve(rt_bus *bus)
{
    crn_mailbox *mailbox = bus->mailbox;
    set_attached(bus);
    if (serve_change(bus)) return true;
    uint32_t number = crn_mailbox_read(&mailbox->host.token);
    if (number == crn_mailbox_read(&mailbox->device.token_done)) return false;
    rt_usb_packet packet;
    rt_usb_reply reply = read_token(mailbox, &packet) ? rt_usb_transact(bus->chip, &packet) : RT_USB_SILENCE;
    bool has_data = reply == RT_USB_DATA0 || reply == RT_USB_DATA1;
    if (has_data) memcpy(mailbox->device_data, packet.data, packet.bytes);
    crn_mailbox_write(&mailbox->device.reply, reply_of(reply));
    crn_mailbox_write(&mailbox->device.reply_bytes, has_data ? packet.bytes : 0);
    crn_mailbox_write(&mailbox->device.token_done, number);
    return true;
}
