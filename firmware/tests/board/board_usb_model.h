/* This header compiles firmware/port/imxrt1062/usb_udc.c unchanged against a model of the controller as the
 * chip's manual describes it (i.MX RT1060, chapter 42). The model of the USB controller covers queue heads,
 * transfer descriptors, the priming and flushing of endpoints, bits that are cleared by writing ones, the
 * trip wire of setup packets, and the host on the bus. The code accesses every register through the macros
 * LOAD and STORE of imxrt1062_registers.h, which the model defines here. */
#ifndef CRN_BOARD_USB_MODEL_H
#define CRN_BOARD_USB_MODEL_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static volatile uint32_t *model_place(uint32_t base, uint32_t offset);
static uint32_t model_load(volatile uint32_t *where);
static void model_store(volatile uint32_t *where, uint32_t value);

#define R32(base, offset) (*model_place(base, offset))
#define LOAD(REGISTER) model_load(&(REGISTER))
#define STORE(REGISTER, value) model_store(&(REGISTER), value)
#define CRN_CORTEX_M7_H /* the test machine has no such processor */
static inline void core_data_barrier(void) {}
#include "firmware/port/imxrt1062/usb_udc.c"

/* --- the controller ------------------------------------------------------------------------------------- */
enum { REGISTER_BYTES = 0x200, STATUS_TRANSFER = 1 };

typedef enum host_answer { HOST_ACKED, HOST_NAKED, HOST_STALLED, HOST_SILENT } host_answer;

static struct model {
    volatile uint32_t cells[REGISTER_BYTES / 4];
    uint32_t done[PIPES]; /* bytes of the transfer under way */
    uint32_t armed[PIPES];
    unsigned toggle[PIPES];
    int flushes_outlived;      /* number of flushes during which a packet is still under way */
    const uint8_t *next_setup; /* arrives while the one before is being read */
} model;

static volatile uint32_t *cell(uint32_t offset)
{
    return &model.cells[offset / 4];
}

static volatile uint32_t *model_place(uint32_t base, uint32_t offset)
{
    assert_int_equal(base, BASE_USB1);
    assert_true(offset < REGISTER_BYTES && offset % 4 == 0);
    return cell(offset);
}

/* Transfer descriptors hold only 32 bits of an address. The model chooses the missing upper bits of an
 * address so that the address lies as near as possible to the model's own memory. */
static uint8_t *address_of(uint32_t low)
{
    uintptr_t here = (uintptr_t)&memory;
    return (uint8_t *)(here + (uintptr_t)(intptr_t)(int32_t)(low - (uint32_t)here));
}

static usb_transfer *transfer_of(uint32_t pipe)
{
    return (usb_transfer *)(void *)address_of(memory.heads[pipe].current);
}

static uint32_t pipe_bit(uint32_t pipe)
{
    return 1u << (pipe / 2 + (pipe % 2) * 16);
}

static void take_setup_bytes(const uint8_t bytes[8])
{
    for (int i = 0; i < 8; i++) memory.heads[0].setup[i] = bytes[i];
    *cell(USB_ENDPTSETUPSTAT) |= 1;
    *cell(USB_USBCMD) &= ~MASK(USB_USBCMD_SUTW);
    *cell(USB_ENDPTCTRL0) &= ~(MASK(USB_ENDPTCTRL0_RXS) | MASK(USB_ENDPTCTRL0_TXS));
    model.toggle[0] = model.toggle[1] = 1;
}

static uint32_t model_load(volatile uint32_t *where)
{
    if (where == cell(USB_USBCMD) && (*where & MASK(USB_USBCMD_SUTW)) != 0 && model.next_setup != NULL) {
        take_setup_bytes(model.next_setup);
        model.next_setup = NULL;
    }
    return *where;
}

static void prime_pipe(uint32_t pipe)
{
    usb_head *head = &memory.heads[pipe];
    if (pipe < 2 && *cell(USB_ENDPTSETUPSTAT) != 0)
        return; /* required by the manual: not before the setup packet is taken */
    assert_int_equal(*cell(USB_ASYNCLISTADDR), (uint32_t)(uintptr_t)memory.heads);
    assert_int_equal(head->next % 32, 0);
    assert_int_equal(head->token & (TOKEN_ACTIVE | TOKEN_HALTED), 0);
    head->current = head->next;
    usb_transfer *transfer = transfer_of(pipe);
    assert_int_equal(transfer->next & 1, LINK_END);
    assert_true((transfer->token & TOKEN_ACTIVE) != 0);
    model.done[pipe] = 0;
    model.armed[pipe] = transfer->token >> TOKEN_BYTES_SHIFT & TOKEN_BYTES_MASK;
    *cell(USB_ENDPTSTAT) |= pipe_bit(pipe);
}

static void write_control(uint32_t number, uint32_t value)
{
    /* The control bits RXR and TXR reset the data toggles of the two directions of an endpoint. */
    if (number != 0 && (value & MASK(USB_ENDPTCTRL_0_RXR)) != 0) model.toggle[2 * number] = 0;
    if (number != 0 && (value & MASK(USB_ENDPTCTRL_0_TXR)) != 0) model.toggle[2 * number + 1] = 0;
    *cell(USB_ENDPTCTRL0 + 4 * number) = value & ~(MASK(USB_ENDPTCTRL_0_RXR) | MASK(USB_ENDPTCTRL_0_TXR));
}

static void model_store(volatile uint32_t *where, uint32_t value)
{
    const uint32_t offset = (uint32_t)(where - model.cells) * 4;
    switch (offset) {
    case USB_USBCMD:
        if (value & MASK(USB_USBCMD_RST)) memset((void *)(uintptr_t)model.cells, 0, sizeof model.cells);
        *where = value & ~MASK(USB_USBCMD_RST);
        break;
    case USB_USBSTS:
    case USB_ENDPTSETUPSTAT:
    case USB_ENDPTCOMPLETE:
        *where &= ~value; /* cleared by ones */
        break;
    case USB_ENDPTPRIME:
        for (uint32_t pipe = 0; pipe < PIPES; pipe++)
            if (value & pipe_bit(pipe)) prime_pipe(pipe);
        break;
    case USB_ENDPTFLUSH:
        if (model.flushes_outlived > 0)
            model.flushes_outlived--;
        else
            *cell(USB_ENDPTSTAT) &= ~value;
        break;
    case USB_PORTSC1: /* only the test mode is ever written here */
        *where = (*where & ~MASK(USB_PORTSC1_PTC)) | (value & MASK(USB_PORTSC1_PTC));
        break;
    case USB_ENDPTSTAT:
        fail_msg("ENDPTSTAT is read only");
        break;
    default:
        if (offset >= USB_ENDPTCTRL0 && offset < USB_ENDPTCTRL0 + 4 * ENDPOINTS)
            write_control((offset - USB_ENDPTCTRL0) / 4, value);
        else
            *where = value;
    }
}

/* --- the host on the bus -------------------------------------------------------------------------------- */
static uint8_t *buffer_byte(uint32_t pipe, uint32_t index)
{
    const usb_transfer *transfer = transfer_of(pipe);
    const uint32_t place = transfer->pages[0] % PAGE_BYTES + index;
    assert_true(place / PAGE_BYTES < PAGES);
    return address_of((transfer->pages[place / PAGE_BYTES] & ~(PAGE_BYTES - 1u)) + place % PAGE_BYTES);
}

static void retire(uint32_t pipe, uint32_t left, uint32_t status)
{
    transfer_of(pipe)->token = left << TOKEN_BYTES_SHIFT | TOKEN_INTERRUPT | status;
    *cell(USB_ENDPTSTAT) &= ~pipe_bit(pipe);
    *cell(USB_ENDPTCOMPLETE) |= pipe_bit(pipe);
    *cell(USB_USBSTS) |= STATUS_TRANSFER;
}

/* Returns HOST_ACKED if a transfer is ready for this token. */
static host_answer look(uint32_t pipe)
{
    const uint32_t number = pipe / 2, control = *cell(USB_ENDPTCTRL0 + 4 * number);
    const uint32_t enabled = pipe % 2 ? MASK(USB_ENDPTCTRL_0_TXE) : MASK(USB_ENDPTCTRL_0_RXE),
                   stalled = pipe % 2 ? MASK(USB_ENDPTCTRL_0_TXS) : MASK(USB_ENDPTCTRL_0_RXS);
    if ((*cell(USB_USBCMD) & MASK(USB_USBCMD_RS)) == 0) return HOST_SILENT;
    if (number != 0 && (control & enabled) == 0) return HOST_SILENT;
    if (control & stalled) return HOST_STALLED;
    return *cell(USB_ENDPTSTAT) & pipe_bit(pipe) ? HOST_ACKED : HOST_NAKED;
}

static uint32_t packet_bytes(uint32_t pipe)
{
    return memory.heads[pipe].capabilities >> HEAD_PACKET_SHIFT & 0x7ff;
}

static host_answer host_in(uint32_t number, uint8_t *bytes, uint32_t *count)
{
    const uint32_t pipe = 2 * number + 1, most = packet_bytes(pipe);
    const host_answer answer = look(pipe);
    *count = 0;
    if (answer != HOST_ACKED) return answer;
    const uint32_t left = model.armed[pipe] - model.done[pipe];
    *count = left < most ? left : most;
    for (uint32_t i = 0; i < *count; i++) bytes[i] = *buffer_byte(pipe, model.done[pipe] + i);
    model.done[pipe] += *count;
    model.toggle[pipe] ^= 1;
    const bool ends_by_itself = (memory.heads[pipe].capabilities & HEAD_NO_EMPTY_PACKETS) != 0;
    if (*count == left && (ends_by_itself || *count < most)) retire(pipe, 0, 0);
    return HOST_ACKED;
}

static host_answer host_out(uint32_t number, const uint8_t *bytes, uint32_t count)
{
    const uint32_t pipe = 2 * number;
    const host_answer answer = look(pipe);
    if (answer != HOST_ACKED) return answer;
    const uint32_t left = model.armed[pipe] - model.done[pipe];
    model.toggle[pipe] ^= 1;
    if (count > left) {
        retire(pipe, left, TOKEN_HALTED);
        return HOST_ACKED;
    }
    for (uint32_t i = 0; i < count; i++) *buffer_byte(pipe, model.done[pipe] + i) = bytes[i];
    model.done[pipe] += count;
    if (count == left || count < packet_bytes(pipe)) retire(pipe, left - count, 0);
    return HOST_ACKED;
}

/* A setup packet does not end a transfer that was primed on endpoint 0; the driver has to remove this
 * transfer. */
static void host_setup(const uint8_t bytes[8])
{
    take_setup_bytes(bytes);
}

static void host_reset_begins(void)
{
    *cell(USB_PORTSC1) = MASK(USB_PORTSC1_PR);
    *cell(USB_USBSTS) |= MASK(USB_USBSTS_URI);
}

static void host_reset_ends(uint32_t speed)
{
    *cell(USB_PORTSC1) = BITS(USB_PORTSC1_PSPD, speed);
    *cell(USB_USBSTS) |= MASK(USB_USBSTS_PCI);
}

#endif
