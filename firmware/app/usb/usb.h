/* This header declares the USB device, which works with any controller of firmware/port/udc.h. The device has
 * the standard requests (chapter 9), a HID interface, and a vendor-specific interface with a pair of bulk
 * endpoints.
 *
 *   at power-up        crn_usb_init(usb, &config)      off the bus; then crn_usb_connect(usb, true)
 *   always             crn_usb_poll(usb)               from the main loop: events, replies, bytes to the app
 *   1 ms passed        crn_usb_timer(usb, &state)      the state report of this tick
 *   a frame to send    crn_usb_transmit(usb, ...)      carries out crn_port.transmit
 *
 * The stream (bulk pair) carries frames as bytes, and the borders of packets have no meaning:
 *
 * - Towards the host, the queue takes a whole frame or refuses it. When the queue to the host runs empty
 *   after a full packet, the device sends an empty packet, so that a host's longer read ends.
 *
 * - Towards the device, an empty packet has no meaning. The app receives bytes frame by frame,
 *   and only while the queue has space for the longest answer (`reply_bytes`). Otherwise the packet is held
 *   and the host sees NAK.
 *
 * - A byte stream over the bulk endpoints begins after SET_CONFIGURATION, SET_INTERFACE, or a CLEAR_FEATURE
 *   that ends a halt. A byte stream begins with an empty queue and a zero byte in each direction; the zero
 *   byte ends a frame that an earlier stream left incomplete. */
#ifndef CRN_USB_H
#define CRN_USB_H

#include "firmware/port/udc.h"
#include "shared/wire/hid.h"
#include "shared/wire/wire_frame.h"

/* this is pid.codes' number for tests; a rig that leaves the laboratory needs a number of its own (make
 * USB_ID=1209:0001) */
#ifndef CRN_USB_VENDOR_ID
#define CRN_USB_VENDOR_ID 0x1209
#endif
#ifndef CRN_USB_PRODUCT_ID
#define CRN_USB_PRODUCT_ID 0x0001
#endif

/* Interfaces and endpoints. Only the images for the kernel's module usbtest have another table
 * (firmware/app/usb/source_sink). */
#ifndef CRN_USB_TABLE
#define CRN_USB_TABLE "firmware/app/usb/usb_table.def"
#endif

enum {
    CRN_USB_CONTROL_BYTES = 256,    /* longest control transfer; the longest descriptor has 178 bytes */
    CRN_USB_STREAM_PACKET = 512,    /* of the bulk pair at high speed */
    CRN_USB_STREAM_BURST = 1 << 14, /* longest IN transfer given to the controller at once */
    CRN_USB_SERIAL_MAX = 32,        /* characters */
    CRN_USB_REPORT_QUEUE = 64,      /* state reports that wait for a late host: 64 ms */
    CRN_USB_EVENTS_PER_POLL = 8,
    CRN_USB_OFF_MAX_ms = 10000,

    /* vendor requests to the device */
    CRN_USB_REQUEST_MS_OS = 0x20, /* IN, wIndex 7: Microsoft OS 2.0 descriptor set */
    CRN_USB_REQUEST_UNPLUG =
        0x21, /* OUT, no data: off the bus for wValue ms (1 .. 10 000), then back. wIndex 0: at once, else
                 with that packet of the stream, which is lost in the middle of a transfer */
};

typedef enum crn_usb_link {
    CRN_USB_DETACHED = 0, /* no cable, or no host that configured the device */
    CRN_USB_CONFIGURED,   /* a host may use both interfaces */
    CRN_USB_SUSPENDED,    /* it was configured, and the bus sleeps */
} crn_usb_link;

/* Lists the callbacks that a port provides; each callback runs inside crn_usb_poll. */
typedef struct crn_usb_app {
    void *context;
    void (*receive)(void *context, const uint8_t *bytes, size_t count); /* of the stream; may transmit */
    void (*link)(void *context, crn_usb_link link);
    void (*command)(void *context, const crn_hid_command *command);
    void (*identity)(void *context, crn_hid_identity *identity);
    void (*capabilities)(void *context, crn_hid_capabilities *capabilities);
    void (*calibration)(void *context, crn_hid_calibration *calibration);
    void (*limits)(void *context, crn_hid_limits *limits);
    /* False: the report was refused and changed nothing; the host sees STALL. */
    bool (*set_calibration)(void *context, const crn_hid_calibration *calibration);
    bool (*set_limits)(void *context, const crn_hid_limits *limits);
} crn_usb_app;

typedef struct crn_usb_config {
    const crn_udc *udc;
    const crn_usb_app *app;
    const char *serial; /* ASCII, 1 .. CRN_USB_SERIAL_MAX characters; it distinguishes two rigs */
    uint8_t *queue;     /* frames on their way to the host */
    uint32_t queue_bytes;
    uint32_t reply_bytes; /* At least `reply_bytes` must be free in the queue to the host before the app
                             receives a request, so that all frames of the reply fit. At least
                             CRN_WIRE_FRAME_MAX, at most half of the queue */
} crn_usb_config;

/* Lists the endpoints in the order of the table. */
typedef enum crn_usb_pipe {
#define USB_ENDPOINT(INTERFACE, NAME, address, type, full_bytes, full_interval, high_bytes, high_interval,   \
                     text)                                                                                   \
    CRN_USB_##NAME,
#include CRN_USB_TABLE
    CRN_USB_PIPE_COUNT,
} crn_usb_pipe;

typedef struct crn_usb_setup { /* USB 2.0, table 9-2 */
    uint8_t type, request;
    uint16_t value, index, length;
} crn_usb_setup;

typedef struct crn_usb {
    crn_usb_config config;

    /* the bus */
    bool is_connected; /* requested by the port; the device is off the bus while off_ms counts down */
    bool is_suspended;
    uint8_t speed; /* crn_udc_speed */
    uint8_t address;
    uint8_t configuration; /* 0 or 1 */
    uint8_t link;          /* last reported to the app */
    uint32_t off_ms;       /* 0: not counting */
    uint16_t off_packets;  /* packets of the stream to the device until it goes off the bus; 0: it stays */
    uint16_t off_value_ms; /* and then for so long */
    bool is_halted[CRN_USB_PIPE_COUNT];
    bool is_armed[CRN_USB_PIPE_COUNT];

    /* control transfers */
    uint8_t stage;             /* of the transfer under way */
    uint8_t after_status;      /* what to do after the status stage */
    uint16_t after_value;      /* with which value */
    uint16_t after_index;      /* and index */
    bool ends_empty;           /* an empty packet must still follow the data */
    crn_usb_setup setup;       /* its request */
    uint32_t requests_refused; /* answered with STALL */
    uint8_t hid_idle;

    /* HID */
    crn_hid_state state;
    uint32_t report_first, report_count; /* ring of reports that wait */
    uint32_t reports_dropped;            /* reports lost because the host was later than the queue is long */
    uint32_t reports_refused;            /* packets on the interrupt pipe that were no reports */

    /* the stream: the queue is a ring */
    uint32_t queue_begin, queue_count;
    uint32_t sending;              /* bytes of the ring given to the controller */
    bool ends_full;                /* the last packet sent was full */
    uint32_t held_begin, held_end; /* received bytes that the app has not taken yet */
    uint32_t frames_refused;

    _Alignas(32) uint8_t control[CRN_USB_CONTROL_BYTES];
    _Alignas(32) uint8_t report_in[CRN_HID_REPORT_BYTES_MAX]; /* under way */
    uint8_t reports[CRN_USB_REPORT_QUEUE][CRN_HID_REPORT_BYTES_MAX];
    _Alignas(32) uint8_t report_out[CRN_HID_REPORT_BYTES_MAX];
    _Alignas(32) uint8_t stream_out[CRN_USB_STREAM_PACKET];
} crn_usb;

/* The function copies `config`; the objects to which `config` points must exist as long as the stack is used.
 * False: the queue or the room for replies is too short, or the serial number is empty, too long or not
 * printable ASCII. */
bool crn_usb_init(crn_usb *usb, const crn_usb_config *config);

/* Connects the device to the bus, or disconnects it as if somebody had pulled the cable. */
void crn_usb_connect(crn_usb *usb, bool connected);

/* Does a bounded amount of work for the bus: at most CRN_USB_EVENTS_PER_POLL events and one frame for the
 * app. Returns true if the USB stack may have more work to do. */
bool crn_usb_poll(crn_usb *usb);

/* One millisecond has passed. Makes a HID state report from `state` and queues it behind the waiting reports.
 * When the queue of state reports is full, the oldest report is dropped. State reports are queued only
 * while a host has configured the device and the bus is awake. */
void crn_usb_timer(crn_usb *usb, const crn_hid_state *state);

/* Queues a whole frame for the host. Returns false and queues nothing if the device is not configured or the
 * queue has no space. */
bool crn_usb_transmit(crn_usb *usb, const uint8_t *frame, size_t frame_bytes);

/* Returns how many more bytes the queue to the host can take. A caller that knows how much space the queue
 * has can drop a picture of the tools before the queue refuses a frame. */
uint32_t crn_usb_queue_room(const crn_usb *usb);

#endif
