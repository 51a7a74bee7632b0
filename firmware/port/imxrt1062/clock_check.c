/* This port has never run on hardware. Compares the millisecond timer with the frames of USB, which the
 * host's own clock gives every millisecond: docs/safety.md, "Self-test". A motor has power only with a host,
 * so the comparison has always been made before. */
#include "firmware/port/imxrt1062/board.h"

enum {
    WINDOW_edges = 128,
    DIFFERENCE_MOST = 8, /* 6 %; both clocks are crystals, within 0.1 % together */
    /* So many edges without a new frame: no bus, or it is suspended. So many frames at once: the processor
     * stood still, or the bus was reset. After such a gap a new window begins. */
    REST = 20,
    FRAMES = 2048,
};

static struct {
    uint32_t edge_begin, frames;    /* of the window: its first edge, and the frames since then */
    uint32_t edge_last, frame_last; /* at which the last new frame was seen */
    int32_t gap;                    /* frames less edges of the gap that came last; 0: none, or both agree */
    bool has_frame;
} window;

static void begin(uint32_t edges)
{
    window.edge_begin = edges;
    window.frames = 0;
}

static bool is_far(int32_t difference)
{
    return difference > DIFFERENCE_MOST || difference < -DIFFERENCE_MOST;
}

/* One gap has a cause on the bus or in the processor. Two in a row, without a frame in time between them,
 * show a timer that is twenty times too fast or too slow. */
static int32_t after_gap(uint32_t edges, int32_t difference)
{
    const int32_t before = window.gap;
    begin(edges);
    window.gap = is_far(difference) ? difference : 0;
    const bool is_again = (before > 0 && window.gap > 0) || (before < 0 && window.gap < 0);
    return is_again ? difference : 0;
}

/* Requirement: SR-26 */
int32_t clock_check(uint32_t edges, uint32_t frame)
{
    if (window.has_frame && frame == window.frame_last) return 0;
    const uint32_t edges_more = edges - window.edge_last, frames_more = (frame - window.frame_last) % FRAMES;
    const bool is_first = !window.has_frame;
    window.has_frame = true;
    window.frame_last = frame;
    window.edge_last = edges;
    if (is_first) {
        begin(edges);
        return 0;
    }
    if (edges_more >= REST || frames_more >= REST)
        return after_gap(edges, (int32_t)frames_more - (int32_t)edges_more);
    window.gap = 0;
    window.frames += frames_more;
    const uint32_t passed = edges - window.edge_begin;
    if (passed < WINDOW_edges) return 0;
    const int32_t difference = (int32_t)window.frames - (int32_t)passed;
    begin(edges);
    return is_far(difference) ? difference : 0;
}
