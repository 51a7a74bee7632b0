// The program as `make run` builds it on a machine without a display: everything but the window.
#include "host/command/cli.hpp"

int main(int argc, char **argv)
{
    return crn::command_line(argc, argv, nullptr);
}
