/* This port has never run on hardware. Each of the six motors has a pulse-width signal (20 kHz) from FlexPWM2
 * or FlexPWM3, and a direction line. The fault line (pin 5) is low at over-current, or when the line's cable
 * is broken. A low level of the fault line turns all outputs off in the PWM unit's own logic, which needs
 * neither a clock nor the processor. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum {
    MOTORS = 2 * CRN_PORT_TOOL_MAX, /* motor 2 k: axial of track k; motor 2 k + 1: its rotation */
    PERIOD_counts = BOARD_PERIPHERAL_HZ / 20000,
    SUBMODULE_BYTES = PWM_STRIDE_SMCTRL,
    FAULT_INPUT = 1, /* bit of fault 0 */
    FAULT_FILTER_SAMPLES = 0,
    FAULT_FILTER_CLOCKS = 0, /* off: the comparator in front of it decides */
    CROSSBAR_FAULT_LINE = 17,
    CROSSBAR_PWM2_FAULT0 = 49,
    CROSSBAR_PWM3_FAULT0 = 56,
    DIRECTION_BIT = 12, /* bit of GPIO3 for axial 1; the others follow */
};

static const struct output {
    uint32_t base, submodule;
    bool is_b;
} outputs[MOTORS] = {
    {BASE_PWM2, 2, false}, {BASE_PWM2, 2, true},  {BASE_PWM2, 3, false},
    {BASE_PWM2, 3, true},  {BASE_PWM3, 1, false}, {BASE_PWM3, 1, true},
};

static void connect_fault(uint32_t output)
{
    volatile uint16_t *select = &R16(BASE_XBARA1, XBARA_SEL0 + (output & ~1u));
    uint32_t shift = output % 2 * 8;
    *select = (uint16_t)((*select & ~(0x7fu << shift)) | (uint32_t)CROSSBAR_FAULT_LINE << shift);
}

static void start_submodule(uint32_t base, uint32_t submodule)
{
    uint32_t at = base + submodule * SUBMODULE_BYTES;
    R16(at, PWM_SMCTRL2_0) = (uint16_t)MASK(PWM_SMCTRL2_0_INDEP);
    R16(at, PWM_SMCTRL_0) = (uint16_t)MASK(PWM_SMCTRL_0_FULL);
    R16(at, PWM_SMINIT_0) = 0;
    R16(at, PWM_SMVAL1_0) = PERIOD_counts - 1;
    R16(at, PWM_SMVAL2_0) = R16(at, PWM_SMVAL3_0) = 0;
    R16(at, PWM_SMVAL4_0) = R16(at, PWM_SMVAL5_0) = 0;
    R16(at, PWM_SMDISMAP0_0) =
        (uint16_t)(BITS(PWM_SMDISMAP0_0_DIS0A, FAULT_INPUT) | BITS(PWM_SMDISMAP0_0_DIS0B, FAULT_INPUT) |
                   BITS(PWM_SMDISMAP0_0_DIS0X, FAULT_INPUT));
}

static void start_module(uint32_t base, uint32_t submodules)
{
    R16(base, PWM_OUTEN) = 0;
    R16(base, PWM_FFILT0) = (uint16_t)(BITS(PWM_FFILT0_FILT_CNT, FAULT_FILTER_SAMPLES) |
                                       BITS(PWM_FFILT0_FILT_PER, FAULT_FILTER_CLOCKS));
    /* A low level of the fault line counts as a fault. The PWM unit keeps a fault until software clears it,
     * which is impossible while the fault line is low. */
    R16(base, PWM_FCTRL0) = (uint16_t)(BITS(PWM_FCTRL0_FLVL, 0) | BITS(PWM_FCTRL0_FAUTO, 0) |
                                       BITS(PWM_FCTRL0_FSAFE, FAULT_INPUT));
    for (uint32_t i = 0; i < 4; i++) {
        if (submodules >> i & 1u) start_submodule(base, i);
    }
    R16(base, PWM_FSTS0) = (uint16_t)(BITS(PWM_FSTS0_FFULL, FAULT_INPUT) | BITS(PWM_FSTS0_FFLAG, 15));
    R16(base, PWM_MCTRL) |= (uint16_t)BITS(PWM_MCTRL_LDOK, submodules);
    R16(base, PWM_MCTRL) |= (uint16_t)BITS(PWM_MCTRL_RUN, submodules);
}

void motors_start(void)
{
    connect_fault(CROSSBAR_PWM2_FAULT0);
    connect_fault(CROSSBAR_PWM3_FAULT0);
    R32(BASE_GPIO3, GPIO_DR_CLEAR) = ((1u << MOTORS) - 1u) << DIRECTION_BIT;
    R32(BASE_GPIO3, GPIO_GDIR) |= ((1u << MOTORS) - 1u) << DIRECTION_BIT;
    start_module(BASE_PWM2, 1u << 2 | 1u << 3);
    start_module(BASE_PWM3, 1u << 1);
}

/* Whatever the app's memory and code have become, no duty orders more than `most`. */
/* Requirement: SR-28 */
static void write_one(uint32_t motor, int32_t value, int32_t most, int32_t full)
{
    const struct output *output = &outputs[motor];
    uint32_t at = output->base + output->submodule * SUBMODULE_BYTES, bit = 1u << output->submodule;
    if (value > most) value = most;
    if (value < -most) value = -most;
    uint32_t duty = (uint32_t)(value < 0 ? -value : value) * PERIOD_counts / (uint32_t)full;
    uint32_t pin = 1u << (DIRECTION_BIT + motor);
    if (value < 0) {
        R32(BASE_GPIO3, GPIO_DR_SET) = pin;
    } else {
        R32(BASE_GPIO3, GPIO_DR_CLEAR) = pin;
    }
    R16(output->base, PWM_MCTRL) |= (uint16_t)BITS(PWM_MCTRL_CLDOK, bit);
    if (output->is_b) {
        R16(at, PWM_SMVAL5_0) = (uint16_t)duty;
    } else {
        R16(at, PWM_SMVAL3_0) = (uint16_t)duty;
    }
    R16(output->base, PWM_MCTRL) |= (uint16_t)BITS(PWM_MCTRL_LDOK, bit);
    uint16_t enable = (uint16_t)(output->is_b ? BITS(PWM_OUTEN_PWMB_EN, bit) : BITS(PWM_OUTEN_PWMA_EN, bit));
    if (duty != 0) {
        R16(output->base, PWM_OUTEN) |= enable;
    } else {
        R16(output->base, PWM_OUTEN) &= (uint16_t)~enable;
    }
}

void motors_write(const crn_port_motor motors[CRN_PORT_TOOL_MAX])
{
    _Static_assert((uint64_t)BOARD_AXIAL_FULL_mN * PERIOD_counts < UINT32_MAX &&
                       (uint64_t)BOARD_TORQUE_FULL_uN_m * PERIOD_counts < UINT32_MAX,
                   "the product of force and period fits");
    _Static_assert((int)BOARD_AXIAL_MAX_mN <= (int)BOARD_AXIAL_FULL_mN &&
                       (int)BOARD_TORQUE_MAX_uN_m <= (int)BOARD_TORQUE_FULL_uN_m,
                   "a duty is at most the whole period");
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        write_one(2 * k, motors[k].axial_mN, BOARD_AXIAL_MAX_mN, BOARD_AXIAL_FULL_mN);
        write_one(2 * k + 1, motors[k].torque_uN_m, BOARD_TORQUE_MAX_uN_m, BOARD_TORQUE_FULL_uN_m);
    }
}

void motors_off(void)
{
    R16(BASE_PWM2, PWM_OUTEN) = 0;
    R16(BASE_PWM3, PWM_OUTEN) = 0;
}

bool motors_fault(void)
{
    /* An edge of the line sets the flag. A line that has been low since before motors_start() makes no edge,
     * so its level counts, too. */
    uint32_t flags = R16(BASE_PWM2, PWM_FSTS0) | R16(BASE_PWM3, PWM_FSTS0);
    return (flags & (BITS(PWM_FSTS0_FFLAG, FAULT_INPUT) | BITS(PWM_FSTS0_FFPIN, FAULT_INPUT))) != 0;
}

static void clear_fault(uint32_t base)
{
    uint16_t keep = (uint16_t)BITS(PWM_FSTS0_FFULL, FAULT_INPUT);
    R16(base, PWM_FSTS0) = (uint16_t)(keep | BITS(PWM_FSTS0_FFLAG, FAULT_INPUT));
}

void motors_clear_fault(void)
{
    clear_fault(BASE_PWM2);
    clear_fault(BASE_PWM3);
}
