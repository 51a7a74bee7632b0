/* Symbols of the image, so that reports name functions in place of addresses. */
#include "hil_tests/rt1062/engine_internal.h"
#include <elf.h>
#include <string.h>

/* Calls `visit` for every symbol of the image until it returns true. */
typedef bool visitor(void *context, const char *name, const Elf32_Sym *symbol);

static void visit_symbols(const rt_engine *engine, visitor *visit, void *context)
{
    Elf32_Ehdr header;
    memcpy(&header, engine->file, sizeof header);
    for (uint32_t i = 0; i < header.e_shnum; i++) {
        Elf32_Shdr table, names;
        memcpy(&table, engine->file + header.e_shoff + i * sizeof table, sizeof table);
        if (table.sh_type != SHT_SYMTAB) continue;
        memcpy(&names, engine->file + header.e_shoff + table.sh_link * sizeof names, sizeof names);
        for (uint32_t k = 0; k < table.sh_size / sizeof(Elf32_Sym); k++) {
            Elf32_Sym symbol;
            memcpy(&symbol, engine->file + table.sh_offset + k * sizeof symbol, sizeof symbol);
            if (visit(context, (const char *)engine->file + names.sh_offset + symbol.st_name, &symbol))
                return;
        }
    }
}

typedef struct search {
    const char *name;
    uint32_t address, distance;
} search;

static bool has_name(void *context, const char *name, const Elf32_Sym *symbol)
{
    search *found = context;
    if (strcmp(name, found->name) != 0) return false;
    found->address = symbol->st_value;
    return true;
}

uint32_t rt_engine_symbol(const rt_engine *engine, const char *name)
{
    search found = {.name = name};
    visit_symbols(engine, has_name, &found);
    return found.address;
}

static bool is_nearer(void *context, const char *name, const Elf32_Sym *symbol)
{
    search *found = context;
    uint32_t begin = symbol->st_value & ~1u;
    bool is_function = ELF32_ST_TYPE(symbol->st_info) == STT_FUNC && begin <= found->address;
    if (!is_function || found->address - begin > found->distance) return false;
    found->name = name;
    found->distance = found->address - begin;
    return false;
}

const char *rt_engine_place(void *context, uint32_t pc)
{
    rt_engine *engine = context;
    search found = {.name = "?", .address = pc, .distance = UINT32_MAX};
    visit_symbols(engine, is_nearer, &found);
    snprintf(engine->place, sizeof engine->place, "%s+0x%x", found.name, found.distance);
    return engine->place;
}
