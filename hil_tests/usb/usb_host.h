/* Simulates a USB host controller, which is the host's end of the token mailbox. The controller sends tokens,
 * keeps data toggles, repeats lost packets, and gives up in time. Tests, fuzz targets and bridges use this
 * controller; the device may run in the same process or in another process.
 *
 * The caller provides the function `wait`, which lets time pass. The controller calls `wait` between two
 * reads of the mailbox, and between two attempts to send a packet if the device has answered NAK. If the
 * device is in this process, `wait` runs the device; if the device is in another process, `wait` sleeps.
 * After the deadline that `begin_wait` set, `wait` returns false. The deadline that `begin_wait` set limits
 * how long a device may take to answer one token. NAKs are counted. */
#ifndef CRN_USB_HOST_H
#define CRN_USB_HOST_H

#include <stddef.h>

#include "shared/mailbox/mailbox.h"

typedef enum usb_result {
    USB_OK = 0,
    USB_STALLED, /* the endpoint or request is refused */
    USB_NAKED,   /* the device had nothing, or no room, until the deadline */
    USB_SILENT,  /* three tries without an answer: address, endpoint or device does not exist */
    USB_DEAD,    /* nothing serves the mailbox itself: the device's program hangs */
    USB_BROKEN,  /* the device broke a rule: a packet longer than fits, or a reply that does not belong to the
                    token */
} usb_result;

typedef struct usb_host {
    crn_mailbox *mailbox;
    bool (*wait)(void *context);
    void (*begin_wait)(void *context);
    void *context;
    uint8_t address;
    uint32_t boot_count;   /* count of the device at the last reset of the bus */
    uint16_t packet_bytes; /* of endpoint 0 */
    uint32_t naks_max;     /* NAKs of a packet until the host gives up; 1: a single try */
    bool toggle_in[16], toggle_out[16];
    uint32_t lose_in, lose_out; /* one of this many packets loses its acknowledgement; 0: none */
    uint32_t count_in, count_out;
    uint32_t naks, repeats; /* seen so far */
} usb_host;

typedef struct usb_request {
    uint8_t type, request;
    uint16_t value, index, length;
} usb_request;

const char *usb_result_name(usb_result result);

/* Returns true if a device is connected and has switched on its pull-up resistor. */
bool usb_host_sees_device(const usb_host *host);

/* Changes the state of the bus; a reset clears the address and the toggles. */
usb_result usb_host_bus(usb_host *host, crn_mailbox_bus state);

/* Sends one token unchanged, and stores at most `capacity` bytes of the device's reply in `in`. Returns
 * USB_OK, USB_DEAD or USB_BROKEN. */
usb_result usb_host_token(usb_host *host, crn_mailbox_token kind, uint8_t endpoint, uint32_t flags,
                          const uint8_t *out, uint32_t out_bytes, crn_mailbox_reply *reply, uint8_t *in,
                          uint32_t capacity, uint32_t *in_bytes);

/* Runs a whole control transfer. `bytes` has space for request->length bytes; `*count` receives the number of
 * bytes that the device sent (IN). */
usb_result usb_host_control(usb_host *host, const usb_request *request, uint8_t *bytes, uint32_t *count);

/* Transfers one packet. A longer transfer consists of as many packets as needed. */
usb_result usb_host_packet_out(usb_host *host, uint8_t endpoint, const uint8_t *bytes, uint32_t count);
usb_result usb_host_packet_in(usb_host *host, uint8_t endpoint, uint8_t *bytes, uint32_t capacity,
                              uint32_t *count);

/* Reads packets until `capacity` bytes have arrived, or until a short packet ends the transfer. */
usb_result usb_host_in(usb_host *host, uint8_t endpoint, uint16_t packet_bytes, uint8_t *bytes,
                       uint32_t capacity, uint32_t *count);
usb_result usb_host_out(usb_host *host, uint8_t endpoint, uint16_t packet_bytes, const uint8_t *bytes,
                        uint32_t count);

/* Clears the halt and the toggle of an endpoint, both in the device and in the host. */
usb_result usb_host_clear_halt(usb_host *host, uint8_t endpoint_address);

#endif
