/* The app on USB: joins seld_app and the USB device stack for a port that has a controller.
 *
 *   at power-up     fill seld_port with seld_rig_usb_transmit and seld_rig_usb_room and this as context of those two,
 *                   seld_app_init, seld_rig_usb_init, seld_rig_usb_connect
 *   always          seld_rig_usb_poll        from the main loop: bytes, commands and settings of the host
 *   1 ms passed     seld_app_timer, then seld_rig_usb_timer
 *
 * The stream carries the wire. HID carries the state, STOP and RESET, and reads and writes calibration and limits, as the wire's
 * `command` and `rig` do: the app judges both alike, so nothing can be done by HID that the wire would refuse. Its answer to such
 * a message goes to the stream as one that nobody asked for.
 *
 * May include: firmware/app, firmware/port/port.h, udc.h, shared. Called by: firmware/port/<port>.
 */
#ifndef SELD_RIG_USB_H
#define SELD_RIG_USB_H

#include "firmware/app/app.h"
#include "firmware/app/usb/usb.h"

enum {
    /* The longest answer is a snapshot: chunks with their heads and COBS bytes, begin, end, status. */
    SELD_RIG_USB_REPLY_BYTES = SELD_APP_SNAPSHOT_BYTES + SELD_APP_SNAPSHOT_BYTES / 50 + SELD_WIRE_FRAME_MAX,
    SELD_RIG_USB_QUEUE_BYTES = 2 * SELD_RIG_USB_REPLY_BYTES,
};

typedef struct seld_rig_usb {
    seld_app *app;
    seld_usb usb;
    seld_usb_app callbacks;
    uint32_t works; /* how often bytes, commands or settings of the host came to the app; wraps */
    uint8_t command_number, command_result;
    uint8_t queue[SELD_RIG_USB_QUEUE_BYTES];
} seld_rig_usb;

/* `app` and `udc` must outlive it. The serial number is that of the app's port. False: it is empty or not printable. */
bool seld_rig_usb_init(seld_rig_usb *rig, seld_app *app, const seld_udc *udc);
void seld_rig_usb_connect(seld_rig_usb *rig, bool connected);

/* A host has the device, and what the app says is kept for it, also while the bus sleeps. */
bool seld_rig_usb_is_configured(const seld_rig_usb *rig);

/* True: there may be more to do. */
bool seld_rig_usb_poll(seld_rig_usb *rig);
void seld_rig_usb_timer(seld_rig_usb *rig);

/* For seld_port; `context` is the seld_rig_usb. */
bool seld_rig_usb_transmit(void *context, const uint8_t *frame, size_t frame_bytes);
size_t seld_rig_usb_room(void *context);

#endif
