// This file judges sessions in FREE_RUN: a hand pushes against a wire that a seal holds, the motors have
// power, and a fault occurs.
#include "hil_tests/campaign/judge.hpp"
#include <cmath>
#include <cstring>

namespace hil
{

namespace
{

constexpr std::uint32_t host_every_ms = 8, silent_ms = 30, latched_ms = 20, lasting_ms = 8;
constexpr double hand_m_per_s = 0.1, hand_rad_per_s = 3.0, harm_N = 1.0;
constexpr double reversed_growth_N = 12 * 0.050; // the lag that is assumed, 4 ms of judging, 50 mN per ms

// Lists, for each fault of the rig, the fault codes that the device may report afterwards. A 0 in the list
// means that the device need not report anything if the fault had no effect.
struct Answer {
    const char *kind;
    std::vector<int> codes;
};
const Answer answers[] = {
    {"rig.encoder_jump", {CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION}},
    {"rig.encoder_turn_jump", {CRN_FAULT_CODE_ENCODER_JUMP_ROTATION}},
    {"rig.encoder_turn_stuck", {0}}, // it looks like a hand: the torque limit protects
    {"rig.encoder_turn_reversed", {0, CRN_FAULT_CODE_ENCODER_JUMP_ROTATION}},
    {"rig.encoder_stuck", {0, CRN_FAULT_CODE_ENCODER_STUCK}},
    {"rig.encoder_reversed", {0, CRN_FAULT_CODE_ENCODER_REVERSED, CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION}},
    {"rig.encoder_lost", {CRN_FAULT_CODE_ENCODER_LOST}},
    {"rig.force_sensor_range", {CRN_FAULT_CODE_FORCE_SENSOR_LOST}},
    {"rig.force_sensor_silent", {CRN_FAULT_CODE_FORCE_SENSOR_LOST}},
    {"rig.force_jump",
     {CRN_FAULT_CODE_FORCE_OVER, CRN_FAULT_CODE_FORCE_MISMATCH, CRN_FAULT_CODE_ACTUATOR_STUCK_ON}},
    {"rig.over_current", {CRN_FAULT_CODE_OVER_CURRENT}},
    {"rig.actuator_stuck_on",
     {CRN_FAULT_CODE_OVER_CURRENT, CRN_FAULT_CODE_FORCE_MISMATCH, CRN_FAULT_CODE_ACTUATOR_STUCK_ON}},
    {"rig.supply_lost", {CRN_FAULT_CODE_SUPPLY_LOST}},
    {"rig.emergency_stop", {CRN_FAULT_CODE_EMERGENCY_STOP}},
    {"rig.freeze", {CRN_FAULT_CODE_STAGE_LOST, CRN_FAULT_CODE_TICK_STALLED}},
};

const Answer *answer_of(const Fault &fault)
{
    for (const Answer &answer : answers) {
        if (fault.is(answer.kind)) return &answer;
    }
    return nullptr;
}

class Loop
{
  public:
    Loop(Level &level, const Fault *fault, const Undisturbed &undisturbed, Outcome &outcome)
        : fault_(fault), undisturbed_(undisturbed), outcome_(outcome),
          bench_(level.make(campaign_plant(fault != nullptr && fault->is("rig.actuator_stuck_on")))),
          pipe_(bench_->pipe()), link_(pipe_)
    {
        campaign_set_up(link_);
        start_free_run(*bench_, link_);
        Plant::Track &track = bench_->plant().track(0);
        track.translation.set_hand(Hand::spring);
        track.rotation.set_hand(Hand::spring);
        track.translation.move_hand(hand_m_per_s);
        track.rotation.move_hand(hand_rad_per_s);
        if (fault_ != nullptr) pipe_.arm(*fault_);
    }

    void run()
    {
        while (ms_ < free_ticks) {
            if (fault_ != nullptr && ms_ + 1 == fault_->at) inject();
            if (ms_ % host_every_ms == 0) talk();
            pipe_.tick();
            bench_->advance(1);
            observe();
            motor_N_.push_back(motor_N());
        }
        talk();
    }

    void judge();
    const std::vector<crn_wire_tick_state> &recorded() const { return recorded_; }
    const std::vector<double> &motor() const { return motor_N_; }

  private:
    void inject();
    void break_rig();
    void talk();
    void observe();
    void watch_silence();
    void expect_off(SafeClass which);
    void judge_recording();
    void judge_rig(const crn_wire_status &status);
    void judge_log(std::uint16_t code, bool is_there);
    void repair();
    crn_wire_status ask_status();
    void start_again();

    double motor_N() { return bench_->plant().track(0).translation.motor_force(); }
    bool is_safe()
    {
        Plant &plant = bench_->plant();
        return plant.motor_peak_N() <= force_none_N && plant.motor_torque_peak_N_m() <= torque_none_N_m;
    }
    bool is_unseen() const { return is("rig.encoder_turn_stuck") || is("rig.encoder_turn_reversed"); }
    bool is_wrong_way() const { return is("rig.encoder_stuck") || is("rig.encoder_reversed"); }
    bool is(const char *kind) const { return fault_->is(kind); }

    const Fault *fault_;
    const Undisturbed &undisturbed_;
    Outcome &outcome_;
    std::unique_ptr<Bench> bench_;
    FaultyPipe pipe_;
    crn::Link link_;
    std::uint32_t ms_ = 0, delivered_ = 0, last_frame_ms_ = 0, silence_ms_ = 0, silent_from_ms_ = 0;
    int onset_ms_ = -1;
    bool is_cut_ = false;
    std::vector<crn_wire_tick_state> recorded_;
    std::vector<double> motor_N_;
};

// --- the session ---

void Loop::talk()
{
    if (is_cut_) return;
    bool has_asked = false;
    try {
        link_.send_input(sample_input(0));
        has_asked = true;
        link_.free_run(0);
    } catch (const crn::LinkError &error) {
        outcome_.message = error.what();
        check(!outcome_.message.empty(), "an error without a message");
    }
    if (has_asked)
        for (const crn_wire_live_tick &live : link_.live_ticks()) recorded_.push_back(live.state);
    if (pipe_.delivered() != delivered_) last_frame_ms_ = ms_;
    delivered_ = pipe_.delivered();
    is_cut_ = fault_ != nullptr && is("link.cut") && pipe_.has_struck();
}

// Records the present moment as the onset of the fault; the motor's force must end within the time limit of
// the fault's class.
void Loop::expect_off(SafeClass which)
{
    if (onset_ms_ >= 0) return;
    outcome_.safe_class = which;
    onset_ms_ = static_cast<int>(ms_);
}

void Loop::observe()
{
    ms_++;
    Plant &plant = bench_->plant();
    outcome_.peak_N = std::max(outcome_.peak_N, plant.motor_peak_N());
    outcome_.peak_N_m = std::max(outcome_.peak_N_m, plant.motor_torque_peak_N_m());
    if (fault_ == nullptr) return;
    if (fault_->is_group("link.")) watch_silence();
    if (is_wrong_way()) {
        // Checks whether a motor force of 1 N lasts although no hand holds the carriage (a lasting force as
        // docs/faults.md defines it).
        const double held = plant.track(0).translation.force_on_hand();
        double least = harm_N;
        for (std::size_t i = motor_N_.size(); i > 0 && i + lasting_ms > motor_N_.size(); i--)
            least = std::min(least, std::abs(motor_N_[i - 1]) - std::abs(held));
        if (ms_ > fault_->at + lasting_ms && least >= harm_N) expect_off(SafeClass::sensors_and_forces);
    }
    if (onset_ms_ < 0) return;
    if (static_cast<int>(ms_) - onset_ms_ > CRN_PORT_DRIVE_HOLD_ms && ms_ > fault_->at && is("rig.freeze"))
        check(!plant.is_stage_on(), "the power stage holds longer than %d ms", int{CRN_PORT_DRIVE_HOLD_ms});
    if (outcome_.safe_ms >= 0) return;
    const int since = static_cast<int>(ms_) - onset_ms_;
    if (is_safe())
        outcome_.safe_ms = since;
    else
        check(since < bar_ms(outcome_.safe_class),
              "force %.3f N, torque %.2f mN m %d ms after the fault, allowed %d", plant.motor_peak_N(),
              plant.motor_torque_peak_N_m() * 1e3, since, bar_ms(outcome_.safe_class));
}

// The time for which the host has been silent is measured from the host's last frame that arrived complete.
void Loop::watch_silence()
{
    const std::uint32_t gap = ms_ - last_frame_ms_;
    silence_ms_ = std::max(silence_ms_, gap);
    if (gap < silent_ms) return;
    if (gap == silent_ms && silent_from_ms_ == 0) silent_from_ms_ = ms_;
    const int bar = bar_ms(SafeClass::host_silence);
    outcome_.safe_class = SafeClass::host_silence;
    check(is_safe() || static_cast<int>(gap) < bar, "%.3f N %u ms after the last frame, allowed %d",
          bench_->plant().motor_peak_N(), unsigned{gap}, bar);
    if (is_safe() && outcome_.safe_ms < 0) outcome_.safe_ms = static_cast<int>(gap);
}

// --- faults ---

void Loop::inject()
{

    if (fault_->is_group("link.") || fault_->is_group("device.")) return; // the pipe applies the fault
    if (fault_->is_group("host.")) {
        const bool stops =
            is("host.wrong_schema") || (is("host.second") && (fault_->value == 3 || fault_->value == 4));
        strange_host(*fault_, bench_->pipe());
        if (stops) expect_off(SafeClass::command);
        return;
    }
    if (!is_wrong_way() && !is_unseen()) {
        const bool is_supply = is("rig.brown_out") || is("rig.supply_lost");
        expect_off(is("rig.freeze") ? SafeClass::processor
                   : is_supply      ? SafeClass::supply
                                    : SafeClass::sensors_and_forces);
    }
    break_rig();
}

void Loop::break_rig()
{
    Plant &plant = bench_->plant();
    Plant::Track &track = plant.track(0);
    Encoder &along = track.translation_encoder, &about = track.rotation_encoder;
    const auto stand_still = [&](std::uint32_t count) {
        for (std::uint32_t i = 0; i < count; i++) {
            bench_->freeze(1);
            observe();
        }
    };
    if (is("rig.encoder_jump")) along.set_fault(SensorFault::jump, fault_->value);
    if (is("rig.encoder_turn_jump")) about.set_fault(SensorFault::jump, fault_->value);
    if (is("rig.encoder_stuck")) along.set_fault(SensorFault::stuck);
    if (is("rig.encoder_reversed")) along.set_fault(SensorFault::reversed);
    if (is_wrong_way() && fault_->value == 0) track.translation.set_hand(Hand::none);
    if (is("rig.encoder_turn_stuck")) about.set_fault(SensorFault::stuck);
    if (is("rig.encoder_turn_reversed")) about.set_fault(SensorFault::reversed);
    if (is_unseen() && fault_->value == 0) track.rotation.set_hand(Hand::none);
    if (is("rig.encoder_lost")) (fault_->value == 0 ? along : about).set_fault(SensorFault::silent);
    if (is("rig.force_sensor_range")) track.force_fault = SensorFault::range;
    if (is("rig.force_sensor_silent")) track.force_fault = SensorFault::silent;
    if (is("rig.force_jump")) {
        track.force_fault = SensorFault::jump;
        track.force_jump_N = fault_->value * 1e-3;
    }
    if (is("rig.over_current")) track.is_over_current = true;
    if (is("rig.actuator_stuck_on"))
        (fault_->value == 0 ? track.translation : track.rotation).set_motor_fault(MotorFault::stuck_on);
    if (is("rig.emergency_stop")) plant.emergency_stop = true;
    if (is("rig.supply_lost") || is("rig.brown_out")) plant.supply_good = false;
    if (is("rig.freeze") || is("rig.brown_out")) stand_still(fault_->value);
    if (is("rig.brown_out")) bench_->brown_out(1);
}

void Loop::repair()
{
    Plant &plant = bench_->plant();
    Plant::Track &track = plant.track(0);
    for (Axis *axis : {&track.translation, &track.rotation}) {
        axis->set_motor_fault(MotorFault::none);
        axis->move_hand(0.0);
    }
    track.translation_encoder.set_fault(SensorFault::none);
    track.rotation_encoder.set_fault(SensorFault::none);
    track.force_fault = SensorFault::none;
    track.is_over_current = plant.emergency_stop = false;
    plant.supply_good = true;
    pipe_.plug();
    bench_->advance(2);
}

// --- the verdict ---

void Loop::judge_recording()
{
    std::size_t strange = 0;
    const bool may_miss = (fault_->is_group("link.") || fault_->is_group("device.")) && fault_->to_host;
    const bool is_rig = fault_->is_group("rig.");
    const std::size_t same_until = is_rig                     ? fault_->at - 1
                                   : silence_ms_ >= silent_ms ? silent_from_ms_ - 1
                                                              : free_ticks;
    std::uint32_t last = 0;
    for (const crn_wire_tick_state &state : recorded_) {
        const bool is_sane = state.tick >= 1 && state.tick <= free_ticks;
        const bool is_known =
            is_sane && (state.tick > same_until || same_state(state, undisturbed_.free_run[state.tick - 1]));
        strange += !is_known;
        check(may_miss || state.tick == last + 1, "the recording has no tick %u", unsigned{last + 1});
        check(!is_sane || !is_known || state.tick > last, "tick %u came twice", unsigned{state.tick});
        if (is_known) last = state.tick;
    }
    const std::size_t lied = fault_->is("device.lies") ? 16 : 0;
    check(strange <= lied, "%zu ticks differ from the undisturbed session", strange);
    if (may_miss && !fault_->is("device.lies") && recorded_.size() < last)
        check(link_.ticks_missing() >= last - recorded_.size(),
              "%zu ticks are missing, and the host knows of %u", last - recorded_.size(),
              unsigned{link_.ticks_missing()});
}

crn_wire_status Loop::ask_status()
{
    for (int attempt = 0;; attempt++) {
        try {
            return link_.read_status();
        } catch (const crn::LinkError &error) {
            outcome_.message = error.what();
            if (attempt == 3) throw;
            if (error.reject.code == CRN_REJECT_NOT_GREETED || attempt > 0) link_.hello();
        }
    }
}

void Loop::judge_log(std::uint16_t code, bool is_there)
{
    const crn_wire_fault_log log = link_.read_fault_log();
    bool is_found = false;
    for (std::uint16_t i = 0; i < log.entries_count; i++) is_found = is_found || log.entries[i].code == code;
    check(is_found == is_there, "%s is %s the fault log", crn_wire_fault_name(code),
          is_found ? "in" : "not in");
}

void Loop::judge_rig(const crn_wire_status &status)
{
    if (is("rig.brown_out")) {
        check(status.state == CRN_WIRE_STATE_READY, "%s after a brown-out",
              crn_wire_state_name(status.state));
        outcome_.ending = "started again";
        return;
    }
    const Answer *answer = answer_of(*fault_);
    check(answer != nullptr, "nobody says what the device must do");
    bool is_expected = false;
    for (int code : answer->codes) is_expected = is_expected || code == status.fault_code;
    check(is_expected, "%s, cause %s", crn_wire_state_name(status.state),
          crn_wire_fault_name(status.fault_code));
    if (status.fault_code == 0) {
        outcome_.ending = "goes on";
        return;
    }
    check(status.state == CRN_WIRE_STATE_FAULT, "%s, not FAULT", crn_wire_state_name(status.state));
    judge_log(status.fault_code, true);
    outcome_.ending = std::string("FAULT ") + crn_wire_fault_name(status.fault_code);
    check(recorded_.size() == status.tick, "%zu ticks recorded of %u up to the fault", recorded_.size(),
          unsigned{status.tick});
    for (std::uint32_t i = 0; i < latched_ms; i++) {
        bench_->advance(1);
        check(!bench_->plant().is_stage_on(), "power came back %u ms later", unsigned{i});
    }
}

void Loop::judge()
{
    check(outcome_.peak_N <= force_limit_N && outcome_.peak_N_m <= torque_limit_N_m,
          "the actuator gave %.3f N and %.2f mN m, limits %.3f and %.2f", outcome_.peak_N,
          outcome_.peak_N_m * 1e3, force_limit_N, torque_limit_N_m * 1e3);
    if (is("rig.encoder_reversed") && fault_->value == 0) {
        // No hand holds the carriage. The allowed force is the larger of two forces: the motor force before
        // the fault, and the force that moves the carriage. The allowed force may also grow at the slew limit
        // during the 12 ms until the device detects the fault.
        const double there_N = std::max(harm_N, std::abs(undisturbed_.motor_N[fault_->at - 1]));
        check(outcome_.peak_N <= there_N + reversed_growth_N, "the reversed track rose to %.3f N from %.3f N",
              outcome_.peak_N, there_N);
    }
    judge_recording();
    pipe_.plug();
    const crn_wire_status status = ask_status();
    const bool is_off = is("host.wrong_schema") || (is("host.second") && fault_->value == 3);
    if (fault_->is_group("rig.")) {
        judge_rig(status);
    } else if (is_off || (is("host.second") && fault_->value == 4)) {
        const std::uint8_t state = is_off ? CRN_WIRE_STATE_ARMED : CRN_WIRE_STATE_READY;
        check(status.state == state && !bench_->plant().is_stage_on(), "%s after the other host",
              crn_wire_state_name(status.state));
        outcome_.ending = "stopped";
    } else {
        check(status.state == CRN_WIRE_STATE_RUNNING, "%s, not RUNNING", crn_wire_state_name(status.state));
        judge_log(CRN_FAULT_CODE_HOST_SILENT, silence_ms_ >= silent_ms);
        outcome_.ending = silence_ms_ < silent_ms ? "goes on" : is_cut_ ? "resumed" : "faded, goes on";
    }
    start_again();
}

// After RESET and repair of the fault, the next session must run as if no fault had happened.
void Loop::start_again()
{
    repair();
    Ending ending;
    for (int attempt = 0; ending.states.empty(); attempt++) {
        try {
            crn::Link again(pipe_);
            campaign_set_up(again);
            ending = lockstep_session(again, 4, 2);
        } catch (const crn::LinkError &error) {
            outcome_.message = error.what();
            check(attempt < 3, "no new session: %s", error.what());
        }
    }
    for (const crn_wire_tick_state &state : ending.states)
        check(same_state(state, undisturbed_.lockstep[state.tick - 1]),
              "tick %u of a new session has another hash", unsigned{state.tick});
}

} // namespace

void free_run_undisturbed(Level &level, Undisturbed &undisturbed)
{
    Outcome outcome;
    Loop loop(level, nullptr, undisturbed, outcome);
    loop.run();
    undisturbed.free_run = loop.recorded();
    undisturbed.motor_N = loop.motor();
}

void run_free(Level &level, const Fault &fault, const Undisturbed &undisturbed, Outcome &outcome)
{
    Loop loop(level, &fault, undisturbed, outcome);
    loop.run();
    loop.judge();
}

} // namespace hil
