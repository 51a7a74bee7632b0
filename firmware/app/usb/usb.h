/* The USB device: chapter 9, a HID interface and a vendor bulk pair over any controller of firmware/port/udc.h.
 *
 *   at power-up        seld_usb_init(usb, &config)      off the bus; then seld_usb_connect(usb, true)
 *   always             seld_usb_poll(usb)               from the main loop: events, replies, bytes to the app
 *   1 ms passed        seld_usb_timer(usb, &state)      the state report of this tick
 *   a frame to send    seld_usb_transmit(usb, ...)      what seld_port.transmit asks for
 *
 * Rules of the stream (bulk pair): frames are bytes, packets have no meaning.
 *  - To the host: a frame is queued whole or refused. When the queue runs empty behind a full packet, an empty packet
 *    follows, so that a host's longer read ends.
 *  - To the device: an empty packet means nothing. Bytes are handed to the app frame by frame, and only while the queue
 *    has room for the longest answer (`reply_bytes`); otherwise the packet is held and the host sees NAK.
 *  - A stream begins (SET_CONFIGURATION, SET_INTERFACE, CLEAR_FEATURE of a halt) with an empty queue and a zero byte, both
 *    ways, which ends a frame that was cut.
 *
 * May include: firmware/port/udc.h, shared/wire. Called by: firmware/port/<port>, tests.
 */
#ifndef SELD_USB_H
#define SELD_USB_H

#include "firmware/port/udc.h"
#include "shared/wire/hid.h"
#include "shared/wire/wire_frame.h"

/* pid.codes' number for tests; a rig that leaves the laboratory needs one of its own (make USB_ID=1209:0001). */
#ifndef SELD_USB_VENDOR_ID
#define SELD_USB_VENDOR_ID 0x1209
#endif
#ifndef SELD_USB_PRODUCT_ID
#define SELD_USB_PRODUCT_ID 0x0001
#endif

enum {
    SELD_USB_CONTROL_BYTES = 256,    /* longest control transfer; the longest descriptor has 178 */
    SELD_USB_STREAM_PACKET = 512,    /* of the bulk pair at high speed */
    SELD_USB_STREAM_BURST = 1 << 14, /* longest IN transfer given to the controller at once */
    SELD_USB_SERIAL_MAX = 32,        /* characters */
    SELD_USB_REPORT_QUEUE = 64,      /* state reports that wait for a late host: 64 ms */
    SELD_USB_EVENTS_PER_POLL = 8,
    SELD_USB_OFF_MAX_ms = 10000,

    /* vendor requests to the device */
    SELD_USB_REQUEST_MS_OS = 0x20, /* IN, wIndex 7: Microsoft OS 2.0 descriptor set */
    SELD_USB_REQUEST_UNPLUG =
        0x21, /* OUT, no data: off the bus for wValue ms (1 .. 10 000), then back. wIndex 0: at once, else with
                                       that packet of the stream, which is lost in the middle of a transfer */
};

typedef enum seld_usb_link {
    SELD_USB_DETACHED = 0, /* no cable, or no host that configured the device */
    SELD_USB_CONFIGURED,   /* a host may use both interfaces */
    SELD_USB_SUSPENDED,    /* it was configured, and the bus sleeps */
} seld_usb_link;

/* What the glue gives; every callback runs inside seld_usb_poll. */
typedef struct seld_usb_app {
    void *context;
    void (*receive)(void *context, const uint8_t *bytes, size_t count); /* of the stream; may transmit */
    void (*link)(void *context, seld_usb_link link);
    void (*command)(void *context, const seld_hid_command *command);
    void (*identity)(void *context, seld_hid_identity *identity);
    void (*capabilities)(void *context, seld_hid_capabilities *capabilities);
    void (*calibration)(void *context, seld_hid_calibration *calibration);
    void (*limits)(void *context, seld_hid_limits *limits);
    /* False: refused, nothing changed; the host sees STALL. */
    bool (*set_calibration)(void *context, const seld_hid_calibration *calibration);
    bool (*set_limits)(void *context, const seld_hid_limits *limits);
} seld_usb_app;

typedef struct seld_usb_config {
    const seld_udc *udc;
    const seld_usb_app *app;
    const char *serial; /* ASCII, 1 .. SELD_USB_SERIAL_MAX characters; what tells two rigs apart */
    uint8_t *queue;     /* frames on their way to the host */
    uint32_t queue_bytes;
    uint32_t reply_bytes; /* room that a request must find: all the frames that may answer one. At least
                             SELD_WIRE_FRAME_MAX, at most half of the queue */
} seld_usb_config;

/* Endpoints in the order of usb_table.def. */
typedef enum seld_usb_pipe {
#define USB_ENDPOINT(INTERFACE, NAME, address, type, full_bytes, full_interval, high_bytes, high_interval,   \
                     text)                                                                                   \
    SELD_USB_##NAME,
#include "firmware/app/usb/usb_table.def"
    SELD_USB_PIPE_COUNT,
} seld_usb_pipe;

typedef struct seld_usb_setup { /* USB 2.0, table 9-2 */
    uint8_t type, request;
    uint16_t value, index, length;
} seld_usb_setup;

typedef struct seld_usb {
    seld_usb_config config;

    /* the bus */
    bool is_connected; /* wished; off while off_ms counts down */
    bool is_suspended;
    uint8_t speed; /* seld_udc_speed */
    uint8_t address;
    uint8_t configuration; /* 0 or 1 */
    uint8_t link;          /* last told to the app */
    uint32_t off_ms;       /* 0: not counting */
    uint16_t off_packets;  /* of the stream to the device until it goes off the bus; 0: stays */
    uint16_t off_value_ms; /* and then for so long */
    bool is_halted[SELD_USB_PIPE_COUNT];
    bool is_armed[SELD_USB_PIPE_COUNT];

    /* control transfers */
    uint8_t stage;             /* of the transfer under way */
    uint8_t after_status;      /* what to do when its status stage is over */
    uint16_t after_value;      /* with which value */
    uint16_t after_index;      /* and index */
    bool ends_empty;           /* an empty packet is still to follow the data */
    seld_usb_setup setup;      /* its request */
    uint32_t requests_refused; /* answered with STALL */
    uint8_t hid_idle;

    /* HID */
    seld_hid_state state;
    uint32_t report_first, report_count; /* ring of reports that wait */
    uint32_t reports_dropped;            /* the host was later than the queue is long */
    uint32_t reports_refused;            /* came on the interrupt pipe and were none */

    /* the stream: the queue is a ring */
    uint32_t queue_begin, queue_count;
    uint32_t sending;              /* bytes of the ring given to the controller */
    bool ends_full;                /* the last packet sent was full */
    uint32_t held_begin, held_end; /* received bytes that the app has not got yet */
    uint32_t frames_refused;

    _Alignas(32) uint8_t control[SELD_USB_CONTROL_BYTES];
    _Alignas(32) uint8_t report_in[SELD_HID_REPORT_BYTES_MAX]; /* under way */
    uint8_t reports[SELD_USB_REPORT_QUEUE][SELD_HID_REPORT_BYTES_MAX];
    _Alignas(32) uint8_t report_out[SELD_HID_REPORT_BYTES_MAX];
    _Alignas(32) uint8_t stream_out[SELD_USB_STREAM_PACKET];
} seld_usb;

/* `config` is copied; what it points to must outlive the stack. False: the queue or the room for replies is too short, or the serial is
 * empty, too long or not printable ASCII. */
bool seld_usb_init(seld_usb *usb, const seld_usb_config *config);

/* Show the device to the host, or take it off the bus: as if the cable were pulled. */
void seld_usb_connect(seld_usb *usb, bool connected);

/* Bounded work: at most SELD_USB_EVENTS_PER_POLL events and one frame for the app. True: there may be more to do. */
bool seld_usb_poll(seld_usb *usb);

/* One millisecond has passed. `state` becomes a state report behind those that wait; when the queue is full the oldest one is
 * left out. Nothing waits while no host has configured the device, or the bus sleeps. */
void seld_usb_timer(seld_usb *usb, const seld_hid_state *state);

/* Queue a whole frame for the host. False: not configured, or no room; nothing was queued. */
bool seld_usb_transmit(seld_usb *usb, const uint8_t *frame, size_t frame_bytes);

/* Bytes that the queue still takes: for who wants to leave out a picture rather than be refused. */
uint32_t seld_usb_queue_room(const seld_usb *usb);

#endif
