/* This header has the declarations that the files of the USB stack share. The declarations of functions are
 * grouped by the file that defines the functions. */
#ifndef CRN_USB_INTERNAL_H
#define CRN_USB_INTERNAL_H

#include "firmware/app/usb/usb.h"

/* bmRequestType and requests (USB 2.0, 9.3 and 9.4; HID 1.11, 7.2) */
enum {
    CRN_USB_TYPE_IN = 0x80,
    CRN_USB_TYPE_KIND = 0x60, /* mask */
    CRN_USB_TYPE_STANDARD = 0x00,
    CRN_USB_TYPE_CLASS = 0x20,
    CRN_USB_TYPE_VENDOR = 0x40,
    CRN_USB_TYPE_RECIPIENT = 0x1f, /* mask */
    CRN_USB_TO_DEVICE = 0,
    CRN_USB_TO_INTERFACE = 1,
    CRN_USB_TO_ENDPOINT = 2,

    CRN_USB_GET_STATUS = 0,
    CRN_USB_CLEAR_FEATURE = 1,
    CRN_USB_SET_FEATURE = 3,
    CRN_USB_SET_ADDRESS = 5,
    CRN_USB_GET_DESCRIPTOR = 6,
    CRN_USB_GET_CONFIGURATION = 8,
    CRN_USB_SET_CONFIGURATION = 9,
    CRN_USB_GET_INTERFACE = 10,
    CRN_USB_SET_INTERFACE = 11,

    CRN_USB_FEATURE_HALT = 0,
    CRN_USB_FEATURE_TEST = 2,
    CRN_USB_TEST_MAX = 4, /* Test_J, Test_K, Test_SE0_NAK, Test_Packet */

    CRN_USB_HID_GET_REPORT = 1,
    CRN_USB_HID_GET_IDLE = 2,
    CRN_USB_HID_SET_REPORT = 9,
    CRN_USB_HID_SET_IDLE = 10,

    CRN_USB_DESCRIPTOR_DEVICE = 1,
    CRN_USB_DESCRIPTOR_CONFIGURATION = 2,
    CRN_USB_DESCRIPTOR_STRING = 3,
    CRN_USB_DESCRIPTOR_INTERFACE = 4,
    CRN_USB_DESCRIPTOR_ENDPOINT = 5,
    CRN_USB_DESCRIPTOR_QUALIFIER = 6,
    CRN_USB_DESCRIPTOR_OTHER_SPEED = 7,
    CRN_USB_DESCRIPTOR_BOS = 15,
    CRN_USB_DESCRIPTOR_HID = 0x21,
    CRN_USB_DESCRIPTOR_REPORT = 0x22,
};

/* Lists the interfaces in the order of the table. */
typedef enum crn_usb_interface {
#define USB_INTERFACE(NAME, class, text) CRN_USB_INTERFACE_##NAME,
#include CRN_USB_TABLE
    CRN_USB_INTERFACE_COUNT,
} crn_usb_interface;

typedef struct crn_usb_endpoint { /* one row of the table */
    uint8_t interface, address, type;
    uint16_t packet_bytes[2]; /* by crn_udc_speed */
    uint8_t interval[2];
} crn_usb_endpoint;

/* usb_descriptors.c */
extern const crn_usb_endpoint crn_usb_endpoints[CRN_USB_PIPE_COUNT];
extern const uint8_t crn_usb_interface_classes[CRN_USB_INTERFACE_COUNT];
/* Writes the whole USB descriptor that the setup packet `setup` requests. False: there is none. */
bool crn_usb_descriptor(const crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply);
bool crn_usb_ms_os_set(crn_wire_writer *reply);
void crn_usb_put_bytes(crn_wire_writer *reply, const uint8_t *bytes, size_t count);

/* usb_control.c: stages of control transfers */
typedef enum crn_usb_after { /* when the status stage is over */
                             CRN_USB_AFTER_NOTHING = 0,
                             CRN_USB_AFTER_ADDRESS,
                             CRN_USB_AFTER_UNPLUG,
                             CRN_USB_AFTER_TEST,
} crn_usb_after;
void crn_usb_control_reset(crn_usb *usb);
void crn_usb_control_setup(crn_usb *usb, const uint8_t bytes[CRN_UDC_SETUP_BYTES]);
void crn_usb_control_done(crn_usb *usb, uint8_t endpoint, uint32_t bytes);

/* If the function that handles a request in usb_standard.c, usb_vendor.c or usb_hid.c returns false, the
 * device answers with STALL. The struct `reply` is empty at first and receives the data of IN requests. */
bool crn_usb_standard(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply);
bool crn_usb_vendor(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply);
bool crn_usb_hid_request(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply);
bool crn_usb_hid_takes(const crn_usb *usb, const crn_usb_setup *setup);
bool crn_usb_hid_data(crn_usb *usb, const crn_usb_setup *setup, const uint8_t *bytes, size_t count);

/* usb_hid.c: the HID descriptor within a configuration, the descriptors that a host requests from the HID
 * interface (false: there is none), and the interrupt pair */
void crn_usb_hid_put_descriptor(crn_wire_writer *reply);
bool crn_usb_hid_class_descriptor(const crn_usb_setup *setup, crn_wire_writer *reply);
void crn_usb_hid_begin(crn_usb *usb);
void crn_usb_hid_queue(crn_usb *usb, const crn_hid_state *state);
void crn_usb_hid_send(crn_usb *usb);
void crn_usb_hid_received(crn_usb *usb, uint32_t bytes);

/* usb_stream.c: the bulk pair */
void crn_usb_stream_begin(crn_usb *usb, bool to_host);
void crn_usb_stream_send(crn_usb *usb);
void crn_usb_stream_sent(crn_usb *usb, uint32_t bytes);
void crn_usb_stream_received(crn_usb *usb, uint32_t bytes);
bool crn_usb_stream_deliver(crn_usb *usb); /* one frame, or less; true: there is more */

/* usb.c */
void crn_usb_configure(crn_usb *usb, uint8_t configuration);
void crn_usb_pipe_open(crn_usb *usb,
                       crn_usb_pipe pipe); /* starts the endpoint anew: DATA0, not halted, nothing armed */
void crn_usb_pipe_halt(crn_usb *usb, crn_usb_pipe pipe);
void crn_usb_pipe_arm(crn_usb *usb, crn_usb_pipe pipe, uint8_t *bytes, uint32_t count);
bool crn_usb_pipe_is_free(const crn_usb *usb, crn_usb_pipe pipe); /* open, not halted, nothing armed */
void crn_usb_tell_link(crn_usb *usb);
void crn_usb_leave(crn_usb *usb); /* off the bus for off_value_ms */

#endif
