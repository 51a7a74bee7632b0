/* The transceiver of USB1: it works when it is out of reset, its clock gate is open (CLKGATE 0), nothing of
 * it is powered down, and the 480 MHz and its 3 V supply run. Behaviour: reference manual, chapter USBPHY,
 * from memory. */
#include "hil_tests/rt1062/chip.h"

#define USBPHY_PWD_ALL 0x001e1c00u

uint32_t rt_usb_phy_read(rt_chip *chip, uint32_t offset)
{
    if (offset == USBPHY_PWD) return chip->usb.phy_pwd;
    if (offset == USBPHY_CTRL) return chip->usb.phy_control;
    rt_unmodelled(chip, "USBPHY1", offset, false);
    return 0;
}

void rt_usb_phy_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_usb *usb = &chip->usb;
    bool is_in_reset = (usb->phy_control & MASK(USBPHY_CTRL_SFTRST)) != 0;
    if (offset == USBPHY_CTRL_SET) {
        usb->phy_control |= value;
        if (value & MASK(USBPHY_CTRL_SFTRST)) { /* the reset stops the clock, too, and powers all down */
            usb->phy_control |= MASK(USBPHY_CTRL_CLKGATE);
            usb->phy_pwd = USBPHY_PWD_ALL;
        }
    } else if (offset == USBPHY_CTRL_CLR) {
        usb->phy_control &= ~value;
    } else if (offset == USBPHY_PWD) {
        if (is_in_reset) rt_find(chip, "USBPHY1_PWD is written while the transceiver is in reset");
        if (!is_in_reset) usb->phy_pwd = value;
    } else {
        rt_unmodelled(chip, "USBPHY1", offset, true);
    }
}

bool rt_usb_phy_runs(rt_chip *chip)
{
    const rt_usb *usb = &chip->usb;
    return (usb->phy_control & (MASK(USBPHY_CTRL_SFTRST) | MASK(USBPHY_CTRL_CLKGATE))) == 0 &&
           usb->phy_pwd == 0 && rt_clock_usb_runs(chip) && rt_gate_is_open(chip, 6, 0);
}
