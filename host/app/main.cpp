#include "host/app/cli.hpp"

int main(int argc, char **argv)
{
    return seld::command_line(argc, argv);
}
