/* This port has never run on hardware. This header has the i.MX RT1062's registers that this port uses, and
 * no others.
 *
 *   BASE_<instance>            address of a peripheral
 *   <MODULE>_<REGISTER>        offset; _0 is the first of an array, <MODULE>_STRIDE_<REGISTER> the step to the next
 *   <MODULE>_<REGISTER>_<FIELD> lowest bit, bits
 *   PAD_<pad>_<function>       offset of its mux register, its mux mode, offset of its pad register (of IOMUXC)
 *   DAISY_<input>_<pad>        offset of an input's selection register, its value (of IOMUXC)
 *
 * The command `make registers` (tools/check/check_registers.py) compares every line of this header, and the
 * width of every access, with the machine-readable description in the crate imxrt-ral. */
#ifndef CRN_IMXRT1062_REGISTERS_H
#define CRN_IMXRT1062_REGISTERS_H

#include <stdint.h>

#ifndef R32
#define R16(base, offset) (*(volatile uint16_t *)(uintptr_t)((base) + (offset)))
#define R32(base, offset) (*(volatile uint32_t *)(uintptr_t)((base) + (offset)))
/* If a test provides a model of the chip, the macros LOAD and STORE tell the model the name of the register
 * and let the model carry out the access. */
#define LOAD(REGISTER) (REGISTER)
#define STORE(REGISTER, value) ((REGISTER) = (value))
#endif

/* In BITS(FIELD, value), MASK(FIELD) and SET_FIELD(REGISTER, FIELD, value), FIELD is one of the pairs of
 * numbers (first bit, number of bits) that this header defines. */
#define BITS(...) BITS_(__VA_ARGS__)
#define BITS_(shift, bits, value) ((uint32_t)(value) << (shift))
#define MASK(...) MASK_(__VA_ARGS__)
#define MASK_(shift, bits) (((1u << (bits)) - 1u) << (shift))
#define SET_FIELD(REGISTER, FIELD, value) ((REGISTER) = ((REGISTER) & ~MASK(FIELD)) | BITS(FIELD, value))

#define BASE_CCM 0x400fc000u
#define CCM_CACRR 0x10u
#define CCM_CACRR_ARM_PODF 0, 3
#define CCM_CBCDR 0x14u
#define CCM_CBCDR_IPG_PODF 8, 2
#define CCM_CBCDR_AHB_PODF 10, 3
#define CCM_CBCDR_PERIPH_CLK_SEL 25, 1
#define CCM_CBCDR_PERIPH_CLK2_PODF 27, 3
#define CCM_CBCMR 0x18u
#define CCM_CBCMR_FLEXSPI2_CLK_SEL 8, 2
#define CCM_CBCMR_PERIPH_CLK2_SEL 12, 2
#define CCM_CBCMR_PRE_PERIPH_CLK_SEL 18, 2
#define CCM_CBCMR_FLEXSPI2_PODF 29, 3
#define CCM_CSCMR1 0x1cu
#define CCM_CSCMR1_PERCLK_PODF 0, 6
#define CCM_CSCMR1_PERCLK_CLK_SEL 6, 1
#define CCM_CSCDR1 0x24u
#define CCM_CSCDR1_UART_CLK_PODF 0, 6
#define CCM_CSCDR1_UART_CLK_SEL 6, 1
#define CCM_CDHIPR 0x48u
#define CCM_CDHIPR_AHB_PODF_BUSY 1, 1
#define CCM_CDHIPR_PERIPH_CLK_SEL_BUSY 5, 1
#define CCM_CDHIPR_ARM_PODF_BUSY 16, 1
#define CCM_CCGR0 0x68u
#define CCM_CCGR7 0x84u

#define BASE_CCM_ANALOG 0x400d8000u
#define CCM_ANALOG_PLL_ARM 0x0u
#define CCM_ANALOG_PLL_ARM_DIV_SELECT 0, 7
#define CCM_ANALOG_PLL_ARM_ENABLE 13, 1
#define CCM_ANALOG_PLL_ARM_BYPASS 16, 1
#define CCM_ANALOG_PLL_ARM_LOCK 31, 1
#define CCM_ANALOG_PLL_USB1 0x10u
#define CCM_ANALOG_PLL_USB1_EN_USB_CLKS 6, 1
#define CCM_ANALOG_PLL_USB1_POWER 12, 1
#define CCM_ANALOG_PLL_USB1_ENABLE 13, 1
#define CCM_ANALOG_PLL_USB1_BYPASS 16, 1
#define CCM_ANALOG_PLL_USB1_LOCK 31, 1

#define BASE_PMU 0x400d8000u
#define PMU_REG_3P0 0x120u
#define PMU_REG_3P0_ENABLE_LINREG 0, 1

#define BASE_DCDC 0x40080000u
#define DCDC_REG0 0x0u
#define DCDC_REG0_STS_DC_OK 31, 1
#define DCDC_REG3 0xcu
#define DCDC_REG3_TRG 0, 5

#define BASE_IOMUXC_GPR 0x400ac000u
#define IOMUXC_GPR_GPR6 0x18u
#define IOMUXC_GPR_GPR6_QTIMER1_TRM0_INPUT_SEL 0, 1
#define IOMUXC_GPR_GPR6_QTIMER1_TRM1_INPUT_SEL 1, 1
#define IOMUXC_GPR_GPR6_QTIMER3_TRM0_INPUT_SEL 8, 1
#define IOMUXC_GPR_GPR6_QTIMER3_TRM1_INPUT_SEL 9, 1
#define IOMUXC_GPR_GPR6_QTIMER3_TRM2_INPUT_SEL 10, 1
#define IOMUXC_GPR_GPR6_QTIMER3_TRM3_INPUT_SEL 11, 1
#define IOMUXC_GPR_GPR14 0x38u
#define IOMUXC_GPR_GPR14_CM7_CFGITCMSZ 16, 4
#define IOMUXC_GPR_GPR14_CM7_CFGDTCMSZ 20, 4
#define IOMUXC_GPR_GPR16 0x40u
#define IOMUXC_GPR_GPR16_INIT_ITCM_EN 0, 1
#define IOMUXC_GPR_GPR16_INIT_DTCM_EN 1, 1
#define IOMUXC_GPR_GPR16_FLEXRAM_BANK_CFG_SEL 2, 1
#define IOMUXC_GPR_GPR17 0x44u
#define IOMUXC_GPR_GPR26 0x68u
#define IOMUXC_GPR_GPR29 0x74u

#define BASE_OCOTP 0x401f4000u
#define OCOTP_CFG0 0x410u
#define OCOTP_CFG1 0x420u

#define BASE_SRC 0x400f8000u
#define SRC_SRSR 0x8u
#define SRC_SRSR_WDOG_RST_B 4, 1
#define SRC_SRSR_WDOG3_RST_B 7, 1

#define BASE_PIT 0x40084000u
#define PIT_MCR 0x0u
#define PIT_LDVAL_0 0x100u
#define PIT_TCTRL_0 0x108u
#define PIT_TCTRL_0_TEN 0, 1
#define PIT_TCTRL_0_TIE 1, 1
#define PIT_TFLG_0 0x10cu
#define PIT_TFLG_0_TIF 0, 1

#define BASE_GPT1 0x401ec000u
#define GPT_CR 0x0u
#define GPT_CR_EN 0, 1
#define GPT_CR_ENMOD 1, 1
#define GPT_CR_WAITEN 3, 1
#define GPT_CR_CLKSRC 6, 3
#define GPT_CR_FRR 9, 1
#define GPT_CR_SWR 15, 1
#define GPT_PR 0x4u
#define GPT_PR_PRESCALER 0, 12
#define GPT_CNT 0x24u

#define BASE_WDOG1 0x400b8000u
#define WDOG_WCR 0x0u
#define WDOG_WCR_WDE 2, 1
#define WDOG_WCR_WDBG 1, 1
#define WDOG_WCR_SRS 4, 1
#define WDOG_WCR_WDA 5, 1
#define WDOG_WCR_WT 8, 8
#define WDOG_WSR 0x2u
#define WDOG_WMCR 0x8u

#define BASE_RTWDOG 0x400bc000u
#define RTWDOG_CS 0x0u
#define RTWDOG_CS_UPDATE 5, 1
#define RTWDOG_CS_EN 7, 1
#define RTWDOG_CNT 0x4u
#define RTWDOG_TOVAL 0x8u

#define BASE_GPIO1 0x401b8000u
#define BASE_GPIO2 0x401bc000u
#define BASE_GPIO3 0x401c0000u
#define GPIO_GDIR 0x4u
#define GPIO_PSR 0x8u
#define GPIO_DR_SET 0x84u
#define GPIO_DR_CLEAR 0x88u

#define BASE_LPUART6 0x40198000u
#define LPUART_BAUD 0x10u
#define LPUART_BAUD_SBR 0, 13
#define LPUART_BAUD_OSR 24, 5
#define LPUART_STAT 0x14u
#define LPUART_STAT_TDRE 23, 1
#define LPUART_CTRL 0x18u
#define LPUART_CTRL_TE 19, 1
#define LPUART_DATA 0x1cu

#define BASE_XBARA1 0x403bc000u
#define XBARA_SEL0 0x0u

#define BASE_ENC1 0x403c8000u
#define BASE_ENC2 0x403cc000u
#define BASE_ENC3 0x403d0000u
#define BASE_ENC4 0x403d4000u
#define ENC_CTRL 0x0u
#define ENC_CTRL_SWIP 11, 1
#define ENC_FILT 0x2u
#define ENC_FILT_FILT_PER 0, 8
#define ENC_FILT_FILT_CNT 8, 3
#define ENC_LPOS 0x10u
#define ENC_UPOSH 0x12u
#define ENC_UINIT 0x16u
#define ENC_LINIT 0x18u
#define ENC_CTRL2 0x1eu
#define ENC_CTRL2_SABIRQ 11, 1

#define BASE_TMR1 0x401dc000u
#define BASE_TMR3 0x401e4000u
#define TMR_CNTR0 0xau
#define TMR_CTRL0 0xcu
#define TMR_CTRL0_SCS 7, 2
#define TMR_CTRL0_PCS 9, 4
#define TMR_CTRL0_CM 13, 3
#define TMR_FILT0 0x16u
#define TMR_FILT0_FILT_PER 0, 8
#define TMR_FILT0_FILT_CNT 8, 3
#define TMR_ENBL 0x1eu
#define TMR_STRIDE_CTRL 0x20u

#define BASE_PWM2 0x403e0000u
#define BASE_PWM3 0x403e4000u
#define PWM_SMINIT_0 0x2u
#define PWM_SMCTRL2_0 0x4u
#define PWM_SMCTRL2_0_INDEP 13, 1
#define PWM_SMCTRL_0 0x6u
#define PWM_SMCTRL_0_FULL 10, 1
#define PWM_SMVAL1_0 0xeu
#define PWM_SMVAL2_0 0x12u
#define PWM_SMVAL3_0 0x16u
#define PWM_SMVAL4_0 0x1au
#define PWM_SMVAL5_0 0x1eu
#define PWM_SMDISMAP0_0 0x2cu
#define PWM_SMDISMAP0_0_DIS0A 0, 4
#define PWM_SMDISMAP0_0_DIS0B 4, 4
#define PWM_SMDISMAP0_0_DIS0X 8, 4
#define PWM_OUTEN 0x180u
#define PWM_OUTEN_PWMB_EN 4, 4
#define PWM_OUTEN_PWMA_EN 8, 4
#define PWM_MCTRL 0x188u
#define PWM_MCTRL_LDOK 0, 4
#define PWM_MCTRL_CLDOK 4, 4
#define PWM_MCTRL_RUN 8, 4
#define PWM_FCTRL0 0x18cu
#define PWM_FCTRL0_FSAFE 4, 4
#define PWM_FCTRL0_FAUTO 8, 4
#define PWM_FCTRL0_FLVL 12, 4
#define PWM_FSTS0 0x18eu
#define PWM_FSTS0_FFLAG 0, 4
#define PWM_FSTS0_FFULL 4, 4
#define PWM_FSTS0_FFPIN 8, 4
#define PWM_FFILT0 0x190u
#define PWM_FFILT0_FILT_PER 0, 8
#define PWM_FFILT0_FILT_CNT 8, 3
#define PWM_STRIDE_SMCTRL 0x60u

#define BASE_ADC1 0x400c4000u
#define BASE_ADC2 0x400c8000u
#define ADC_HC0 0x0u
#define ADC_HC0_ADCH 0, 5
#define ADC_HS 0x20u
#define ADC_HS_COCO0 0, 1
#define ADC_R0 0x24u
#define ADC_R0_CDATA 0, 12
#define ADC_CFG 0x44u
#define ADC_CFG_ADICLK 0, 2
#define ADC_CFG_MODE 2, 2
#define ADC_CFG_ADLSMP 4, 1
#define ADC_CFG_ADIV 5, 2
#define ADC_CFG_ADHSC 10, 1
#define ADC_CFG_AVGS 14, 2
#define ADC_GC 0x48u
#define ADC_GC_AVGE 5, 1
#define ADC_GC_CAL 7, 1
#define ADC_GS 0x4cu
#define ADC_GS_CALF 1, 1

#define BASE_FLEXSPI2 0x402a4000u
#define FLEXSPI_MCR0 0x0u
#define FLEXSPI_MCR0_SWRESET 0, 1
#define FLEXSPI_MCR0_MDIS 1, 1
#define FLEXSPI_MCR0_RXCLKSRC 4, 2
#define FLEXSPI_AHBCR 0xcu
#define FLEXSPI_AHBCR_CACHABLEEN 3, 1
#define FLEXSPI_AHBCR_BUFFERABLEEN 4, 1
#define FLEXSPI_AHBCR_READADDROPT 6, 1
#define FLEXSPI_INTR 0x14u
#define FLEXSPI_INTR_IPCMDDONE 0, 1
#define FLEXSPI_INTR_IPCMDERR 3, 1
#define FLEXSPI_LUTKEY 0x18u
#define FLEXSPI_LUTCR 0x1cu
#define FLEXSPI_LUTCR_UNLOCK 1, 1
#define FLEXSPI_FLSHA1CR0 0x60u
#define FLEXSPI_FLSHA1CR0_FLSHSZ 0, 23
#define FLEXSPI_FLSHCR1_0 0x70u
#define FLEXSPI_FLSHCR1_0_TCSS 0, 5
#define FLEXSPI_FLSHCR1_0_TCSH 5, 5
#define FLEXSPI_FLSHCR2_0 0x80u
#define FLEXSPI_FLSHCR2_0_ARDSEQID 0, 4
#define FLEXSPI_FLSHCR2_0_AWRSEQID 8, 4
#define FLEXSPI_IPCR0 0xa0u
#define FLEXSPI_IPCR1 0xa4u
#define FLEXSPI_IPCR1_ISEQID 16, 4
#define FLEXSPI_IPCMD 0xb0u
#define FLEXSPI_IPCMD_TRG 0, 1
#define FLEXSPI_STS0 0xe0u
#define FLEXSPI_STS0_SEQIDLE 0, 1
#define FLEXSPI_STS0_ARBIDLE 1, 1
#define FLEXSPI_LUT_0 0x200u
#define FLEXSPI_STRIDE_LUT 0x4u

#define BASE_USBPHY1 0x400d9000u
#define USBPHY_PWD 0x0u
#define USBPHY_CTRL_ENUTMILEVEL2 14, 1
#define USBPHY_CTRL_ENUTMILEVEL3 15, 1
#define USBPHY_CTRL_CLKGATE 30, 1
#define USBPHY_CTRL_SFTRST 31, 1
#define USBPHY_CTRL_SET 0x34u
#define USBPHY_CTRL_CLR 0x38u

#define BASE_USB1 0x402e0000u
#define USB_USBCMD 0x140u
#define USB_USBCMD_RS 0, 1
#define USB_USBCMD_RST 1, 1
#define USB_USBCMD_SUTW 13, 1
#define USB_USBCMD_ITC 16, 8
#define USB_USBSTS 0x144u
#define USB_USBSTS_PCI 2, 1
#define USB_USBSTS_URI 6, 1
#define USB_USBSTS_SLI 8, 1
#define USB_FRINDEX 0x14cu
#define USB_FRINDEX_FRINDEX 0, 14
#define USB_DEVICEADDR 0x154u
#define USB_DEVICEADDR_USBADR 25, 7
#define USB_ASYNCLISTADDR 0x158u
#define USB_PORTSC1 0x184u
#define USB_PORTSC1_PR 8, 1
#define USB_PORTSC1_SUSP 7, 1
#define USB_PORTSC1_PTC 16, 4
#define USB_PORTSC1_PSPD 26, 2
#define USB_OTGSC 0x1a4u
#define USB_OTGSC_BSV 11, 1
#define USB_USBMODE 0x1a8u
#define USB_USBMODE_CM 0, 2
#define USB_USBMODE_SLOM 3, 1
#define USB_ENDPTSETUPSTAT 0x1acu
#define USB_ENDPTPRIME 0x1b0u
#define USB_ENDPTFLUSH 0x1b4u
#define USB_ENDPTSTAT 0x1b8u
#define USB_ENDPTCOMPLETE 0x1bcu
#define USB_ENDPTCTRL0 0x1c0u
#define USB_ENDPTCTRL0_RXS 0, 1
#define USB_ENDPTCTRL0_TXS 16, 1
#define USB_ENDPTCTRL_0 0x1c4u
#define USB_ENDPTCTRL_0_RXS 0, 1
#define USB_ENDPTCTRL_0_RXT 2, 2
#define USB_ENDPTCTRL_0_RXR 6, 1
#define USB_ENDPTCTRL_0_RXE 7, 1
#define USB_ENDPTCTRL_0_TXS 16, 1
#define USB_ENDPTCTRL_0_TXT 18, 2
#define USB_ENDPTCTRL_0_TXR 22, 1
#define USB_ENDPTCTRL_0_TXE 23, 1
#define USB_STRIDE_ENDPTCTRL 0x4u

#define BASE_IOMUXC 0x401f8000u
#define PAD_EMC_04_XBAR1_INOUT06 0x24u, 3, 0x214u
#define DAISY_XBAR1_IN06_EMC_04 0x61cu, 0
#define PAD_EMC_05_XBAR1_INOUT07 0x28u, 3, 0x218u
#define DAISY_XBAR1_IN07_EMC_05 0x620u, 0
#define PAD_EMC_06_XBAR1_INOUT08 0x2cu, 3, 0x21cu
#define DAISY_XBAR1_IN08_EMC_06 0x624u, 0
#define PAD_EMC_07_XBAR1_INOUT09 0x30u, 3, 0x220u
#define DAISY_XBAR1_IN09_EMC_07 0x628u, 0
#define PAD_EMC_36_XBAR1_IN22 0xa4u, 1, 0x294u
#define DAISY_XBAR1_IN22_EMC_36 0x638u, 0
#define PAD_EMC_37_XBAR1_IN23 0xa8u, 1, 0x298u
#define DAISY_XBAR1_IN23_EMC_37 0x63cu, 0
#define PAD_B1_00_XBAR1_INOUT14 0x17cu, 1, 0x36cu
#define DAISY_XBAR1_IN14_B1_00 0x644u, 1
#define PAD_B1_01_XBAR1_INOUT15 0x180u, 1, 0x370u
#define DAISY_XBAR1_IN15_B1_01 0x648u, 1
#define PAD_EMC_08_XBAR1_INOUT17 0x34u, 3, 0x224u
#define DAISY_XBAR1_IN17_EMC_08 0x62cu, 0
#define PAD_AD_B1_00_QTIMER3_TIMER0 0xfcu, 1, 0x2ecu
#define DAISY_QTIMER3_TIMER0_AD_B1_00 0x57cu, 1
#define PAD_AD_B1_01_QTIMER3_TIMER1 0x100u, 1, 0x2f0u
#define DAISY_QTIMER3_TIMER1_AD_B1_01 0x580u, 0
#define PAD_AD_B1_02_QTIMER3_TIMER2 0x104u, 1, 0x2f4u
#define DAISY_QTIMER3_TIMER2_AD_B1_02 0x584u, 1
#define PAD_AD_B1_03_QTIMER3_TIMER3 0x108u, 1, 0x2f8u
#define DAISY_QTIMER3_TIMER3_AD_B1_03 0x588u, 1
#define PAD_B0_00_QTIMER1_TIMER0 0x13cu, 1, 0x32cu
#define PAD_B0_01_QTIMER1_TIMER1 0x140u, 1, 0x330u
#define PAD_B0_10_FLEXPWM2_PWMA02 0x164u, 2, 0x354u
#define PAD_B0_11_FLEXPWM2_PWMB02 0x168u, 2, 0x358u
#define PAD_B1_02_FLEXPWM2_PWMA03 0x184u, 6, 0x374u
#define PAD_B1_03_FLEXPWM2_PWMB03 0x188u, 6, 0x378u
#define PAD_EMC_31_FLEXPWM3_PWMA01 0x90u, 1, 0x280u
#define PAD_EMC_32_FLEXPWM3_PWMB01 0x94u, 1, 0x284u
#define PAD_SD_B0_00_GPIO3_IO12 0x1bcu, 5, 0x3acu
#define PAD_SD_B0_01_GPIO3_IO13 0x1c0u, 5, 0x3b0u
#define PAD_SD_B0_02_GPIO3_IO14 0x1c4u, 5, 0x3b4u
#define PAD_SD_B0_03_GPIO3_IO15 0x1c8u, 5, 0x3b8u
#define PAD_SD_B0_04_GPIO3_IO16 0x1ccu, 5, 0x3bcu
#define PAD_SD_B0_05_GPIO3_IO17 0x1d0u, 5, 0x3c0u
#define PAD_B0_12_GPIO2_IO12 0x16cu, 5, 0x35cu
#define PAD_AD_B1_15_GPIO1_IO31 0x138u, 5, 0x328u
#define PAD_B0_03_GPIO2_IO03 0x148u, 5, 0x338u
#define PAD_AD_B0_12_GPIO1_IO12 0xecu, 5, 0x2dcu
#define PAD_AD_B0_13_GPIO1_IO13 0xf0u, 5, 0x2e0u
#define PAD_B0_02_GPIO2_IO02 0x144u, 5, 0x334u
#define PAD_B1_12_GPIO2_IO28 0x1acu, 5, 0x39cu
#define PAD_B1_13_GPIO2_IO29 0x1b0u, 5, 0x3a0u
#define PAD_AD_B0_02_LPUART6_TX 0xc4u, 2, 0x2b4u
#define DAISY_LPUART6_TX_AD_B0_02 0x554u, 1
#define PAD_AD_B1_06_GPIO1_IO22 0x114u, 5, 0x304u
#define PAD_AD_B1_07_GPIO1_IO23 0x118u, 5, 0x308u
#define PAD_AD_B1_08_GPIO1_IO24 0x11cu, 5, 0x30cu
#define PAD_AD_B1_09_GPIO1_IO25 0x120u, 5, 0x310u
#define PAD_AD_B1_10_GPIO1_IO26 0x124u, 5, 0x314u
#define PAD_AD_B1_11_GPIO1_IO27 0x128u, 5, 0x318u
#define PAD_AD_B1_04_GPIO1_IO20 0x10cu, 5, 0x2fcu
#define PAD_AD_B1_14_GPIO1_IO30 0x134u, 5, 0x324u
#define PAD_EMC_23_FLEXSPI2_A_DQS 0x70u, 8, 0x260u
#define DAISY_FLEXSPI2_IPP_IND_DQS_FA_EMC_23 0x72cu, 1
#define PAD_EMC_24_FLEXSPI2_A_SS0_B 0x74u, 8, 0x264u
#define PAD_EMC_25_FLEXSPI2_A_SCLK 0x78u, 8, 0x268u
#define DAISY_FLEXSPI2_IPP_IND_SCK_FA_EMC_25 0x750u, 1
#define PAD_EMC_26_FLEXSPI2_A_DATA00 0x7cu, 8, 0x26cu
#define DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT0_EMC_26 0x730u, 1
#define PAD_EMC_27_FLEXSPI2_A_DATA01 0x80u, 8, 0x270u
#define DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT1_EMC_27 0x734u, 1
#define PAD_EMC_28_FLEXSPI2_A_DATA02 0x84u, 8, 0x274u
#define DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT2_EMC_28 0x738u, 1
#define PAD_EMC_29_FLEXSPI2_A_DATA03 0x88u, 8, 0x278u
#define DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT3_EMC_29 0x73cu, 1
#define IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_DSE 3, 3
#define IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_SPEED 6, 2
#define IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PKE 12, 1
#define IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PUE 13, 1
#define IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_PUS 14, 2
#define IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_HYS 16, 1

#endif
