/* This header describes a model of the i.MX RT1062 on its board, down to the registers that the firmware
 * image uses. The model has no processor: engine.h adds one, and a test of one peripheral does without.
 *
 * Every "ready" is earned. A status bit becomes ready only if the image has programmed gate, clock, divider
 * and mux rightly, and if its time has passed. A read of a status bit that is not ready calls rt_pending()
 * with the reason; rt_report() names every wait that was never answered: register, place in the code, and
 * reason. A wrong access (closed gate, unknown register, wrong width, clock out of range) is a finding, and
 * rt_report() lists the findings, too.
 *
 * Offsets and fields are those of firmware/port/imxrt1062/imxrt1062_registers.h, which `make registers`
 * compares with the chip's public description, and of registers.h, which the same command compares.
 * docs/rt1062.md states for each behaviour where it comes from. */
#ifndef CRN_RT1062_CHIP_H
#define CRN_RT1062_CHIP_H

#include "hil_tests/rt1062/fault.h"
#include "hil_tests/rt1062/mutant.h"
#include "hil_tests/rt1062/peripherals.h"
#include <stdio.h>

enum {
    RT_WAITS_MAX = 64,
    RT_FINDINGS_MAX = 32,
    RT_TEXT_BYTES = 160,
    RT_FLEXRAM_BYTES = 512 << 10,
    RT_OCRAM_BYTES = 512 << 10,
    RT_FLASH_BYTES = 8 << 20,
    RT_PSRAM_BYTES = 8 << 20,
    RT_CONSOLE_BYTES = 4096,
    RT_INTERRUPT_PIT = 122, /* of the millisecond timer */
};

#define RT_FLASH_BEGIN 0x60000000u
#define RT_PSRAM_BEGIN 0x70000000u
#define RT_OCRAM_BEGIN 0x20200000u
#define RT_DTCM_BEGIN 0x20000000u

typedef struct rt_wait {
    uint32_t address, pc;
    uint64_t polls, first, last;
    bool is_answered;
    char reason[RT_TEXT_BYTES];
} rt_wait;

typedef struct rt_finding {
    uint32_t pc;
    uint64_t count;
    char text[RT_TEXT_BYTES];
} rt_finding;

/* The registers that the processor has accessed, in the order of the first access. */
enum { RT_CENSUS_MAX = 1024 };
typedef struct rt_census {
    uint32_t count;
    struct {
        uint32_t address, bytes, reads, writes;
        uint32_t ones, zeros, written_ones, written_zeros; /* bits that were read as 1, as 0, ... */
    } registers[RT_CENSUS_MAX];
} rt_census;

typedef enum rt_reset_cause { RT_RESET_NONE, RT_RESET_POWER, RT_RESET_WDOG1, RT_RESET_RTWDOG } rt_reset_cause;

/* One kilobyte-aligned piece of memory as the processor sees it; `bytes` is 0 where nothing answers. */
typedef struct rt_region {
    uint32_t begin, bytes;
    uint8_t *memory;
    bool is_code_only, is_data_only;
} rt_region;

typedef struct rt_chip {
    uint64_t now; /* instants since power-up: RT_INSTANTS_PER_s of them are a second */
    uint32_t pc;  /* of the running block of code, for reports */
    uint8_t *flexram, *ocram, *flash;
    rt_clocks clocks;
    rt_flexram flex;
    rt_flexspi flexspi;
    rt_psram psram;
    rt_pit pit;
    rt_gpt gpt;
    rt_watchdogs watchdogs;
    rt_pins pins;
    rt_crossbar crossbar;
    rt_decoder decoders[RT_DECODERS];
    rt_counter counters[RT_TIMER_CHANNELS];
    rt_pwm pwm[RT_PWM_MODULES];
    rt_adc adc[RT_ADCS];
    rt_uart uart;
    rt_usb usb;
    rt_core core;
    bool is_map_changed; /* the processor's view of the memories has to be made anew */
    rt_reset_cause reset;
    rt_wait waits[RT_WAITS_MAX];
    uint32_t waits_count;
    rt_finding findings[RT_FINDINGS_MAX];
    uint32_t findings_count;
    struct {
        uint32_t address, clear, set;
    } tamper;
    rt_fault fault;
    rt_mutant mutant;
    rt_census *census; /* NULL: nobody counts */
} rt_chip;

/* Allocates a chip whose power has just been switched on; NULL without memory. */
rt_chip *rt_chip_create(void);
void rt_chip_destroy(rt_chip *chip);

/* Resets all registers, as the cause does; memories keep their contents, except at power-up. */
void rt_chip_reset(rt_chip *chip, rt_reset_cause cause);

/* An access of the processor to a register, 1, 2 or 4 bytes wide. */
uint32_t rt_chip_read(rt_chip *chip, uint32_t address, unsigned bytes);
void rt_chip_write(rt_chip *chip, uint32_t address, unsigned bytes, uint32_t value);

/* Lets time pass without a processor, for tests of one peripheral. */
void rt_chip_pass_us(rt_chip *chip, double us);
/* Does what is due at `chip->now`, and returns the instant at which something is due next. */
uint64_t rt_chip_run_due(rt_chip *chip);
/* The highest-priority interrupt that is enabled and pending, or -1. */
int rt_chip_interrupt(rt_chip *chip);

/* Memory as the controllers on the chip's bus see it (DMA); NULL with a finding if nothing answers there. */
uint8_t *rt_chip_memory(rt_chip *chip, uint32_t address, uint32_t bytes);

/* Changes what the image writes to a register, as if the image were wrong: the bits `clear` of every value
 * become 0, then the bits `set` become 1. */
void rt_chip_tamper(rt_chip *chip, uint32_t address, uint32_t clear, uint32_t set);

/* --- for the peripherals --- */
void rt_pending(rt_chip *chip, uint32_t address, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void rt_answered(rt_chip *chip, uint32_t address);
void rt_find(rt_chip *chip, const char *format, ...) __attribute__((format(printf, 2, 3)));
void rt_unmodelled(rt_chip *chip, const char *module, uint32_t offset, bool is_write);

/* --- for people --- */
typedef const char *rt_name_place(void *context, uint32_t pc);
/* Prints waits that were never answered and findings; returns how many. */
uint32_t rt_report(const rt_chip *chip, FILE *to, rt_name_place *name, void *context);
const rt_wait *rt_unanswered(const rt_chip *chip, uint32_t index);

#endif
