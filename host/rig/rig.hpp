// Declares the commands of cournand rig, which find, inspect, test and calibrate a rig, and let the user's
// hand feel forces.
#pragma once
#include "host/link/hid_rig.hpp"
#include "host/link/link.hpp"
#include <cstdio>
#include <functional>
#include <string>

namespace crn
{

struct RigOptions {
    std::string command;        // list, info, monitor, selftest, calibrate, force, log
    std::string device = "usb"; // as parse_device
    std::string hid = "hidraw"; // hidraw or libusb
    std::string csv;
    std::string save, load; // files of a calibration
    bool json = false, motors = false, yes = false, reset = false;
    double seconds = 0.0; // monitor: 0 until Ctrl-C; force: how long
    unsigned track = 1;   // from the innermost
    std::string what = "all";
    double distance_mm = 100.0, turns = 1.0, weight_g = 100.0;
    unsigned force_mN = 300;
    double damping_N_s_per_m = 0.0; // 0: the rig's own value
};

// Carries out options.command and returns the exit code.
int command_rig(const RigOptions &options);

// Defines how a command communicates with its user; tests replace these functions by their own.
struct RigTalk {
    std::FILE *out = stdout;
    bool is_terminal = false;
    std::function<bool(std::string &)> read_line; // an answer; false: end of input, or Ctrl-C
    std::function<bool()> is_interrupted;
    // Prints a question for the user and returns the answer. Throws RigStopped for end of input and Ctrl-C.
    std::string ask(const std::string &question) const;
};
RigTalk console_talk();

// The rig dialogue throws this exception when the user ends the dialogue; its message states which settings
// were left unchanged.
class RigStopped : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Every function below carries out one command on a link to a device that has already answered HELLO. These
// functions return 0 for success and 1 for a failure.
int rig_info(Link &link, const crn_wire_hello_reply &hello, const RigOptions &options, const RigTalk &talk);
int rig_log(Link &link, const RigTalk &talk);
int rig_selftest(Link &link, const crn_wire_hello_reply &hello, const RigOptions &options,
                 const RigTalk &talk);
int rig_calibrate(Link &link, const RigOptions &options, const RigTalk &talk);
int rig_force(Link &link, const RigOptions &options, const RigTalk &talk);
// The function `next` returns the next state report, or no value while the rig is silent.
using StateSource = std::function<std::optional<crn_hid_state>()>;
int rig_monitor(const StateSource &next, const RigOptions &options, const RigTalk &talk);
// Prints the rig's state as rig_monitor does, but reads the state through the HID interface.
int rig_monitor_hid(const HidApi &api, const std::string &serial, const RigOptions &options,
                    const RigTalk &talk);

// --- shared by the commands ---

std::string state_name(unsigned state);
std::string sensor_name(unsigned status);
std::string serial_of(const crn_wire_hello_reply &hello);
// Brings the rig to the state READY, in which settings may change; if `may_reset` is true, it may reset the
// rig for this. Throws LinkError if the rig does not reach READY; the message names the rig's present
// activity.
void require_ready(Link &link, bool may_reset);

// A trial on one track. During the trial a spring connects the user's hand with a simulated straight tool in
// free space; the valve around the tool has the friction `force_mN`. The hand feels at most the friction
// force of the valve while the hand moves slowly, and no force while the hand rests. The rig's motors have
// power from begin() to end(). The function end() restores the former settings of the rig; the destructor
// calls end().
class MotorTrial
{
  public:
    MotorTrial(Link &link, unsigned track, unsigned force_mN, double damping_N_s_per_m);
    ~MotorTrial();
    MotorTrial(const MotorTrial &) = delete;
    MotorTrial &operator=(const MotorTrial &) = delete;
    void begin(); // ARM, ARM_MOTORS, CONFIRM, START
    // Runs the rig for 10 ms in FREE_RUN and returns the ticks that the rig sent. Throws LinkError with cause
    // and remedy when the rig went into FAULT.
    const std::vector<crn_wire_live_tick> &run();
    void end();

  private:
    Link &link_;
    unsigned track_;
    crn_wire_rig before_{}, trial_{};
    bool is_changed_ = false;
};

} // namespace crn
