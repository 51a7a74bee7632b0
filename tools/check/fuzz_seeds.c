/* This file contains the main function of every program `NAME_seeds`. A program `NAME_seeds` writes each
 * valid input of the fuzz target NAME into a separate file of a folder.
 *
 * Each fuzz target (fuzz_*.c) defines the function `size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t
 * capacity)`. The function fuzz_seed() writes the valid input number `index` into `bytes` and returns the
 * input's size, or 0 if there is no input with this number. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { SEED_BYTES_MAX = 4 << 20, SEED_COUNT_MAX = 1000 };

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

static int write_seed(const char *folder, unsigned index, const uint8_t *bytes, size_t size)
{
    char path[4096];
    int length = snprintf(path, sizeof(path), "%s/seed-%03u", folder, index);
    FILE *file = length > 0 && (size_t)length < sizeof(path) ? fopen(path, "wb") : NULL;
    if (file == NULL) {
        fprintf(stderr, "fuzz_seeds: cannot write seed %u into %s: does the folder exist?\n", index, folder);
        return 1;
    }
    size_t written = fwrite(bytes, 1, size, file);
    if (fclose(file) != 0 || written != size) {
        fprintf(stderr, "fuzz_seeds: %s is incomplete: is the disk full?\n", path);
        return 1;
    }
    return 0;
}

int main(int argc, char **argv)
{
    static uint8_t bytes[SEED_BYTES_MAX];
    if (argc != 2) {
        fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
        return 2;
    }
    for (unsigned index = 0; index < SEED_COUNT_MAX; index++) {
        size_t size = fuzz_seed(index, bytes, sizeof(bytes));
        if (size == 0) {
            return index == 0; /* a target without a single valid input would only fuzz the first check */
        }
        if (size > sizeof(bytes) || write_seed(argv[1], index, bytes, size) != 0) {
            return 1;
        }
    }
    return 0;
}
