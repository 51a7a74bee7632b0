// A process that writes one text and ends.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>

namespace soak
{

struct Process {
    pid_t who;
    int pipe; // carries its output; it is closed when the process ends
};

// Runs `work` in the new process. It ends with 0 when the whole returned text was read, otherwise, or without
// a text, with 1. It ends with its parent. Throws std::runtime_error.
Process start_process(const std::function<std::optional<std::string>()> &work);

// Returns the status in the form of waitpid().
int status_of_end(pid_t who);

} // namespace soak
