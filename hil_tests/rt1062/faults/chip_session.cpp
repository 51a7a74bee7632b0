#include "hil_tests/rt1062/faults/chip_session.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <sys/wait.h>
#include <unistd.h>

namespace hil
{

namespace
{

constexpr std::uint32_t host_every_ms = 8, checkpoints = 4, first_checkpoint_ms = 32, between_ms = 32,
                        still_ms = 15, strike_max_ms = 120, undisturbed_ms = 90, child_max_s = 120;
constexpr double hand_m_per_s = 0.1, hand_rad_per_s = 3.0;
// A force that was not asked for: what docs/faults.md lets the device take for one, and for how long.
constexpr double strange_N = 1.0, strange_share = 0.25, strange_ms = 12;
// The undisturbed session feels at least this. Without a force, no fault could break a limit.
constexpr double felt_N = 0.5;

// The pipe to the device. Before the fault it is the bench's own. Afterwards no call lets time pass, because
// time belongs to the rig and its judge.
class Tap final : public crn::Transport
{
  public:
    explicit Tap(BoardBench &bench) : bench_(bench) {}
    void write(std::span<const std::uint8_t> bytes) override
    {
        if (!is_strict_) bench_.pipe().write(bytes);
        if (is_strict_ && !bench_.push(bytes)) throw crn::LinkError("the stream is full");
    }
    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        return is_strict_ ? bench_.take(bytes) : bench_.pipe().read(bytes);
    }
    void pass_time_ms(std::uint32_t milliseconds) override
    {
        if (!is_strict_) bench_.pipe().pass_time_ms(milliseconds);
    }
    bool has_own_clock() const override { return false; }
    void be_strict() { is_strict_ = true; }

  private:
    BoardBench &bench_;
    bool is_strict_ = false;
};

class ChipSession
{
  public:
    explicit ChipSession(const std::string &image) : bench_(board_plant(), image), tap_(bench_), link_(tap_)
    {
        bench_.plant().local_unlock = true; // as BoardLevel has it
        bench_.advance(20);
        campaign_set_up(link_);
        link_.set_stream({1, 0});
        start_free_run(bench_, link_);
        Plant::Track &track = bench_.plant().track(0);
        track.translation.set_hand(Hand::spring);
        track.rotation.set_hand(Hand::spring);
        track.translation.move_hand(hand_m_per_s);
        track.rotation.move_hand(hand_rad_per_s);
    }

    // Runs undisturbed; the registers and the words of memory that the image uses are noted.
    void run_to(std::uint32_t ms, rt_census &census, rt_touched &touched)
    {
        chip()->census = &census;
        rt_engine_watch(&bench_.engine(), &touched);
        while (ms_ < ms) step();
        chip()->census = nullptr;
        rt_engine_watch(&bench_.engine(), nullptr);
    }

    std::vector<double> run_undisturbed(std::uint32_t milliseconds)
    {
        std::vector<double> forces;
        tap_.be_strict();
        for (std::uint32_t i = 0; i < milliseconds; i++) {
            step();
            forces.push_back(bench_.plant().track(0).translation.motor_force());
        }
        return forces;
    }

    ChipOutcome judge(const ChipFault &fault, const std::vector<double> &undisturbed);
    rt_engine &engine() { return bench_.engine(); }

  private:
    static PlantSettings board_plant()
    {
        PlantSettings settings = campaign_plant();
        settings.force_per_count_N = 9766e-6;
        return settings;
    }

    rt_chip *chip() { return rt_engine_chip(&bench_.engine()); }

    void talk()
    {
        try {
            link_.send_input(sample_input(0));
            link_.free_run(0);
        } catch (const crn::LinkError &) { // the host's part is judged by hil_tests/campaign
        }
    }

    void step()
    {
        if (ms_ % host_every_ms == 0) talk();
        bench_.advance(1);
        ms_++;
    }

    static double ms_of(std::uint64_t instants)
    {
        return static_cast<double>(instants) / (RT_INSTANTS_PER_us * 1e3);
    }
    double since_ms() { return chip()->fault.has_begun ? ms_of(chip()->now - chip()->fault.struck_at) : -1; }
    // The age of the host's last frame when the fault came: silence counts from there.
    double frame_age_ms()
    {
        return ms_of(chip()->now - last_frame_) - ms_of(chip()->now - chip()->fault.struck_at);
    }

    // A device whose handshakes are lost still takes one frame.
    bool is_frame_taken()
    {
        if (!chip()->fault.has_begun) return true;
        return chip()->fault.kind == RT_FAULT_LOST_ACK && late_frames_++ == 0;
    }

    void strike(const ChipFault &drawn);
    void observe(const ChipFault &drawn, ChipOutcome &outcome, double undisturbed_N);
    void end(const ChipFault &drawn, ChipOutcome &outcome);
    bool has_force()
    {
        Plant &plant = bench_.plant();
        return plant.motor_peak_N() > force_none_N || plant.motor_torque_peak_N_m() > torque_none_N_m;
    }
    static void fail(ChipOutcome &outcome, const std::string &why)
    {
        if (outcome.failure[0] == '\0')
            std::strncpy(outcome.failure, why.c_str(), sizeof outcome.failure - 1);
    }

    BoardBench bench_;
    Tap tap_;
    crn::Link link_;
    std::uint32_t ms_ = 0, off_ms_ = 0, strange_ms_ = 0, late_frames_ = 0;
    std::uint64_t last_frame_ = 0;
    double was_safe_since_ms_ = -1;
    std::uint64_t felt_at_ = 0; // instant from which the time without force counts; 0: not yet
    bool has_been_off_ = false;
};

void ChipSession::strike(const ChipFault &drawn)
{
    rt_fault fault = drawn.fault;
    fault.begin += chip()->now;
    if (fault.end != RT_NEVER) fault.end += chip()->now;
    rt_fault_set(chip(), &fault);
    tap_.be_strict();
    if (drawn.is_of_motor) { // as docs/porting.md asks of the drivers
        for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
            bench_.plant().track(k).translation.set_motor_limit(force_limit_N);
            bench_.plant().track(k).rotation.set_motor_limit(torque_limit_N_m);
        }
    }
    link_.take_notices();
}

// Looks at the rig at the end of a millisecond.
void ChipSession::observe(const ChipFault &drawn, ChipOutcome &outcome, double undisturbed_N)
{
    Plant &plant = bench_.plant();
    outcome.peak_N = std::max(outcome.peak_N, plant.motor_peak_N());
    outcome.peak_N_m = std::max(outcome.peak_N_m, plant.motor_torque_peak_N_m());
    for (const crn_port_motor &motor : bench_.outputs().motors)
        outcome.asked_N =
            std::max(outcome.asked_N, plant.is_stage_on() ? std::abs(motor.axial_mN) * 1e-3 : 0);
    if (outcome.peak_N > force_limit_N * 1.000001 || outcome.peak_N_m > torque_limit_N_m * 1.000001)
        fail(outcome,
             text("the actuator gives %.3f N and %.2f mN m", outcome.peak_N, outcome.peak_N_m * 1e3));
    if (!chip()->fault.has_begun) return;
    // The plant reads the motors' inputs once a millisecond, so a wrong input acts from now on, and only now
    // can the driver report its limit; every other fault counts from its own instant.
    if (felt_at_ == 0) felt_at_ = drawn.is_of_motor ? chip()->now : chip()->fault.struck_at;
    if (has_force())
        was_safe_since_ms_ = -1;
    else if (was_safe_since_ms_ < 0)
        was_safe_since_ms_ =
            ms_of(chip()->now - felt_at_) + (drawn.must == Must::no_force ? frame_age_ms() : 0);
    const bool is_on = plant.is_stage_on();
    off_ms_ = is_on ? 0 : off_ms_ + 1;
    if (is_on && has_been_off_) fail(outcome, "the power came back without START");
    has_been_off_ = has_been_off_ || !is_on;

    const double force = plant.track(0).translation.motor_force();
    const double margin = strange_N + strange_share * std::abs(undisturbed_N);
    const bool is_strange =
        force > std::max(0.0, undisturbed_N) + margin || force < std::min(0.0, undisturbed_N) - margin;
    strange_ms_ = drawn.is_of_motor && is_on && is_strange ? strange_ms_ + 1 : 0;
    if (strange_ms_ > strange_ms)
        fail(outcome, text("a force of %.2f N in place of %.2f N lasts", force, undisturbed_N));
}

void ChipSession::end(const ChipFault &drawn, ChipOutcome &outcome)
{
    const bool is_on = bench_.plant().is_stage_on();
    const bool has_restarted = chip()->watchdogs.srsr != MASK(SRC_SRSR_IPP_RESET_B);
    std::string ending = is_on ? has_force() ? "goes on" : "no force" : "power off";
    for (const crn_wire_notice &notice : link_.take_notices()) {
        if (notice.kind != CRN_WIRE_EVENT_FAULT) continue;
        ending += std::string(" ") + crn_wire_fault_name(notice.code);
        break;
    }
    if (rt_engine_trouble(&bench_.engine())[0] != '\0') ending += ", locked up";
    if (has_restarted) ending += ", started again";
    std::strncpy(outcome.ending, ending.c_str(), sizeof outcome.ending - 1);
    outcome.safe_ms = was_safe_since_ms_;
    if (!chip()->fault.has_begun) fail(outcome, "the fault has not happened");
    if (drawn.must == Must::nothing) return;
    const double bar = bar_ms(drawn.safe_class);
    outcome.bar_ms = bar;
    if (drawn.must != Must::no_force && is_on) fail(outcome, "the power is on");
    constexpr double instruction_ms = 0.01; // a millisecond of the chip ends with its last instruction
    if (outcome.safe_ms < 0 || outcome.safe_ms > bar + instruction_ms)
        fail(outcome, text("no force after %.2f ms, allowed %.0f", outcome.safe_ms, bar));
    if (drawn.must == Must::restart && !has_restarted) fail(outcome, "the watchdog has not reset the chip");
}

ChipOutcome ChipSession::judge(const ChipFault &drawn, const std::vector<double> &undisturbed)
{
    ChipOutcome outcome;
    strike(drawn);
    const double horizon_ms = drawn.horizon_ms;
    for (std::uint32_t i = 0; since_ms() < horizon_ms && i < horizon_ms + strike_max_ms; i++) {
        if (ms_ % host_every_ms == 0 && is_frame_taken()) last_frame_ = chip()->now;
        step();
        observe(drawn, outcome, undisturbed[std::min<std::size_t>(i, undisturbed.size() - 1)]);
        if (drawn.must != Must::restart && off_ms_ > still_ms && chip()->fault.has_ended) break;
        if (drawn.must != Must::restart && off_ms_ > 2 * still_ms) break;
    }
    end(drawn, outcome);
    return outcome;
}

// --- copies of the process ---

struct Copy {
    pid_t process;
    int pipe;
};

// Begins a copy of this process that calls send(end of the pipe) and ends; send returns whether all was sent.
template <class Send> Copy begin_copy(const Send &send)
{
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe to a copy of the process");
    std::fflush(nullptr);
    const pid_t process = fork();
    if (process < 0) throw std::runtime_error("no copy of the process");
    if (process > 0) {
        close(ends[1]);
        return {process, ends[0]};
    }
    alarm(child_max_s); // a model that hangs is killed, which is a failure
    _exit(send(ends[1]) ? 0 : 1);
}

// Waits for what the copy sends. Returns false if it has ended before.
bool end_copy(const Copy &copy, void *to, std::size_t bytes)
{
    const bool is_whole = read(copy.pipe, to, bytes) == static_cast<ssize_t>(bytes);
    close(copy.pipe);
    waitpid(copy.process, nullptr, 0);
    return is_whole;
}

bool is_sent(int to, const void *from, std::size_t bytes)
{
    return write(to, from, bytes) == static_cast<ssize_t>(bytes);
}

struct Child {
    Copy copy;
    ChipFault fault;
};

Child begin_child(ChipSession &session, const ChipFault &fault, const std::vector<double> &undisturbed)
{
    const Copy copy = begin_copy([&](int to) {
        ChipOutcome outcome;
        const auto begin = std::chrono::steady_clock::now();
        try {
            outcome = session.judge(fault, undisturbed);
        } catch (const std::exception &error) {
            std::strncpy(outcome.failure, error.what(), sizeof outcome.failure - 1);
        }
        outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        return is_sent(to, &outcome, sizeof outcome);
    });
    return {copy, fault};
}

void end_child(const Child &child, const ChipFaultDone &done)
{
    ChipOutcome outcome;
    if (!end_copy(child.copy, &outcome, sizeof outcome)) {
        outcome = {};
        std::strncpy(outcome.failure, "the model ended or hung", sizeof outcome.failure - 1);
    }
    done(child.fault, outcome);
}

// The forces of the same milliseconds without a fault.
std::vector<double> undisturbed_forces(ChipSession &session)
{
    std::vector<double> forces(undisturbed_ms);
    const std::size_t bytes = forces.size() * sizeof forces[0];
    const Copy copy = begin_copy(
        [&](int to) { return is_sent(to, session.run_undisturbed(undisturbed_ms).data(), bytes); });
    if (!end_copy(copy, forces.data(), bytes))
        throw std::runtime_error("the undisturbed session ended early");
    if (std::none_of(forces.begin(), forces.end(), [](double N) { return std::abs(N) >= felt_N; }))
        throw std::runtime_error(
            "the undisturbed session feels no force: nothing would be tried; look why its "
            "motors have no power (hil_rt1062)");
    return forces;
}

} // namespace

void run_chip_faults(const std::string &image, std::vector<std::uint32_t> seeds, std::uint32_t jobs,
                     const ChipFaultDone &done)
{
    ChipSession session(image);
    rt_census census{};
    const auto touched = std::make_unique<rt_touched>();
    for (std::uint32_t i = 0; i < checkpoints; i++) {
        session.run_to(first_checkpoint_ms + i * between_ms, census, *touched);
        ChipSurvey survey = survey_of(session.engine(), *touched);
        survey.census = census;
        const std::vector<double> undisturbed = undisturbed_forces(session);
        std::vector<Child> running;
        for (const std::uint32_t seed : seeds) {
            if (seed * 2654435761u >> 16 & 1u ? i / 2 != 0 : i / 2 == 0) continue;
            if ((seed * 2246822519u >> 20 & 1u) != i % 2) continue;
            if (running.size() == std::max(1u, jobs)) {
                end_child(running.front(), done);
                running.erase(running.begin());
            }
            running.push_back(begin_child(session, draw_chip_fault(seed, survey), undisturbed));
        }
        for (const Child &child : running) end_child(child, done);
    }
}

} // namespace hil
