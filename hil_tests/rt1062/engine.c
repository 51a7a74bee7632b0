/* Runs an image block by block: the hook at the begin of a block counts its instructions, lets the time pass
 * that they take, and stops when something is due. */
#include "hil_tests/rt1062/engine_internal.h"
#include "hil_tests/rt1062/rom.h"
#include <elf.h>
#include <stdlib.h>
#include <string.h>

enum {
    /* Code in the flash is fetched without a cache: command, address and waiting clocks of two reads (code,
     * and one word of data) at 60 MHz, then two clocks a byte. The ROM may prefetch, so this is the slowest
     * case. */
    FLASH_CLOCKS = 2 * 20 + 8,
    FLASH_CLOCKS_PER_BYTE = 2,
    FLASH_MHz = 60,
    ENDLESS_LOOP = 0xffff, /* in place of a count: a branch to itself */
    BRANCH_TO_ITSELF = 0xe7fe,
};

/* --- blocks --- */
static uint32_t count_instructions(const uint8_t *code, uint32_t bytes)
{
    uint32_t count = 0;
    for (uint32_t at = 0; at < bytes; count++) {
        uint32_t top = code[at + 1] >> 3;
        at += top == 0x1d || top == 0x1e || top == 0x1f ? 4 : 2;
    }
    return count;
}

static uint32_t instructions_of(rt_engine *engine, uint32_t address, uint32_t bytes)
{
    uint32_t slot = address >> 1 & (RT_COUNTS - 1);
    if (engine->counts[slot].address == address && engine->counts[slot].bytes == bytes)
        return engine->counts[slot].count;
    const uint8_t *code = rt_engine_memory(engine, address);
    uint32_t count = code == NULL ? 0 : count_instructions(code, bytes);
    if (count == 1 && bytes == 2 && (code[0] | code[1] << 8) == BRANCH_TO_ITSELF) count = ENDLESS_LOOP;
    engine->counts[slot].address = address;
    engine->counts[slot].bytes = (uint16_t)bytes;
    engine->counts[slot].count = (uint16_t)count;
    return count;
}

static bool is_unmasked(rt_engine *engine)
{
    return engine->is_held && (rt_engine_register(engine, UC_ARM_REG_PRIMASK) & 1u) == 0;
}

static void on_block(uc_engine *uc, uint64_t address, uint32_t bytes, void *context)
{
    rt_engine *engine = context;
    rt_chip *chip = engine->chip;
    if (chip->now >= engine->stop_at || chip->is_map_changed || chip->reset != RT_RESET_NONE ||
        is_unmasked(engine)) {
        uc_emu_stop(uc);
        return;
    }
    chip->pc = (uint32_t)address;
    if (engine->touched != NULL) rt_engine_note_code(engine, chip->pc, bytes);
    uint32_t count = instructions_of(engine, chip->pc, bytes);
    uint32_t executed = count == ENDLESS_LOOP ? 1 : count;
    engine->instructions += executed;
    chip->core.cycles += executed;
    chip->now += executed * chip->clocks.instants_per_cycle;
    if (chip->pc >= RT_FLASH_BEGIN) {
        uint64_t clocks = FLASH_CLOCKS + (uint64_t)FLASH_CLOCKS_PER_BYTE * bytes;
        chip->now += clocks * RT_INSTANTS_PER_us / FLASH_MHz;
    }
    bool waits = rt_usb_is_idle(chip) || count == ENDLESS_LOOP;
    if (waits && chip->now < engine->stop_at) { /* nothing happens until then */
        chip->core.cycles += (engine->stop_at - chip->now) / chip->clocks.instants_per_cycle;
        chip->now = engine->stop_at;
        chip->usb.idle_polls = 0;
        engine->idle_jumps++;
    }
}

/* --- boot --- */
static bool load(rt_chip *chip, const uint8_t *file, size_t bytes)
{
    Elf32_Ehdr header;
    if (bytes < sizeof header) return false;
    memcpy(&header, file, sizeof header);
    if (memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_machine != EM_ARM) return false;
    for (uint32_t i = 0; i < header.e_phnum; i++) {
        Elf32_Phdr part;
        if (header.e_phoff + (i + 1) * sizeof part > bytes) return false;
        memcpy(&part, file + header.e_phoff + i * sizeof part, sizeof part);
        if (part.p_type != PT_LOAD || part.p_filesz == 0) continue;
        uint32_t at = part.p_paddr - RT_FLASH_BEGIN;
        if (at > RT_FLASH_BYTES || part.p_filesz > RT_FLASH_BYTES - at ||
            part.p_offset + part.p_filesz > bytes)
            return false;
        memcpy(chip->flash + at, file + part.p_offset, part.p_filesz);
    }
    return true;
}

static uint8_t *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) return NULL;
    fseek(file, 0, SEEK_END);
    long length = ftell(file);
    rewind(file);
    uint8_t *content = length > 0 ? malloc((size_t)length) : NULL;
    *bytes = content != NULL ? fread(content, 1, (size_t)length, file) : 0;
    fclose(file);
    return content;
}

static bool boot(rt_engine *engine)
{
    rt_entry entry;
    const char *refusal = rt_rom_boot(engine->chip, &entry);
    rt_engine_map(engine);
    if (refusal != NULL) {
        snprintf(engine->trouble, sizeof engine->trouble, "the boot ROM refuses the flash: %s", refusal);
        return false;
    }
    rt_cache_clear(&engine->cache);
    engine->fault = 0;
    engine->returns = engine->is_held = false;
    rt_engine_set_register(engine, UC_ARM_REG_XPSR, 1u << 24);
    rt_engine_set_register(engine, UC_ARM_REG_PRIMASK, 0);
    rt_engine_set_register(engine, UC_ARM_REG_FAULTMASK, 0);
    rt_engine_set_register(engine, UC_ARM_REG_SP, entry.stack);
    rt_engine_set_register(engine, UC_ARM_REG_PC, entry.start);
    return true;
}

rt_engine *rt_engine_create(rt_chip *chip, const char *elf_path, const char **error)
{
    rt_engine *engine = calloc(1, sizeof *engine);
    *error = "there is no memory for the processor";
    if (engine == NULL) return NULL;
    engine->chip = chip;
    engine->guard.engine = engine->psram.engine = engine;
    engine->psram.begin = RT_PSRAM_BEGIN;
    engine->file = read_file(elf_path, &engine->file_bytes);
    uc_hook block;
    if (engine->file == NULL || !load(chip, engine->file, engine->file_bytes)) {
        *error = "the image is missing or is no ELF file for this flash: run `make firmware-board`";
    } else if (uc_open(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS, &engine->uc) != UC_ERR_OK ||
               uc_ctl_set_cpu_model(engine->uc, UC_CPU_ARM_CORTEX_M7) != UC_ERR_OK ||
               !rt_engine_map_registers(engine) || !rt_engine_count_lines(engine) ||
               !rt_engine_add_hooks(engine) ||
               uc_hook_add(engine->uc, &block, UC_HOOK_BLOCK, (void *)(uintptr_t)on_block, engine, 1, 0) !=
                   UC_ERR_OK) {
        *error = "libunicorn does not provide a Cortex-M7";
    } else {
        *error = NULL;
        engine->is_running = boot(engine);
        return engine;
    }
    rt_engine_destroy(engine);
    return NULL;
}

void rt_engine_destroy(rt_engine *engine)
{
    if (engine == NULL) return;
    if (engine->uc != NULL) uc_close(engine->uc);
    free(engine->file);
    free(engine);
}

void rt_engine_power_cycle(rt_engine *engine)
{
    rt_chip_reset(engine->chip, RT_RESET_POWER);
    engine->trouble[0] = '\0';
    engine->is_running = boot(engine);
}

/* --- run --- */
static bool run_slice(rt_engine *engine)
{
    uint32_t pc = rt_engine_register(engine, UC_ARM_REG_PC);
    uc_err error = uc_emu_start(engine->uc, pc | 1u, RT_NOWHERE, 0, 0);
    if (engine->returns) rt_engine_return(engine);
    if (error == UC_ERR_INSN_INVALID) rt_engine_set_fault(engine, RT_USAGE_FAULT, RT_CFSR_UNDEFINED);
    if (error != UC_ERR_OK && engine->fault == 0) {
        snprintf(engine->trouble, sizeof engine->trouble, "libunicorn stops at 0x%08x: %s", pc,
                 uc_strerror(error));
        return false;
    }
    return true;
}

rt_stop rt_engine_run(rt_engine *engine, uint64_t instant)
{
    rt_chip *chip = engine->chip;
    engine->run_end = instant;
    while (engine->is_running && chip->now < instant) {
        uint64_t next = rt_chip_run_due(chip);
        if (chip->reset != RT_RESET_NONE) {
            rt_chip_reset(chip, chip->reset);
            engine->is_running = boot(engine);
            return engine->is_running ? RT_STOP_RESET : RT_STOP_LOCKUP;
        }
        if (chip->fault.waits_for_engine) rt_engine_strike(engine);
        if (chip->is_map_changed) rt_engine_map(engine);
        if (rt_fault_core_stands(chip)) {
            uint64_t end = next < instant ? next : instant;
            chip->now = end > chip->now ? end : chip->now + 1;
            continue;
        }
        if (!rt_engine_take_exception(engine)) engine->is_running = false;
        engine->stop_at = next < instant ? next : instant;
        if (engine->is_running && !run_slice(engine)) engine->is_running = false;
    }
    if (!engine->is_running && chip->now < instant) { /* the rest of the board goes on */
        double us = (double)(instant - chip->now) / RT_INSTANTS_PER_us;
        rt_chip_pass_us(chip, us);
        if (chip->reset != RT_RESET_NONE) engine->is_running = true;
    }
    return engine->is_running ? RT_STOP_TIME : RT_STOP_LOCKUP;
}

rt_stop rt_engine_run_us(rt_engine *engine, double us)
{
    return rt_engine_run(engine, engine->chip->now + (uint64_t)(us * RT_INSTANTS_PER_us));
}

/* --- for reports and tests --- */
rt_chip *rt_engine_chip(rt_engine *engine)
{
    return engine->chip;
}

uint64_t rt_engine_idle_jumps(const rt_engine *engine)
{
    return engine->idle_jumps;
}

uint64_t rt_engine_instructions(const rt_engine *engine)
{
    return engine->instructions;
}

uint64_t rt_engine_cache_misses(const rt_engine *engine)
{
    return engine->cache.misses;
}

double rt_engine_busy_cycles(const rt_engine *engine)
{
    double waited = (double)engine->cache.instants / (double)engine->chip->clocks.instants_per_cycle;
    return (double)engine->instructions + waited;
}

const char *rt_engine_trouble(const rt_engine *engine)
{
    return engine->trouble;
}

uint32_t rt_engine_word(rt_engine *engine, uint32_t address)
{
    uint32_t value = 0;
    const uint8_t *memory = rt_engine_memory(engine, address);
    if (memory != NULL) memcpy(&value, memory, sizeof value);
    return value;
}

void rt_engine_patch(rt_engine *engine, uint32_t flash_address, uint16_t half)
{
    memcpy(engine->chip->flash + (flash_address - RT_FLASH_BEGIN), &half, sizeof half);
}
