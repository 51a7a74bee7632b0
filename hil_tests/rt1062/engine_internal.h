/* What the files of the engine share: engine.c (run, time), engine_memory.c (the processor's view of the
 * memories), engine_exceptions.c (faults and interrupts). */
#ifndef CRN_RT1062_ENGINE_INTERNAL_H
#define CRN_RT1062_ENGINE_INTERNAL_H

#include "hil_tests/rt1062/cache.h"
#include "hil_tests/rt1062/engine.h"
#include <stddef.h>
#include <unicorn/unicorn.h>

enum {
    RT_MAPS_MAX = 8,
    RT_COUNTS = 1 << 15, /* blocks whose instructions are known, by address */
    RT_HARD_FAULT = 3,
    RT_MEMORY_FAULT = 4,
    RT_BUS_FAULT = 5,
    RT_USAGE_FAULT = 6,
    RT_INTERRUPT_0 = 16,
    RT_CFSR_CODE = 0x01,
    RT_CFSR_DATA = 0x82, /* DACCVIOL, address valid */
    RT_CFSR_STACKING = 0x10,
    RT_CFSR_BUS = 0x8200, /* PRECISERR, address valid */
    RT_CFSR_UNDEFINED = 1 << 16,
};
#define RT_NOWHERE 0xfffff000u

typedef struct rt_map {
    uint32_t begin, bytes, rights;
    uint8_t *memory; /* NULL: a region that is emulated access by access */
} rt_map;

/* A region that is emulated access by access. */
typedef struct rt_emulated {
    rt_engine *engine;
    uint32_t begin;
} rt_emulated;

struct rt_engine {
    rt_chip *chip;
    uc_engine *uc;
    uint8_t *file; /* the ELF file */
    size_t file_bytes;
    rt_map maps[RT_MAPS_MAX];
    uint32_t map_count;
    rt_emulated guard, psram;
    rt_cache cache;
    uint64_t run_end, stop_at, instructions, idle_jumps;
    struct {
        uint32_t address;
        uint16_t bytes, count;
    } counts[RT_COUNTS];
    int fault; /* exception that waits, 0: none */
    uint32_t fault_status;
    bool returns, is_running, is_held;
    char trouble[RT_TEXT_BYTES], place[96];
    rt_touched *touched; /* NULL: nobody watches */
    uc_hook watch;
};

/* engine_memory.c */
uint8_t *rt_engine_memory(const rt_engine *engine, uint32_t address); /* NULL: none there */
void rt_engine_map(rt_engine *engine);
bool rt_engine_map_registers(rt_engine *engine);
bool rt_engine_count_lines(rt_engine *engine);

/* engine_fault.c */
void rt_engine_strike(rt_engine *engine);
void rt_engine_note_code(rt_engine *engine, uint32_t address, uint32_t bytes);

/* engine_exceptions.c */
void rt_engine_set_fault(rt_engine *engine, int exception, uint32_t status);
/* Takes the exception or interrupt that is due; false: the processor has locked up. */
bool rt_engine_take_exception(rt_engine *engine);
void rt_engine_return(rt_engine *engine);
bool rt_engine_ignores_bus_errors(rt_engine *engine);
bool rt_engine_add_hooks(rt_engine *engine);
uint32_t rt_engine_register(rt_engine *engine, int number);
void rt_engine_set_register(rt_engine *engine, int number, uint32_t value);

#endif
