/* This port has never run on hardware. This file starts the clock and the transceiver of the USB controller:
 * the chip makes 480 MHz from its crystal and contains the high-speed transceiver. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

bool usb_phy_start(void)
{
    volatile uint32_t *pll = &R32(BASE_CCM_ANALOG, CCM_ANALOG_PLL_USB1);
    R32(BASE_PMU, PMU_REG_3P0) |= MASK(PMU_REG_3P0_ENABLE_LINREG); /* 3 V for the transceiver, from the bus */
    *pll |= MASK(CCM_ANALOG_PLL_USB1_POWER);
    if (!board_wait(pll, MASK(CCM_ANALOG_PLL_USB1_LOCK), MASK(CCM_ANALOG_PLL_USB1_LOCK))) return false;
    SET_FIELD(*pll, CCM_ANALOG_PLL_USB1_BYPASS, 0);
    *pll |= MASK(CCM_ANALOG_PLL_USB1_ENABLE) | MASK(CCM_ANALOG_PLL_USB1_EN_USB_CLKS);

    R32(BASE_USBPHY1, USBPHY_CTRL_SET) = MASK(USBPHY_CTRL_SFTRST);
    R32(BASE_USBPHY1, USBPHY_CTRL_CLR) = MASK(USBPHY_CTRL_SFTRST);
    R32(BASE_USBPHY1, USBPHY_CTRL_CLR) = MASK(USBPHY_CTRL_CLKGATE);
    R32(BASE_USBPHY1, USBPHY_CTRL_SET) = MASK(USBPHY_CTRL_ENUTMILEVEL2) | MASK(USBPHY_CTRL_ENUTMILEVEL3);
    R32(BASE_USBPHY1, USBPHY_PWD) = 0; /* everything on */
    return true;
}
