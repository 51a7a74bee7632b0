/* This file implements the pair of USB bulk endpoints. Frames go to the host through a ring buffer, and bytes
 * from the host go to the app frame by frame. */
#include "firmware/app/usb/usb_internal.h"

/* The controller sends directly from the ring buffer; the bytes [queue_begin, queue_begin + sending) belong
 * to the controller. */
static void queue_byte(crn_usb *usb, uint8_t byte)
{
    uint32_t place = usb->queue_begin + usb->queue_count;
    if (place >= usb->config.queue_bytes) place -= usb->config.queue_bytes;
    usb->config.queue[place] = byte;
    usb->queue_count++;
}

/* Starts the byte stream anew: a zero byte ends an incomplete frame, and messages that were meant for an
 * earlier host are dropped. The zero byte for the app is stored as if the host had sent it, before the bytes
 * of the first packet. */
void crn_usb_stream_begin(crn_usb *usb, bool to_host)
{
    if (to_host) {
        usb->queue_begin = usb->queue_count = usb->sending = 0;
        usb->ends_full = false;
        queue_byte(usb, 0);
        return;
    }
    usb->stream_out[0] = 0;
    usb->held_begin = 0;
    usb->held_end = 1;
}

/* --- to the host --- */
uint32_t crn_usb_queue_room(const crn_usb *usb)
{
    return usb->configuration == 0 ? 0 : usb->config.queue_bytes - usb->queue_count;
}

bool crn_usb_transmit(crn_usb *usb, const uint8_t *frame, size_t frame_bytes)
{
    if (frame_bytes > crn_usb_queue_room(usb)) {
        usb->frames_refused++;
        return false;
    }
    for (size_t i = 0; i < frame_bytes; i++) queue_byte(usb, frame[i]);
    return true;
}

/* Sends as many bytes as lie in one contiguous piece of the ring buffer. A piece that ends at the end of the
 * ring buffer may end with a short packet; the length of a packet has no meaning in the stream. */
void crn_usb_stream_send(crn_usb *usb)
{
    if (!crn_usb_pipe_is_free(usb, CRN_USB_STREAM_IN)) return;
    uint32_t count = usb->queue_count;
    if (count > usb->config.queue_bytes - usb->queue_begin)
        count = usb->config.queue_bytes - usb->queue_begin;
    if (count > CRN_USB_STREAM_BURST) count = CRN_USB_STREAM_BURST;
    if (count == 0 && !usb->ends_full) return;
    usb->sending = count;
    usb->ends_full = count != 0 && count % crn_usb_endpoints[CRN_USB_STREAM_IN].packet_bytes[usb->speed] == 0;
    crn_usb_pipe_arm(usb, CRN_USB_STREAM_IN, usb->config.queue + usb->queue_begin, count);
}

void crn_usb_stream_sent(crn_usb *usb, uint32_t bytes)
{
    if (bytes > usb->sending) bytes = usb->sending;
    usb->queue_begin += bytes;
    if (usb->queue_begin >= usb->config.queue_bytes) usb->queue_begin -= usb->config.queue_bytes;
    usb->queue_count -= bytes;
    usb->sending = 0;
}

/* --- to the device --- */
void crn_usb_stream_received(crn_usb *usb, uint32_t bytes)
{
    usb->held_begin = 0;
    usb->held_end = bytes < sizeof usb->stream_out ? bytes : (uint32_t)sizeof usb->stream_out;
}

/* Takes the received bytes only up to the end of the next frame, so that the queue has space for the reply to
 * one request. When all bytes of the present packet are taken, the function makes the endpoint ready for the
 * next packet. */
bool crn_usb_stream_deliver(crn_usb *usb)
{
    if (usb->configuration == 0 || usb->is_halted[CRN_USB_STREAM_OUT]) return false;
    if (usb->held_begin < usb->held_end) {
        if (crn_usb_queue_room(usb) < usb->config.reply_bytes) return false;
        uint32_t begin = usb->held_begin, end = begin + 1;
        while (end < usb->held_end && usb->stream_out[end - 1] != 0) end++;
        usb->held_begin = end;
        usb->config.app->receive(usb->config.app->context, usb->stream_out + begin, end - begin);
    }
    if (usb->held_begin < usb->held_end) return true;
    crn_usb_pipe_arm(usb, CRN_USB_STREAM_OUT, usb->stream_out,
                     crn_usb_endpoints[CRN_USB_STREAM_OUT].packet_bytes[usb->speed]);
    return false;
}
