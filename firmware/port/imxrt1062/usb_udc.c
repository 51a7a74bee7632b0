/* This port has never run on hardware. This file is the driver of the USB device controller (EHCI's
 * registers, used from the device's side), and provides the functions of firmware/port/udc.h.
 *
 * Every endpoint has a queue head (64 bytes, in one table whose address the controller holds) and one
 * transfer descriptor of up to 16 kB. To arm an endpoint, the driver writes the descriptor, lets the queue
 * head point to the descriptor, and primes the endpoint. Once an endpoint is primed, the controller transfers
 * the packets, and sets a bit of ENDPTCOMPLETE when the transfer is done. Queue heads, descriptors and
 * buffers lie in memory that is not cached (the section .dma, or tightly coupled memory). The USB interrupts
 * stay off; poll() reads the controller's events. Every loop has a bound. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/cortex_m7.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum {
    ENDPOINTS = 8,
    PIPES = 2 * ENDPOINTS, /* out 0, in 0, out 1, in 1 ... in the order of the controller's table */
    PAGES = 5,
    PAGE_BYTES = 4096,
    TRANSFER_BYTES_MAX = (PAGES - 1) * PAGE_BYTES, /* fits wherever in a page the transfer begins */
    WAIT_MAX = 1000,                               /* turns: some microseconds */
    LINK_END = 1,
    TOKEN_ACTIVE = 1 << 7,
    TOKEN_HALTED = 1 << 6,
    TOKEN_ERRORS = 1 << 5 | 1 << 3, /* data buffer, transaction */
    TOKEN_INTERRUPT = 1 << 15,
    TOKEN_BYTES_SHIFT = 16,
    TOKEN_BYTES_MASK = 0x7fff,
    HEAD_INTERRUPT_ON_SETUP = 1 << 15,
    HEAD_NO_EMPTY_PACKETS = 1 << 29, /* the stack itself requests an empty packet when one is due */
    HEAD_PACKET_SHIFT = 16,
    IN_SHIFT = 16, /* in the endpoint bit maps: OUT below, IN above */
    SPEED_HIGH = 2,
    MODE_DEVICE = 2,
    TYPE_UNUSED = CRN_UDC_BULK, /* the other direction of an endpoint must not be a control one */
};

typedef struct usb_transfer {
    volatile uint32_t next, token, pages[PAGES];
    uint32_t padding;
} usb_transfer;

typedef struct usb_head {
    volatile uint32_t capabilities, current;
    volatile uint32_t next, token, pages[PAGES];
    uint32_t reserved;
    volatile uint8_t setup[CRN_UDC_SETUP_BYTES];
    uint32_t padding[4];
} usb_head;
_Static_assert(sizeof(usb_transfer) == 32 && sizeof(usb_head) == 64, "the controller's layout");

static struct usb_memory {
    _Alignas(2048) usb_head heads[PIPES];
    _Alignas(32) usb_transfer transfers[PIPES];
} memory __attribute__((section(".dma"), aligned(2048)));

static struct usb_controller {
    uint32_t armed_bytes[PIPES];
    uint32_t complete; /* bits taken from ENDPTCOMPLETE and not yet reported */
    bool is_resetting, is_suspended, has_power;
    crn_udc udc;
} controller;

static uint32_t pipe_of(uint8_t endpoint)
{
    return 2u * (endpoint % ENDPOINTS) + (endpoint & CRN_UDC_IN ? 1u : 0u);
}

static uint32_t bit_of(uint8_t endpoint)
{
    return 1u << (endpoint % ENDPOINTS + (endpoint & CRN_UDC_IN ? IN_SHIFT : 0));
}

static volatile uint32_t *control_of(uint8_t endpoint)
{
    uint32_t number = endpoint % ENDPOINTS;
    if (number == 0) return &R32(BASE_USB1, USB_ENDPTCTRL0);
    return &R32(BASE_USB1, USB_ENDPTCTRL_0 + (number - 1) * USB_STRIDE_ENDPTCTRL);
}

static void change(volatile uint32_t *where, uint32_t mask, uint32_t bits)
{
    STORE(*where, (LOAD(*where) & ~mask) | bits);
}

static void wait_clear(volatile uint32_t *where, uint32_t bits)
{
    for (int i = 0; i < WAIT_MAX && (LOAD(*where) & bits) != 0; i++) {
    }
}

/* One flush may not end a packet that is being transferred, so the driver flushes the endpoint again until
 * its status shows that no transfer is ready. */
static void flush(uint32_t bits)
{
    for (int i = 0; i < 4; i++) {
        STORE(R32(BASE_USB1, USB_ENDPTFLUSH), bits);
        wait_clear(&R32(BASE_USB1, USB_ENDPTFLUSH), bits);
        if ((LOAD(R32(BASE_USB1, USB_ENDPTSTAT)) & bits) == 0) break;
    }
    STORE(R32(BASE_USB1, USB_ENDPTCOMPLETE), bits);
    controller.complete &= ~bits;
}

/* While a setup packet waits that the driver has not yet reported, a transfer or a stall of endpoint 0 would
 * answer the wrong request, and is void. */
static bool has_setup(void)
{
    return (LOAD(R32(BASE_USB1, USB_ENDPTSETUPSTAT)) & 1u) != 0;
}

/* --- requests of the stack --- */
static void udc_connect(void *context, bool connected)
{
    (void)context;
    change(&R32(BASE_USB1, USB_USBCMD), MASK(USB_USBCMD_RS), BITS(USB_USBCMD_RS, connected ? 1u : 0u));
}

static void udc_set_address(void *context, uint8_t address)
{
    (void)context;
    STORE(R32(BASE_USB1, USB_DEVICEADDR), BITS(USB_DEVICEADDR_USBADR, address));
}

static bool udc_open(void *context, uint8_t endpoint, crn_udc_type type, uint16_t packet_bytes)
{
    (void)context;
    if ((endpoint & 0x7fu) == 0 || (endpoint & 0x7fu) >= ENDPOINTS || packet_bytes > 1024) return false;
    usb_head *head = &memory.heads[pipe_of(endpoint)];
    volatile uint32_t *control = control_of(endpoint);
    flush(bit_of(endpoint));
    head->capabilities = (uint32_t)packet_bytes << HEAD_PACKET_SHIFT | HEAD_NO_EMPTY_PACKETS;
    head->next = LINK_END;
    head->token = 0;
    uint32_t value = LOAD(*control);
    if (endpoint & CRN_UDC_IN) {
        if ((value & MASK(USB_ENDPTCTRL_0_RXE)) == 0) SET_FIELD(value, USB_ENDPTCTRL_0_RXT, TYPE_UNUSED);
        value &= ~(MASK(USB_ENDPTCTRL_0_TXT) | MASK(USB_ENDPTCTRL_0_TXS));
        value |= BITS(USB_ENDPTCTRL_0_TXT, type) | MASK(USB_ENDPTCTRL_0_TXR) | MASK(USB_ENDPTCTRL_0_TXE);
    } else {
        if ((value & MASK(USB_ENDPTCTRL_0_TXE)) == 0) SET_FIELD(value, USB_ENDPTCTRL_0_TXT, TYPE_UNUSED);
        value &= ~(MASK(USB_ENDPTCTRL_0_RXT) | MASK(USB_ENDPTCTRL_0_RXS));
        value |= BITS(USB_ENDPTCTRL_0_RXT, type) | MASK(USB_ENDPTCTRL_0_RXR) | MASK(USB_ENDPTCTRL_0_RXE);
    }
    STORE(*control, value);
    return true;
}

static void udc_close(void *context, uint8_t endpoint)
{
    (void)context;
    if ((endpoint & 0x7fu) == 0) return;
    flush(bit_of(endpoint));
    change(control_of(endpoint),
           endpoint & CRN_UDC_IN ? MASK(USB_ENDPTCTRL_0_TXE) : MASK(USB_ENDPTCTRL_0_RXE), 0);
}

/* Gives the controller the transfer that the endpoint's transfer descriptor describes. */
static void prime(uint8_t endpoint)
{
    usb_head *head = &memory.heads[pipe_of(endpoint)];
    head->next = (uint32_t)(uintptr_t)&memory.transfers[pipe_of(endpoint)];
    head->token = 0;
    core_data_barrier();
    STORE(R32(BASE_USB1, USB_ENDPTPRIME), bit_of(endpoint));
}

static void udc_arm(void *context, uint8_t endpoint, uint8_t *bytes, uint32_t count)
{
    (void)context;
    if ((endpoint & 0x7fu) == 0 && has_setup()) return;
    usb_transfer *transfer = &memory.transfers[pipe_of(endpoint)];
    uint32_t begin = (uint32_t)(uintptr_t)bytes;
    if (count > TRANSFER_BYTES_MAX) count = TRANSFER_BYTES_MAX;
    controller.armed_bytes[pipe_of(endpoint)] = count;
    transfer->next = LINK_END;
    transfer->pages[0] = begin;
    for (uint32_t i = 1; i < PAGES; i++) transfer->pages[i] = (begin & ~(PAGE_BYTES - 1u)) + i * PAGE_BYTES;
    transfer->token = count << TOKEN_BYTES_SHIFT | TOKEN_INTERRUPT | TOKEN_ACTIVE;
    prime(endpoint);
}

static void udc_stall(void *context, uint8_t endpoint)
{
    (void)context;
    volatile uint32_t *control = control_of(endpoint);
    if ((endpoint & 0x7fu) == 0) {
        if (has_setup()) return;
        flush(bit_of(0) | bit_of(CRN_UDC_IN));
        uint32_t both = MASK(USB_ENDPTCTRL0_RXS) | MASK(USB_ENDPTCTRL0_TXS);
        change(control, both, both); /* the next setup packet clears them */
        return;
    }
    flush(bit_of(endpoint));
    uint32_t stall = endpoint & CRN_UDC_IN ? MASK(USB_ENDPTCTRL_0_TXS) : MASK(USB_ENDPTCTRL_0_RXS);
    change(control, stall, stall);
}

static void udc_test(void *context, uint8_t selector)
{
    (void)context;
    change(&R32(BASE_USB1, USB_PORTSC1), MASK(USB_PORTSC1_PTC), BITS(USB_PORTSC1_PTC, selector));
}

/* --- events --- */
static void close_all(void)
{
    STORE(R32(BASE_USB1, USB_ENDPTSETUPSTAT), LOAD(R32(BASE_USB1, USB_ENDPTSETUPSTAT)));
    STORE(R32(BASE_USB1, USB_ENDPTCOMPLETE), LOAD(R32(BASE_USB1, USB_ENDPTCOMPLETE)));
    wait_clear(&R32(BASE_USB1, USB_ENDPTPRIME), UINT32_MAX);
    flush(UINT32_MAX);
    controller.complete = 0;
    STORE(R32(BASE_USB1, USB_DEVICEADDR), 0);
    for (uint8_t number = 1; number < ENDPOINTS; number++) STORE(*control_of(number), 0);
    for (uint32_t pipe = 0; pipe < PIPES; pipe++) {
        memory.heads[pipe].next = LINK_END;
        memory.heads[pipe].token = 0;
    }
    for (uint32_t pipe = 0; pipe < 2; pipe++) {
        memory.heads[pipe].capabilities = (uint32_t)CRN_UDC_CONTROL_PACKET_BYTES << HEAD_PACKET_SHIFT |
                                          HEAD_NO_EMPTY_PACKETS | (pipe == 0 ? HEAD_INTERRUPT_ON_SETUP : 0);
    }
}

/* Reports events of the bus: a reset begins (URI) and ends (port change, the speed is known), the bus is
 * quiet for 3 ms (SLI), or the cable changes (BSV). */
static bool take_bus(crn_udc_event *event)
{
    uint32_t status = LOAD(R32(BASE_USB1, USB_USBSTS)), port = LOAD(R32(BASE_USB1, USB_PORTSC1));
    STORE(R32(BASE_USB1, USB_USBSTS), status);
    bool had_power = controller.has_power;
    controller.has_power = (LOAD(R32(BASE_USB1, USB_OTGSC)) & MASK(USB_OTGSC_BSV)) != 0;
    if (had_power && !controller.has_power) {
        close_all();
        controller.is_resetting = controller.is_suspended = false;
        event->kind = CRN_UDC_UNPLUG;
    } else if (status & MASK(USB_USBSTS_URI)) {
        close_all();
        controller.is_resetting = true;
    }
    if (controller.is_resetting && (port & MASK(USB_PORTSC1_PR)) == 0 &&
        (status & MASK(USB_USBSTS_PCI)) != 0) {
        controller.is_resetting = controller.is_suspended = false;
        event->kind = CRN_UDC_RESET;
        bool high = (port & MASK(USB_PORTSC1_PSPD)) == BITS(USB_PORTSC1_PSPD, SPEED_HIGH);
        event->speed = high ? CRN_UDC_HIGH_SPEED : CRN_UDC_FULL_SPEED;
    } else if (!controller.is_resetting && !controller.is_suspended && controller.has_power &&
               (status & MASK(USB_USBSTS_SLI)) != 0 && (port & MASK(USB_PORTSC1_SUSP)) != 0) {
        controller.is_suspended = true;
        event->kind = CRN_UDC_SUSPEND;
    } else if (controller.is_suspended && (port & MASK(USB_PORTSC1_SUSP)) == 0) {
        controller.is_suspended = false;
        event->kind = CRN_UDC_RESUME;
    }
    return event->kind != CRN_UDC_NOTHING;
}

/* The driver reads the eight bytes of a setup packet again if another setup packet arrived meanwhile, which
 * the controller shows by clearing the trip wire bit. */
static bool take_setup(crn_udc_event *event)
{
    volatile uint32_t *command = &R32(BASE_USB1, USB_USBCMD);
    STORE(R32(BASE_USB1, USB_ENDPTSETUPSTAT), 1);
    bool is_whole = false;
    for (int i = 0; i < WAIT_MAX && !is_whole; i++) {
        change(command, MASK(USB_USBCMD_SUTW), MASK(USB_USBCMD_SUTW));
        for (uint32_t k = 0; k < CRN_UDC_SETUP_BYTES; k++) event->setup[k] = memory.heads[0].setup[k];
        is_whole = (LOAD(*command) & MASK(USB_USBCMD_SUTW)) != 0;
    }
    change(command, MASK(USB_USBCMD_SUTW), 0);
    wait_clear(&R32(BASE_USB1, USB_ENDPTSETUPSTAT), 1);
    flush(bit_of(0) | bit_of(CRN_UDC_IN));
    if (!is_whole) return false;
    event->kind = CRN_UDC_SETUP;
    return true;
}

/* A transfer that ended by an error of the bus is started again. A halted one (the host sent more than was
 * requested) is answered with STALL. */
static bool take_transfer(uint8_t endpoint, crn_udc_event *event)
{
    usb_transfer *transfer = &memory.transfers[pipe_of(endpoint)];
    uint32_t armed = controller.armed_bytes[pipe_of(endpoint)];
    uint32_t token = transfer->token, left = token >> TOKEN_BYTES_SHIFT & TOKEN_BYTES_MASK;
    if (token & TOKEN_ACTIVE) return false;
    if (token & TOKEN_HALTED) {
        udc_stall(NULL, endpoint);
        return false;
    }
    if (token & TOKEN_ERRORS) {
        transfer->token = armed << TOKEN_BYTES_SHIFT | TOKEN_INTERRUPT | TOKEN_ACTIVE;
        prime(endpoint);
        return false;
    }
    event->kind = CRN_UDC_DONE;
    event->endpoint = endpoint;
    event->bytes = left <= armed ? armed - left : 0;
    return true;
}

static bool take_complete(crn_udc_event *event)
{
    uint32_t bits = LOAD(R32(BASE_USB1, USB_ENDPTCOMPLETE));
    STORE(R32(BASE_USB1, USB_ENDPTCOMPLETE), bits);
    controller.complete |= bits;
    for (uint8_t number = 0; number < ENDPOINTS && controller.complete != 0; number++) {
        for (uint32_t way = 0; way < 2; way++) {
            uint8_t endpoint = (uint8_t)(number | (way ? CRN_UDC_IN : 0));
            if ((controller.complete & bit_of(endpoint)) == 0) continue;
            controller.complete &= ~bit_of(endpoint);
            if (take_transfer(endpoint, event)) return true;
        }
    }
    return false;
}

static bool udc_poll(void *context, crn_udc_event *event)
{
    (void)context;
    *event = (crn_udc_event){.kind = CRN_UDC_NOTHING};
    if (take_bus(event)) return true;
    /* What ended before the setup packet is in ENDPTCOMPLETE by now. It is reported first, because opening an
     * endpoint, and the setup packet itself, clear what has not been reported. */
    const bool setup_waits = has_setup();
    return take_complete(event) || (setup_waits && take_setup(event));
}

/* The controller counts microframes of 125 us, and takes the upper eleven bits from the host's packets. */
uint32_t usb_udc_frame(void)
{
    return (R32(BASE_USB1, USB_FRINDEX) & MASK(USB_FRINDEX_FRINDEX)) >> 3;
}

/* Returns NULL when the controller does not come out of its reset. */
const crn_udc *usb_udc_start(void)
{
    volatile uint32_t *command = &R32(BASE_USB1, USB_USBCMD);
    STORE(*command, MASK(USB_USBCMD_RST));
    if (!board_wait(command, MASK(USB_USBCMD_RST), 0)) return NULL;
    STORE(R32(BASE_USB1, USB_USBMODE), BITS(USB_USBMODE_CM, MODE_DEVICE) | BITS(USB_USBMODE_SLOM, 1));
    change(command, MASK(USB_USBCMD_ITC), 0);
    close_all();
    /* In device mode the register ENDPTLISTADDR holds the address of the queue heads. */
    STORE(R32(BASE_USB1, USB_ASYNCLISTADDR), (uint32_t)(uintptr_t)memory.heads);
    controller.udc = (crn_udc){
        .context = NULL,
        .can_high_speed = true,
        .connect = udc_connect,
        .set_address = udc_set_address,
        .open = udc_open,
        .close = udc_close,
        .arm = udc_arm,
        .stall = udc_stall,
        .test = udc_test,
        .poll = udc_poll,
    };
    return &controller.udc;
}
