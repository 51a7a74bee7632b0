// Runs other programs of this project, such as `anatomy` and `bake`, from the folder of this program.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace crn
{

// Returns the path of a program in the folder of the running program. Throws a std::runtime_error that states
// the remedy if there is no such program.
std::string
sibling_program(const std::string &name,
                const std::string &remedy = "build it by `make cases`, or install all programs by "
                                            "`make install`");

// Replaces the running program by another one; the first word is its path. Throws std::runtime_error if it
// cannot be started.
[[noreturn]] void become_program(const std::vector<std::string> &words);

struct ProgramResult {
    int code = 0;        // exit code, or 128 and the number of the signal
    std::string said;    // standard output
    std::string refused; // standard error
    bool was_stopped = false;
};

// Runs a program until it ends. The function calls `goes_on` about ten times per second. When `goes_on`
// returns false, the program gets SIGTERM, and SIGKILL two seconds later. The program also ends when this
// process dies. Throws std::runtime_error if the program cannot be started.
ProgramResult run_program(const std::vector<std::string> &words, const std::function<bool()> &goes_on);

} // namespace crn
