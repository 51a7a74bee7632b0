/* A USB device controller made of memory: answers the tokens of shared/mailbox as the chip on a board would, with
 * addresses, data toggles, NAK and STALL. For tests in one process and for the image in an emulator.
 *
 * May include: firmware/port/udc.h, shared/mailbox. Called by: firmware/port/<port>, hil_tests, fuzz targets.
 */
#ifndef SELD_MAILBOX_UDC_H
#define SELD_MAILBOX_UDC_H

#include "firmware/port/udc.h"
#include "shared/mailbox/mailbox.h"

enum { SELD_MAILBOX_ENDPOINT_COUNT = 16 };

typedef struct seld_mailbox_endpoint { /* one direction of an endpoint number */
    bool is_open, is_stalled, is_armed;
    bool toggle; /* of the next packet */
    uint16_t packet_bytes;
    uint8_t *bytes;
    uint32_t count, done;
} seld_mailbox_endpoint;

typedef struct seld_mailbox_udc {
    seld_udc udc; /* for the stack */
    seld_mailbox *mailbox;
    uint8_t address;
    bool is_powered; /* a host is at the other end, and has reset the bus since */
    seld_mailbox_endpoint in[SELD_MAILBOX_ENDPOINT_COUNT];
    seld_mailbox_endpoint out[SELD_MAILBOX_ENDPOINT_COUNT];
} seld_mailbox_udc;

/* Power up on `mailbox`, 64 KiB aligned to 4 bytes, all zero before the first start; both must outlive the controller.
 * A start while a host is waiting leaves its token without an answer, as a device that loses power does. */
void seld_mailbox_udc_init(seld_mailbox_udc *controller, seld_mailbox *mailbox, bool can_high_speed);

/* What an idle loop may look at instead of polling: whether the host asks for something, and whether that may bring the device
 * work (it may not when the host only asks for data). */
typedef enum seld_mailbox_demand {
    SELD_MAILBOX_IDLE,
    SELD_MAILBOX_ASKS_DATA,
    SELD_MAILBOX_BRINGS_WORK,
} seld_mailbox_demand;
seld_mailbox_demand seld_mailbox_udc_demand(const seld_mailbox_udc *controller);

#endif
