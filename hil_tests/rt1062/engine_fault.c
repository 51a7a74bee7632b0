/* What a fault (fault.h) does to the processor: its code in memory, its exceptions, its power; and which
 * words of memory are worth a fault, because the processor uses them. */
#include "hil_tests/rt1062/engine_internal.h"
#include <string.h>

static void flip_memory(rt_engine *engine, const rt_fault *fault)
{
    uint32_t word, stack = fault->set != 0 ? rt_engine_register(engine, UC_ARM_REG_SP) : 0;
    uint32_t address = (stack + fault->address) & ~3u;
    uint8_t *memory = rt_engine_memory(engine, address);
    if (memory == NULL) return;
    memcpy(&word, memory, sizeof word);
    word ^= fault->flip;
    memcpy(memory, &word, sizeof word);
    uint32_t begin = address & ~0xfffu; /* translated code must be read anew */
    if (address < RT_DTCM_BEGIN) uc_ctl_remove_cache(engine->uc, begin, begin + 0x1000u);
}

void rt_engine_strike(rt_engine *engine)
{
    rt_fault *fault = &engine->chip->fault;
    fault->waits_for_engine = false;
    if (fault->kind == RT_FAULT_MEMORY) flip_memory(engine, fault);
    if (fault->kind == RT_FAULT_EXCEPTION) rt_engine_set_fault(engine, RT_BUS_FAULT, RT_CFSR_BUS);
    if (fault->kind == RT_FAULT_POWER && !fault->has_ended) rt_chip_reset(engine->chip, RT_RESET_POWER);
    if (fault->kind == RT_FAULT_POWER && fault->has_ended) rt_engine_power_cycle(engine);
}

/* --- what the processor uses --- */
static void note(uint8_t *bits, uint32_t offset)
{
    if (offset < RT_FLEXRAM_BYTES) bits[offset / 32] |= (uint8_t)(1u << offset / 4 % 8);
}

void rt_engine_note_code(rt_engine *engine, uint32_t address, uint32_t bytes)
{
    for (uint32_t i = 0; i < bytes; i += 2) note(engine->touched->code, address + i);
}

static void on_read(uc_engine *uc, uc_mem_type type, uint64_t address, int bytes, int64_t value,
                    void *context)
{
    (void)uc, (void)type, (void)bytes, (void)value;
    rt_engine *engine = context;
    if (engine->touched != NULL) note(engine->touched->data, (uint32_t)address - RT_DTCM_BEGIN);
}

bool rt_engine_watch(rt_engine *engine, rt_touched *touched)
{
    bool begins = touched != NULL && engine->touched == NULL;
    engine->touched = touched;
    if (touched == NULL) return uc_hook_del(engine->uc, engine->watch) == UC_ERR_OK;
    return !begins || uc_hook_add(engine->uc, &engine->watch, UC_HOOK_MEM_READ, (void *)(uintptr_t)on_read,
                                  engine, RT_DTCM_BEGIN, RT_DTCM_BEGIN + RT_FLEXRAM_BYTES - 1) == UC_ERR_OK;
}
