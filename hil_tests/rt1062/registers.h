/* Registers and fields of the i.MX RT1062 that the model (chip.h) needs besides those of the port
 * (firmware/port/imxrt1062/imxrt1062_registers.h, which also explains the form of the lines). The command
 * `make registers` compares this header with the same public description of the chip. */
#ifndef CRN_RT1062_REGISTERS_H
#define CRN_RT1062_REGISTERS_H

#define CCM_ANALOG_PLL_ARM_POWERDOWN 12, 1
#define CCM_ANALOG_PLL_SYS 0x30u
#define CCM_ANALOG_PLL_SYS_POWERDOWN 12, 1
#define CCM_ANALOG_PLL_SYS_ENABLE 13, 1
#define CCM_ANALOG_PLL_SYS_BYPASS 16, 1
#define CCM_ANALOG_PLL_USB1_DIV_SELECT 1, 1
#define CCM_ANALOG_PFD_528 0x100u
#define CCM_ANALOG_PFD_528_PFD2_FRAC 16, 6
#define CCM_ANALOG_PFD_528_PFD2_CLKGATE 23, 1

#define SRC_SRSR_IPP_RESET_B 0, 1

#define PIT_MCR_MDIS 1, 1

#define WDOG_WMCR_PDE 0, 1

#define GPIO_DR 0x0u

#define PWM_SMVAL0_0 0xau
#define PWM_FSTS0_FHALF 12, 4

#define FLEXSPI_INTR_AHBCMDERR 4, 1

#define USB_USBINTR 0x148u
#define USB_USBSTS_UI 0, 1
#define USB_PORTSC1_CCS 0, 1

#define USBPHY_CTRL 0x30u

#endif
