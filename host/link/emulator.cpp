#include "host/link/emulator.hpp"
#include "host/base/interrupt.hpp"
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sched.h>
#include <sstream>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace crn
{

namespace
{

using Clock = std::chrono::steady_clock;

constexpr int not_found = 127; // the shell's exit code for it

[[noreturn]] void refuse(const std::string &what)
{
    throw EmulatorError(what + ": " + std::strerror(errno));
}

std::string image_path(const std::string &given)
{
    if (!given.empty()) return given;
    if (const char *image = std::getenv("CRN_IMAGE")) return image;
    const char *build = std::getenv("BUILD");
    return std::string(build ? build : "build") + "/firmware/cournand-mps2_an500.elf";
}

[[noreturn]] void become(const std::vector<std::string> &command, const std::string &log, pid_t parent)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    setpgid(0, 0); // Ctrl-C is for this program: it ends the session in order, and then the emulator
    if (getppid() != parent) _exit(126); // the parent ended before the line above took effect
    const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600),
              none = open("/dev/null", O_RDONLY);
    dup2(none, 0);
    dup2(file, 1);
    dup2(file, 2);
    std::vector<char *> words;
    for (const std::string &word : command) words.push_back(const_cast<char *>(word.c_str()));
    words.push_back(nullptr);
    execvp(words[0], words.data());
    _exit(not_found);
}

std::string read_text(const std::string &path)
{
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

} // namespace

Emulator::Emulator(const EmulatorOptions &options) : options_(options)
{
    options_.image = image_path(options.image);
    if (!std::filesystem::exists(options_.image))
        throw EmulatorError(options_.image +
                            " does not exist. Remedy: make firmware, or CRN_IMAGE=the image");
    std::string pattern =
        (std::filesystem::exists("/dev/shm") ? std::string("/dev/shm")
                                             : std::filesystem::temp_directory_path().string()) +
        "/cournand_XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) refuse("cannot make a folder for the emulator's memory");
    folder_ = pattern;
    try {
        make_memory();
        start();
    } catch (...) {
        kill();
        if (memory_ != nullptr) munmap(memory_, RIG_MEMORY_BYTES);
        std::filesystem::remove_all(folder_);
        throw;
    }
}

Emulator::~Emulator()
{
    kill();
    munmap(memory_, RIG_MEMORY_BYTES);
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

void Emulator::make_memory()
{
    const int file = open((folder_ + "/memory").c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
    if (file < 0 || ftruncate(file, RIG_MEMORY_BYTES) != 0) refuse("cannot make the emulator's memory");
    void *memory = mmap(nullptr, RIG_MEMORY_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (memory == MAP_FAILED) refuse("cannot map the emulator's memory");
    memory_ = static_cast<std::uint8_t *>(memory);
    rig_host_half &host = page().host;
    options_.serial.copy(host.serial, RIG_SERIAL_BYTES);
    host.version = RIG_VERSION;
    host.tick_source = RIG_TICK_PLANT;
    host.inputs.switches = RIG_SUPPLY_GOOD;
    rig_write(&host.magic, RIG_MAGIC);
}

void Emulator::start()
{
    std::vector<std::string> command = {
        "qemu-system-arm",
        "-M",
        "mps2-an500,memory-backend=ram",
        "-object",
        "memory-backend-file,id=ram,size=" + std::to_string(RIG_MEMORY_BYTES) + ",mem-path=" + folder_ +
            "/memory,share=on",
        "-nodefaults",
        "-display",
        "none",
        "-icount",
        "shift=" + std::to_string(options_.icount_shift) + ",sleep=off",
        "-chardev",
        "file,id=console,append=on,path=" + folder_ + "/console",
        "-serial",
        "chardev:console",
        "-kernel",
        options_.image};
    if (!options_.debugger.empty()) {
        command.insert(command.end(),
                       {"-S", "-chardev", "socket,id=gdb,server=on,wait=off,path=" + options_.debugger,
                        "-gdb", "chardev:gdb"});
    }
    const std::uint32_t boots = boot_count();
    rig_write(&page().device.magic, 0);
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ < 0) refuse("cannot start a process");
    if (process_ == 0) become(command, folder_ + "/log", parent);
    wait([&] { return boot_count() != boots && rig_read(&page().device.magic) == RIG_MAGIC; },
         "the device to start");
}

void Emulator::kill()
{
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
}

void Emulator::pause()
{
    ::kill(process_, SIGSTOP);
    int status = 0;
    waitpid(process_, &status, WUNTRACED); // returns when the process has stopped
    if (!WIFSTOPPED(status))
        throw EmulatorError("the emulator ended instead of standing still\n" + console());
}

void Emulator::resume()
{
    ::kill(process_, SIGCONT);
}

void Emulator::power_cycle()
{
    kill();
    start();
}

void Emulator::wait(const std::function<bool()> &is_done, const char *what, double deadline_s)
{
    constexpr int spins = 4000, yields = 400;
    constexpr auto after_interrupt = std::chrono::milliseconds(500);
    const Clock::time_point begin = Clock::now();
    Clock::time_point interrupted_at{};
    for (long i = 0; !is_done(); i++) {
        if (i < spins) continue;
        if (i < spins + yields) {
            sched_yield();
            continue;
        }
        usleep(50);
        int status = 0;
        if (waitpid(process_, &status, WNOHANG) == process_) {
            process_ = -1;
            if (WIFEXITED(status) && WEXITSTATUS(status) == not_found)
                throw EmulatorError("qemu-system-arm did not start. Remedy: apt-get install qemu-system-arm");
            throw EmulatorError("the emulator ended while we waited for " + std::string(what) + "\n" +
                                console());
        }
        if (is_interrupted() && interrupted_at == Clock::time_point()) interrupted_at = Clock::now();
        if (interrupted_at != Clock::time_point() && Clock::now() - interrupted_at > after_interrupt)
            throw EmulatorError("interrupted while the emulator was waited for: " + std::string(what));
        if (!options_.debugger.empty()) continue;
        if (std::chrono::duration<double>(Clock::now() - begin).count() > deadline_s) {
            throw EmulatorError("waited " + std::to_string(deadline_s) + " s for " + what + "\n" + console());
        }
    }
}

std::string Emulator::console() const
{
    return read_text(folder_ + "/console") + read_text(folder_ + "/log");
}

} // namespace crn
