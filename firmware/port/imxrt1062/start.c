/* This port has never run on hardware. This file contains the code that runs from the processor's reset to
 * main(). The ROM jumps to the function `start` in the flash, which splits the FlexRAM, copies code and data,
 * and switches to the stack in the data memory. This file also ends the program at an exception: the code
 * removes the motor power and writes a line on the console, and the watchdog then resets the processor. The
 * floating-point unit stays off, because nothing uses it. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/cortex_m7.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

extern uint32_t code_begin[], code_end[], code_load[], data_begin[], data_end[], data_load[];
extern uint32_t bss_begin[], bss_end[], dma_begin[], dma_end[], stack_top[], start_stack_top[];

void start(void);

enum {
    /* FlexRAM has 16 banks of 32 kB, each with a code of two bits: 3 is code memory (the lowest 6 banks), and
     * 2 is data memory (10 banks). */
    BANKS_CODE = 6,
    SIZE_512_kB = 10, /* size field of both memories, which must hold their banks: a power of two */
    EXCEPTIONS = 16,
    INTERRUPTS = 160,
    INTERRUPT_PIT = 122,
    FRAME_LR = 5,
    FRAME_PC = 6,
};

__attribute__((section(".start"))) static void copy(uint32_t *to, const uint32_t *end, const uint32_t *from)
{
    while (to < end) *to++ = *from++;
}

__attribute__((section(".start"))) static void clear(uint32_t *to, const uint32_t *end)
{
    while (to < end) *to++ = 0;
}

/* The function `start` runs in the flash, on a stack in the OCRAM, before any other memory is set up. */
__attribute__((section(".start"), noreturn)) void start(void)
{
    __asm__ volatile("cpsid i");
    const uint32_t banks = 0xaaaaaaaau | ((1u << 2 * BANKS_CODE) - 1u);
    R32(BASE_IOMUXC_GPR, IOMUXC_GPR_GPR17) = banks;
    R32(BASE_IOMUXC_GPR, IOMUXC_GPR_GPR16) |= MASK(IOMUXC_GPR_GPR16_INIT_ITCM_EN) |
                                              MASK(IOMUXC_GPR_GPR16_INIT_DTCM_EN) |
                                              MASK(IOMUXC_GPR_GPR16_FLEXRAM_BANK_CFG_SEL);
    SET_FIELD(R32(BASE_IOMUXC_GPR, IOMUXC_GPR_GPR14), IOMUXC_GPR_GPR14_CM7_CFGITCMSZ, SIZE_512_kB);
    SET_FIELD(R32(BASE_IOMUXC_GPR, IOMUXC_GPR_GPR14), IOMUXC_GPR_GPR14_CM7_CFGDTCMSZ, SIZE_512_kB);
    core_barrier();
    copy(code_begin, code_end, code_load);
    const uint32_t bad = self_test_memory();
    if (bad != 0) self_test_stop("self-test: bad memory at 0x", bad);
    copy(data_begin, data_end, data_load);
    const uint32_t difference = self_test_image();
    if (difference != 0) self_test_stop("self-test: the image is damaged, CRC differs by 0x", difference);
    clear(bss_begin, bss_end);
    clear(dma_begin, dma_end);
    CORE_VTOR = (uint32_t)(uintptr_t)code_begin;
    core_barrier();
    __asm__ volatile("msr msp, %0\n bx %1" ::"r"(stack_top), "r"(main));
    __builtin_unreachable();
}

/* `frame` is the stack frame that the processor pushed at the exception. A bus error of the handler's own
 * accesses would lock the processor up. The peripheral that caused the exception may be one that takes the
 * forces away, so the handler ignores bus errors: what does not answer is left out, and the other ways still
 * act. */
/* Requirement: SR-22 */
__attribute__((used)) static void crashed(const uint32_t *frame)
{
    CORE_CCR |= CORE_CCR_IGNORE_BUS_FAULTS;
    core_barrier();
    rig_outputs_off();
    uint32_t number;
    __asm__ volatile("mrs %0, ipsr" : "=r"(number));
    console_number("fault: exception ", number & 0x1ffu);
    console_hex(" at pc 0x", frame[FRAME_PC]);
    console_hex(" lr 0x", frame[FRAME_LR]);
    console_hex(" status 0x", CORE_CFSR);
    console_text("; power off, waiting for the watchdog's reset\n");
    for (;;) {
    }
}

/* Sets FAULTMASK, and switches to the stack of `start`, because the stack in use may have overflowed. If the
 * processor could not push the exception's stack frame because of the guard region below the stack, the code
 * does not read this frame. If the frame could not be pushed, the old stack pointer lies below the stack, and
 * the console shows the words at the guard region's end. */
__attribute__((naked)) static void unexpected(void)
{
    __asm__ volatile("cpsid f\n"
                     "mrs r0, msp\n"
                     "ldr r1, =bss_end + 32\n"
                     "cmp r0, r1\n"
                     "it lo\n"
                     "movlo r0, r1\n"
                     "ldr r1, =start_stack_top\n"
                     "msr msp, r1\n"
                     "b crashed\n"
                     ".ltorg");
}

typedef void vector(void);
/* The data in boot_header.c direct the ROM to this table of initial stack and start address, which has the
 * form that a processor reads after reset. */
__attribute__((section(".start_vectors"), used)) const struct start_entry {
    const uint32_t *stack;
    vector *start;
} start_vectors = {start_stack_top, start};
#define UNEXPECTED_4 unexpected, unexpected, unexpected, unexpected
#define UNEXPECTED_32                                                                                        \
    UNEXPECTED_4, UNEXPECTED_4, UNEXPECTED_4, UNEXPECTED_4, UNEXPECTED_4, UNEXPECTED_4, UNEXPECTED_4,        \
        UNEXPECTED_4
/* The vector table has 15 exceptions and 122 interrupts before the tick's interrupt, and 37 interrupts after
 * it. */
__attribute__((section(".vectors"), used)) static const struct {
    const uint32_t *stack;
    vector *handlers[EXCEPTIONS - 1 + INTERRUPTS];
} vectors = {stack_top,
             {UNEXPECTED_32, UNEXPECTED_32, UNEXPECTED_32, UNEXPECTED_32, UNEXPECTED_4, UNEXPECTED_4,
              unexpected, clocks_tick, UNEXPECTED_32, UNEXPECTED_4, unexpected}};
_Static_assert(EXCEPTIONS - 1 + INTERRUPT_PIT == 4 * 32 + 2 * 4 + 1, "the tick's place");
