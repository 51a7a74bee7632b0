// Contains main() of the program that `make run` builds on a machine without a display: everything except the
// window.
#include "host/command/cli.hpp"

int main(int argc, char **argv)
{
    return crn::command_line(argc, argv, nullptr);
}
