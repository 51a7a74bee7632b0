/* Devices for bridges. */
#define _POSIX_C_SOURCE 200809L
#include "hil_tests/usb/usb_peer.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { MS_ns = 1000000, LOOKS_BEFORE_SLEEP = 200, SLEEP_ns = 20000, COMMAND_BURST = 200 };

int64_t usb_peer_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 * MS_ns + now.tv_nsec;
}

/* --- in this process --- */
void usb_peer_open_here(usb_peer *peer)
{
    memset(peer, 0, sizeof *peer);
    peer->kind = USB_PEER_RIG;
    usb_rig_open(&peer->rig, true);
    peer->host = &peer->rig.host;
    peer->next_tick_ns = usb_peer_now_ns() + MS_ns;
}

static void burst(usb_rig *rig)
{
    static uint8_t frame[CRN_WIRE_FRAME_MAX];
    uint32_t bytes = (uint32_t)rig->command.value2;
    if (bytes < 1 || bytes > sizeof frame) return;
    memset(frame, 'b', bytes);
    frame[bytes - 1] = 0;
    for (int32_t i = 0; i < rig->command.value1 && crn_usb_transmit(&rig->usb, frame, bytes); i++) {
    }
}

void usb_peer_open_app(usb_peer *peer, const char *serial)
{
    memset(peer, 0, sizeof *peer);
    peer->kind = USB_PEER_APP;
    usb_device_start(&peer->app, serial);
    peer->host = &peer->app.host;
    peer->next_tick_ns = usb_peer_now_ns() + MS_ns;
}

static void run_one(usb_peer *peer, bool tick)
{
    if (peer->kind == USB_PEER_RIG) {
        if (tick) usb_rig_tick(&peer->rig);
        usb_rig_settle(&peer->rig);
    } else {
        if (tick) usb_device_tick(&peer->app);
        usb_device_settle(&peer->app);
    }
}

void usb_peer_run(usb_peer *peer)
{
    if (peer->kind == USB_PEER_FILE) return;
    usb_rig *rig = &peer->rig;
    const int64_t now = usb_peer_now_ns();
    if (now - peer->next_tick_ns > 100 * (int64_t)MS_ns)
        peer->next_tick_ns = now; /* this machine was asleep */
    for (; peer->next_tick_ns <= now; peer->next_tick_ns += MS_ns) run_one(peer, true);
    run_one(peer, false);
    if (peer->kind != USB_PEER_RIG) return;
    if (peer->last_command == rig->commands) return;
    peer->last_command = rig->commands;
    if (rig->command.action == COMMAND_BURST) burst(rig);
}

/* --- in another process --- */
static void far_begin_wait(void *context)
{
    usb_peer *peer = context;
    peer->looks = 0;
    peer->deadline_ns = 0;
}

static bool far_wait(void *context)
{
    usb_peer *peer = context;
    if (++peer->looks < LOOKS_BEFORE_SLEEP) return true;
    const int64_t now = usb_peer_now_ns();
    if (peer->deadline_ns == 0) peer->deadline_ns = now + USB_PEER_DEADLINE_s * (int64_t)1000 * MS_ns;
    const struct timespec sleep = {0, SLEEP_ns};
    nanosleep(&sleep, NULL);
    return now < peer->deadline_ns;
}

const char *usb_peer_open_file(usb_peer *peer, const char *path, uint64_t offset)
{
    struct stat status;
    memset(peer, 0, sizeof *peer);
    peer->kind = USB_PEER_FILE;
    const int file = open(path, O_RDWR | O_CLOEXEC);
    if (file < 0) return "the file cannot be opened for reading and writing";
    if (fstat(file, &status) != 0 || (uint64_t)status.st_size < offset + CRN_MAILBOX_BYTES) {
        close(file);
        return "the file is too short for a mailbox at that place";
    }
    void *memory = mmap(NULL, CRN_MAILBOX_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, file, (off_t)offset);
    close(file);
    if (memory == MAP_FAILED) return "the file cannot be mapped; is the offset a multiple of 4096?";
    peer->far = (usb_host){
        .mailbox = memory,
        .wait = far_wait,
        .begin_wait = far_begin_wait,
        .context = peer,
        .packet_bytes = 64,
        .naks_max = 20000,
    };
    peer->host = &peer->far;
    return NULL;
}

const char *usb_peer_open(usb_peer *peer, int count, char **words, int *used)
{
    *used = 1;
    if (count >= 1 && strcmp(words[0], "--here") == 0) {
        usb_peer_open_here(peer);
        return NULL;
    }
    if (count >= 1 && (strcmp(words[0], "--app") == 0 || strncmp(words[0], "--app=", 6) == 0)) {
        usb_peer_open_app(peer, words[0][5] == '=' ? words[0] + 6 : "USB-0001");
        return NULL;
    }
    *used = 2;
    if (count < 2 || strcmp(words[0], "--mailbox") != 0)
        return "name the device: --here, --app, or --mailbox FILE[:OFFSET]";
    char *colon = strrchr(words[1], ':');
    uint64_t offset = 0;
    if (colon != NULL) {
        offset = strtoull(colon + 1, NULL, 0);
        *colon = '\0';
    }
    return usb_peer_open_file(peer, words[1], offset);
}
