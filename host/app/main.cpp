#include "host/app/cli.hpp"

int main(int argc, char **argv)
{
    return crn::command_line(argc, argv);
}
