/* Makes a rig leave the bus for this many milliseconds, as if its cable was pulled, whichever program is
 * using it: unplug MILLISECONDS. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <libusb-1.0/libusb.h>

#include "hil_tests/library/check.h"

enum { REQUEST_UNPLUG = 0x21, TIMEOUT_ms = 2000 };

int main(int argc, char **argv)
{
    libusb_context *usb;
    if (argc != 2 || libusb_init(&usb) != 0) {
        fprintf(stderr, "usage: unplug MILLISECONDS\n");
        return 2;
    }
    libusb_device_handle *device = libusb_open_device_with_vid_pid(usb, CHECK_VENDOR_ID, CHECK_PRODUCT_ID);
    const int result = device == NULL
                           ? LIBUSB_ERROR_NO_DEVICE
                           : libusb_control_transfer(device, 0x40, REQUEST_UNPLUG, (uint16_t)atoi(argv[1]), 0,
                                                     NULL, 0, TIMEOUT_ms);
    if (result < 0) fprintf(stderr, "unplug: %s\n", libusb_error_name(result));
    if (device != NULL) libusb_close(device);
    libusb_exit(usb);
    return result < 0 ? 1 : 0;
}
