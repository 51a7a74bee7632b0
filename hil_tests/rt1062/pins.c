/* Pins: the multiplexer IOMUXC, and GPIO1 to 3. A signal passes between a pin and its peripheral only if mux
 * mode and input selection are those of this function, and if the gates are open. The table below is the
 * table of docs/porting.md, "Pins", written a second time; the offsets, modes and selections are compared
 * with the chip's description by `make registers`. An input that nothing drives has the level of its pull
 * resistor. */
#include "hil_tests/rt1062/chip.h"

enum { NONE = 0, MUX_MODE_MASK = 7, PULL_DOWN = 0 };
/* What drives or reads the pin: bits of GPIO ports are port * 32 + bit. */
enum { OTHER = 255 };

typedef struct row {
    const char *name;
    uint16_t mux, mode, pad;
    uint16_t daisy, choice;
    uint8_t gpio; /* OTHER: not a GPIO pin */
} row;

static const row rows[RT_PINS] = {
    {"encoder translation 1 A", PAD_EMC_04_XBAR1_INOUT06, DAISY_XBAR1_IN06_EMC_04, OTHER},
    {"encoder translation 2 A", PAD_EMC_06_XBAR1_INOUT08, DAISY_XBAR1_IN08_EMC_06, OTHER},
    {"encoder translation 3 A", PAD_EMC_36_XBAR1_IN22, DAISY_XBAR1_IN22_EMC_36, OTHER},
    {"encoder rotation 1 A", PAD_B1_00_XBAR1_INOUT14, DAISY_XBAR1_IN14_B1_00, OTHER},
    {"encoder rotation 2 A", PAD_AD_B1_00_QTIMER3_TIMER0, DAISY_QTIMER3_TIMER0_AD_B1_00, OTHER},
    {"encoder rotation 3 A", PAD_AD_B1_02_QTIMER3_TIMER2, DAISY_QTIMER3_TIMER2_AD_B1_02, OTHER},
    {"encoder syringe A", PAD_B0_00_QTIMER1_TIMER0, NONE, 0, OTHER},
    {"encoder translation 1 B", PAD_EMC_05_XBAR1_INOUT07, DAISY_XBAR1_IN07_EMC_05, OTHER},
    {"encoder translation 2 B", PAD_EMC_07_XBAR1_INOUT09, DAISY_XBAR1_IN09_EMC_07, OTHER},
    {"encoder translation 3 B", PAD_EMC_37_XBAR1_IN23, DAISY_XBAR1_IN23_EMC_37, OTHER},
    {"encoder rotation 1 B", PAD_B1_01_XBAR1_INOUT15, DAISY_XBAR1_IN15_B1_01, OTHER},
    {"encoder rotation 2 B", PAD_AD_B1_01_QTIMER3_TIMER1, DAISY_QTIMER3_TIMER1_AD_B1_01, OTHER},
    {"encoder rotation 3 B", PAD_AD_B1_03_QTIMER3_TIMER3, DAISY_QTIMER3_TIMER3_AD_B1_03, OTHER},
    {"encoder syringe B", PAD_B0_01_QTIMER1_TIMER1, NONE, 0, OTHER},
    {"axial motor 1", PAD_B0_10_FLEXPWM2_PWMA02, NONE, 0, OTHER},
    {"rotation motor 1", PAD_B0_11_FLEXPWM2_PWMB02, NONE, 0, OTHER},
    {"axial motor 2", PAD_B1_02_FLEXPWM2_PWMA03, NONE, 0, OTHER},
    {"rotation motor 2", PAD_B1_03_FLEXPWM2_PWMB03, NONE, 0, OTHER},
    {"axial motor 3", PAD_EMC_31_FLEXPWM3_PWMA01, NONE, 0, OTHER},
    {"rotation motor 3", PAD_EMC_32_FLEXPWM3_PWMB01, NONE, 0, OTHER},
    {"direction of axial 1", PAD_SD_B0_00_GPIO3_IO12, NONE, 0, 64 + 12},
    {"direction of rotation 1", PAD_SD_B0_01_GPIO3_IO13, NONE, 0, 64 + 13},
    {"direction of axial 2", PAD_SD_B0_02_GPIO3_IO14, NONE, 0, 64 + 14},
    {"direction of rotation 2", PAD_SD_B0_03_GPIO3_IO15, NONE, 0, 64 + 15},
    {"direction of axial 3", PAD_SD_B0_04_GPIO3_IO16, NONE, 0, 64 + 16},
    {"direction of rotation 3", PAD_SD_B0_05_GPIO3_IO17, NONE, 0, 64 + 17},
    {"fault line", PAD_EMC_08_XBAR1_INOUT17, DAISY_XBAR1_IN17_EMC_08, OTHER},
    {"drive line", PAD_B0_12_GPIO2_IO12, NONE, 0, 32 + 12},
    {"enable", PAD_AD_B1_15_GPIO1_IO31, NONE, 0, 31},
    {"lamp", PAD_B0_03_GPIO2_IO03, NONE, 0, 32 + 3},
    {"emergency stop", PAD_AD_B0_12_GPIO1_IO12, NONE, 0, 12},
    {"X-ray pedal", PAD_AD_B0_13_GPIO1_IO13, NONE, 0, 13},
    {"cine pedal", PAD_B0_02_GPIO2_IO02, NONE, 0, 32 + 2},
    {"unlock switch", PAD_B1_12_GPIO2_IO28, NONE, 0, 32 + 28},
    {"power stage's feedback", PAD_B1_13_GPIO2_IO29, NONE, 0, 32 + 29},
    {"console", PAD_AD_B0_02_LPUART6_TX, DAISY_LPUART6_TX_AD_B0_02, OTHER},
    {"force 1", PAD_AD_B1_07_GPIO1_IO23, NONE, 0, OTHER},
    {"force 2", PAD_AD_B1_06_GPIO1_IO22, NONE, 0, OTHER},
    {"force 3", PAD_AD_B1_10_GPIO1_IO26, NONE, 0, OTHER},
    {"current 1", PAD_AD_B1_08_GPIO1_IO24, NONE, 0, OTHER},
    {"current 2", PAD_AD_B1_09_GPIO1_IO25, NONE, 0, OTHER},
    {"current 3", PAD_AD_B1_04_GPIO1_IO20, NONE, 0, OTHER},
    {"inflator's pressure", PAD_AD_B1_11_GPIO1_IO27, NONE, 0, OTHER},
    {"motors' supply", PAD_AD_B1_14_GPIO1_IO30, NONE, 0, OTHER},
    {"PSRAM DQS", PAD_EMC_23_FLEXSPI2_A_DQS, DAISY_FLEXSPI2_IPP_IND_DQS_FA_EMC_23, OTHER},
    {"PSRAM select", PAD_EMC_24_FLEXSPI2_A_SS0_B, NONE, 0, OTHER},
    {"PSRAM clock", PAD_EMC_25_FLEXSPI2_A_SCLK, DAISY_FLEXSPI2_IPP_IND_SCK_FA_EMC_25, OTHER},
    {"PSRAM data 0", PAD_EMC_26_FLEXSPI2_A_DATA00, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT0_EMC_26, OTHER},
    {"PSRAM data 1", PAD_EMC_27_FLEXSPI2_A_DATA01, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT1_EMC_27, OTHER},
    {"PSRAM data 2", PAD_EMC_28_FLEXSPI2_A_DATA02, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT2_EMC_28, OTHER},
    {"PSRAM data 3", PAD_EMC_29_FLEXSPI2_A_DATA03, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT3_EMC_29, OTHER},
};

const char *rt_pin_name(rt_pin pin)
{
    return rows[pin].name;
}

static uint32_t word_of(const rt_chip *chip, uint32_t offset)
{
    return chip->pins.iomuxc[offset / 4];
}

static bool is_analog(rt_pin pin)
{
    return pin >= RT_PIN_FORCE0 && pin <= RT_PIN_SUPPLY;
}

bool rt_pin_is_routed(const rt_chip *chip, rt_pin pin)
{
    const row *r = &rows[pin];
    if ((word_of(chip, r->mux) & MUX_MODE_MASK) != (r->mode & MUX_MODE_MASK)) return false;
    if (r->mode > MUX_MODE_MASK && (word_of(chip, r->mux) & 8u) == 0) return false;
    if (is_analog(pin) && (word_of(chip, r->pad) & MASK(IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PKE)) != 0)
        return false; /* a keeper or pull resistor would move an analog value */
    return r->daisy == NONE || word_of(chip, r->daisy) == r->choice;
}

uint32_t rt_iomuxc_read(rt_chip *chip, uint32_t offset)
{
    return word_of(chip, offset);
}

void rt_iomuxc_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    chip->pins.iomuxc[offset / 4] = value;
    rt_pwm_fault(chip); /* the fault line may have been connected */
}

/* The level at the pin itself: the rig's, or that of the pull resistor. */
static bool level_at(const rt_chip *chip, rt_pin pin)
{
    if (chip->pins.rig[pin] != RT_OPEN) return chip->pins.rig[pin] == RT_HIGH;
    uint32_t pad = word_of(chip, rows[pin].pad);
    bool pulls = RT_FIELD(pad, IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PKE) != 0 &&
                 RT_FIELD(pad, IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PUE) != 0;
    return pulls && RT_FIELD(pad, IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PUS) != PULL_DOWN;
}

static bool is_output(rt_pin pin)
{
    return (pin >= RT_PIN_PWM0 && pin < RT_PIN_FAULT) || pin == RT_PIN_DRIVE || pin == RT_PIN_ENABLE ||
           pin == RT_PIN_LAMP;
}

bool rt_pin_level(rt_chip *chip, rt_pin pin)
{
    if (rt_fault_is(&chip->fault, RT_FAULT_PIN) && chip->fault.address == pin) return chip->fault.set != 0;
    if (!is_output(pin)) return rt_pin_is_routed(chip, pin) && level_at(chip, pin);
    uint32_t port = rows[pin].gpio / 32, bit = 1u << rows[pin].gpio % 32;
    if (rows[pin].gpio == OTHER || !rt_pin_is_routed(chip, pin)) return false;
    return (chip->pins.direction[port] & bit) != 0 && (chip->pins.data[port] & bit) != 0;
}

void rt_pin_drive(rt_chip *chip, rt_pin pin, rt_level level, uint64_t instant)
{
    chip->pins.rig[pin] = (uint8_t)level;
    if (pin < RT_PIN_PWM0) {
        bool is_b = pin >= RT_PIN_ENCODER_B0;
        uint32_t encoder = pin - (is_b ? RT_PIN_ENCODER_B0 : RT_PIN_ENCODER_A0);
        rt_encoders_edge(chip, encoder, is_b, rt_pin_level(chip, pin), instant);
    }
    if (pin == RT_PIN_FAULT) rt_pwm_fault(chip);
}

void rt_pin_volts(rt_chip *chip, rt_pin pin, double volts)
{
    chip->pins.volts[pin] = volts;
}

/* --- GPIO --- */
static uint32_t levels_of(rt_chip *chip, uint32_t port)
{
    uint32_t levels = chip->pins.data[port] & chip->pins.direction[port];
    for (rt_pin pin = 0; pin < RT_PINS; pin++) {
        if (rows[pin].gpio == OTHER || rows[pin].gpio / 32u != port || is_output(pin)) continue;
        if (rt_pin_level(chip, pin)) levels |= 1u << rows[pin].gpio % 32;
    }
    return levels;
}

uint32_t rt_gpio_read(rt_chip *chip, uint32_t port, uint32_t offset)
{
    switch (offset) {
    case GPIO_DR:
        return chip->pins.data[port];
    case GPIO_GDIR:
        return chip->pins.direction[port];
    case GPIO_PSR:
        return levels_of(chip, port);
    default:
        rt_unmodelled(chip, "GPIO", offset, false);
        return 0;
    }
}

void rt_gpio_write(rt_chip *chip, uint32_t port, uint32_t offset, uint32_t value)
{
    rt_pins *pins = &chip->pins;
    bool was_driving = rt_pin_level(chip, RT_PIN_DRIVE);
    switch (offset) {
    case GPIO_DR:
        pins->data[port] = value;
        break;
    case GPIO_GDIR:
        pins->direction[port] = value;
        break;
    case GPIO_DR_SET:
        pins->data[port] |= value;
        break;
    case GPIO_DR_CLEAR:
        pins->data[port] &= ~value;
        break;
    default:
        rt_unmodelled(chip, "GPIO", offset, true);
    }
    pins->drive_edges += rt_pin_level(chip, RT_PIN_DRIVE) != was_driving;
}

/* At reset every pin is a GPIO input with a keeper. What the rig drives stays. */
void rt_pins_reset(rt_chip *chip)
{
    rt_pins *pins = &chip->pins;
    for (uint32_t i = 0; i < RT_IOMUXC_WORDS; i++) pins->iomuxc[i] = 0;
    for (rt_pin pin = 0; pin < RT_PINS; pin++) {
        pins->iomuxc[rows[pin].mux / 4] = 5;
        pins->iomuxc[rows[pin].pad / 4] = 0x10b0;
    }
    for (uint32_t port = 0; port < RT_PORTS; port++) pins->data[port] = pins->direction[port] = 0;
}
