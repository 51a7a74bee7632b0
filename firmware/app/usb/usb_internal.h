/* What the files of the stack share. Top to bottom: events -> control transfers -> standard and class requests ->
 * descriptors; events -> reports, stream. May include: usb.h. Called by: this folder only. */
#ifndef SELD_USB_INTERNAL_H
#define SELD_USB_INTERNAL_H

#include "firmware/app/usb/usb.h"

/* bmRequestType and requests (USB 2.0, 9.3 and 9.4; HID 1.11, 7.2) */
enum {
    SELD_USB_TYPE_IN = 0x80,
    SELD_USB_TYPE_KIND = 0x60, /* mask */
    SELD_USB_TYPE_STANDARD = 0x00,
    SELD_USB_TYPE_CLASS = 0x20,
    SELD_USB_TYPE_VENDOR = 0x40,
    SELD_USB_TYPE_RECIPIENT = 0x1f, /* mask */
    SELD_USB_TO_DEVICE = 0,
    SELD_USB_TO_INTERFACE = 1,
    SELD_USB_TO_ENDPOINT = 2,

    SELD_USB_GET_STATUS = 0,
    SELD_USB_CLEAR_FEATURE = 1,
    SELD_USB_SET_FEATURE = 3,
    SELD_USB_SET_ADDRESS = 5,
    SELD_USB_GET_DESCRIPTOR = 6,
    SELD_USB_GET_CONFIGURATION = 8,
    SELD_USB_SET_CONFIGURATION = 9,
    SELD_USB_GET_INTERFACE = 10,
    SELD_USB_SET_INTERFACE = 11,

    SELD_USB_FEATURE_HALT = 0,
    SELD_USB_FEATURE_TEST = 2,
    SELD_USB_TEST_MAX = 4, /* Test_J, Test_K, Test_SE0_NAK, Test_Packet */

    SELD_USB_HID_GET_REPORT = 1,
    SELD_USB_HID_GET_IDLE = 2,
    SELD_USB_HID_SET_REPORT = 9,
    SELD_USB_HID_SET_IDLE = 10,

    SELD_USB_DESCRIPTOR_DEVICE = 1,
    SELD_USB_DESCRIPTOR_CONFIGURATION = 2,
    SELD_USB_DESCRIPTOR_STRING = 3,
    SELD_USB_DESCRIPTOR_INTERFACE = 4,
    SELD_USB_DESCRIPTOR_ENDPOINT = 5,
    SELD_USB_DESCRIPTOR_QUALIFIER = 6,
    SELD_USB_DESCRIPTOR_OTHER_SPEED = 7,
    SELD_USB_DESCRIPTOR_BOS = 15,
    SELD_USB_DESCRIPTOR_HID = 0x21,
    SELD_USB_DESCRIPTOR_REPORT = 0x22,
};

/* Interfaces in the order of usb_table.def. */
typedef enum seld_usb_interface {
#define USB_INTERFACE(NAME, class, text) SELD_USB_INTERFACE_##NAME,
#include "firmware/app/usb/usb_table.def"
    SELD_USB_INTERFACE_COUNT,
} seld_usb_interface;

typedef struct seld_usb_endpoint { /* one row of usb_table.def */
    uint8_t interface, address, type;
    uint16_t packet_bytes[2]; /* by seld_udc_speed */
    uint8_t interval[2];
} seld_usb_endpoint;

/* usb_descriptors.c */
extern const seld_usb_endpoint seld_usb_endpoints[SELD_USB_PIPE_COUNT];
extern const uint8_t seld_usb_interface_classes[SELD_USB_INTERFACE_COUNT];
/* The descriptor that `setup` asks for, whole. False: there is none. */
bool seld_usb_descriptor(const seld_usb *usb, const seld_usb_setup *setup, seld_wire_writer *reply);
bool seld_usb_ms_os_set(seld_wire_writer *reply);

/* usb_control.c: stages of control transfers */
typedef enum seld_usb_after { /* when the status stage is over */
                              SELD_USB_AFTER_NOTHING = 0,
                              SELD_USB_AFTER_ADDRESS,
                              SELD_USB_AFTER_UNPLUG,
                              SELD_USB_AFTER_TEST,
} seld_usb_after;
void seld_usb_control_reset(seld_usb *usb);
void seld_usb_control_setup(seld_usb *usb, const uint8_t bytes[SELD_UDC_SETUP_BYTES]);
void seld_usb_control_done(seld_usb *usb, uint8_t endpoint, uint32_t bytes);

/* usb_standard.c, usb_hid.c: false is answered with STALL. `reply` is empty and takes the data of IN requests. */
bool seld_usb_standard(seld_usb *usb, const seld_usb_setup *setup, seld_wire_writer *reply);
bool seld_usb_hid_request(seld_usb *usb, const seld_usb_setup *setup, seld_wire_writer *reply);
bool seld_usb_hid_takes(const seld_usb *usb, const seld_usb_setup *setup);
bool seld_usb_hid_data(seld_usb *usb, const seld_usb_setup *setup, const uint8_t *bytes, size_t count);

/* usb_hid.c: the interrupt pair */
void seld_usb_hid_begin(seld_usb *usb);
void seld_usb_hid_queue(seld_usb *usb, const seld_hid_state *state);
void seld_usb_hid_send(seld_usb *usb);
void seld_usb_hid_received(seld_usb *usb, uint32_t bytes);

/* usb_stream.c: the bulk pair */
void seld_usb_stream_begin(seld_usb *usb, bool to_host);
void seld_usb_stream_send(seld_usb *usb);
void seld_usb_stream_sent(seld_usb *usb, uint32_t bytes);
void seld_usb_stream_received(seld_usb *usb, uint32_t bytes);
bool seld_usb_stream_deliver(seld_usb *usb); /* one frame, or less; true: there is more */

/* usb.c */
void seld_usb_configure(seld_usb *usb, uint8_t configuration);
void seld_usb_pipe_open(seld_usb *usb, seld_usb_pipe pipe); /* afresh: DATA0, not halted, nothing armed */
void seld_usb_pipe_halt(seld_usb *usb, seld_usb_pipe pipe);
void seld_usb_pipe_arm(seld_usb *usb, seld_usb_pipe pipe, uint8_t *bytes, uint32_t count);
bool seld_usb_pipe_is_free(const seld_usb *usb, seld_usb_pipe pipe); /* open, not halted, nothing armed */
void seld_usb_tell_link(seld_usb *usb);
void seld_usb_leave(seld_usb *usb); /* off the bus for off_value_ms */

#endif
