// Runs the device's firmware image on an emulated Cortex-M7: one QEMU process, and memory that it shares with
// the host.
//
// With -icount every instruction takes 2^shift ns of the board's time, so a run depends only on its inputs:
//   shift 7   counts instructions exactly (3.2 counts of the board's clock each); a millisecond holds 7,812 of them
//   shift 1   500 instructions per us; shift 0   1,000 instructions per us: for anything with milliseconds in it
//
// Every wait has a deadline, and the emulator's process ends when the host's process ends, for whatever
// reason.
#pragma once
#include "firmware/port/mps2_an500/rig_page.h"
#include "host/link/link.hpp"
#include <atomic>
#include <functional>
#include <string>
#include <sys/types.h>

namespace crn
{

// EmulatorError means that the emulator did not start, ended, or missed a deadline; its text ends with the
// emulator's console output.
class EmulatorError : public LinkError
{
  public:
    using LinkError::LinkError;
};

struct EmulatorOptions {
    std::string image{}; // empty: $CRN_IMAGE, else the one below $BUILD (default build)
    int icount_shift = 7;
    std::string serial{}; // of the device; empty: its own
    std::string
        debugger{}; // socket for gdb; the device waits for `continue` there, and there are no deadlines
};

class Emulator
{
  public:
    // Starts the emulator and waits until the device is ready. After the start, the shared memory page
    // describes a rig, and the host advances the rig's clock by milliseconds.
    explicit Emulator(const EmulatorOptions &options);
    ~Emulator();
    Emulator(const Emulator &) = delete;
    Emulator &operator=(const Emulator &) = delete;

    rig_page &page() { return *reinterpret_cast<rig_page *>(memory_ + RIG_PAGE_OFFSET); }
    std::uint8_t *memory() { return memory_; } // RIG_MEMORY_BYTES
    std::string memory_path() const { return folder_ + "/memory"; }

    // The next functions pause and continue the emulated processor, as a debugger does. No instruction runs
    // in between.
    void pause();
    void resume();

    // Cuts the device's power immediately, whatever the device is doing, and restores the power with the
    // memory unchanged.
    void power_cycle();

    // Waits until `is_done` returns true. Throws EmulatorError after the deadline, or
    // when the emulator's process ends; the error message contains `what`, which names the awaited event.
    void wait(const std::function<bool()> &is_done, const char *what, double deadline_s = deadline_default_s);
    static constexpr double deadline_default_s = 20.0;

    std::uint32_t boot_count() { return rig_read(&page().device.boot_count); }
    static constexpr double count_ns = 1e9 / int{RIG_CLOCK_HZ};
    double instructions(std::uint32_t counts) const
    {
        return counts * count_ns / (1 << options_.icount_shift);
    }
    std::string console() const;
    pid_t process() const { return process_; }

  private:
    void make_memory();
    void start();
    void kill();

    EmulatorOptions options_;
    std::string folder_;
    std::uint8_t *memory_ = nullptr;
    pid_t process_ = -1;
};

} // namespace crn
