#include "tools/lab/figures/instructions.hpp"
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>

extern char **environ;

namespace vcsim3
{
namespace
{

constexpr int steps = 10;

// Runs a program whose standard output and standard error go to the file `log`. Returns the program's exit
// code, or -1 when it could not be started.
int run_program(const std::vector<std::string> &arguments, const std::string &log)
{
    std::vector<char *> list;
    for (const std::string &argument : arguments) list.push_back(const_cast<char *>(argument.c_str()));
    list.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    pid_t process = 0;
    const int failed = posix_spawnp(&process, list[0], &actions, nullptr, list.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    int status = 0;
    if (failed != 0 || waitpid(process, &status, 0) != process || !WIFEXITED(status)) return -1;
    return WEXITSTATUS(status);
}

std::string text_of(const std::string &path)
{
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

double count_one(const std::string &token, const std::string &states_folder,
                 const std::vector<std::string> &arguments)
{
    const std::string log = states_folder + "/" + token + ".callgrind";
    std::vector<std::string> command = {"valgrind",
                                        "--tool=callgrind",
                                        "--toggle-collect=vcsim3_measured_step",
                                        "--callgrind-out-file=/dev/null",
                                        std::filesystem::read_symlink("/proc/self/exe").string(),
                                        "steps",
                                        token,
                                        "--states",
                                        states_folder,
                                        "--count",
                                        std::to_string(steps)};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const int code = run_program(command, log);
    const std::string text = text_of(log), words = "Collected : ";
    const std::size_t at = text.find(words);
    const double counted =
        at == std::string::npos ? 0.0 : std::strtod(text.c_str() + at + words.size(), nullptr);
    if (code != 0 || counted <= 0.0)
        throw std::runtime_error("valgrind (package valgrind) did not count the steps of " + token +
                                 ", exit code " + std::to_string(code) + "; its words are in " + log);
    return counted / steps;
}

} // namespace

void count_instructions(Study &study, const std::string &states_folder,
                        const std::vector<std::string> &arguments, const Report &report)
{
    for (std::size_t i = 0; i < study.times.size(); i++) {
        if (!report("instructions", static_cast<double>(i) / static_cast<double>(study.times.size())))
            throw Interrupted();
        study.times[i].instructions = count_one(study.times[i].token, states_folder, arguments);
    }
}

} // namespace vcsim3
