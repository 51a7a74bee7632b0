/* The words in which the chip stores what it was told: a bit of each can flip. Registers whose value the chip
 * makes itself at every read (levels of pins, counts of time) are not here; RT_FAULT_READ is for them. */
#include "hil_tests/rt1062/chip.h"

typedef struct word_list {
    rt_word *words;
    uint32_t count;
} word_list;

static rt_word *put(word_list *list, const char *part, void *at, uint32_t bytes)
{
    if (list->count == RT_WORDS_MAX) list->count--;
    rt_word *word = &list->words[list->count++];
    *word = (rt_word){.part = part, .at = at, .bytes = (uint8_t)bytes};
    return word;
}
#define PUT(PART, WORD) put(list, PART, &(WORD), sizeof(WORD))

static void put_clocks(word_list *list, rt_clocks *clocks)
{
    static const uint16_t ccm[] = {CCM_CACRR, CCM_CBCDR, CCM_CBCMR, CCM_CSCMR1, CCM_CSCDR1};
    static const uint16_t analog[] = {CCM_ANALOG_PLL_ARM, CCM_ANALOG_PLL_USB1, CCM_ANALOG_PLL_SYS,
                                      CCM_ANALOG_PFD_528, PMU_REG_3P0};
    for (uint32_t i = 0; i < sizeof ccm / sizeof ccm[0]; i++)
        PUT("CCM", clocks->ccm[ccm[i] / 4])->is_clock = true;
    for (uint32_t gate = CCM_CCGR0; gate <= CCM_CCGR7; gate += 4)
        PUT("CCM_CCGR", clocks->ccm[gate / 4])->is_clock = true;
    for (uint32_t i = 0; i < sizeof analog / sizeof analog[0]; i++)
        PUT("CCM_ANALOG", clocks->analog[analog[i] / 4])->is_clock = true;
}

static void put_memories(word_list *list, rt_chip *chip)
{
    static const uint8_t banks[] = {IOMUXC_GPR_GPR14 / 4, IOMUXC_GPR_GPR16 / 4, IOMUXC_GPR_GPR17 / 4};
    for (uint32_t i = 0; i < sizeof banks; i++) PUT("IOMUXC_GPR", chip->flex.gpr[banks[i]])->is_map = true;
    for (uint32_t i = 0; i < 12; i++) PUT("FLEXSPI2_LUT", chip->flexspi.lut[i])->is_map = true;
    PUT("FLEXSPI2", chip->flexspi.mcr0)->is_map = true;
    PUT("FLEXSPI2", chip->flexspi.sequences)->is_map = true;
    rt_core *core = &chip->core;
    PUT("VTOR", core->vtor);
    PUT("CCR", core->ccr)->is_map = true;
    PUT("SHCSR", core->shcsr);
    PUT("MPU_CTRL", core->mpu_control)->is_map = true;
    for (uint32_t i = 0; i < 8; i++) PUT("NVIC_ISER", core->enabled[i]);
    for (uint32_t i = 0; i < RT_MPU_REGIONS; i++) {
        PUT("MPU_RBAR", core->begin[i])->is_map = true;
        PUT("MPU_RASR", core->size[i])->is_map = true;
    }
}

static void put_timers(word_list *list, rt_chip *chip)
{
    PUT("PIT_LDVAL", chip->pit.load);
    PUT("PIT_TCTRL", chip->pit.control);
    PUT("PIT_TFLG", chip->pit.flag);
    PUT("PIT_MCR", chip->pit.mcr);
    PUT("GPT_CR", chip->gpt.control);
    PUT("GPT_PR", chip->gpt.prescaler);
    PUT("WDOG_WCR", chip->watchdogs.wcr);
}

static void put_pins(word_list *list, rt_chip *chip)
{
    for (uint32_t port = 0; port < RT_PORTS; port++) {
        PUT("GPIO_DR", chip->pins.data[port])->is_motor = port == 2;
        PUT("GPIO_GDIR", chip->pins.direction[port])->is_motor = port == 2;
    }
    for (uint32_t i = 5; i < RT_IOMUXC_WORDS; i++) {
        if (chip->pins.iomuxc[i] != 0) PUT("IOMUXC", chip->pins.iomuxc[i])->is_motor = true;
    }
    for (uint32_t i = 0; i < RT_CROSSBAR_OUTPUTS / 2; i++)
        if (chip->crossbar.select[i] != 0) PUT("XBARA1_SEL", chip->crossbar.select[i])->is_motor = true;
}

static void put_encoders(word_list *list, rt_chip *chip)
{
    for (uint32_t i = 0; i < RT_DECODERS; i++) {
        PUT("ENC_CTRL2", chip->decoders[i].control2);
        PUT("ENC_FILT", chip->decoders[i].filter);
        PUT("ENC_POS", chip->decoders[i].position);
    }
    for (uint32_t i = 0; i < RT_TIMER_CHANNELS; i++) {
        PUT("TMR_CTRL", chip->counters[i].control);
        PUT("TMR_FILT", chip->counters[i].filter);
        PUT("TMR_CNTR", chip->counters[i].count);
    }
}

static void put_pwm(word_list *list, rt_pwm *pwm)
{
    PUT("PWM_OUTEN", pwm->outen)->is_motor = true;
    PUT("PWM_MCTRL", pwm->mctrl)->is_motor = true;
    PUT("PWM_FCTRL", pwm->fctrl)->is_motor = true;
    PUT("PWM_FSTS", pwm->fsts)->is_motor = true;
    for (uint32_t i = 1; i < RT_PWM_SUBMODULES; i++) {
        rt_pwm_submodule *sub = &pwm->submodules[i];
        PUT("PWM_SMCTRL2", sub->control2)->is_motor = true;
        PUT("PWM_SMDISMAP", sub->disable_map)->is_motor = true;
        PUT("PWM_SMINIT", sub->active.init)->is_motor = true;
        for (uint32_t k = 1; k < 6; k++) PUT("PWM_SMVAL", sub->active.val[k])->is_motor = true;
        PUT("PWM_SMINIT buffer", sub->buffer.init)->is_motor = true; /* acts from the next LDOK on */
        for (uint32_t k = 1; k < 6; k++) PUT("PWM_SMVAL buffer", sub->buffer.val[k])->is_motor = true;
    }
}

static void put_usb(word_list *list, rt_usb *usb)
{
    PUT("USBCMD", usb->command);
    PUT("USBSTS", usb->status);
    PUT("DEVICEADDR", usb->address);
    PUT("ENDPTLISTADDR", usb->list);
    PUT("USBMODE", usb->mode);
    PUT("ENDPTSETUPSTAT", usb->setup_status);
    PUT("ENDPTSTAT", usb->ready);
    PUT("ENDPTCOMPLETE", usb->complete);
    for (uint32_t i = 0; i < 4; i++) PUT("ENDPTCTRL", usb->endpoint_control[i]);
    PUT("USBPHY_CTRL", usb->phy_control);
    PUT("USBPHY_PWD", usb->phy_pwd);
}

uint32_t rt_fault_words(rt_chip *chip, rt_word words[RT_WORDS_MAX])
{
    word_list list = {.words = words};
    put_clocks(&list, &chip->clocks);
    put_memories(&list, chip);
    put_timers(&list, chip);
    put_pins(&list, chip);
    put_encoders(&list, chip);
    for (uint32_t i = 0; i < RT_PWM_MODULES; i++) put_pwm(&list, &chip->pwm[i]);
    for (uint32_t i = 0; i < RT_ADCS; i++) {
        put(&list, "ADC_CFG", &chip->adc[i].cfg, 4);
        put(&list, "ADC_GC", &chip->adc[i].gc, 4);
        put(&list, "ADC_HC", &chip->adc[i].hc, 4);
    }
    put_usb(&list, &chip->usb);
    return list.count;
}
