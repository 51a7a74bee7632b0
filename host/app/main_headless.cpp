// Contains main() of the program that `make run` builds on a machine without a display; this program has
// every command except the one that opens a window.
#include "host/command/cli.hpp"

int main(int argc, char **argv)
{
    return crn::command_line(argc, argv, nullptr);
}
