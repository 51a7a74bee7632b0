/* The processor: an image runs on the chip (chip.h), by libunicorn. Time is counted in instructions, a cycle
 * of the core's clock each, plus what the flash and the PSRAM take; so every run of an image is the same, bit
 * for bit. Exceptions and interrupts are taken between two blocks of code. libunicorn is a test tool (GPL-2)
 * and is never linked into what ships. */
#ifndef CRN_RT1062_ENGINE_H
#define CRN_RT1062_ENGINE_H

#include "hil_tests/rt1062/chip.h"

typedef struct rt_engine rt_engine;

typedef enum rt_stop {
    RT_STOP_TIME,  /* the time is over */
    RT_STOP_RESET, /* a watchdog has reset the chip; the next call boots anew */
    RT_STOP_LOCKUP /* a fault within a fault, or nothing to boot */
} rt_stop;

/* Reads an ELF file into the flash of `chip` (which the caller keeps), and powers up. NULL: `error` says why.
 */
rt_engine *rt_engine_create(rt_chip *chip, const char *elf_path, const char **error);
void rt_engine_destroy(rt_engine *engine);

/* Runs until `instant` at the latest, or to the end of the block that crosses it. */
rt_stop rt_engine_run(rt_engine *engine, uint64_t instant);
rt_stop rt_engine_run_us(rt_engine *engine, double us);
/* Cuts the power and switches it on again. */
void rt_engine_power_cycle(rt_engine *engine);

rt_chip *rt_engine_chip(rt_engine *engine);
uint64_t rt_engine_instructions(const rt_engine *engine);
/* How often the image had nothing to do, so that time jumped to the next event. */
uint64_t rt_engine_idle_jumps(const rt_engine *engine);
/* Lines that the data cache has fetched from the PSRAM since the last start. */
uint64_t rt_engine_cache_misses(const rt_engine *engine);
/* Cycles in which the processor executed or waited for lines, without the time that jumped by. */
double rt_engine_busy_cycles(const rt_engine *engine);
/* Why the engine has locked up, or an empty text. */
const char *rt_engine_trouble(const rt_engine *engine);
/* The address of a symbol, 0 if there is none; and the function at an address, for reports (rt_name_place).
 */
uint32_t rt_engine_symbol(const rt_engine *engine, const char *name);
const char *rt_engine_place(void *engine, uint32_t pc);
/* From now on until it is called with NULL: sets a bit for every word of the tightly coupled memories that
 * the processor executes (`code`, from 0 on) or reads (`data`, from RT_DTCM_BEGIN on). */
enum { RT_TOUCHED_BYTES = RT_FLEXRAM_BYTES / 32 };
typedef struct rt_touched {
    uint8_t code[RT_TOUCHED_BYTES], data[RT_TOUCHED_BYTES];
} rt_touched;
bool rt_engine_watch(rt_engine *engine, rt_touched *touched);
/* Reads a word of the processor's memory, for tests. */
uint32_t rt_engine_word(rt_engine *engine, uint32_t address);
/* Changes a half-word of the flash, for tests that patch the image. */
void rt_engine_patch(rt_engine *engine, uint32_t flash_address, uint16_t half);

#endif
