/* The device that a bridge shows to a host: the loop-back rig in this process, or whatever serves a mailbox in a file that
 * another process has mapped too (an emulator's memory).
 *
 * May include: hil_tests/usb. Called by: bridges.
 */
#ifndef SELD_USB_PEER_H
#define SELD_USB_PEER_H

#include "hil_tests/usb/usb_rig.h"

typedef struct usb_peer {
    usb_host *host;
    bool is_here; /* in this process */
    usb_rig rig;  /* if so */
    usb_host far;
    int64_t next_tick_ns, deadline_ns;
    uint32_t looks;
    uint32_t last_command;
} usb_peer;

enum { USB_PEER_DEADLINE_s = 5 }; /* of a token */

int64_t usb_peer_now_ns(void);

/* A rig in this process, with ticks by the clock. It sends a burst of frames when command 200 asks for it: value1 frames of
 * value2 bytes. */
void usb_peer_open_here(usb_peer *peer);

/* A mailbox at `offset` of a file that is large enough. NULL, or what is wrong. */
const char *usb_peer_open_file(usb_peer *peer, const char *path, uint64_t offset);

/* Let a device in this process do its work up to now. */
void usb_peer_run(usb_peer *peer);

#endif
