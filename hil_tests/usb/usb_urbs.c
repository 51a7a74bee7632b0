/* Transfers that wait. */
#include "hil_tests/usb/usb_urbs.h"

#include <string.h>

static usb_urb *urb_at(usb_urbs *urbs, unsigned pipe, uint32_t index)
{
    return &urbs->urbs[pipe][(urbs->first[pipe] + index) % USB_URBS_PER_ENDPOINT];
}

bool usb_urbs_submit(usb_urbs *urbs, const usb_urb *urb)
{
    const unsigned pipe = usb_urbs_pipe(urb->endpoint);
    if (urbs->packet_bytes[pipe] == 0 || urbs->count[pipe] == USB_URBS_PER_ENDPOINT) return false;
    *urb_at(urbs, pipe, urbs->count[pipe]++) = *urb;
    return true;
}

static void remove_at(usb_urbs *urbs, unsigned pipe, uint32_t index)
{
    for (uint32_t i = index; i + 1 < urbs->count[pipe]; i++)
        *urb_at(urbs, pipe, i) = *urb_at(urbs, pipe, i + 1);
    urbs->count[pipe]--;
}

bool usb_urbs_cancel(usb_urbs *urbs, uint64_t id, usb_urb *urb)
{
    for (unsigned pipe = 0; pipe < USB_URBS_PIPES; pipe++) {
        for (uint32_t i = 0; i < urbs->count[pipe]; i++) {
            if (urb_at(urbs, pipe, i)->id != id) continue;
            *urb = *urb_at(urbs, pipe, i);
            remove_at(urbs, pipe, i);
            return true;
        }
    }
    return false;
}

bool usb_urbs_cancel_any(usb_urbs *urbs, usb_urb *urb)
{
    for (unsigned pipe = 0; pipe < USB_URBS_PIPES; pipe++)
        if (urbs->count[pipe] > 0) return usb_urbs_cancel(urbs, urb_at(urbs, pipe, 0)->id, urb);
    return false;
}

/* Advances the transfer by one packet, and returns true if the whole transfer is over. */
static bool step_out(usb_urbs *urbs, usb_urb *urb, uint16_t packet_bytes, bool *moved)
{
    uint32_t packet = urb->length - urb->done;
    if (packet > packet_bytes) packet = packet_bytes;
    urb->result = usb_host_packet_out(urbs->host, urb->endpoint & 0x0f, urb->bytes + urb->done, packet);
    if (urb->result == USB_NAKED) return false;
    *moved = true;
    if (urb->result != USB_OK) return true;
    urb->done += packet;
    if (urb->done < urb->length) return false;
    if (packet < packet_bytes || !urb->ends_empty) return true;
    urb->ends_empty = false; /* once more, empty */
    return false;
}

static bool step_in(usb_urbs *urbs, usb_urb *urb, uint16_t packet_bytes, bool *moved)
{
    uint8_t packet[CRN_MAILBOX_DATA_MAX];
    uint32_t count = 0;
    urb->result = usb_host_packet_in(urbs->host, urb->endpoint & 0x0f, packet, packet_bytes, &count);
    if (urb->result == USB_NAKED) return false;
    *moved = true;
    if (urb->result != USB_OK) return true;
    if (count > urb->length - urb->done) { /* more than was requested */
        urb->result = USB_BROKEN;
        return true;
    }
    if (count > 0) memcpy(urb->bytes + urb->done, packet, count);
    urb->done += count;
    return count < packet_bytes || urb->done == urb->length;
}

bool usb_urbs_step(usb_urbs *urbs)
{
    bool moved = false;
    const uint32_t naks_max = urbs->host->naks_max;
    for (unsigned pipe = 0; pipe < USB_URBS_PIPES; pipe++) {
        if (urbs->count[pipe] == 0) continue;
        usb_urb *urb = urb_at(urbs, pipe, 0);
        urbs->host->naks_max = 1;
        const bool is_over = pipe >= 16 ? step_in(urbs, urb, urbs->packet_bytes[pipe], &moved)
                                        : step_out(urbs, urb, urbs->packet_bytes[pipe], &moved);
        urbs->host->naks_max = naks_max;
        if (!is_over) continue;
        const usb_urb done = *urb;
        remove_at(urbs, pipe, 0);
        urbs->complete(urbs->context, &done);
    }
    return moved;
}
