/* Faults and interrupts of the processor (ARMv7-M architecture reference manual, B1.5, from memory). An
 * exception is taken between two blocks of code: the program counter in its frame is that of the block's
 * begin, and what a faulting block did before its fault is done again by no one, because every fault of the
 * image is final. */
#include "hil_tests/rt1062/engine_internal.h"
#include <string.h>

enum {
    FRAME_WORDS = 8,
    EXCEPTION_EXIT = 8, /* libunicorn: the processor has loaded EXC_RETURN into its program counter */
    XPSR_ALIGNED = 1 << 9,
    XPSR_EXCEPTION = 0x1ff,
    XPSR_IN_BLOCK = 0x0600fc00,
};
#define EXC_RETURN_THREAD 0xfffffff9u

uint32_t rt_engine_register(rt_engine *engine, int number)
{
    uint32_t value = 0;
    uc_reg_read(engine->uc, number, &value);
    return value;
}

void rt_engine_set_register(rt_engine *engine, int number, uint32_t value)
{
    uc_reg_write(engine->uc, number, &value);
}

void rt_engine_set_fault(rt_engine *engine, int exception, uint32_t status)
{
    if (engine->fault != 0) return;
    engine->fault = exception;
    engine->fault_status = status;
    engine->stop_at = 0;
}

/* BFHFNMIGN: a handler with FAULTMASK, and the hard fault's, may go on after a bus error of their data. */
bool rt_engine_ignores_bus_errors(rt_engine *engine)
{
    enum { IGNORE = 1 << 8 };
    uint32_t running = rt_engine_register(engine, UC_ARM_REG_XPSR) & XPSR_EXCEPTION;
    bool is_above = running == RT_HARD_FAULT || (rt_engine_register(engine, UC_ARM_REG_FAULTMASK) & 1u) != 0;
    return is_above && (engine->chip->core.ccr & IGNORE) != 0;
}

static bool enters(rt_engine *engine, int exception)
{
    static const int saved[FRAME_WORDS] = {UC_ARM_REG_R0,  UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3,
                                           UC_ARM_REG_R12, UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_XPSR};
    rt_chip *chip = engine->chip;
    uint32_t frame[FRAME_WORDS], stack = rt_engine_register(engine, UC_ARM_REG_SP), handler;
    for (int i = 0; i < FRAME_WORDS; i++) frame[i] = rt_engine_register(engine, saved[i]);
    frame[6] &= ~1u;
    frame[7] = (frame[7] & ~(uint32_t)XPSR_ALIGNED) | (stack & 4u ? XPSR_ALIGNED : 0);
    stack = (stack & ~7u) - 4 * FRAME_WORDS;
    uint8_t *memory = rt_engine_memory(engine, stack);
    bool fits = memory != NULL && rt_mpu_allows(chip, stack, RT_ACCESS_WRITE) &&
                rt_mpu_allows(chip, stack + 4 * FRAME_WORDS - 4, RT_ACCESS_WRITE);
    if (fits)
        memcpy(memory, frame, sizeof frame);
    else
        chip->core.cfsr |= RT_CFSR_STACKING;
    const uint8_t *vector = rt_engine_memory(engine, chip->core.vtor + 4u * (uint32_t)exception);
    if (vector == NULL) return false;
    memcpy(&handler, vector, sizeof handler);
    if ((handler & 1u) == 0) return false;
    rt_engine_set_register(engine, UC_ARM_REG_SP, stack);
    rt_engine_set_register(engine, UC_ARM_REG_LR, EXC_RETURN_THREAD);
    rt_engine_set_register(engine, UC_ARM_REG_XPSR,
                           (frame[7] & ~(uint32_t)(XPSR_EXCEPTION | XPSR_IN_BLOCK)) | (uint32_t)exception);
    rt_engine_set_register(engine, UC_ARM_REG_PC, handler);
    return true;
}

void rt_engine_return(rt_engine *engine)
{
    static const int saved[FRAME_WORDS - 2] = {UC_ARM_REG_R0, UC_ARM_REG_R1,  UC_ARM_REG_R2,
                                               UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR};
    uint32_t frame[FRAME_WORDS], stack = rt_engine_register(engine, UC_ARM_REG_SP);
    const uint8_t *memory = rt_engine_memory(engine, stack);
    engine->returns = false;
    if (memory == NULL) return;
    memcpy(frame, memory, sizeof frame);
    rt_engine_set_register(engine, UC_ARM_REG_XPSR, frame[7] & ~(uint32_t)XPSR_ALIGNED);
    for (int i = 0; i < FRAME_WORDS - 2; i++) rt_engine_set_register(engine, saved[i], frame[i]);
    rt_engine_set_register(engine, UC_ARM_REG_SP,
                           stack + 4 * FRAME_WORDS + (frame[7] & XPSR_ALIGNED ? 4 : 0));
    rt_engine_set_register(engine, UC_ARM_REG_PC, frame[6] | 1u);
}

static bool take_fault(rt_engine *engine)
{
    rt_chip *chip = engine->chip;
    int exception = engine->fault;
    bool is_enabled = (chip->core.shcsr >> (16 + exception - RT_MEMORY_FAULT) & 1u) != 0;
    chip->core.cfsr |= engine->fault_status;
    engine->fault = 0;
    uint32_t running = rt_engine_register(engine, UC_ARM_REG_XPSR) & XPSR_EXCEPTION;
    bool is_fatal = running != 0 && running < RT_INTERRUPT_0; /* a fault within a fault */
    if (!is_fatal && enters(engine, is_enabled ? exception : RT_HARD_FAULT)) return true;
    snprintf(engine->trouble, sizeof engine->trouble,
             "the processor locks up: exception %d at 0x%08x, status 0x%x", exception, chip->pc,
             chip->core.cfsr);
    return false;
}

bool rt_engine_take_exception(rt_engine *engine)
{
    if (engine->fault != 0) return take_fault(engine);
    int interrupt = rt_chip_interrupt(engine->chip);
    engine->is_held = false;
    if (interrupt < 0) return true;
    bool in_handler = (rt_engine_register(engine, UC_ARM_REG_XPSR) & XPSR_EXCEPTION) != 0;
    bool is_masked = (rt_engine_register(engine, UC_ARM_REG_PRIMASK) & 1u) != 0;
    engine->is_held = is_masked && !in_handler; /* until the mask is taken away */
    if (is_masked || in_handler) return true;
    if (rt_fault_is(&engine->chip->fault, RT_FAULT_INTERRUPT)) engine->chip->fault.has_ended = true;
    return enters(engine, RT_INTERRUPT_0 + interrupt);
}

/* --- hooks --- */
static bool on_invalid(uc_engine *uc, uc_mem_type type, uint64_t address, int bytes, int64_t value,
                       void *context)
{
    (void)uc, (void)bytes, (void)value;
    rt_engine *engine = context;
    bool is_code = type == UC_MEM_FETCH_UNMAPPED || type == UC_MEM_FETCH_PROT;
    bool is_protected = type == UC_MEM_FETCH_PROT || type == UC_MEM_READ_PROT || type == UC_MEM_WRITE_PROT;
    bool is_forbidden = is_protected || !rt_mpu_allows(engine->chip, (uint32_t)address,
                                                       is_code ? RT_ACCESS_CODE : RT_ACCESS_READ);
    rt_engine_set_fault(engine, is_forbidden ? RT_MEMORY_FAULT : RT_BUS_FAULT,
                        !is_forbidden ? RT_CFSR_BUS
                        : is_code     ? RT_CFSR_CODE
                                      : RT_CFSR_DATA);
    return false;
}

static void on_interrupt(uc_engine *uc, uint32_t number, void *context)
{
    rt_engine *engine = context;
    if (number == EXCEPTION_EXIT)
        engine->returns = true;
    else
        rt_engine_set_fault(engine, RT_USAGE_FAULT, RT_CFSR_UNDEFINED);
    uc_emu_stop(uc);
}

bool rt_engine_add_hooks(rt_engine *engine)
{
    uc_hook invalid, interrupt;
    return uc_hook_add(engine->uc, &invalid, UC_HOOK_MEM_INVALID, (void *)(uintptr_t)on_invalid, engine, 1,
                       0) == UC_ERR_OK &&
           uc_hook_add(engine->uc, &interrupt, UC_HOOK_INTR, (void *)(uintptr_t)on_interrupt, engine, 1, 0) ==
               UC_ERR_OK;
}
