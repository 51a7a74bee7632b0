// Starts a process that writes one text to a pipe and then ends.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>

namespace soak
{

constexpr int check_every_ms = 200; // interval for checking the clock and Ctrl-C

struct Process {
    pid_t who;
    int pipe; // carries its output; it is closed when the process ends
};

// Runs `work` in the new process. The new process exits with 0 after the parent process has read the whole
// text that `work` returned. The new process exits with 1 if the parent did not read the whole text, or if
// `work` returned no text. It ends with its parent. Throws std::runtime_error.
Process start_process(const std::function<std::optional<std::string>()> &work);

// Waits for the process and returns its status in the form of waitpid().
int status_of_end(pid_t who);

} // namespace soak
