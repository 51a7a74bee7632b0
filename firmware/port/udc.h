/* This header declares the USB device controller as the USB stack uses it: the functions that a port provides
 * and that firmware/app/usb calls.
 *
 * The port powers up its USB controller itself and passes a filled crn_udc to the stack. The stack calls the
 * controller's functions only from the main loop and never from an interrupt. None of the controller's
 * functions waits, and none takes longer than the handling of one packet.
 *
 * The transfer buffers belong to the stack; the controller reads and writes them directly (no copy). Buffers
 * of OUT transfers are aligned to 32 bytes and fill whole cache lines of 32 bytes, so that a cache may be
 * invalidated; buffers of IN transfers need not be aligned.
 *
 * The stack names an endpoint by its address, which is the number 0 .. 15 with bit 7 set for IN. Endpoint 0
 * is always open in both directions, with packets of 64 bytes. */
#ifndef CRN_UDC_H
#define CRN_UDC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CRN_UDC_IN = 0x80, CRN_UDC_SETUP_BYTES = 8, CRN_UDC_CONTROL_PACKET_BYTES = 64 };

typedef enum crn_udc_type { /* transfer types as descriptors number them */
                            CRN_UDC_BULK = 2,
                            CRN_UDC_INTERRUPT = 3,
} crn_udc_type;

typedef enum crn_udc_speed {
    CRN_UDC_FULL_SPEED = 0, /* 12 Mbit/s */
    CRN_UDC_HIGH_SPEED = 1, /* 480 Mbit/s */
} crn_udc_speed;

typedef enum crn_udc_event_kind {
    CRN_UDC_NOTHING = 0,
    CRN_UDC_RESET,   /* the bus was reset and `speed` is known; address 0, only endpoint 0 is open, nothing is
                        armed */
    CRN_UDC_SUSPEND, /* no traffic for 3 ms */
    CRN_UDC_RESUME,
    CRN_UDC_UNPLUG, /* the cable is out; the state is that after a reset */
    CRN_UDC_SETUP,  /* a setup packet arrived: what was armed on endpoint 0 is void, without CRN_UDC_DONE */
    CRN_UDC_DONE,   /* the transfer armed on `endpoint` ended after `bytes` */
} crn_udc_event_kind;

typedef struct crn_udc_event {
    uint8_t kind;     /* crn_udc_event_kind */
    uint8_t speed;    /* crn_udc_speed, of CRN_UDC_RESET */
    uint8_t endpoint; /* of CRN_UDC_DONE */
    uint32_t bytes;   /* of CRN_UDC_DONE */
    uint8_t setup[CRN_UDC_SETUP_BYTES];
} crn_udc_event;

typedef struct crn_udc {
    void *context; /* passed back in every call */
    bool can_high_speed;

    /* Turns the pull-up resistor on or off; while the resistor is off, the host sees an empty socket. */
    void (*connect)(void *context, bool connected);

    /* Sets the USB address at which the controller answers from now on. The stack calls this function at the
     * end of the status stage of SET_ADDRESS. */
    void (*set_address)(void *context, uint8_t address);

    /* Opens an endpoint in its initial state: the next packet is DATA0, and the endpoint is neither stalled
     * nor armed. An endpoint that is already open is set to the same initial state. Returns false if the
     * controller cannot provide the requested endpoint. */
    bool (*open)(void *context, uint8_t endpoint, crn_udc_type type, uint16_t packet_bytes);
    void (*close)(void *context, uint8_t endpoint);

    /* Begins one transfer on an endpoint; the stack never begins a second transfer on this endpoint before
     * the first is done or has become void. For an IN transfer, the controller sends `count` bytes in
     * packets, of which the last is short or full; if `count` is 0, it sends one empty packet. For an OUT
     * transfer, the controller receives packets until it has `count` bytes or a packet is short; if `count`
     * is 0, it waits for one empty packet. */
    void (*arm)(void *context, uint8_t endpoint, uint8_t *bytes, uint32_t count);

    /* Makes the endpoint answer STALL and drops its armed transfer. The stall ends when the endpoint is
     * opened, at a bus reset or, on endpoint 0 (in both directions), at the next setup packet. */
    void (*stall)(void *context, uint8_t endpoint);

    /* Enters the electrical test mode `selector` (USB 2.0, 9.4.9) until power-down. The pointer `test` is
     * NULL if the controller has no test modes. */
    void (*test)(void *context, uint8_t selector);

    /* Returns the next event, in the order of the bus: transfers that ended before a setup packet come before
     * it, so that no byte is lost for which the host saw an acknowledgement. The function `poll` returns
     * false if there is no new event. */
    bool (*poll)(void *context, crn_udc_event *event);
} crn_udc;

#endif
