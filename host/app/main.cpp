#include "host/command/cli.hpp"
#include "host/suite/window.hpp"

int main(int argc, char **argv)
{
    return crn::command_line(argc, argv, crn::run_window, crn::open_start);
}
