/* Provides the complete device in this process, connected to the token mailbox: the application, the USB
 * stack, and a USB controller in memory. The device has no rig, so the host sends the positions of the hands.
 * A process can have only one device, because the memory for scenes is static. */
#ifndef CRN_USB_DEVICE_H
#define CRN_USB_DEVICE_H

#include "firmware/port/mailbox/mailbox_udc.h"
#include "firmware/port/usb/rig_usb.h"
#include "hil_tests/usb/usb_host.h"

enum { USB_DEVICE_SLOT_BYTES = 1 << 23, USB_DEVICE_READ_BYTES = 1 << 14 };

typedef struct usb_device {
    crn_mailbox mailbox;
    crn_mailbox_udc controller;
    crn_rig_usb rig_usb;
    crn_port port;
    crn_instrument tool_table[CRN_TABLE_MAX];
    crn_app app;
    crn_port_outputs outputs;
    uint32_t us;
    usb_host host;
    uint32_t waits;
    usb_result last; /* of the pipe below */
    uint32_t read_begin, read_end;
    uint8_t read_bytes[USB_DEVICE_READ_BYTES];
} usb_device;

/* Powers up the device on the bus; a host is connected but has not reset the bus yet. Returns false if the
 * USB stack refused its configuration. */
bool usb_device_start(usb_device *device, const char *serial);

/* Powers up the device as usb_device_start does, resets the bus, sets address and configuration, and reads
 * the zero that begins the byte stream. Returns false if the device refused one of these requests. */
bool usb_device_open(usb_device *device);

/* Runs one millisecond. */
void usb_device_tick(usb_device *device);

/* Lets the device do all work that is possible without a further action of the host. */
void usb_device_settle(usb_device *device);

/* The following functions give access to the byte stream as a pipe; `context` is a pointer to the usb_device.
 */
void usb_device_write(void *context, const uint8_t *bytes, size_t count);
size_t usb_device_read(void *context, uint8_t *bytes, size_t capacity);

#endif
