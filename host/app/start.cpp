#include "host/app/start.hpp"
#include "host/app/window.hpp"
#include "host/command/cli.hpp"

namespace crn
{

int open_start()
{
    WindowOptions options;
    choose_defaults(options);
    return run_window(options);
}

} // namespace crn
