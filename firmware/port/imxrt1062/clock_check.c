/* This port has never run on hardware. Compares the millisecond timer with the frames of USB, which the
 * host's own clock gives every millisecond: docs/safety.md, "Self-test". A motor has power only with a host,
 * so the comparison has always been made before. */
#include "firmware/port/imxrt1062/board.h"

enum {
    WINDOW_edges = 128,
    /* A quarter-second of edges may be waiting; longer windows are not judged, as frames wrap at 2,048. */
    WINDOW_MOST_edges = 512,
    DIFFERENCE_MOST = 8, /* 6 %; both clocks are crystals, within 0.1 % together */
    /* So many edges without a new frame: no bus, or it is suspended. So many frames at once: the processor
     * stood still or was busy. After both, a new window begins. */
    REST = 20,
    FRAMES = 2048,
};

static struct {
    uint32_t edge_begin, frame_begin; /* of the window */
    uint32_t edge_last, frame_last;   /* at which the last new frame was seen */
    bool has_frame;
} window;

static void begin(uint32_t edges, uint32_t frame)
{
    window.edge_begin = edges;
    window.frame_begin = frame;
}

/* Requirement: SR-26 */
int32_t clock_check(uint32_t edges, uint32_t frame)
{
    if (frame == window.frame_last) return 0;
    const bool has_rested =
        !window.has_frame || edges - window.edge_last >= REST || (frame - window.frame_last) % FRAMES >= REST;
    window.has_frame = true;
    window.frame_last = frame;
    window.edge_last = edges;
    if (has_rested) begin(edges, frame);
    const uint32_t passed = edges - window.edge_begin;
    if (passed < WINDOW_edges) return 0;
    const int32_t difference = (int32_t)((frame - window.frame_begin) % FRAMES) - (int32_t)passed;
    begin(edges, frame);
    const bool is_wrong = difference > DIFFERENCE_MOST || difference < -DIFFERENCE_MOST;
    return is_wrong && passed <= WINDOW_MOST_edges ? difference : 0;
}
