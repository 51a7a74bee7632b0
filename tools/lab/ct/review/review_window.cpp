#include "tools/lab/ct/review/review_window.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include "tools/lab/ct/review/review_screen.hpp"
#include <algorithm>
#include <stdexcept>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace crn::ct
{

namespace
{

constexpr double look_s = 0.25; // between looks at the folder
constexpr int frames_after = 3; // that ImGui needs to show what an event has changed
constexpr double frame_s = 1 / 30.0;

} // namespace

ReviewEnd review_patient(const ReviewOptions &options)
{
    watch_for_interrupt();
    ReviewState state(options.folder, options.command);
    SuiteWindow window("Cournand: your own CT", {options.width, options.height}, "");
    Ui ui(window);
    ReviewScreen screen(ui, state);
    ReviewWish wish;
    const auto take = [&wish](const ReviewWish &more) {
        wish.plays = wish.plays || more.plays;
        wish.ends = wish.ends || more.ends;
    };
    window.on_key([&](int key, int action, int) {
        if (action == GLFW_PRESS) take(screen.press(key));
    });
    if (options.runs_at_once) state.run(options.first_command);
    std::string layout;
    int frames = frames_after;
    while (!wish.ends && !wish.plays && !window.wants_close() && !is_interrupted()) {
        const auto before = std::chrono::steady_clock::now();
        window.poll(frames > 0 ? frame_s : look_s);
        const bool had_event = std::chrono::steady_clock::now() - before <
                               std::chrono::duration<double>(0.9 * (frames > 0 ? frame_s : look_s));
        if (state.look() || had_event) frames = frames_after;
        if (frames == 0 && !state.is_running()) continue;
        frames = std::max(frames - 1, 0);
        window.begin_frame();
        take(screen.draw());
        window.end_frame();
        if (options.layout.empty()) continue;
        if (const std::string text = ui.layout_text(); text != layout) {
            write_whole_file(options.layout, text);
            layout = text;
        }
    }
    std::string error;
    if (!options.screenshot.empty() && !write_png(options.screenshot, window.read_back(), error))
        throw std::runtime_error(error);
    state.stop();
    if (is_interrupted()) return ReviewEnd::interrupted;
    return wish.plays ? ReviewEnd::wants_play : ReviewEnd::closed;
}

} // namespace crn::ct
