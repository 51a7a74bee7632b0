#include "hil_tests/lies/judge.hpp"
#include "host/base/interrupt.hpp"
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace hil
{

namespace
{

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

constexpr double patience_s = lie_limit_s + 2.0;             // then the process is killed
constexpr double interrupt_patience_s = 3.0, second_s = 0.5; // the second Ctrl-C must end any command
constexpr double quick_s = 0.5;                              // it ended before a person could press a key

double since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Runs `work` in a child process. The child process writes its output to a file and exits with the result of
// `work`. The child process sends a byte through the pipe when the first false message is sent.
class Child
{
  public:
    Child(const std::string &output, const std::function<int(const std::function<void()> &struck)> &work)
    {
        int ends[2];
        if (::pipe(ends) != 0) std::abort();
        begin_ = Clock::now();
        pid_ = ::fork();
        if (pid_ == 0) {
            std::signal(SIGINT, SIG_DFL);
            std::signal(SIGTERM, SIG_DFL);
            const int file = ::open(output.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
            const int nothing = ::open("/dev/null", O_RDONLY);
            ::dup2(nothing, STDIN_FILENO);
            ::dup2(file, STDOUT_FILENO);
            ::dup2(file, STDERR_FILENO);
            const int end = ends[1];
            const int code = work([end] { static_cast<void>(!::write(end, "!", 1)); });
            std::fflush(nullptr);
            ::_exit(code);
        }
        ::close(ends[1]);
        told_ = ends[0];
        ::fcntl(told_, F_SETFL, O_NONBLOCK);
    }
    ~Child()
    {
        if (pid_ > 0 && !is_over_) {
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, &status_, 0);
        }
        ::close(told_);
    }
    Child(const Child &) = delete;
    Child &operator=(const Child &) = delete;

    // Waits until the child process has ended, `may_stop` returns true, or `seconds` have passed. Returns
    // true if the child process has ended.
    bool wait(double seconds, const std::function<bool()> &may_stop = {})
    {
        const Clock::time_point begin = Clock::now();
        while (!is_over_ && since(begin) < seconds && !(may_stop && may_stop())) {
            char byte;
            has_struck_ = ::read(told_, &byte, 1) == 1 || has_struck_;
            is_over_ = ::waitpid(pid_, &status_, WNOHANG) == pid_;
            if (!is_over_) ::usleep(1000);
        }
        char byte;
        has_struck_ = ::read(told_, &byte, 1) == 1 || has_struck_;
        return is_over_;
    }
    void send(int number) const { ::kill(pid_, number); }
    bool has_struck() const { return has_struck_; }
    double seconds() const { return since(begin_); }
    int code() const { return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1; }
    int end_signal() const { return WIFSIGNALED(status_) ? WTERMSIG(status_) : 0; }

  private:
    pid_t pid_ = -1;
    int told_ = -1, status_ = 0;
    bool is_over_ = false, has_struck_ = false;
    Clock::time_point begin_;
};

std::string last_line(const std::string &path)
{
    std::ifstream file(path);
    std::string line, last;
    while (std::getline(file, line))
        if (line.find_first_not_of(" \t") != std::string::npos) last = line;
    for (char &one : last)
        if (one < 0x20 || one == 0x7f) one = '?';
    return last;
}

bool has_control_characters(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    return text.find("\x1b[2J") != std::string::npos;
}

// Sends Ctrl-C (SIGINT) to the process and measures how soon the process ends. If the process does not end,
// it gets a second Ctrl-C, after which it must end.
void interrupt(const LieCase &one, const std::string &folder, const std::string &output, Verdict &verdict)
{
    Child child(output, [&](const std::function<void()> &struck) {
        return run_command(*one.command, one.lie, folder, struck);
    });
    if (child.wait(1.0, [&] { return child.has_struck(); })) return;
    if (child.wait(0.1)) return;
    const Clock::time_point begin = Clock::now();
    child.send(SIGINT);
    const bool has_ended = child.wait(interrupt_patience_s);
    verdict.interrupt_s = since(begin);
    if (!has_ended) {
        child.send(SIGINT);
        const bool is_ended_by_second = child.wait(second_s);
        verdict.failure =
            is_ended_by_second ? "Ctrl-C did not end it, a second one did" : "two Ctrl-C did not end it";
    } else if (child.end_signal() == SIGINT && !child.has_struck()) {
        verdict.interrupt_s = -1.0; // so early that the program had not installed its handler yet
    } else if (child.end_signal() != 0) {
        verdict.failure = std::string("after Ctrl-C it died: ") + strsignal(child.end_signal());
    } else if (verdict.interrupt_s > lie_interrupt_limit_s) {
        verdict.failure = "it ended too long after Ctrl-C";
    }
}

// Checks in a separate process whether the recording is true, because the recording may contain anything and
// the check may crash or hang.
std::string check_recording(const std::string &recording, const std::string &output, bool has_to_be_complete)
{
    Child child(output, [&](const std::function<void()> &) {
        const std::string wrong = falsehood(recording, has_to_be_complete);
        std::printf("%s\n", wrong.c_str());
        return wrong.empty() ? 0 : 1;
    });
    if (!child.wait(60.0)) return "the recording's check does not end";
    if (child.code() == 0) return "";
    return child.code() == 1 ? last_line(output) : "the recording's check died";
}

Verdict judge_one(const LieCase &one, const std::string &folder)
{
    Verdict verdict;
    const std::string output = folder + "/output";
    const std::string recording = *one.command->recording ? folder + "/" + one.command->recording : "";
    fs::remove(recording);
    {
        Child child(output, [&](const std::function<void()> &struck) {
            return run_command(*one.command, one.lie, folder, struck);
        });
        const bool has_ended = child.wait(patience_s);
        verdict.seconds = child.seconds();
        verdict.has_struck = child.has_struck();
        verdict.message = last_line(output);
        verdict.code = has_ended ? child.code() : -1;
        if (!has_ended)
            verdict.failure = "it did not end";
        else if (child.end_signal() != 0)
            verdict.failure = std::string("it died: ") + strsignal(child.end_signal());
        else if (verdict.code != 0 && verdict.code != 1)
            verdict.failure = "its exit code is neither 0 nor 1";
        else if (verdict.seconds > lie_limit_s)
            verdict.failure = "it ended too late";
        else if (verdict.code == 1 && verdict.message.size() < 10)
            verdict.failure = "it failed without a word";
        else if (has_control_characters(output))
            verdict.failure = "the device writes on the terminal";
    }
    if (!recording.empty()) {
        const std::string wrong = check_recording(recording, folder + "/check", verdict.code == 0);
        verdict.is_false = !wrong.empty();
        if (verdict.is_false) verdict.failure = "recorded falsely: " + wrong;
        // A command that ended before the false message was sent leaves its recording under a temporary name,
        // which is removed here.
        for (const fs::directory_entry &entry : fs::directory_iterator(folder))
            if (entry.path().string().find(".part") != std::string::npos) fs::remove(entry.path());
    }
    if (verdict.seconds > quick_s && verdict.failure.empty()) interrupt(one, folder, output, verdict);
    return verdict;
}

// --- several at a time ---

// Every test case becomes one line: its index and the fields of its verdict, separated by tabs.
void work(const std::vector<LieCase> &cases, std::size_t first, std::size_t step, unsigned ticks, int end)
{
    char name[] = "/tmp/cournand_lies_XXXXXX";
    if (::mkdtemp(name) == nullptr) return;
    const std::string folder = name;
    write_inputs(folder, ticks);
    for (std::size_t i = first; i < cases.size(); i += step) {
        const Verdict verdict = judge_one(cases[i], folder);
        std::ostringstream line;
        line << i << '\t' << verdict.code << '\t' << verdict.seconds << '\t' << verdict.interrupt_s << '\t'
             << verdict.has_struck << '\t' << verdict.is_false << '\t' << verdict.failure.substr(0, 400)
             << '\t' << verdict.message.substr(0, 1000) << '\n';
        const std::string text = line.str(); // less than a pipe accepts at once
        static_cast<void>(!::write(end, text.data(), text.size()));
    }
    fs::remove_all(folder);
}

void take(const std::string &line, std::vector<Verdict> &verdicts)
{
    std::istringstream text(line);
    std::vector<std::string> fields(8);
    for (std::string &field : fields) std::getline(text, field, '\t');
    Verdict &verdict = verdicts.at(std::stoul(fields[0]));
    verdict.code = std::stoi(fields[1]);
    verdict.seconds = std::stod(fields[2]);
    verdict.interrupt_s = std::stod(fields[3]);
    verdict.has_struck = fields[4] == "1";
    verdict.is_false = fields[5] == "1";
    verdict.failure = fields[6];
    verdict.message = fields[7];
}

} // namespace

std::vector<LieCase> cases_of(std::size_t lies_per_command)
{
    std::vector<LieCase> cases;
    for (const LiedTo &command : lied_to()) {
        std::vector<Lie> lies = command.is_by_hid ? hid_lies() : stream_lies();
        if (lies_per_command > 0) lies = spread_lies(lies, lies_per_command);
        for (const Lie &lie : lies) cases.push_back({&command, lie});
    }
    return cases;
}

namespace
{

std::vector<Verdict> judge_once(const std::vector<LieCase> &cases, unsigned jobs, unsigned ticks,
                                const std::function<void(std::size_t done)> &tell)
{
    std::vector<Verdict> verdicts(cases.size());
    for (Verdict &verdict : verdicts) verdict.failure = "not judged";
    int ends[2];
    if (::pipe(ends) != 0) return verdicts;
    std::vector<pid_t> workers;
    std::fflush(nullptr);
    for (unsigned i = 0; i < jobs; i++) {
        const pid_t pid = ::fork();
        if (pid == 0) {
            ::close(ends[0]);
            work(cases, i, jobs, ticks, ends[1]);
            ::_exit(0);
        }
        if (pid > 0) workers.push_back(pid);
    }
    ::close(ends[1]);
    std::FILE *lines = ::fdopen(ends[0], "r");
    char line[4096];
    std::size_t done = 0;
    while (!crn::is_interrupted() && std::fgets(line, sizeof line, lines) != nullptr) {
        take(line, verdicts);
        if (tell) tell(++done);
    }
    std::fclose(lines);
    for (const pid_t pid : workers) {
        if (crn::is_interrupted()) ::kill(pid, SIGKILL);
        ::waitpid(pid, nullptr, 0);
    }
    return verdicts;
}

// Lists the failed test cases that may have failed only because the machine was busy.
bool is_about_time(const std::string &failure)
{
    for (const char *words : {"did not end", "too late", "too long"})
        if (failure.find(words) != std::string::npos) return true;
    return false;
}

} // namespace

std::vector<Verdict> judge(const std::vector<LieCase> &cases, unsigned jobs, unsigned ticks,
                           const std::function<void(std::size_t done)> &tell)
{
    constexpr int more_rounds = 2;
    constexpr std::size_t again_max = 40;
    std::vector<Verdict> verdicts = judge_once(cases, jobs, ticks, tell);
    // A command that was too slow on a busy machine is run and judged again while nothing else runs; a
    // command that really hangs will hang again.
    for (int round = 0; round < more_rounds; round++) {
        std::vector<LieCase> late;
        std::vector<std::size_t> places;
        for (std::size_t i = 0; i < cases.size(); i++) {
            if (!is_about_time(verdicts[i].failure)) continue;
            late.push_back(cases[i]);
            places.push_back(i);
        }
        if (late.empty() || late.size() > again_max || crn::is_interrupted()) break;
        const std::vector<Verdict> again = judge_once(late, 1, ticks, {});
        for (std::size_t i = 0; i < late.size(); i++) verdicts[places[i]] = again[i];
    }
    return verdicts;
}

} // namespace hil
