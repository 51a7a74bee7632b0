/* The core alone, in the memories of the i.MX RT1062 (chip.ld), with a case of the budget (budget_case.h) in
 * the PSRAM. The program `chip` (tools/chip) calls these functions in an emulated Cortex-M7. */
#include "firmware/bench/budget_case.h"
#include "firmware/core/motion.h"

enum { CHIP_CASE_BYTES = 16 << 20 };

uint8_t chip_case[CHIP_CASE_BYTES] __attribute__((section(".scenes"), aligned(32)));
static uint8_t near_memory[BUDGET_NEAR_BYTES] __attribute__((section(".near"), aligned(32)));
static crn_lumen lumen;
static crn_model model __attribute__((section(".hot")));
static crn_state state __attribute__((section(".hot")));
static crn_output output;

uint32_t chip_start(void);
uint32_t chip_tick(uint32_t tick);

/* Returns 0 when the core refuses the case. */
uint32_t chip_start(void)
{
    const budget_case *c = (const budget_case *)(const void *)chip_case;
    if (!budget_build(c, &lumen, &model) || crn_lumen_near_bytes(&lumen) > BUDGET_NEAR_BYTES) return 0;
    crn_lumen_near_begin(&lumen, NULL, NULL, near_memory, BUDGET_NEAR_BYTES);
    return crn_state_restore(&model, &state, budget_state(c));
}

/* Returns 1 when the state after this tick has the hash that the PC computed after the case's last tick. */
uint32_t chip_tick(uint32_t tick)
{
    const budget_case *c = (const budget_case *)(const void *)chip_case;
    crn_step(&model, &state, &budget_inputs(c)[tick], &output);
    return output.hash_lane[0] == c->hash_lane[0] && output.hash_lane[1] == c->hash_lane[1];
}
