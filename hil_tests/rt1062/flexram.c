/* IOMUXC_GPR: the banks of the FlexRAM (GPR14, 16, 17), the timers' inputs (GPR6), and which port the GPIO
 * pins belong to (GPR26 to 29). Until the image chooses banks by GPR17 the FlexRAM is split as the fuses say:
 * 128 kB for code, 128 kB for data (reference manual, from memory); start-up must not use it. */
#include "hil_tests/rt1062/chip.h"

enum { BANKS = 16, BANK_BYTES = 32 << 10, BANK_CODE = 3, BANK_DATA = 2, FUSED_BANKS = 4 };

static uint32_t gpr(const rt_chip *chip, uint32_t offset)
{
    return chip->flex.gpr[offset / 4];
}

/* The size field of a tightly coupled memory: 3 is 4 kB, and each further one doubles it. */
static uint32_t window(uint32_t size)
{
    return size < 3 ? 0 : 4096u << (size - 3);
}

static uint32_t bytes_of(const rt_chip *chip, uint32_t kind, bool is_on, uint32_t size)
{
    uint32_t banks = 0;
    if (RT_FIELD(gpr(chip, IOMUXC_GPR_GPR16), IOMUXC_GPR_GPR16_FLEXRAM_BANK_CFG_SEL) == 0) {
        banks = FUSED_BANKS;
    } else {
        for (uint32_t bank = 0; bank < BANKS; bank++)
            banks += (gpr(chip, IOMUXC_GPR_GPR17) >> (2 * bank) & 3u) == kind;
    }
    uint32_t bytes = banks * BANK_BYTES;
    if (!is_on) return 0;
    return bytes < window(size) ? bytes : window(size);
}

uint32_t rt_itcm_bytes(const rt_chip *chip)
{
    return bytes_of(chip, BANK_CODE,
                    RT_FIELD(gpr(chip, IOMUXC_GPR_GPR16), IOMUXC_GPR_GPR16_INIT_ITCM_EN) != 0,
                    RT_FIELD(gpr(chip, IOMUXC_GPR_GPR14), IOMUXC_GPR_GPR14_CM7_CFGITCMSZ));
}

uint32_t rt_dtcm_bytes(const rt_chip *chip)
{
    return bytes_of(chip, BANK_DATA,
                    RT_FIELD(gpr(chip, IOMUXC_GPR_GPR16), IOMUXC_GPR_GPR16_INIT_DTCM_EN) != 0,
                    RT_FIELD(gpr(chip, IOMUXC_GPR_GPR14), IOMUXC_GPR_GPR14_CM7_CFGDTCMSZ));
}

static bool is_modelled(uint32_t offset)
{
    return offset == IOMUXC_GPR_GPR6 || offset == IOMUXC_GPR_GPR14 || offset == IOMUXC_GPR_GPR16 ||
           offset == IOMUXC_GPR_GPR17 || (offset >= IOMUXC_GPR_GPR26 && offset <= IOMUXC_GPR_GPR29);
}

uint32_t rt_gpr_read(rt_chip *chip, uint32_t offset)
{
    if (!is_modelled(offset)) {
        rt_unmodelled(chip, "IOMUXC_GPR", offset, false);
        return 0;
    }
    return gpr(chip, offset);
}

void rt_gpr_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    if (!is_modelled(offset)) {
        rt_unmodelled(chip, "IOMUXC_GPR", offset, true);
        return;
    }
    chip->flex.gpr[offset / 4] = value;
    if (offset >= IOMUXC_GPR_GPR14 && offset <= IOMUXC_GPR_GPR17) chip->is_map_changed = true;
}

void rt_flexram_reset(rt_chip *chip)
{
    chip->flex = (rt_flexram){0};
    chip->flex.gpr[IOMUXC_GPR_GPR16 / 4] =
        0x00200000u | MASK(IOMUXC_GPR_GPR16_INIT_ITCM_EN) | MASK(IOMUXC_GPR_GPR16_INIT_DTCM_EN);
    chip->flex.gpr[IOMUXC_GPR_GPR14 / 4] =
        BITS(IOMUXC_GPR_GPR14_CM7_CFGITCMSZ, 8) | BITS(IOMUXC_GPR_GPR14_CM7_CFGDTCMSZ, 8);
    chip->is_map_changed = true;
}
