/* This program counts the instructions of crn_step(), and of the hash that is a part of it, on the Cortex-M7
 * (docs/bench.md, "budget"). The program reads a case, restores its state, and computes its ticks. It prints
 * mean, largest and smallest count, the number of second solves, and whether the state's hash equals the
 * PC's. usage (as semihosting arguments): budget_image CASE_FILE */
#include "firmware/bench/budget_case.h"
#include "firmware/core/motion.h"
#include "firmware/core/rod.h"
#include "firmware/port/console_digits.h"
#include "firmware/port/mps2_an500/semihost.h"
#include "firmware/port/mps2_an500/systick.h"

static uint8_t file[12 << 20] __attribute__((section(".scenes"), aligned(8)));
static uint8_t near_memory[BUDGET_NEAR_BYTES] __attribute__((aligned(32)));
static crn_lumen lumen;
static crn_model model;
static crn_state state;

static void write_number(const char *name, uint32_t value)
{
    char text[CONSOLE_DIGITS_BYTES];
    semihost_write(name);
    semihost_write(" ");
    semihost_write(console_digits(text, value));
    semihost_write("\n");
}

static int fail(const char *sentence)
{
    semihost_write(sentence);
    return 1;
}

typedef struct counts {
    uint32_t sum, most, least, most_twice, twice, contacts;
} counts;

/* Runs one tick between two readings of the instruction counter; a reading itself takes less than half a
 * count. */
static void __attribute__((noinline)) step(const crn_input *input, crn_output *output, counts *c)
{
    uint32_t start = systick_now();
    crn_step(&model, &state, input, output);
    uint32_t count = systick_since(start);
    c->sum += count;
    c->most = count > c->most ? count : c->most;
    c->least = count < c->least ? count : c->least;
    c->contacts = output->contact_count;
    if (output->solve_count > 1) {
        c->twice++;
        c->most_twice = count > c->most_twice ? count : c->most_twice;
    }
}

static uint32_t __attribute__((noinline)) count_hash(void)
{
    uint32_t lane[2], start = systick_now();
    crn_state_hash_lanes(&state, lane);
    return systick_since(start);
}

int main(int argc, char **argv)
{
    const budget_case *c = (const budget_case *)(const void *)file;
    if (argc != 2 || semihost_read_file(argv[1], file, sizeof file) < sizeof *c) {
        return fail("budget_image: give a case file of at most 12 MB\n");
    }
    if (!budget_build(c, &lumen, &model) || crn_lumen_near_bytes(&lumen) > BUDGET_NEAR_BYTES)
        return fail("budget_image: the core refuses the case\n");
    crn_lumen_near_begin(&lumen, NULL, NULL, near_memory, BUDGET_NEAR_BYTES);
    if (!crn_state_restore(&model, &state, budget_state(c)))
        return fail("budget_image: the core refuses the state\n");
    counts n = {0, 0, SYSTICK_MASK, 0, 0, 0};
    crn_output output = {0};
    systick_start();
    /* computes what a restored state lacks; not counted */
    crn_step(&model, &state, budget_inputs(c), &output);
    for (uint32_t tick = 1; tick < c->ticks; tick++) step(&budget_inputs(c)[tick], &output, &n);
    if (output.hash_lane[0] != c->hash_lane[0] || output.hash_lane[1] != c->hash_lane[1]) {
        return fail("budget_image: the state's hash is not the PC's\n");
    }
    write_number("ticks", c->ticks - 1);
    write_number("counts", n.sum);
    write_number("most", n.most * SYSTICK_INSTRUCTIONS_PER_COUNT);
    write_number("least", n.least * SYSTICK_INSTRUCTIONS_PER_COUNT);
    write_number("most_twice", n.most_twice * SYSTICK_INSTRUCTIONS_PER_COUNT);
    write_number("twice", n.twice);
    write_number("contacts", n.contacts);
    write_number("hash", count_hash() * SYSTICK_INSTRUCTIONS_PER_COUNT);
    return 0;
}
