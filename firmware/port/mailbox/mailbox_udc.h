/* This header declares a USB device controller that is simulated in memory. The controller answers the bus
 * tokens of shared/mailbox like the controller chip on a board, with addresses, data toggles, NAK and STALL.
 * Tests use it within one process, and the firmware image uses it in an emulator. */
#ifndef CRN_MAILBOX_UDC_H
#define CRN_MAILBOX_UDC_H

#include "firmware/port/udc.h"
#include "shared/mailbox/mailbox.h"

enum { CRN_MAILBOX_ENDPOINT_COUNT = 16 };

typedef struct crn_mailbox_endpoint { /* one direction of an endpoint number */
    bool is_open, is_stalled, is_armed;
    bool toggle; /* toggle of the next packet */
    uint16_t packet_bytes;
    uint8_t *bytes;
    uint32_t count, done;
} crn_mailbox_endpoint;

typedef struct crn_mailbox_udc {
    crn_udc udc; /* for the stack */
    crn_mailbox *mailbox;
    uint8_t address;
    bool is_powered; /* a host is connected, and has reset the bus since */
    crn_mailbox_endpoint in[CRN_MAILBOX_ENDPOINT_COUNT];
    crn_mailbox_endpoint out[CRN_MAILBOX_ENDPOINT_COUNT];
} crn_mailbox_udc;

/* Powers up the simulated controller on `mailbox`, a memory area of 64 KiB that is aligned to 4 bytes and all
 * zero before the first start. The memory of `mailbox` and `controller` must exist as long as the controller
 * is used. If the controller starts while a host is waiting for the answer to a token, the controller does
 * not answer this token, like a device that loses power. */
void crn_mailbox_udc_init(crn_mailbox_udc *controller, crn_mailbox *mailbox, bool can_high_speed);

/* Lists the results of crn_mailbox_udc_demand(), which an idle loop can call instead of polling the
 * controller. The function crn_mailbox_udc_demand() tells whether the host has no request, only requests
 * data, or has a request that may cause work in the device. A host that only requests data causes no work in
 * the device. */
typedef enum crn_mailbox_demand {
    CRN_MAILBOX_IDLE,
    CRN_MAILBOX_ASKS_DATA,
    CRN_MAILBOX_BRINGS_WORK,
} crn_mailbox_demand;
crn_mailbox_demand crn_mailbox_udc_demand(const crn_mailbox_udc *controller);

#endif
