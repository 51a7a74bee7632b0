/* The device's own app and USB stack with a port whose hardware is simulated: a timer that makes an edge in
 * every millisecond, a register with the number of the last USB frame, and a clock of microseconds. The main
 * loop is that of a board: it answers the bus, and runs the work of one edge as often as edges are due. An
 * edge that comes while the processor is busy waits, as an interrupt's counter lets it wait.
 *
 * Time belongs to the caller: the device calls `pass` when its processor works. C11 and C++20. */
#ifndef CRN_HOURS_DEVICE_H
#define CRN_HOURS_DEVICE_H

#include "firmware/port/port.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HOURS_SLOT_BYTES = 8 << 20 };

/* The hardware around the processor. */
typedef struct hours_hardware {
    void *context;
    void (*pass)(void *context, uint32_t us); /* the processor works for so long; the hardware goes on */
    uint32_t (*now_us)(void *context);        /* of the device's crystal; wraps */
    uint32_t (*frame)(void *context);         /* number of the host's last frame, 0 .. 2,047 */
    uint32_t (*work_us)(void *context, bool is_ticking); /* how long the work of the present edge takes */
    void (*sample)(void *context, crn_port_inputs *inputs);
    void (*drive)(void *context, const crn_port_outputs *outputs);
} hours_hardware;

/* What the device has counted; all but `overruns` since power-up. */
typedef struct hours_counts {
    uint32_t edges;      /* by the timer's interrupt */
    uint32_t edges_done; /* by the app */
    uint32_t frames;     /* of the bus, counted from the register of eleven bits */
    uint32_t overruns;   /* as in the message `status` */
    int32_t clock_error; /* not 0: what the board's check of the timer against the frames said */
    uint32_t reports_dropped, frames_refused;
    uint32_t reports_waiting;
    uint8_t state, mode;
} hours_counts;

typedef struct hours_device hours_device;

/* `mailbox` is the bus (shared/mailbox). Returns NULL if there is not enough memory. */
hours_device *hours_device_create(const hours_hardware *hardware, void *mailbox);
void hours_device_destroy(hours_device *device);

/* The processor restarts; the scene slots keep their contents. */
void hours_device_power_up(hours_device *device);

/* The timer's interrupt. */
void hours_device_edge(hours_device *device);
uint32_t hours_device_edges_due(const hours_device *device);

/* One round of the main loop: the bus, then one edge if one is due. Returns true if it found work. */
bool hours_device_round(hours_device *device);

/* One look at the bus. */
bool hours_device_poll(hours_device *device);

hours_counts hours_device_read(const hours_device *device);

/* False if a byte beside the device's memory has changed. */
bool hours_device_is_sound(const hours_device *device);

#ifdef __cplusplus
}
#endif

#endif
