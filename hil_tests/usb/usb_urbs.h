/* Keeps queues of USB transfers, one queue for each endpoint, as the driver of a host controller does. Every
 * step tries to send or receive one packet of the first transfer in each endpoint's queue. No step waits for
 * a device that has no data, so a slow endpoint does not delay the others. */
#ifndef CRN_USB_URBS_H
#define CRN_USB_URBS_H

#include "hil_tests/usb/usb_host.h"

enum {
    USB_URBS_PER_ENDPOINT = 64,
    USB_URBS_PIPES = 32, /* 0 .. 15 OUT, 16 .. 31 IN */
    USB_URB_BYTES_MAX = 1 << 20,
};

typedef struct usb_urb {
    uint64_t id; /* the submitter's */
    uint8_t endpoint;
    uint8_t *bytes; /* owned by the submitter until the transfer is done */
    uint32_t length, done;
    bool ends_empty; /* OUT: an empty packet behind a full last one */
    usb_result result;
} usb_urb;

typedef struct usb_urbs {
    usb_host *host;
    void (*complete)(void *context, const usb_urb *urb); /* may submit */
    void *context;
    uint16_t packet_bytes[USB_URBS_PIPES]; /* 0: no such endpoint */
    uint32_t first[USB_URBS_PIPES], count[USB_URBS_PIPES];
    usb_urb urbs[USB_URBS_PIPES][USB_URBS_PER_ENDPOINT];
} usb_urbs;

static inline unsigned usb_urbs_pipe(uint8_t endpoint)
{
    return (endpoint & 0x0fu) | (endpoint & 0x80 ? 0x10u : 0);
}

/* Adds a transfer to its endpoint's queue; returns false if there is no such endpoint, or if the queue is
 * full. */
bool usb_urbs_submit(usb_urbs *urbs, const usb_urb *urb);

/* Removes a transfer from its queue. After the removal, the submitter owns the transfer's buffer again, and
 * the function `complete` is not called. Returns false if the queue does not contain this transfer. */
bool usb_urbs_cancel(usb_urbs *urbs, uint64_t id, usb_urb *urb);

/* Removes the first transfer from an endpoint's queue, if the queue is not empty. */
bool usb_urbs_cancel_any(usb_urbs *urbs, usb_urb *urb);

/* Tries one packet per endpoint. Returns true when something moved. If nothing serves the mailbox, the
 * transfer ends with the result USB_DEAD. */
bool usb_urbs_step(usb_urbs *urbs);

#endif
