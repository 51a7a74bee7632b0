/* Opens a USB device for a bridge, which makes the device visible to a host. The device is in this process (a
 * loop-back rig or the complete application), or it is a program in another process, such as an emulator. The
 * mailbox of a program in another process is a file that both processes map into memory. */
#ifndef CRN_USB_PEER_H
#define CRN_USB_PEER_H

#include "hil_tests/usb/usb_device.h"
#include "hil_tests/usb/usb_rig.h"

typedef enum usb_peer_kind { USB_PEER_RIG, USB_PEER_APP, USB_PEER_FILE } usb_peer_kind;

typedef struct usb_peer {
    usb_peer_kind kind;
    usb_host *host;
    usb_rig rig; /* one of these three */
    usb_device app;
    usb_host far;
    int64_t next_tick_ns, deadline_ns;
    uint32_t looks;
    uint32_t last_command;
} usb_peer;

enum { USB_PEER_DEADLINE_s = 5 }; /* of a token */

int64_t usb_peer_now_ns(void);

/* Opens a loop-back rig in this process. The rig makes its ticks in real time. If the host sends command 200,
 * the rig sends `value1` frames of `value2` bytes each, without a pause. */
void usb_peer_open_here(usb_peer *peer);

/* Opens the device's application in this process; the device then runs in real time. There can be only one.
 */
void usb_peer_open_app(usb_peer *peer, const char *serial);

/* Opens the mailbox that begins at `offset` in a file; the file must be large enough for a mailbox at this
 * offset. Returns NULL on success, otherwise an error message. */
const char *usb_peer_open_file(usb_peer *peer, const char *path, uint64_t offset);

/* Opens the device that a command line names ("--here", "--app", "--app=SERIAL", or "--mailbox" and
 * FILE[:OFFSET]). Sets `*used` to the number of words on the command line that name the device. Returns NULL
 * on success, otherwise an error message. */
const char *usb_peer_open(usb_peer *peer, int count, char **words, int *used);

/* Lets a device in this process do all work that is due by now. */
void usb_peer_run(usb_peer *peer);

#endif
