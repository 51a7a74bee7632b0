// A process that says one text and ends.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>

namespace soak
{

struct Process {
    pid_t who;
    int pipe; // of what it says; it closes when it ends
};

// Runs `work` there and ends with 0 when all that it returned was taken, else, or for nothing, with 1. It
// ends with its parent. Throws std::runtime_error.
Process start_process(const std::function<std::optional<std::string>()> &work);

// As waitpid() tells it.
int status_of_end(pid_t who);

} // namespace soak
