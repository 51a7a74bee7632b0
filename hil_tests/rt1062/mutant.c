#include "hil_tests/rt1062/chip.h"
#include <inttypes.h>
#include <stdlib.h>

void rt_mutant_take(rt_chip *chip)
{
    const char *text = getenv("RT_MUTANT");
    unsigned kind = 0;
    rt_mutant *mutant = &chip->mutant;
    if (getenv("RT_CENSUS") != NULL) chip->census = calloc(1, sizeof *chip->census);
    if (text == NULL) return;
    if (sscanf(text, "%u %" SCNx32 " %" SCNu32 " %" SCNu32, &kind, &mutant->address, &mutant->shift,
               &mutant->bits) == 4 &&
        kind < RT_MUTANT_KINDS)
        mutant->kind = (rt_mutant_kind)kind;
}

static uint32_t mask_of(const rt_mutant *mutant)
{
    return (mutant->bits >= 32 ? 0xffffffffu : (1u << mutant->bits) - 1u) << mutant->shift;
}

void rt_mutant_reset(rt_chip *chip)
{
    static rt_word words[RT_WORDS_MAX];
    const rt_mutant *mutant = &chip->mutant;
    if (mutant->kind != RT_MUTANT_RESET) return;
    if (mutant->address < rt_fault_words(chip, words)) rt_word_flip(&words[mutant->address], mask_of(mutant));
}

static uint32_t changed(const rt_mutant *mutant, uint32_t value, int how)
{
    uint32_t mask = mask_of(mutant), one = 1u << mutant->shift;
    switch (how) {
    case RT_MUTANT_READ_CLEAR:
        return value & ~mask;
    case RT_MUTANT_READ_SET:
        return value | mask;
    case RT_MUTANT_READ_FLIP:
        return value ^ mask;
    default:
        return (value & ~mask) | ((value + one) & mask);
    }
}

uint32_t rt_mutant_read(const rt_chip *chip, uint32_t address, uint32_t value)
{
    const rt_mutant *mutant = &chip->mutant;
    bool is_here = mutant->kind >= RT_MUTANT_READ_CLEAR && mutant->kind <= RT_MUTANT_READ_MORE &&
                   mutant->address == address;
    return is_here ? changed(mutant, value, (int)mutant->kind) : value;
}

bool rt_mutant_write(const rt_chip *chip, uint32_t address, uint32_t *value)
{
    const rt_mutant *mutant = &chip->mutant;
    if (mutant->kind < RT_MUTANT_WRITE_CLEAR || mutant->kind > RT_MUTANT_WRITE_LOST ||
        mutant->address != address)
        return true;
    static const int how[] = {RT_MUTANT_READ_CLEAR, RT_MUTANT_READ_SET, RT_MUTANT_READ_MORE};
    if (mutant->kind == RT_MUTANT_WRITE_LOST) return false;
    *value = changed(mutant, *value, how[mutant->kind - RT_MUTANT_WRITE_CLEAR]);
    return true;
}

uint64_t rt_mutant_time(const rt_chip *chip, rt_duration which, uint64_t instants)
{
    const rt_mutant *mutant = &chip->mutant;
    if (mutant->address != (uint32_t)which || instants == RT_NEVER) return instants;
    if (mutant->kind == RT_MUTANT_EARLY) return instants / 4;
    return mutant->kind == RT_MUTANT_LATE ? 4 * instants : instants;
}

void rt_mutant_write_census(const rt_chip *chip)
{
    const char *path = getenv("RT_CENSUS");
    FILE *file = path != NULL && chip->census != NULL ? fopen(path, "a") : NULL;
    if (file == NULL) return;
    static rt_word words[RT_WORDS_MAX];
    const rt_census *census = chip->census;
    rt_chip *fresh = rt_chip_create();
    uint32_t count = fresh != NULL ? rt_fault_words(fresh, words) : 0;
    for (uint32_t i = 0; i < count; i++) fprintf(file, "word %" PRIu32 " %s\n", i, words[i].part);
    if (fresh != NULL) free(fresh->census), fresh->census = NULL;
    rt_chip_destroy(fresh);
    for (uint32_t i = 0; i < census->count; i++)
        fprintf(file,
                "%08" PRIx32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %08" PRIx32 " %08" PRIx32 " %08" PRIx32
                " %08" PRIx32 "\n",
                census->registers[i].address, census->registers[i].bytes, census->registers[i].reads,
                census->registers[i].writes, census->registers[i].ones, census->registers[i].zeros,
                census->registers[i].written_ones, census->registers[i].written_zeros);
    fclose(file);
    free(chip->census);
}
