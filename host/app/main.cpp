#include "host/app/start.hpp"
#include "host/app/window.hpp"
#include "host/command/cli.hpp"

int main(int argc, char **argv)
{
    return crn::command_line(argc, argv, crn::run_window, crn::open_start);
}
