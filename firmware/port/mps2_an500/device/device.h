/* This header has the declarations that the files of the device's program for the MPS2 board share.
 *
 *   boot.c     reset, vectors, exceptions            clock.c    time, the 1 ms edge, the watchdog
 *   console.c  text on UART 0                        rig.c      port inputs and outputs <-> rig_page.h
 *   pipe.c     bytes from and to the host            main.c     memory, the port's table, the loop */
#ifndef CRN_AN500_DEVICE_H
#define CRN_AN500_DEVICE_H

#include "firmware/port/mps2_an500/rig_page.h"
#include "firmware/port/port.h"

static rig_page *const rig = (rig_page *)(RIG_MEMORY_ADDRESS + RIG_PAGE_OFFSET);

int main(void);

/* boot.c */
uint32_t stack_free(void); /* looks at a piece of the memory in each call; bytes that were never written */

/* console.c */
void console_start(void);
void console_text(const char *text);
void console_number(const char *name, uint32_t value);
void console_hex(const char *name, uint64_t value, int digits);

/* clock.c */
void clock_start(void);
uint32_t clock_counts(void); /* of RIG_CLOCK_HZ; wraps */
uint32_t clock_us(void);
uint32_t clock_work_begin(void); /* called before bytes or an edge are processed */
uint32_t clock_edges_due(void);  /* milliseconds that have begun and are not processed yet */
void clock_edge_begin(void);
void clock_edge_done(void);
bool clock_waits_for_plant(void); /* the plant makes the milliseconds, and none is due */
void clock_feed_watchdog(void);
void clock_tick(void); /* the interrupt */

/* rig.c */
bool rig_is_there(void);
bool rig_inputs_read(void *context, crn_port_inputs *inputs);
void rig_outputs_write(void *context, const crn_port_outputs *outputs);
void rig_outputs_off(void); /* can be called in any state of the processor */

/* pipe.c */
void pipe_start(void);
size_t pipe_received(const uint8_t **bytes); /* the received bytes, in one piece; 0: none */
void pipe_release(size_t count);
size_t pipe_room(void *context);
bool pipe_transmit(void *context, const uint8_t *frame, size_t frame_bytes);

#endif
