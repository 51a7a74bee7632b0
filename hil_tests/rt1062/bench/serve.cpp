#include "hil_tests/rt1062/bench/serve.hpp"
#include "hil_tests/plant/plant.hpp"
#include "hil_tests/rt1062/bench/rig_pins.hpp"
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <sys/mman.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace hil
{

namespace
{

using Clock = std::chrono::steady_clock;

constexpr double slice_us = 20; // between two looks at the mailbox
constexpr double lead_max_us = 500, lag_max_us = 50000;
constexpr int waits_looks_max = 100;

// Holds the mailbox in a file that the bridge maps, too. The file goes with this object.
class MailboxFile
{
  public:
    MailboxFile()
    {
        file_ = mkstemp(path_.data());
        if (file_ < 0 || ftruncate(file_, CRN_MAILBOX_BYTES) != 0)
            throw std::runtime_error(path_ + ": cannot be written");
        void *memory = mmap(nullptr, CRN_MAILBOX_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
        if (memory == MAP_FAILED) throw std::runtime_error(path_ + ": cannot be mapped");
        mailbox_ = static_cast<crn_mailbox *>(memory);
    }
    ~MailboxFile()
    {
        munmap(mailbox_, CRN_MAILBOX_BYTES);
        close(file_);
        unlink(path_.c_str());
    }
    MailboxFile(const MailboxFile &) = delete;
    MailboxFile &operator=(const MailboxFile &) = delete;
    crn_mailbox *mailbox() { return mailbox_; }
    std::string place() const { return path_ + ":0"; }

  private:
    std::string path_ = "/dev/shm/cournand_board_XXXXXX";
    int file_ = -1;
    crn_mailbox *mailbox_ = nullptr;
};

struct ChipEnd {
    void operator()(rt_chip *chip) const { rt_chip_destroy(chip); }
    void operator()(rt_engine *engine) const { rt_engine_destroy(engine); }
};

class LiveBoard
{
  public:
    LiveBoard(const std::string &image, crn_mailbox *mailbox)
        : chip_(rt_chip_create()), plant_({}), pins_(*chip_)
    {
        const char *error = nullptr;
        pins_.put(plant_.inputs());
        engine_.reset(rt_engine_create(chip_.get(), image.c_str(), &error));
        if (!engine_) throw std::runtime_error(image + ": " + error);
        rt_bus_start(&bus_, chip_.get(), mailbox);
        begin_ = Clock::now();
        next_ms_ = chip_->now + ms;
    }

    // Answers tokens, and lets the chip's clock follow the wall's. Time that this machine did not have is
    // lost.
    void run()
    {
        if (rt_bus_serve(&bus_) && bus_.change_until == 0) return;
        const double lead_us = static_cast<double>(chip_->now) / RT_INSTANTS_PER_us -
                               std::chrono::duration<double, std::micro>(Clock::now() - begin_).count();
        if (lead_us > lead_max_us) {
            std::this_thread::sleep_for(std::chrono::microseconds(20));
            return;
        }
        if (lead_us < -lag_max_us) begin_ += std::chrono::microseconds(static_cast<long>(-lead_us));
        if (rt_engine_run_us(engine_.get(), slice_us) == RT_STOP_RESET)
            rt_bus_start(&bus_, chip_.get(), bus_.mailbox);
        if (chip_->now < next_ms_) return;
        next_ms_ += ms;
        plant_.step(pins_.outputs());
        pins_.put(plant_.inputs());
    }

    // The command may have ended while the image waits, for a conversion of the ADC for example. Such a wait
    // is over within a millisecond.
    std::uint32_t report()
    {
        for (int i = 0; i < waits_looks_max && rt_unanswered(chip_.get(), 0) != nullptr; i++)
            rt_engine_run_us(engine_.get(), slice_us);
        return rt_report(chip_.get(), stderr, rt_engine_place, engine_.get());
    }

  private:
    static constexpr std::uint64_t ms = RT_INSTANTS_PER_us * 1000;
    std::unique_ptr<rt_chip, ChipEnd> chip_;
    std::unique_ptr<rt_engine, ChipEnd> engine_;
    Plant plant_;
    RigPins pins_;
    rt_bus bus_{};
    Clock::time_point begin_;
    std::uint64_t next_ms_ = 0;
};

pid_t start(std::vector<std::string> command, const std::string &place)
{
    for (std::string &word : command) {
        const std::size_t at = word.find("{mailbox}");
        if (at != std::string::npos) word.replace(at, std::strlen("{mailbox}"), place);
    }
    std::vector<char *> words;
    for (std::string &word : command) words.push_back(word.data());
    words.push_back(nullptr);
    const pid_t child = fork();
    if (child != 0) return child;
    execvp(words[0], words.data());
    std::perror(words[0]);
    _exit(1);
}

} // namespace

int serve_board(const std::string &image, const std::vector<std::string> &command)
{
    MailboxFile file;
    LiveBoard board(image, file.mailbox());
    const auto booted = [&] { return crn_mailbox_read(&file.mailbox()->device.attached) != 0; };
    const Clock::time_point deadline = Clock::now() + std::chrono::seconds(10);
    while (!booted() && Clock::now() < deadline) board.run();
    if (!booted()) throw std::runtime_error("the device does not connect to the bus within 10 s");
    const pid_t child = start(command, file.place());
    if (child < 0) throw std::runtime_error(command[0] + ": cannot be started");
    int status = 0;
    for (int i = 0;; i++) {
        board.run();
        if (i % 256 == 0 && waitpid(child, &status, WNOHANG) == child) break;
    }
    const std::uint32_t troubles = board.report();
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
    return code == 0 && troubles != 0 ? 1 : code;
}

} // namespace hil
