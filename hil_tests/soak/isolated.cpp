// Runs and judges one session in a separate process, and converts verdicts to lines of text.
#include "hil_tests/soak/process.hpp"
#include "hil_tests/soak/trial.hpp"
#include "host/base/interrupt.hpp"
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <poll.h>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace soak
{

namespace
{

using Clock = std::chrono::steady_clock;

std::string without_tabs(std::string text)
{
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\t' || c == '\n' || c == '\r'; }, ' ');
    return text.empty() ? "-" : text;
}

// Reads the output of the process until the process closes the pipe. Returns false if the process did not end
// within `seconds_max`.
bool read_all(int pipe, pid_t who, double seconds_max, std::string &text)
{
    const Clock::time_point begin = Clock::now();
    bool was_told = false;
    for (;;) {
        if (crn::is_interrupted() && !was_told) kill(who, SIGINT);
        was_told = was_told || crn::is_interrupted();
        if (std::chrono::duration<double>(Clock::now() - begin).count() > seconds_max) return false;
        pollfd one{pipe, POLLIN, 0};
        if (poll(&one, 1, check_every_ms) <= 0) continue;
        char bytes[4096];
        const ssize_t count = read(pipe, bytes, sizeof bytes);
        if (count == 0) return true;
        if (count > 0) text.append(bytes, static_cast<std::size_t>(count));
        if (count < 0 && errno != EINTR && errno != EAGAIN) return true;
    }
}

} // namespace

Verdict run_isolated(const std::function<Verdict()> &trial, double seconds_max)
{
    const Process process = start_process([&] { return line_of(trial()); });
    std::string text;
    const bool is_in_time = read_all(process.pipe, process.who, seconds_max, text);
    close(process.pipe);
    if (!is_in_time) kill(process.who, SIGKILL);
    const int status = status_of_end(process.who);
    if (is_in_time && WIFEXITED(status) && WEXITSTATUS(status) == 0) return verdict_of(text);
    Verdict verdict;
    verdict.was_interrupted = crn::is_interrupted();
    verdict.broken = is_in_time ? "crash" : "time";
    verdict.text = is_in_time && WIFSIGNALED(status) ? std::string("crash: ") + strsignal(WTERMSIG(status))
                   : is_in_time
                       ? "crash: exit code " + std::to_string(WEXITSTATUS(status))
                       : "time: not done within " + std::to_string(static_cast<int>(seconds_max)) + " s";
    return verdict;
}

std::string line_of(const Verdict &verdict)
{
    char numbers[200];
    std::snprintf(numbers, sizeof numbers, "%u\t%u\t%.4f\t%.4f\t%.3f\t%u\t%.3f\t%016llx\t",
                  unsigned{verdict.ticks}, unsigned{verdict.tick}, verdict.penetration_mm, verdict.length_pct,
                  verdict.force_N, unsigned{verdict.capped}, verdict.injected_mg,
                  static_cast<unsigned long long>(verdict.hash));
    return (verdict.was_interrupted ? "interrupted" : without_tabs(verdict.broken)) + "\t" + numbers +
           without_tabs(verdict.text);
}

Verdict verdict_of(const std::string &line)
{
    std::istringstream in(line);
    Verdict verdict;
    std::string hash;
    in >> verdict.broken >> verdict.ticks >> verdict.tick >> verdict.penetration_mm >> verdict.length_pct >>
        verdict.force_N >> verdict.capped >> verdict.injected_mg >> hash;
    if (!in || hash.size() != 16) throw std::runtime_error("'" + line + "' is no verdict");
    verdict.hash = std::stoull(hash, nullptr, 16);
    in.get();
    std::getline(in, verdict.text);
    verdict.was_interrupted = verdict.broken == "interrupted";
    if (verdict.was_interrupted || verdict.broken == "-") verdict.broken.clear();
    if (verdict.text == "-") verdict.text.clear();
    return verdict;
}

} // namespace soak
