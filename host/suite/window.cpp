#include "host/suite/window.hpp"
#include "host/base/interrupt.hpp"
#include "host/command/cli.hpp"
#include "host/command/names.hpp"
#include "host/suite/suite_app.hpp"

namespace crn
{

int run_window(WindowOptions options)
{
    const bool is_session = !options.opens_start && options.replays.empty() && !options.lesson;
    if (is_session && options.pictures.bodies_path.empty())
        options.pictures.bodies_path = bodies_beside(options.scene);
    options.pictures.scene_path = is_session ? options.scene : "";
    std::vector<NamedPath> inputs = tool_inputs(options.instrument, options.tools);
    for (const std::string &stent : options.stents) inputs.push_back({"--stent", stent});
    inputs.insert(inputs.end(), {{"--scene", options.scene}, {"--bodies", options.pictures.bodies_path}});
    if (options.record.empty() && options.keeps_recording && is_session) options.record = kept_recording();
    if (!options.replays.empty()) inputs.push_back({"--replay", options.replays});
    check_outputs(inputs, {{"--record", options.record},
                           {"--screenshot", options.screenshot},
                           {"--layout", options.layout},
                           {"--timing", options.timing},
                           {"--json", options.json},
                           {"--score", options.score}});
    check_dicom_settings(options.pictures.dicom);
    watch_for_interrupt();
    return SuiteApp(options).run();
}

int open_start()
{
    WindowOptions options;
    choose_defaults(options);
    options.opens_start = true;
    options.shows_help = false;
    return run_window(options);
}

} // namespace crn
