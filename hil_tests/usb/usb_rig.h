/* Simulates a rig that consists only of its USB side, in this process. The rig has the USB stack, a
 * controller in memory, and an application that sends back every frame it receives and records the
 * requests. */
#ifndef CRN_USB_RIG_H
#define CRN_USB_RIG_H

#include "firmware/app/usb/usb.h"
#include "firmware/port/mailbox/mailbox_udc.h"
#include "hil_tests/usb/usb_host.h"

enum {
    USB_RIG_QUEUE_BYTES = 3 * CRN_WIRE_FRAME_MAX,
    USB_RIG_WAITS_MAX = 100, /* polls of the device before the host regards it as dead */
    USB_RIG_NAKS_MAX = 500,
};

typedef struct usb_rig {
    crn_mailbox mailbox;
    crn_mailbox_udc controller;
    crn_usb usb;
    crn_usb_app app;
    uint8_t queue[USB_RIG_QUEUE_BYTES];
    usb_host host;

    /* the app */
    bool is_deaf; /* it takes bytes and sends nothing back */
    uint8_t frame[CRN_WIRE_FRAME_MAX];
    uint32_t frame_bytes;
    uint32_t frames_back, frames_lost, bytes_in;
    crn_usb_link link;
    uint32_t link_changes;
    crn_hid_command command; /* the last one */
    uint32_t commands;
    crn_hid_calibration calibration;
    crn_hid_limits limits;

    uint32_t waits; /* polls left until the host gives up */
} usb_rig;

/* Powers up the rig on the bus; a host is connected but has not reset the bus yet. */
void usb_rig_open(usb_rig *rig, bool can_high_speed);

/* Powers up the device again as after a drop of the supply voltage; the host's half of the mailbox stays
 * unchanged. */
void usb_rig_reboot(usb_rig *rig, bool can_high_speed);

/* Lets the device run for one millisecond, which makes the next state report. */
void usb_rig_tick(usb_rig *rig);

/* Lets the device do all work that is possible without a further action of the host. */
void usb_rig_settle(usb_rig *rig);

/* Reset, address 5, configuration 1. */
usb_result usb_rig_configure(usb_rig *rig, bool high_speed);

/* Carries out a control transfer by one call. */
usb_result usb_rig_control(usb_rig *rig, uint8_t type, uint8_t request, uint16_t value, uint16_t index,
                           uint16_t length, uint8_t *bytes, uint32_t *count);

#endif
