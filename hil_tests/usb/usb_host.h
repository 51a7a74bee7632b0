/* The host's end of the token mailbox: a host controller that sends tokens, keeps data toggles, repeats what
 * was lost, and gives up in time. For tests, fuzz targets and bridges; the device may run in this process or
 * in another.
 *
 * Waiting is the caller's: `wait` runs between two looks at the mailbox and between two tries of a packet
 * that was NAKed. In one process it runs the device; towards another process it sleeps. It returns false when
 * the deadline is over that `begin_wait` set: how long a device may take to serve one token. NAKs are
 * counted.
 */
#ifndef CRN_USB_HOST_H
#define CRN_USB_HOST_H

#include <stddef.h>

#include "shared/mailbox/mailbox.h"

typedef enum usb_result {
    USB_OK = 0,
    USB_STALLED, /* the endpoint or request is refused */
    USB_NAKED,   /* the device had nothing, or no room, until the deadline */
    USB_SILENT,  /* three tries without an answer: address, endpoint or device is not there */
    USB_DEAD,    /* the mailbox itself is not served: the device's program hangs */
    USB_BROKEN,  /* the device broke a rule: a longer packet than fits, a reply that does not belong to the
                    token */
} usb_result;

typedef struct usb_host {
    crn_mailbox *mailbox;
    bool (*wait)(void *context);
    void (*begin_wait)(void *context);
    void *context;
    uint8_t address;
    uint32_t boot_count;   /* of the device at the last reset of the bus */
    uint16_t packet_bytes; /* of endpoint 0 */
    uint32_t naks_max;     /* of a packet until it is given up; 1: a single try */
    bool toggle_in[16], toggle_out[16];
    uint32_t lose_in, lose_out; /* every so manyth packet loses its acknowledgement, 0: none */
    uint32_t count_in, count_out;
    uint32_t naks, repeats; /* seen so far */
} usb_host;

typedef struct usb_request {
    uint8_t type, request;
    uint16_t value, index, length;
} usb_request;

const char *usb_result_name(usb_result result);

/* Is a device at the other end, with its pull-up on? */
bool usb_host_sees_device(const usb_host *host);

/* Change the bus; a reset forgets the address and the toggles. */
usb_result usb_host_bus(usb_host *host, crn_mailbox_bus state);

/* One token as it is; the reply's data in `bytes` of at most `capacity`. USB_OK, USB_DEAD or USB_BROKEN. */
usb_result usb_host_token(usb_host *host, crn_mailbox_token kind, uint8_t endpoint, uint32_t flags,
                          const uint8_t *out, uint32_t out_bytes, crn_mailbox_reply *reply, uint8_t *in,
                          uint32_t capacity, uint32_t *in_bytes);

/* A whole control transfer. `bytes` holds request->length; `*count` gets what came of IN data. */
usb_result usb_host_control(usb_host *host, const usb_request *request, uint8_t *bytes, uint32_t *count);

/* One packet. A full transfer is as many of them as it takes. */
usb_result usb_host_packet_out(usb_host *host, uint8_t endpoint, const uint8_t *bytes, uint32_t count);
usb_result usb_host_packet_in(usb_host *host, uint8_t endpoint, uint8_t *bytes, uint32_t capacity,
                              uint32_t *count);

/* Packets until `capacity` bytes are full or a short packet came. */
usb_result usb_host_in(usb_host *host, uint8_t endpoint, uint16_t packet_bytes, uint8_t *bytes,
                       uint32_t capacity, uint32_t *count);
usb_result usb_host_out(usb_host *host, uint8_t endpoint, uint16_t packet_bytes, const uint8_t *bytes,
                        uint32_t count);

/* The halt and the toggle are the device's and the host's: both are cleared. */
usb_result usb_host_clear_halt(usb_host *host, uint8_t endpoint_address);

#endif
