/* The processor's view of the memories, as FlexRAM banks, MPU and FlexSPI2 allow it. Memories are mapped at
 * once; two regions are emulated access by access: the page with the guard below the stack (its region is
 * smaller than a page), and the PSRAM, until lines of it can be cached. */
#include "hil_tests/rt1062/engine_internal.h"
#include <string.h>

enum { PAGE_BYTES = 4096, REGISTERS_BYTES = 0x04000000, PRIVATE_BYTES = 0x100000, MPU_SMALL_BELOW_log2 = 12 };
#define REGISTERS 0x40000000u
#define PRIVATE 0xe0000000u

uint8_t *rt_engine_memory(const rt_engine *engine, uint32_t address)
{
    const rt_chip *chip = engine->chip;
    uint32_t data = rt_dtcm_bytes(chip);
    if (address < rt_itcm_bytes(chip)) return chip->flexram + address;
    if (address - RT_DTCM_BEGIN < data)
        return chip->flexram + (RT_FLEXRAM_BYTES - data) + (address - RT_DTCM_BEGIN);
    if (address - RT_OCRAM_BEGIN < RT_OCRAM_BYTES) return chip->ocram + (address - RT_OCRAM_BEGIN);
    if (address - RT_FLASH_BEGIN < RT_FLASH_BYTES) return chip->flash + (address - RT_FLASH_BEGIN);
    if (address - RT_PSRAM_BEGIN < RT_PSRAM_BYTES) return chip->psram.memory + (address - RT_PSRAM_BEGIN);
    return NULL;
}

/* --- regions that are emulated --- */
static bool reach(const rt_emulated *region, uint32_t address, unsigned bytes, bool is_write, uint32_t *value)
{
    rt_engine *engine = region->engine;
    rt_chip *chip = engine->chip;
    if (!rt_mpu_allows(chip, address, is_write ? RT_ACCESS_WRITE : RT_ACCESS_READ)) {
        rt_engine_set_fault(engine, RT_MEMORY_FAULT, RT_CFSR_DATA);
        return false;
    }
    if (region != &engine->psram) {
        uint8_t *memory = rt_engine_memory(engine, address);
        memcpy(is_write ? memory : (uint8_t *)value, is_write ? (const uint8_t *)value : memory, bytes);
        return true;
    }
    bool is_good = rt_flexspi_access(chip, address, bytes, is_write, value);
    if (!is_good) rt_engine_set_fault(engine, RT_BUS_FAULT, RT_CFSR_BUS);
    chip->now += chip->flexspi.access_instants;
    return is_good;
}

static uint64_t read_emulated(uc_engine *uc, uint64_t offset, unsigned bytes, void *context)
{
    (void)uc;
    const rt_emulated *region = context;
    uint32_t value = 0;
    reach(region, region->begin + (uint32_t)offset, bytes, false, &value);
    return value;
}

static void write_emulated(uc_engine *uc, uint64_t offset, unsigned bytes, uint64_t word, void *context)
{
    (void)uc;
    const rt_emulated *region = context;
    uint32_t value = (uint32_t)word;
    reach(region, region->begin + (uint32_t)offset, bytes, true, &value);
}

/* --- registers --- */
static uint64_t read_register(rt_engine *engine, uint32_t address, unsigned bytes)
{
    if (rt_fault_is_bus_error(engine->chip, address)) {
        if (!rt_engine_ignores_bus_errors(engine)) rt_engine_set_fault(engine, RT_BUS_FAULT, RT_CFSR_BUS);
        return 0;
    }
    return rt_chip_read(engine->chip, address, bytes);
}

/* A write may start a timer, so what is due next is found anew. */
static void write_register(rt_engine *engine, uint32_t address, unsigned bytes, uint32_t value)
{
    if (rt_fault_is_bus_error(engine->chip, address)) {
        if (!rt_engine_ignores_bus_errors(engine)) rt_engine_set_fault(engine, RT_BUS_FAULT, RT_CFSR_BUS);
        return;
    }
    rt_chip_write(engine->chip, address, bytes, value);
    uint64_t next = rt_chip_run_due(engine->chip);
    if (engine->stop_at != 0) engine->stop_at = next < engine->run_end ? next : engine->run_end;
}

static uint64_t read_peripheral(uc_engine *uc, uint64_t offset, unsigned bytes, void *context)
{
    (void)uc;
    return read_register(context, REGISTERS + (uint32_t)offset, bytes);
}

static void write_peripheral(uc_engine *uc, uint64_t offset, unsigned bytes, uint64_t value, void *context)
{
    (void)uc;
    write_register(context, REGISTERS + (uint32_t)offset, bytes, (uint32_t)value);
}

static uint64_t read_private(uc_engine *uc, uint64_t offset, unsigned bytes, void *context)
{
    (void)uc;
    return read_register(context, PRIVATE + (uint32_t)offset, bytes);
}

static void write_private(uc_engine *uc, uint64_t offset, unsigned bytes, uint64_t value, void *context)
{
    (void)uc;
    write_register(context, PRIVATE + (uint32_t)offset, bytes, (uint32_t)value);
}

bool rt_engine_map_registers(rt_engine *engine)
{
    uc_err error = uc_mmio_map(engine->uc, REGISTERS, REGISTERS_BYTES, read_peripheral, engine,
                               write_peripheral, engine);
    if (error == UC_ERR_OK)
        error = uc_mmio_map(engine->uc, PRIVATE, PRIVATE_BYTES, read_private, engine, write_private, engine);
    return error == UC_ERR_OK;
}

/* --- the cache's time --- */
static void on_cached(uc_engine *uc, uc_mem_type type, uint64_t address, int bytes, int64_t value,
                      void *context)
{
    (void)uc, (void)bytes, (void)value;
    rt_engine *engine = context;
    if (!rt_core_has_data_cache(engine->chip) || !rt_mpu_is_cached(engine->chip, (uint32_t)address)) return;
    rt_cache_access(&engine->cache, engine->chip, (uint32_t)address, type == UC_MEM_WRITE);
}

bool rt_engine_count_lines(rt_engine *engine)
{
    uc_hook hook;
    const uint32_t kinds = UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE;
    void *call = (void *)(uintptr_t)on_cached;
    return uc_hook_add(engine->uc, &hook, (int)kinds, call, engine, RT_PSRAM_BEGIN,
                       RT_PSRAM_BEGIN + RT_PSRAM_BYTES - 1) == UC_ERR_OK &&
           uc_hook_add(engine->uc, &hook, (int)kinds, call, engine, RT_OCRAM_BEGIN,
                       RT_OCRAM_BEGIN + RT_OCRAM_BYTES - 1) == UC_ERR_OK;
}

/* --- memories --- */
static uint32_t rights_of(const rt_chip *chip, uint32_t address)
{
    return (rt_mpu_allows(chip, address, RT_ACCESS_READ) ? UC_PROT_READ : 0u) |
           (rt_mpu_allows(chip, address, RT_ACCESS_WRITE) ? UC_PROT_WRITE : 0u) |
           (rt_mpu_allows(chip, address, RT_ACCESS_CODE) ? UC_PROT_EXEC : 0u);
}

static void add(const rt_engine *engine, rt_map *maps, uint32_t *count, uint32_t begin, uint32_t bytes,
                bool emulated)
{
    if (bytes == 0) return;
    maps[(*count)++] = (rt_map){begin, bytes, rights_of(engine->chip, begin),
                                emulated ? NULL : rt_engine_memory(engine, begin)};
}

/* The page with a protected region that is smaller than a page; 0: none. */
static uint32_t guarded_page(const rt_core *core)
{
    if ((core->mpu_control & 1u) == 0) return 0;
    for (uint32_t i = 0; i < RT_MPU_REGIONS; i++) {
        bool is_small = (core->size[i] & 1u) != 0 && (core->size[i] >> 1 & 31u) + 1 < MPU_SMALL_BELOW_log2;
        if (is_small) return core->begin[i] & ~(PAGE_BYTES - 1u);
    }
    return 0;
}

static uint32_t wanted(rt_engine *engine, rt_map *maps)
{
    rt_chip *chip = engine->chip;
    uint32_t count = 0, data = rt_dtcm_bytes(chip), guard = guarded_page(&chip->core),
             end = RT_DTCM_BEGIN + data;
    bool in_lines =
        rt_core_has_data_cache(chip) && rt_mpu_is_cached(chip, RT_PSRAM_BEGIN) && rt_flexspi_is_sound(chip);
    memset(maps, 0, RT_MAPS_MAX * sizeof *maps);
    add(engine, maps, &count, 0, rt_itcm_bytes(chip), false);
    if (guard >= RT_DTCM_BEGIN && guard < end) {
        engine->guard.begin = guard;
        add(engine, maps, &count, RT_DTCM_BEGIN, guard - RT_DTCM_BEGIN, false);
        add(engine, maps, &count, guard, PAGE_BYTES, true);
        add(engine, maps, &count, guard + PAGE_BYTES, end - guard - PAGE_BYTES, false);
    } else {
        add(engine, maps, &count, RT_DTCM_BEGIN, data, false);
    }
    add(engine, maps, &count, RT_OCRAM_BEGIN, RT_OCRAM_BYTES, false);
    add(engine, maps, &count, RT_FLASH_BEGIN, RT_FLASH_BYTES, false);
    add(engine, maps, &count, RT_PSRAM_BEGIN, RT_PSRAM_BYTES, !in_lines);
    return count;
}

void rt_engine_map(rt_engine *engine)
{
    rt_map maps[RT_MAPS_MAX];
    engine->chip->is_map_changed = false;
    uint32_t count = wanted(engine, maps);
    if (count == engine->map_count && memcmp(maps, engine->maps, sizeof maps) == 0) return;
    for (uint32_t i = 0; i < engine->map_count; i++)
        uc_mem_unmap(engine->uc, engine->maps[i].begin, engine->maps[i].bytes);
    for (uint32_t i = 0; i < count; i++) {
        const rt_map *map = &maps[i];
        rt_emulated *region = map->begin == RT_PSRAM_BEGIN ? &engine->psram : &engine->guard;
        uc_err error = map->memory != NULL
                           ? uc_mem_map_ptr(engine->uc, map->begin, map->bytes, map->rights, map->memory)
                           : uc_mmio_map(engine->uc, map->begin, map->bytes, read_emulated, region,
                                         write_emulated, region);
        if (error != UC_ERR_OK)
            snprintf(engine->trouble, sizeof engine->trouble, "0x%08x cannot be mapped: %s", map->begin,
                     uc_strerror(error));
    }
    memcpy(engine->maps, maps, sizeof maps);
    engine->map_count = count;
}
