/* This port has never run on hardware. This file sets the function of every pin, row by row as in the table
 * of docs/porting.md, "Pins". */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

#define PAD_FIELD(FIELD, value) BITS(IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_##FIELD, value)
#define PULL(value) (PAD_FIELD(PKE, 1) | PAD_FIELD(PUE, 1) | PAD_FIELD(PUS, value))
#define DRIVE (PAD_FIELD(DSE, 6) | PAD_FIELD(SPEED, 1))

enum {
    OUTPUT = DRIVE,
    INPUT_UP = PULL(3) | PAD_FIELD(HYS, 1),   /* 22 kOhm to 3.3 V: a broken cable reads high */
    INPUT_DOWN = PULL(0) | PAD_FIELD(HYS, 1), /* 100 kOhm to ground: a broken cable reads low */
    ANALOG = 0,
    MEMORY = PAD_FIELD(DSE, 6) | PAD_FIELD(SPEED, 3) | PAD_FIELD(HYS, 1),
    FORCE_INPUT_PATH = 1 << 4, /* the outgoing strobe is read back */
    NO_DAISY = 0,
};

typedef struct pin {
    uint16_t mux, mode, pad;
    uint32_t control;
    uint16_t daisy, choice;
} pin;

static const pin pins[] = {
    /* encoders: translation 1, 2, 3 and rotation 1 by the crossbar; rotation 2 and 3 and syringe by timers */
    {PAD_EMC_04_XBAR1_INOUT06, INPUT_UP, DAISY_XBAR1_IN06_EMC_04},
    {PAD_EMC_05_XBAR1_INOUT07, INPUT_UP, DAISY_XBAR1_IN07_EMC_05},
    {PAD_EMC_06_XBAR1_INOUT08, INPUT_UP, DAISY_XBAR1_IN08_EMC_06},
    {PAD_EMC_07_XBAR1_INOUT09, INPUT_UP, DAISY_XBAR1_IN09_EMC_07},
    {PAD_EMC_36_XBAR1_IN22, INPUT_UP, DAISY_XBAR1_IN22_EMC_36},
    {PAD_EMC_37_XBAR1_IN23, INPUT_UP, DAISY_XBAR1_IN23_EMC_37},
    {PAD_B1_00_XBAR1_INOUT14, INPUT_UP, DAISY_XBAR1_IN14_B1_00},
    {PAD_B1_01_XBAR1_INOUT15, INPUT_UP, DAISY_XBAR1_IN15_B1_01},
    {PAD_AD_B1_00_QTIMER3_TIMER0, INPUT_UP, DAISY_QTIMER3_TIMER0_AD_B1_00},
    {PAD_AD_B1_01_QTIMER3_TIMER1, INPUT_UP, DAISY_QTIMER3_TIMER1_AD_B1_01},
    {PAD_AD_B1_02_QTIMER3_TIMER2, INPUT_UP, DAISY_QTIMER3_TIMER2_AD_B1_02},
    {PAD_AD_B1_03_QTIMER3_TIMER3, INPUT_UP, DAISY_QTIMER3_TIMER3_AD_B1_03},
    {PAD_B0_00_QTIMER1_TIMER0, INPUT_UP, NO_DAISY, 0},
    {PAD_B0_01_QTIMER1_TIMER1, INPUT_UP, NO_DAISY, 0},
    /* motors: width of axial and rotation 1, 2, 3, their directions, and the fault line, low when broken */
    {PAD_B0_10_FLEXPWM2_PWMA02, OUTPUT, NO_DAISY, 0},
    {PAD_B0_11_FLEXPWM2_PWMB02, OUTPUT, NO_DAISY, 0},
    {PAD_B1_02_FLEXPWM2_PWMA03, OUTPUT, NO_DAISY, 0},
    {PAD_B1_03_FLEXPWM2_PWMB03, OUTPUT, NO_DAISY, 0},
    {PAD_EMC_31_FLEXPWM3_PWMA01, OUTPUT, NO_DAISY, 0},
    {PAD_EMC_32_FLEXPWM3_PWMB01, OUTPUT, NO_DAISY, 0},
    {PAD_SD_B0_00_GPIO3_IO12, OUTPUT, NO_DAISY, 0},
    {PAD_SD_B0_01_GPIO3_IO13, OUTPUT, NO_DAISY, 0},
    {PAD_SD_B0_02_GPIO3_IO14, OUTPUT, NO_DAISY, 0},
    {PAD_SD_B0_03_GPIO3_IO15, OUTPUT, NO_DAISY, 0},
    {PAD_SD_B0_04_GPIO3_IO16, OUTPUT, NO_DAISY, 0},
    {PAD_SD_B0_05_GPIO3_IO17, OUTPUT, NO_DAISY, 0},
    {PAD_EMC_08_XBAR1_INOUT17, INPUT_DOWN, DAISY_XBAR1_IN17_EMC_08},
    /* drive, enable, lamp; emergency stop, pedals, switch, feedback of the power stage */
    {PAD_B0_12_GPIO2_IO12, OUTPUT, NO_DAISY, 0},
    {PAD_AD_B1_15_GPIO1_IO31, OUTPUT, NO_DAISY, 0},
    {PAD_B0_03_GPIO2_IO03, OUTPUT, NO_DAISY, 0},
    {PAD_AD_B0_12_GPIO1_IO12, INPUT_UP, NO_DAISY, 0},
    {PAD_AD_B0_13_GPIO1_IO13, INPUT_UP, NO_DAISY, 0},
    {PAD_B0_02_GPIO2_IO02, INPUT_UP, NO_DAISY, 0},
    {PAD_B1_12_GPIO2_IO28, INPUT_UP, NO_DAISY, 0},
    {PAD_B1_13_GPIO2_IO29, INPUT_DOWN, NO_DAISY, 0},
    {PAD_AD_B0_02_LPUART6_TX, OUTPUT, DAISY_LPUART6_TX_AD_B0_02},
    /* analog: force 1, 2, 3, pressure, current 1, 2, 3, supply */
    {PAD_AD_B1_07_GPIO1_IO23, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_06_GPIO1_IO22, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_10_GPIO1_IO26, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_11_GPIO1_IO27, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_08_GPIO1_IO24, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_09_GPIO1_IO25, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_04_GPIO1_IO20, ANALOG, NO_DAISY, 0},
    {PAD_AD_B1_14_GPIO1_IO30, ANALOG, NO_DAISY, 0},
    /* the PSRAM, soldered under the board */
    {PAD_EMC_23_FLEXSPI2_A_DQS, MEMORY, DAISY_FLEXSPI2_IPP_IND_DQS_FA_EMC_23},
    {PAD_EMC_24_FLEXSPI2_A_SS0_B, MEMORY, NO_DAISY, 0},
    {PAD_EMC_25_FLEXSPI2_A_SCLK, MEMORY, DAISY_FLEXSPI2_IPP_IND_SCK_FA_EMC_25},
    {PAD_EMC_26_FLEXSPI2_A_DATA00, MEMORY, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT0_EMC_26},
    {PAD_EMC_27_FLEXSPI2_A_DATA01, MEMORY, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT1_EMC_27},
    {PAD_EMC_28_FLEXSPI2_A_DATA02, MEMORY, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT2_EMC_28},
    {PAD_EMC_29_FLEXSPI2_A_DATA03, MEMORY, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT3_EMC_29},
};

/* Sets the level of every output pin to low before the pin becomes an output. The pins' fast alternatives
 * (GPIO6 to 9) are not used. */
void pins_start(void)
{
    for (uint32_t gpr = IOMUXC_GPR_GPR26; gpr <= IOMUXC_GPR_GPR29; gpr += 4) R32(BASE_IOMUXC_GPR, gpr) = 0;
    rig_outputs_off();
    for (uint32_t i = 0; i < sizeof pins / sizeof pins[0]; i++) {
        const pin *p = &pins[i];
        uint32_t mode = p->control == MEMORY ? p->mode | FORCE_INPUT_PATH : p->mode;
        R32(BASE_IOMUXC, p->pad) = p->control;
        R32(BASE_IOMUXC, p->mux) = mode;
        if (p->daisy != NO_DAISY) R32(BASE_IOMUXC, p->daisy) = p->choice;
    }
}
