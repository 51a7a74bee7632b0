/* Declares what the source files of test level L2 share: a device, its transfers, and the device nodes (files
 * in /dev) through which programs access it. Every device has a lock, because umockdev's thread answers the
 * programs' calls while another thread advances the bus.
 *
 * Programs poll their nodes. A plain file is always ready for reading and writing. If a device node were a
 * plain file, libusb would poll the node in an endless loop. Every node is therefore a FIFO. The FIFO
 * /dev/bus/usb/... is ready for writing while a transfer is complete and the program has not fetched it (as
 * with the real usbfs); otherwise this FIFO is full. The FIFO /dev/hidraw0 contains one byte for each report
 * that no program has read yet. */
#ifndef CRN_MOCK_H
#define CRN_MOCK_H

#include <pthread.h>

#include <umockdev.h>

#include "hil_tests/usb/usb_peer.h"
#include "hil_tests/usb/usb_urbs.h"

enum { MOCK_REPORTS = 64, MOCK_PIPE_BYTES = 4096 };

typedef struct mock_urb { /* a transfer of a program */
    struct mock_urb *next;
    UMockdevIoctlClient *client; /* the program that sent it; the value is only compared */
    UMockdevIoctlData *urb, *buffer;
    bool is_done;
} mock_urb;

typedef struct mock {
    pthread_mutex_t lock;
    pthread_cond_t handed_in; /* a transfer for the bus to move */
    bool is_handed_in;
    usb_peer peer;
    usb_urbs urbs;
    UMockdevTestbed *testbed;
    UMockdevIoctlBase *usbfs, *hidraw;
    char *root;
    bool is_plugged, is_attached; /* after an unplug the nodes answer until the device returns */
    int64_t unplugged_ns;
    unsigned number; /* number of the device, from 0 */
    char usb_path[64], hid_path[96], usb_node[32], hid_node[32];

    mock_urb *first; /* in the order of submission */
    int usbfs_fifo, hidraw_fifo;
    bool usbfs_is_full;

    unsigned hidraw_clients;
    bool hidraw_is_reading;
    bool hid_is_claimed; /* a program has unbound usbhid, and nothing else takes reports */
    uint8_t hidraw_packet[CRN_MAILBOX_DATA_MAX];
    uint8_t reports[MOCK_REPORTS][CRN_HID_REPORT_BYTES_MAX];
    uint32_t report_first, report_count, reports_lost;
    uint8_t report_bytes[MOCK_REPORTS];
} mock;

/* mock_usbfs.c: /dev/bus/usb/001/002 */
gboolean mock_usbfs_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
void mock_usbfs_vanished(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
void mock_usbfs_complete(mock *m, const usb_urb *urb);
void mock_usbfs_unplugged(mock *m);
int mock_errno(usb_result result);

/* mock_hidraw.c: /dev/hidraw0 */
gboolean mock_hidraw_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
gboolean mock_hidraw_read(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
gboolean mock_hidraw_write(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
void mock_hidraw_connected(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
void mock_hidraw_vanished(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m);
void mock_hidraw_complete(mock *m, const usb_urb *urb);
void mock_hidraw_step(mock *m);
void mock_hidraw_unbind(mock *m);

#endif
