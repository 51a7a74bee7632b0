/* The USB device controller USB1: registers, queue heads and transfer descriptors in memory, and the bus as a
 * host sees it. It answers nothing until its transceiver runs (usb_phy.c), its mode is "device", and RS is
 * set. Behaviour: reference manual, chapter USB, and EHCI's descriptors as seen from the device's side, from
 * memory. The model reads the descriptors as the bus does: addresses in no memory, or in cached memory, are
 * findings. */
#include "hil_tests/rt1062/chip.h"
#include <string.h>

enum {
    CONTROLLER_RESET_us = 5,
    PRIME_ns = 500,
    FLUSH_ns = 500,
    BUS_RESET_us = 10000, /* at least 10 ms, as a hub makes it */
    MODE_DEVICE = 2,
    HEAD_BYTES = 64,
    HEAD_CAPABILITIES = 0,
    HEAD_CURRENT = 1,
    HEAD_OVERLAY = 2, /* next, token, five pages: as in a transfer descriptor */
    HEAD_SETUP_BYTES_AT = 40,
    TRANSFER_BYTES = 32,
    LINK_END = 1,
    TOKEN_ACTIVE = 1 << 7,
    TOKEN_HALTED = 1 << 6,
    TOKEN_INTERRUPT = 1 << 15,
    TOKEN_LEFT_SHIFT = 16,
    TOKEN_LEFT_MASK = 0x7fff,
    ZERO_LENGTH_OFF = 1 << 29,
    PACKET_SHIFT = 16,
    PACKET_MASK = 0x7ff,
    PAGE_BYTES = 4096,
    PAGES = 5,
    IN_SHIFT = 16,
    SPEED_FULL = 0,
    SPEED_HIGH = 2,
    POLLS_UNTIL_IDLE = 4,
};

static uint32_t pipe_of(uint32_t endpoint, bool is_in)
{
    return 2 * endpoint + (is_in ? 1 : 0);
}

static uint32_t bit_of(uint32_t endpoint, bool is_in)
{
    return 1u << (endpoint + (is_in ? IN_SHIFT : 0));
}

static uint32_t load(const uint8_t *memory, uint32_t word)
{
    uint32_t value;
    memcpy(&value, memory + 4 * word, sizeof value);
    return value;
}

static void store(uint8_t *memory, uint32_t word, uint32_t value)
{
    memcpy(memory + 4 * word, &value, sizeof value);
}

static uint8_t *reach(rt_chip *chip, uint32_t address, uint32_t bytes)
{
    if (rt_core_has_data_cache(chip) && rt_mpu_is_cached(chip, address))
        rt_find(chip, "USB1 accesses 0x%08x, which the processor may hold in its cache", address);
    return rt_chip_memory(chip, address, bytes);
}

static uint8_t *head_of(rt_chip *chip, uint32_t endpoint, bool is_in)
{
    if (chip->usb.list == 0) return NULL;
    return reach(chip, chip->usb.list + HEAD_BYTES * pipe_of(endpoint, is_in), HEAD_BYTES);
}

/* --- prime, flush --- */
/* Takes the next descriptor of a queue head into its overlay; false if there is none that is active. */
static bool take_next(rt_chip *chip, uint32_t endpoint, bool is_in)
{
    uint8_t *head = head_of(chip, endpoint, is_in);
    if (head == NULL) return false;
    uint32_t next = load(head, HEAD_OVERLAY);
    if (next & LINK_END) return false;
    uint8_t *transfer = reach(chip, next & ~31u, TRANSFER_BYTES);
    if (transfer == NULL || (load(transfer, 1) & TOKEN_ACTIVE) == 0) return false;
    store(head, HEAD_CURRENT, next & ~31u);
    memcpy(head + 4 * HEAD_OVERLAY, transfer, TRANSFER_BYTES - 4);
    chip->usb.done[pipe_of(endpoint, is_in)] = 0;
    return true;
}

static void prime_all(rt_chip *chip)
{
    rt_usb *usb = &chip->usb;
    for (uint32_t endpoint = 0; endpoint < RT_USB_ENDPOINTS; endpoint++) {
        for (int way = 0; way < 2; way++) {
            uint32_t bit = bit_of(endpoint, way != 0);
            if ((usb->prime & bit) == 0) continue;
            /* a setup packet that waits makes the priming of endpoint 0 void */
            bool is_void = endpoint == 0 && (usb->setup_status & 1u) != 0;
            if (!is_void && take_next(chip, endpoint, way != 0)) usb->ready |= bit;
        }
    }
    usb->prime = 0;
}

static void settle(rt_chip *chip)
{
    rt_usb *usb = &chip->usb;
    if (!rt_usb_phy_runs(chip)) return;
    if (usb->prime != 0 && chip->now >= usb->prime_until) prime_all(chip);
    if (usb->flush != 0 && chip->now >= usb->flush_until) {
        usb->ready &= ~usb->flush;
        usb->flush = 0;
    }
}

/* --- registers --- */
static const char *why_no_reset(rt_chip *chip)
{
    return rt_usb_phy_runs(chip) ? "the reset takes its time" : "the transceiver does not run";
}

static void reset_registers(rt_usb *usb)
{
    usb->command = 8u << 16;
    usb->status = usb->interrupts = usb->address = usb->list = usb->mode = 0;
    usb->setup_status = usb->prime = usb->flush = usb->ready = usb->complete = 0;
    memset(usb->endpoint_control, 0, sizeof usb->endpoint_control);
    usb->endpoint_control[0] = MASK(USB_ENDPTCTRL_0_RXE) | MASK(USB_ENDPTCTRL_0_TXE);
}

static uint32_t read_command(rt_chip *chip)
{
    rt_usb *usb = &chip->usb;
    uint32_t at = BASE_USB1 + USB_USBCMD;
    if (usb->reset_until == 0) return usb->command;
    if (rt_usb_phy_runs(chip) && chip->now >= usb->reset_until) {
        usb->reset_until = 0;
        reset_registers(usb);
        rt_answered(chip, at);
        return usb->command;
    }
    rt_pending(chip, at, "USB1_USBCMD RST: %s", why_no_reset(chip));
    return usb->command | MASK(USB_USBCMD_RST);
}

static uint32_t port_status(const rt_usb *usb)
{
    uint32_t port = usb->port;
    if (usb->bus != RT_BUS_UNPLUGGED) port |= MASK(USB_PORTSC1_CCS);
    if (usb->bus == RT_BUS_RESET) port |= MASK(USB_PORTSC1_PR);
    if (usb->bus == RT_BUS_SUSPENDED) port |= MASK(USB_PORTSC1_SUSP);
    return port | BITS(USB_PORTSC1_PSPD, usb->is_high_speed ? SPEED_HIGH : SPEED_FULL);
}

static uint32_t read_pending_bits(rt_chip *chip, uint32_t offset, uint32_t bits, const char *name)
{
    if (bits == 0)
        rt_answered(chip, BASE_USB1 + offset);
    else
        rt_pending(chip, BASE_USB1 + offset, "USB1_%s: %s", name, why_no_reset(chip));
    return bits;
}

/* The image polls USBSTS, ENDPTSETUPSTAT and ENDPTCOMPLETE in turn; after some rounds without an event it is
 * idle. */
static uint32_t read_complete(rt_usb *usb)
{
    bool is_quiet = usb->status == 0 && usb->setup_status == 0 && usb->complete == 0;
    usb->idle_polls = is_quiet ? usb->idle_polls + 1 : 0;
    return usb->complete;
}

bool rt_usb_is_idle(const rt_chip *chip)
{
    const rt_usb *usb = &chip->usb;
    return usb->idle_polls >= POLLS_UNTIL_IDLE && usb->prime == 0 && usb->flush == 0;
}

/* The host sends the number of a frame every millisecond while the bus is active. */
static uint32_t read_frame(rt_chip *chip)
{
    rt_usb *usb = &chip->usb;
    if (usb->bus == RT_BUS_ACTIVE && !rt_fault_is(&chip->fault, RT_FAULT_SILENCE))
        usb->frame_index = (uint32_t)(chip->now / (125 * RT_INSTANTS_PER_us)) & MASK(USB_FRINDEX_FRINDEX);
    return usb->frame_index;
}

uint32_t rt_usb_read(rt_chip *chip, uint32_t offset)
{
    rt_usb *usb = &chip->usb;
    settle(chip);
    if (offset >= USB_ENDPTCTRL0 && offset < USB_ENDPTCTRL0 + 4 * RT_USB_ENDPOINTS)
        return usb->endpoint_control[(offset - USB_ENDPTCTRL0) / 4];
    switch (offset) {
    case USB_USBCMD:
        return read_command(chip);
    case USB_USBSTS:
        return usb->status;
    case USB_FRINDEX:
        return read_frame(chip);
    case USB_DEVICEADDR:
        return usb->address;
    case USB_ASYNCLISTADDR:
        return usb->list;
    case USB_PORTSC1:
        return port_status(usb);
    case USB_OTGSC:
        return usb->bus != RT_BUS_UNPLUGGED ? MASK(USB_OTGSC_BSV) : 0;
    case USB_USBMODE:
        return usb->mode;
    case USB_ENDPTSETUPSTAT:
        return usb->setup_status;
    case USB_ENDPTPRIME:
        return read_pending_bits(chip, offset, usb->prime, "ENDPTPRIME");
    case USB_ENDPTFLUSH:
        return read_pending_bits(chip, offset, usb->flush, "ENDPTFLUSH");
    case USB_ENDPTSTAT:
        return usb->ready;
    case USB_ENDPTCOMPLETE:
        return read_complete(usb);
    default:
        rt_unmodelled(chip, "USB1", offset, false);
        return 0;
    }
}

static void write_endpoint_control(rt_chip *chip, uint32_t endpoint, uint32_t value)
{
    rt_usb *usb = &chip->usb;
    if (value & MASK(USB_ENDPTCTRL_0_RXR)) usb->next_toggle[pipe_of(endpoint, false)] = false;
    if (value & MASK(USB_ENDPTCTRL_0_TXR)) usb->next_toggle[pipe_of(endpoint, true)] = false;
    bool out = RT_FIELD(value, USB_ENDPTCTRL_0_RXE) != 0, in = RT_FIELD(value, USB_ENDPTCTRL_0_TXE) != 0;
    bool unused_is_control = (out && !in && RT_FIELD(value, USB_ENDPTCTRL_0_TXT) == 0) ||
                             (in && !out && RT_FIELD(value, USB_ENDPTCTRL_0_RXT) == 0);
    if (endpoint != 0 && unused_is_control)
        rt_find(chip, "USB1_ENDPTCTRL%u: the unused direction has the type control, which spoils the toggles",
                endpoint);
    if (endpoint == 0) value |= MASK(USB_ENDPTCTRL_0_RXE) | MASK(USB_ENDPTCTRL_0_TXE);
    usb->endpoint_control[endpoint] = value & ~(MASK(USB_ENDPTCTRL_0_RXR) | MASK(USB_ENDPTCTRL_0_TXR));
}

static void write_command(rt_chip *chip, uint32_t value)
{
    rt_usb *usb = &chip->usb;
    if (value & MASK(USB_USBCMD_RST)) {
        usb->reset_until =
            chip->now + rt_mutant_time(chip, RT_TIME_USB_RESET, CONTROLLER_RESET_us * RT_INSTANTS_PER_us);
        return;
    }
    if ((value & MASK(USB_USBCMD_RS)) != 0 && RT_FIELD(usb->mode, USB_USBMODE_CM) != MODE_DEVICE)
        rt_find(chip, "USB1_USBCMD RS is set before USBMODE says device");
    usb->command = value;
}

void rt_usb_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_usb *usb = &chip->usb;
    settle(chip);
    if (value != 0) usb->idle_polls = 0;
    if (offset >= USB_ENDPTCTRL0 && offset < USB_ENDPTCTRL0 + 4 * RT_USB_ENDPOINTS) {
        write_endpoint_control(chip, (offset - USB_ENDPTCTRL0) / 4, value);
        return;
    }
    switch (offset) {
    case USB_USBCMD:
        write_command(chip, value);
        break;
    case USB_USBSTS:
        usb->status &= ~value;
        break;
    case USB_USBINTR:
        usb->interrupts = value;
        break;
    case USB_DEVICEADDR:
        usb->address = RT_FIELD(value, USB_DEVICEADDR_USBADR);
        break;
    case USB_ASYNCLISTADDR:
        if (value % 2048 != 0)
            rt_find(chip, "USB1: queue heads at 0x%08x are not aligned to 2,048 bytes", value);
        usb->list = value & ~2047u;
        break;
    case USB_PORTSC1:
        usb->port = value & MASK(USB_PORTSC1_PTC);
        break;
    case USB_USBMODE:
        usb->mode = value;
        break;
    case USB_ENDPTSETUPSTAT:
        usb->setup_status &= ~value;
        break;
    case USB_ENDPTPRIME:
        if ((usb->ready & value) != 0)
            rt_find(chip,
                    "USB1 primes endpoints 0x%08x anew, while their transfers are not over; flush them first",
                    usb->ready & value);
        usb->prime |= value;
        usb->prime_until =
            chip->now + rt_mutant_time(chip, RT_TIME_USB_PRIME, PRIME_ns * RT_INSTANTS_PER_us / 1000);
        break;
    case USB_ENDPTFLUSH:
        usb->flush |= value;
        usb->flush_until =
            chip->now + rt_mutant_time(chip, RT_TIME_USB_FLUSH, FLUSH_ns * RT_INSTANTS_PER_us / 1000);
        break;
    case USB_ENDPTCOMPLETE:
        usb->complete &= ~value;
        break;
    default:
        rt_unmodelled(chip, "USB1", offset, true);
    }
}

/* --- the bus --- */
bool rt_usb_is_attached(rt_chip *chip)
{
    const rt_usb *usb = &chip->usb;
    return usb->bus != RT_BUS_UNPLUGGED && (usb->command & MASK(USB_USBCMD_RS)) != 0 &&
           RT_FIELD(usb->mode, USB_USBMODE_CM) == MODE_DEVICE && usb->reset_until == 0 &&
           rt_usb_phy_runs(chip);
}

static void happen(rt_chip *chip, uint32_t events)
{
    chip->usb.status |= events;
    chip->usb.idle_polls = 0;
}

void rt_usb_plug(rt_chip *chip, bool plugged)
{
    chip->usb.bus = plugged ? RT_BUS_POWERED : RT_BUS_UNPLUGGED;
    chip->usb.bus_reset_until = RT_NEVER;
    happen(chip, MASK(USB_USBSTS_PCI));
}

void rt_usb_bus_reset(rt_chip *chip, bool high_speed)
{
    rt_usb *usb = &chip->usb;
    if (!rt_usb_is_attached(chip)) return;
    usb->bus = RT_BUS_RESET;
    usb->is_high_speed = high_speed;
    usb->address = 0;
    usb->bus_reset_until =
        chip->now + rt_mutant_time(chip, RT_TIME_USB_BUS_RESET, BUS_RESET_us * RT_INSTANTS_PER_us);
    happen(chip, MASK(USB_USBSTS_URI));
}

void rt_usb_suspend(rt_chip *chip, bool suspended)
{
    rt_usb *usb = &chip->usb;
    if (usb->bus != (suspended ? RT_BUS_ACTIVE : RT_BUS_SUSPENDED)) return;
    usb->bus = suspended ? RT_BUS_SUSPENDED : RT_BUS_ACTIVE;
    happen(chip, suspended ? MASK(USB_USBSTS_SLI) : MASK(USB_USBSTS_PCI));
}

uint64_t rt_usb_run_due(rt_chip *chip)
{
    rt_usb *usb = &chip->usb;
    if (usb->bus == RT_BUS_RESET && chip->now >= usb->bus_reset_until) {
        usb->bus = RT_BUS_ACTIVE;
        usb->bus_reset_until = RT_NEVER;
        happen(chip, MASK(USB_USBSTS_PCI));
    }
    return usb->bus == RT_BUS_RESET ? usb->bus_reset_until : RT_NEVER;
}

/* --- transactions --- */
static void retire(rt_chip *chip, uint8_t *head, uint32_t endpoint, bool is_in, uint32_t token)
{
    rt_usb *usb = &chip->usb;
    uint8_t *transfer = reach(chip, load(head, HEAD_CURRENT), TRANSFER_BYTES);
    token &= ~(uint32_t)TOKEN_ACTIVE;
    store(head, HEAD_OVERLAY + 1, token);
    if (transfer != NULL) store(transfer, 1, token);
    usb->complete |= bit_of(endpoint, is_in);
    usb->ready &= ~bit_of(endpoint, is_in);
    happen(chip, token & TOKEN_INTERRUPT ? MASK(USB_USBSTS_UI) : 0);
    if ((token & TOKEN_HALTED) == 0 && take_next(chip, endpoint, is_in))
        usb->ready |= bit_of(endpoint, is_in);
}

/* Copies between a packet and the five pages of the overlay. */
static bool move(rt_chip *chip, const uint8_t *head, uint32_t done, uint8_t *packet, uint32_t bytes,
                 bool is_in)
{
    uint32_t begin = load(head, HEAD_OVERLAY + 2) % PAGE_BYTES + done;
    while (bytes > 0) {
        uint32_t page = begin / PAGE_BYTES, inside = begin % PAGE_BYTES, part = PAGE_BYTES - inside;
        if (part > bytes) part = bytes;
        if (page >= PAGES) return false;
        uint32_t address = (load(head, HEAD_OVERLAY + 2 + page) & ~(PAGE_BYTES - 1u)) + inside;
        uint8_t *memory = reach(chip, address, part);
        if (memory == NULL) return false;
        if (is_in)
            memcpy(packet, memory, part);
        else
            memcpy(memory, packet, part);
        packet += part, begin += part, bytes -= part;
    }
    return true;
}

static rt_usb_reply fail(rt_chip *chip, uint8_t *head, uint32_t endpoint, bool is_in, uint32_t token)
{
    retire(chip, head, endpoint, is_in, token | TOKEN_HALTED);
    return RT_USB_STALL;
}

static rt_usb_reply send(rt_chip *chip, uint8_t *head, rt_usb_packet *packet)
{
    rt_usb *usb = &chip->usb;
    uint32_t pipe = pipe_of(packet->endpoint, true), capabilities = load(head, HEAD_CAPABILITIES);
    uint32_t token = load(head, HEAD_OVERLAY + 1), left = token >> TOKEN_LEFT_SHIFT & TOKEN_LEFT_MASK;
    uint32_t most = capabilities >> PACKET_SHIFT & PACKET_MASK, bytes = left < most ? left : most;
    if (!move(chip, head, usb->done[pipe], packet->data, bytes, true))
        return fail(chip, head, packet->endpoint, true, token);
    packet->bytes = bytes;
    rt_usb_reply reply = usb->next_toggle[pipe] ? RT_USB_DATA1 : RT_USB_DATA0;
    if (packet->is_ack_lost) return reply;
    usb->next_toggle[pipe] = !usb->next_toggle[pipe];
    usb->done[pipe] += bytes;
    left -= bytes;
    token = (token & ~((uint32_t)TOKEN_LEFT_MASK << TOKEN_LEFT_SHIFT)) | left << TOKEN_LEFT_SHIFT;
    store(head, HEAD_OVERLAY + 1, token);
    bool owes_empty = (capabilities & ZERO_LENGTH_OFF) == 0 && bytes == most;
    if (left == 0 && !owes_empty) retire(chip, head, packet->endpoint, true, token);
    return reply;
}

static rt_usb_reply receive(rt_chip *chip, uint8_t *head, rt_usb_packet *packet)
{
    rt_usb *usb = &chip->usb;
    uint32_t pipe = pipe_of(packet->endpoint, false);
    uint32_t token = load(head, HEAD_OVERLAY + 1), left = token >> TOKEN_LEFT_SHIFT & TOKEN_LEFT_MASK;
    uint32_t most = load(head, HEAD_CAPABILITIES) >> PACKET_SHIFT & PACKET_MASK;
    if (packet->bytes > most) return RT_USB_SILENCE;
    if (packet->bytes > left || !move(chip, head, usb->done[pipe], packet->data, packet->bytes, false))
        return fail(chip, head, packet->endpoint, false, token);
    usb->next_toggle[pipe] = !usb->next_toggle[pipe];
    usb->done[pipe] += packet->bytes;
    left -= packet->bytes;
    token = (token & ~((uint32_t)TOKEN_LEFT_MASK << TOKEN_LEFT_SHIFT)) | left << TOKEN_LEFT_SHIFT;
    store(head, HEAD_OVERLAY + 1, token);
    if (left == 0 || packet->bytes < most) retire(chip, head, packet->endpoint, false, token);
    return RT_USB_ACK;
}

static rt_usb_reply take_setup(rt_chip *chip, const rt_usb_packet *packet)
{
    rt_usb *usb = &chip->usb;
    uint8_t *head = head_of(chip, 0, false);
    if (packet->endpoint != 0 || packet->bytes != 8 || head == NULL) return RT_USB_SILENCE;
    memcpy(head + HEAD_SETUP_BYTES_AT, packet->data, 8);
    usb->setup_status |= 1u;
    usb->command &= ~MASK(USB_USBCMD_SUTW);
    usb->endpoint_control[0] &= ~(MASK(USB_ENDPTCTRL0_RXS) | MASK(USB_ENDPTCTRL0_TXS));
    usb->ready &= ~(bit_of(0, false) | bit_of(0, true));
    usb->next_toggle[0] = usb->next_toggle[1] = true;
    happen(chip, MASK(USB_USBSTS_UI));
    return RT_USB_ACK;
}

/* A token that does not arrive whole. Noise spoils half of them. */
static bool is_lost(const rt_chip *chip)
{
    bool is_spoilt = (chip->usb.tokens * 2654435761u >> 15 & 1u) != 0;
    return rt_fault_core_stands(chip) || rt_fault_is(&chip->fault, RT_FAULT_SILENCE) ||
           (rt_fault_is(&chip->fault, RT_FAULT_NOISE) && is_spoilt);
}

static rt_usb_reply answer(rt_chip *chip, rt_usb_packet *packet)
{
    rt_usb *usb = &chip->usb;
    bool is_in = packet->token == RT_TOKEN_IN;
    if (!rt_usb_is_attached(chip) || usb->bus != RT_BUS_ACTIVE || packet->address != usb->address ||
        packet->endpoint >= RT_USB_ENDPOINTS)
        return RT_USB_SILENCE;
    if (packet->token == RT_TOKEN_SETUP) return take_setup(chip, packet);
    uint32_t control = usb->endpoint_control[packet->endpoint];
    if ((control & (is_in ? MASK(USB_ENDPTCTRL_0_TXE) : MASK(USB_ENDPTCTRL_0_RXE))) == 0)
        return RT_USB_SILENCE;
    if ((control & (is_in ? MASK(USB_ENDPTCTRL_0_TXS) : MASK(USB_ENDPTCTRL_0_RXS))) != 0) return RT_USB_STALL;
    if (packet->endpoint == 0 && (usb->setup_status & 1u) != 0) return RT_USB_NAK;
    bool is_repeated = !is_in && packet->is_data1 != usb->next_toggle[pipe_of(packet->endpoint, false)];
    if (is_repeated) return RT_USB_ACK; /* the host missed the last ACK */
    if ((usb->ready & bit_of(packet->endpoint, is_in)) == 0) return RT_USB_NAK;
    uint8_t *head = head_of(chip, packet->endpoint, is_in);
    if (head == NULL) return RT_USB_NAK;
    return is_in ? send(chip, head, packet) : receive(chip, head, packet);
}

rt_usb_reply rt_usb_transact(rt_chip *chip, rt_usb_packet *packet)
{
    settle(chip);
    chip->usb.tokens++;
    rt_fault_token(chip);
    if (is_lost(chip)) return RT_USB_SILENCE;
    bool loses = rt_fault_is(&chip->fault, RT_FAULT_LOST_ACK);
    packet->is_ack_lost = packet->is_ack_lost || loses;
    rt_usb_reply reply = answer(chip, packet);
    return loses && reply == RT_USB_ACK ? RT_USB_SILENCE : reply;
}

/* The cable stays as it is; a host sees the device leave. */
void rt_usb_reset(rt_chip *chip)
{
    rt_usb *usb = &chip->usb;
    rt_usb_bus bus = usb->bus == RT_BUS_UNPLUGGED ? RT_BUS_UNPLUGGED : RT_BUS_POWERED;
    uint64_t tokens = usb->tokens;
    *usb = (rt_usb){.phy_control = MASK(USBPHY_CTRL_SFTRST) | MASK(USBPHY_CTRL_CLKGATE),
                    .phy_pwd = 0x001e1c00u,
                    .bus = bus,
                    .bus_reset_until = RT_NEVER,
                    .tokens = tokens};
    reset_registers(usb);
}
