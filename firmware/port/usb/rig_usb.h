/* This header connects the app (crn_app) with the USB device stack for a port that has a USB controller.
 *
 *   at power-up     fill crn_port with crn_rig_usb_transmit and crn_rig_usb_room and this as context of those two,
 *                   crn_app_init, crn_rig_usb_init, crn_rig_usb_connect
 *   always          crn_rig_usb_poll        from the main loop: bytes, commands and settings of the host
 *   1 ms passed     crn_app_timer, then crn_rig_usb_timer
 *
 * The stream carries the wire. By HID, a host can read the state, send STOP and RESET, and read and write
 * calibration and force limits, as by the messages `command` and `rig` of the wire protocol. The app applies
 * the same checks to HID reports as to the wire protocol, so a HID report cannot do anything that the wire
 * protocol would refuse. The app answers a HID report by a message in the byte stream, whose field `answers`
 * is 0. */
#ifndef CRN_RIG_USB_H
#define CRN_RIG_USB_H

#include "firmware/app/app.h"
#include "firmware/app/usb/usb.h"

enum {
    /* The app's longest answer is the one to a request for a snapshot: the snapshot's chunks with their
     * headers and COBS bytes, and the messages begin, end and status. */
    CRN_RIG_USB_REPLY_BYTES = CRN_APP_SNAPSHOT_BYTES + CRN_APP_SNAPSHOT_BYTES / 50 + CRN_WIRE_FRAME_MAX,
    CRN_RIG_USB_QUEUE_BYTES = 2 * CRN_RIG_USB_REPLY_BYTES,
};

typedef struct crn_rig_usb {
    crn_app *app;
    crn_usb usb;
    crn_usb_app callbacks;
    uint32_t works; /* how often bytes, commands or settings of the host reached the app; wraps */
    uint8_t command_number, command_result;
    uint8_t queue[CRN_RIG_USB_QUEUE_BYTES];
} crn_rig_usb;

/* `app` and `udc` must exist as long as `rig` is used. The device's serial number is that of the app's port.
 * Returns false if the serial number is empty or not printable. */
bool crn_rig_usb_init(crn_rig_usb *rig, crn_app *app, const crn_udc *udc);
void crn_rig_usb_connect(crn_rig_usb *rig, bool connected);

/* Returns true if a host has configured the device. While a host has configured the device, the device keeps
 * the app's messages for this host, even while the bus sleeps. */
bool crn_rig_usb_is_configured(const crn_rig_usb *rig);

/* Returns true if the USB stack may have more work to do. */
bool crn_rig_usb_poll(crn_rig_usb *rig);
void crn_rig_usb_timer(crn_rig_usb *rig);

/* A port enters the following functions in its crn_port, with the crn_rig_usb as `context`. */
bool crn_rig_usb_transmit(void *context, const uint8_t *frame, size_t frame_bytes);
size_t crn_rig_usb_room(void *context);

#endif
