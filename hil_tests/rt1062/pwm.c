/* FlexPWM2 and FlexPWM3 with their fault input 0. The values of a submodule are buffered: LDOK lets them act
 * at the next reload, which the model does at once. The fault input turns outputs off without a clock; they
 * come back only when the flag has been cleared and the input has gone (FSAFE 1, FAUTO 0). FFLAG is set by an
 * edge of the input, so it can be cleared while the fault lasts; FFPIN shows the input itself. Behaviour:
 * reference manual, chapter eFlexPWM, from memory; FSAFE and FAUTO as the public register description of the
 * later RT1176 says. */
#include "hil_tests/rt1062/chip.h"

enum {
    GATE_PWM2 = 9, /* of CCGR4 */
    CROSSBAR_PIN = 17,
    FAULT0 = 1,
    CLEARS_LDOK_SHIFT = 4,
};
static const uint32_t crossbar_fault[RT_PWM_MODULES] = {49, 56};

/* True while the fault input of the module is active. An input that is not connected reads 0 (input 0 of the
 * crossbar is the constant low level), which is a fault if FLVL is 0. */
static bool input_is_active(rt_chip *chip, uint32_t module)
{
    int input = rt_crossbar_input(chip, crossbar_fault[module]);
    bool level = input == CROSSBAR_PIN ? rt_pin_level(chip, RT_PIN_FAULT) : false;
    bool active_high = (RT_FIELD(chip->pwm[module].fctrl, PWM_FCTRL0_FLVL) & FAULT0) != 0;
    return level == active_high;
}

static void update_module(rt_chip *chip, uint32_t module)
{
    rt_pwm *pwm = &chip->pwm[module];
    bool was = (RT_FIELD(pwm->fsts, PWM_FSTS0_FFPIN) & FAULT0) != 0, is = input_is_active(chip, module);
    pwm->fsts =
        (uint16_t)((pwm->fsts & ~BITS(PWM_FSTS0_FFPIN, FAULT0)) | BITS(PWM_FSTS0_FFPIN, is ? FAULT0 : 0));
    if (is && !was) pwm->fsts |= (uint16_t)BITS(PWM_FSTS0_FFLAG, FAULT0);
    if (is) pwm->is_disabled = true;
    bool flag = (RT_FIELD(pwm->fsts, PWM_FSTS0_FFLAG) & FAULT0) != 0;
    bool is_safe = (RT_FIELD(pwm->fctrl, PWM_FCTRL0_FSAFE) & FAULT0) != 0;
    bool is_automatic = (RT_FIELD(pwm->fctrl, PWM_FCTRL0_FAUTO) & FAULT0) != 0;
    bool reloads = (RT_FIELD(pwm->fsts, PWM_FSTS0_FFULL) & FAULT0) != 0 ||
                   (RT_FIELD(pwm->fsts, PWM_FSTS0_FHALF) & FAULT0) != 0;
    bool may_return = is_automatic ? !is : !flag && (!is_safe || !is);
    if (pwm->is_disabled && reloads && may_return) pwm->is_disabled = false;
}

void rt_pwm_fault(rt_chip *chip)
{
    for (uint32_t module = 0; module < RT_PWM_MODULES; module++) update_module(chip, module);
}

/* --- registers --- */
static uint16_t *submodule_register(rt_pwm_submodule *sub, uint32_t offset)
{
    switch (offset) {
    case PWM_SMINIT_0:
        return &sub->buffer.init;
    case PWM_SMCTRL2_0:
        return &sub->control2;
    case PWM_SMCTRL_0:
        return &sub->control;
    case PWM_SMVAL0_0:
        return &sub->buffer.val[0];
    case PWM_SMVAL1_0:
        return &sub->buffer.val[1];
    case PWM_SMVAL2_0:
        return &sub->buffer.val[2];
    case PWM_SMVAL3_0:
        return &sub->buffer.val[3];
    case PWM_SMVAL4_0:
        return &sub->buffer.val[4];
    case PWM_SMVAL5_0:
        return &sub->buffer.val[5];
    case PWM_SMDISMAP0_0:
        return &sub->disable_map;
    default:
        return NULL;
    }
}

static bool is_value(uint32_t offset)
{
    return offset == PWM_SMINIT_0 || (offset >= PWM_SMVAL0_0 && offset <= PWM_SMVAL5_0);
}

uint32_t rt_pwm_read(rt_chip *chip, uint32_t module, uint32_t offset)
{
    rt_pwm *pwm = &chip->pwm[module];
    if (offset < RT_PWM_SUBMODULES * PWM_STRIDE_SMCTRL) {
        const uint16_t *word =
            submodule_register(&pwm->submodules[offset / PWM_STRIDE_SMCTRL], offset % PWM_STRIDE_SMCTRL);
        if (word != NULL) return *word;
    }
    switch (offset) {
    case PWM_OUTEN:
        return pwm->outen;
    case PWM_MCTRL:
        return pwm->mctrl;
    case PWM_FCTRL0:
        return pwm->fctrl;
    case PWM_FSTS0:
        return pwm->fsts;
    case PWM_FFILT0:
        return pwm->filter;
    default:
        rt_unmodelled(chip, "PWM", offset, false);
        return 0;
    }
}

/* LDOK cannot be set and the values of a submodule cannot be written while it is set, until the reload; the
 * model reloads at once when the submodule runs. */
static void write_mctrl(rt_chip *chip, rt_pwm *pwm, uint32_t value)
{
    uint32_t clear = RT_FIELD(value, PWM_MCTRL_CLDOK), load = RT_FIELD(value, PWM_MCTRL_LDOK);
    uint32_t pending = RT_FIELD(pwm->mctrl, PWM_MCTRL_LDOK);
    load = (pending | load) & ~clear;
    uint32_t run = RT_FIELD(value, PWM_MCTRL_RUN);
    for (uint32_t i = 0; i < RT_PWM_SUBMODULES; i++) {
        rt_pwm_submodule *sub = &pwm->submodules[i];
        if ((load >> i & 1u) == 0 || (run >> i & 1u) == 0) continue;
        if (RT_FIELD(sub->control, PWM_SMCTRL_0_FULL) == 0)
            rt_find(chip, "PWM submodule %u has no reload: LDOK stays pending", i);
        else
            sub->active = sub->buffer, load &= ~(1u << i);
    }
    pwm->mctrl = (uint16_t)(BITS(PWM_MCTRL_LDOK, load) | BITS(PWM_MCTRL_RUN, run));
}

static void write_submodule(rt_chip *chip, rt_pwm *pwm, uint32_t offset, uint32_t value)
{
    uint32_t number = offset / PWM_STRIDE_SMCTRL, inside = offset % PWM_STRIDE_SMCTRL;
    uint16_t *word = submodule_register(&pwm->submodules[number], inside);
    if (word == NULL) {
        rt_unmodelled(chip, "PWM", offset, true);
    } else if (is_value(inside) && (RT_FIELD(pwm->mctrl, PWM_MCTRL_LDOK) >> number & 1u) != 0) {
        rt_find(chip, "PWM: a value of submodule %u is written while LDOK is set, and is lost", number);
    } else {
        *word = (uint16_t)value;
    }
}

void rt_pwm_write(rt_chip *chip, uint32_t module, uint32_t offset, uint32_t value)
{
    rt_pwm *pwm = &chip->pwm[module];
    switch (offset) {
    case PWM_OUTEN:
        pwm->outen = (uint16_t)value;
        break;
    case PWM_MCTRL:
        write_mctrl(chip, pwm, value);
        break;
    case PWM_FCTRL0:
        pwm->fctrl = (uint16_t)value;
        break;
    case PWM_FFILT0:
        pwm->filter = (uint16_t)value;
        break;
    case PWM_FSTS0: /* flags are cleared by ones; FFULL and FHALF are plain */
        pwm->fsts = (uint16_t)((pwm->fsts & ~(value & MASK(PWM_FSTS0_FFLAG)) &
                                ~(MASK(PWM_FSTS0_FFULL) | MASK(PWM_FSTS0_FHALF))) |
                               (value & (MASK(PWM_FSTS0_FFULL) | MASK(PWM_FSTS0_FHALF))));
        break;
    default:
        if (offset < RT_PWM_SUBMODULES * PWM_STRIDE_SMCTRL)
            write_submodule(chip, pwm, offset, value);
        else
            rt_unmodelled(chip, "PWM", offset, true);
    }
    update_module(chip, module);
}

static double share_of(const rt_pwm_submodule *sub, bool is_b)
{
    double begin = (int16_t)sub->active.init, period = (int16_t)sub->active.val[1] + 1 - begin;
    double on = (int16_t)sub->active.val[is_b ? 4 : 2], off = (int16_t)sub->active.val[is_b ? 5 : 3];
    double width = off - on;
    return period <= 0 || width <= 0 ? 0 : width >= period ? 1 : width / period;
}

/* The place in the motors' period of 50 us, 0 .. 1. */
static double phase_of(uint64_t instant)
{
    const uint64_t period = 50 * RT_INSTANTS_PER_us;
    return (double)(instant % period) / (double)period;
}

/* Without its clock, an output stays at the level that it has. */
double rt_pwm_duty(rt_chip *chip, uint32_t module, uint32_t submodule, bool is_b)
{
    const rt_pwm *pwm = &chip->pwm[module];
    const rt_pwm_submodule *sub = &pwm->submodules[submodule];
    uint32_t enabled =
        is_b ? RT_FIELD(pwm->outen, PWM_OUTEN_PWMB_EN) : RT_FIELD(pwm->outen, PWM_OUTEN_PWMA_EN);
    uint32_t map = is_b ? RT_FIELD(sub->disable_map, PWM_SMDISMAP0_0_DIS0B)
                        : RT_FIELD(sub->disable_map, PWM_SMDISMAP0_0_DIS0A);
    if (!rt_gate_is_open(chip, 4, GATE_PWM2 + module)) return 0;
    if ((enabled >> submodule & 1u) == 0 || (RT_FIELD(pwm->mctrl, PWM_MCTRL_RUN) >> submodule & 1u) == 0)
        return 0;
    if (pwm->is_disabled && (map & FAULT0) != 0) return 0;
    if (is_b && RT_FIELD(sub->control2, PWM_SMCTRL2_0_INDEP) == 0)
        return 0; /* the complement of A: not this board */
    double share = share_of(sub, is_b);
    if (rt_fault_core_stands(chip)) return phase_of(chip->fault.struck_at) < share ? 1 : 0;
    return share;
}

void rt_pwm_reset(rt_chip *chip)
{
    for (uint32_t module = 0; module < RT_PWM_MODULES; module++) {
        chip->pwm[module] = (rt_pwm){0};
        for (uint32_t i = 0; i < RT_PWM_SUBMODULES; i++) {
            chip->pwm[module].submodules[i].control = (uint16_t)MASK(PWM_SMCTRL_0_FULL);
            chip->pwm[module].submodules[i].disable_map = 0xffff;
        }
        update_module(chip, module);
    }
}
