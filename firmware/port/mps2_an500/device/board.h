/* This header has the registers of ARM's MPS2 board (AN500 image) that the device uses. */
#ifndef CRN_AN500_BOARD_H
#define CRN_AN500_BOARD_H

#include <stdint.h>

enum { BOARD_CLOCK_HZ = 25000000 };

typedef struct board_timer { /* counts down from `reload` */
    volatile uint32_t control, value, reload, interrupt;
} board_timer;
static board_timer *const board_timer0 = (board_timer *)0x40000000u;
enum { BOARD_TIMER_ON = 1 };

typedef struct board_uart {
    volatile uint32_t data, state, control, interrupt, divider;
} board_uart;
static board_uart *const board_uart0 = (board_uart *)0x40004000u;
enum { BOARD_UART_TRANSMIT_FULL = 1, BOARD_UART_TRANSMIT_ON = 1, BOARD_UART_DIVIDER_MIN = 16 };

typedef struct board_watchdog { /* the first expiry raises an NMI, the second resets */
    volatile uint32_t load, value, control, clear;
} board_watchdog;
static board_watchdog *const board_watchdog0 = (board_watchdog *)0x40008000u;
enum { BOARD_WATCHDOG_INTERRUPT_AND_RESET = 3 };

typedef struct board_systick {
    volatile uint32_t control, reload, value;
} board_systick;
static board_systick *const board_systick0 = (board_systick *)0xe000e010u;
enum { BOARD_SYSTICK_ON_INTERRUPT_PROCESSOR_CLOCK = 7 };

typedef struct board_faults { /* registers of the system control block */
    volatile uint32_t configurable, hard, debug, memory_address, bus_address;
} board_faults;
static board_faults *const board_faults0 = (board_faults *)0xe000ed28u;

#endif
