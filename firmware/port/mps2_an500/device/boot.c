/* This file contains the code that runs from the processor's reset to main(). This file also ends the program
 * at an exception: the motor power goes off, a line appears on the console, and a record is kept that
 * survives the watchdog's reset. */
#include "firmware/port/mps2_an500/device/board.h"
#include "firmware/port/mps2_an500/device/device.h"

extern uint32_t data_start[], data_end[], data_load[], bss_start[], bss_end[], stack_top[];
void reset(void);

enum { EXCEPTION_NMI = 2, EXCEPTION_SYSTICK = 15, EXCEPTIONS = 16, FRAME_LR = 5, FRAME_PC = 6 };
enum { PAINT = 0x5354414b, PAINT_CLEAR_words = 32, SWEEP_words = 64 };

/* The memory between the variables and the stack begins with a pattern, which shows later how far the stack
 * has reached. */
static void paint_stack(void)
{
    uint32_t *stack;
    __asm__ volatile("mov %0, sp" : "=r"(stack));
    for (volatile uint32_t *word = bss_end; word < stack - PAINT_CLEAR_words; word++) *word = PAINT;
}

uint32_t stack_free(void)
{
    static const uint32_t *low, *at; /* lowest word that was written, and the next word to look at */
    if (low == NULL) {
        low = stack_top;
        at = bss_end;
    }
    for (int i = 0; i < SWEEP_words && at < low; i++, at++)
        if (*(const volatile uint32_t *)at != PAINT) low = at;
    if (at >= low) at = bss_end;
    return (uint32_t)(low - bss_end) * (uint32_t)sizeof *low;
}

void reset(void)
{
    const uint32_t *from = data_load;
    for (uint32_t *word = data_start; word < data_end; word++) *word = *from++;
    for (uint32_t *word = bss_start; word < bss_end; word++) *word = 0;
    paint_stack();
    main();
}

/* `frame` is the stack frame that the processor pushed at the exception. */
__attribute__((used)) static void crashed(const uint32_t *frame)
{
    rig_outputs_off();
    uint32_t number;
    __asm__ volatile("mrs %0, ipsr" : "=r"(number));
    number &= 0x1ff;
    rig_crash *crash = &rig->device.crash;
    if (number != EXCEPTION_NMI || crash->exception == 0) { /* the first cause counts */
        *crash = (rig_crash){number, frame[FRAME_PC], frame[FRAME_LR], board_faults0->configurable,
                             board_faults0->bus_address};
    }
    console_number(number == EXCEPTION_NMI ? "watchdog: exception " : "fault: exception ", number);
    console_hex(" at pc 0x", frame[FRAME_PC], 8);
    console_hex(" lr 0x", frame[FRAME_LR], 8);
    console_hex(" status 0x", board_faults0->configurable, 8);
    console_text("; power off, waiting for the watchdog's reset\n");
    for (;;) {
    }
}

/* The function `crashed` needs the value that the stack pointer has at entry, before the function's own
 * prologue changes the pointer. */
__attribute__((naked)) static void unexpected(void)
{
    __asm__ volatile("mrs r0, msp\n b crashed");
}

typedef void vector(void);
__attribute__((section(".vectors"), used)) static const struct {
    const uint32_t *stack;
    vector *exceptions[EXCEPTIONS - 1];
} vectors = {stack_top,
             {reset, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected,
              unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, clock_tick}};
