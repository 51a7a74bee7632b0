// Judges sessions in which the device sends frames only as answers: set-ups and LOCKSTEP sessions. A
// disturbed LOCKSTEP session must end with the same state hash as an undisturbed session.
#include "hil_tests/campaign/judge.hpp"

namespace hil
{

namespace
{

constexpr int attempts_max = 6;

// A host that records. After an error, the host in this test sends HELLO again, and continues at the tick
// that the device has reached.
class Host
{
  public:
    Host(Level &level, const Fault &fault, const Undisturbed &undisturbed)
        : fault_(fault), undisturbed_(undisturbed), bench_(level.make(campaign_plant())),
          pipe_(bench_->pipe())
    {
    }

    void run(Outcome &outcome)
    {
        if (fault_.session == Session::setup) pipe_.arm(fault_);
        int attempts = 0, resumed = 0, replayed = 0;
        for (bool is_done = false; !is_done; attempts++) {
            check(attempts < attempts_max, "no end after %d attempts, the last: %s", attempts,
                  outcome.message.c_str());
            try {
                (has_begun_ && goes_on() ? resumed : replayed)++;
                finish();
                is_done = true;
            } catch (const crn::LinkError &error) {
                outcome.message = error.what();
                check(!outcome.message.empty(), "an error without a message");
                pipe_.plug();
            }
        }
        if (fault_.is_group("host."))
            check(has_met_, "the other host did not come");
        else
            check(pipe_.has_struck(), "the frame did not come: %u frames only",
                  unsigned{pipe_.frames_written()});
        outcome.ending = attempts == 1 ? "goes on" : resumed > 0 ? "resumed" : "replayed";
        check_motors();
    }

  private:
    // Returns true if the device still runs this session, and if the device's last tick is also the last tick
    // in the recording.
    bool goes_on()
    {
        link_.emplace(pipe_);
        link_->hello();
        const crn_wire_status status = link_->read_status();
        const bool is_built = status.state == CRN_WIRE_STATE_RUNNING || status.state == CRN_WIRE_STATE_ARMED;
        if (is_built && status.mode == CRN_WIRE_MODE_LOCKSTEP && status.tick == recorded_.size()) {
            if (status.state == CRN_WIRE_STATE_RUNNING) link_->stop();
            link_->start();
            return true;
        }
        begin();
        return false;
    }

    void begin()
    {
        link_.emplace(pipe_);
        campaign_set_up(*link_);
        link_->use_lockstep();
        link_->arm();
        link_->start();
    }

    void meet(std::uint32_t tick)
    {
        if (has_met_ || !fault_.is_group("host.") || tick != fault_.at - 1) return;
        has_met_ = true;
        strange_host(fault_, bench_->pipe());
    }

    void finish()
    {
        if (!has_begun_) {
            begin();
            has_begun_ = true;
            if (fault_.session == Session::lockstep) pipe_.arm(fault_);
        }
        while (link_->tick() < lockstep_ticks) {
            const std::uint32_t tick = link_->tick();
            const crn_wire_tick_input input = sample_input(tick);
            meet(tick);
            const crn_wire_tick_state state = link_->step({&input, 1}, false).front();
            check(state.tick == tick + 1, "tick %u came as %u", unsigned{tick + 1}, unsigned{state.tick});
            take(state);
        }
        const crn::Hash64 hash = link_->read_hash64();
        const bool is_same = hash.hash == undisturbed_.lockstep_hash && hash.tick == lockstep_ticks;
        if (!is_same && fault_.is("device.lies") && !has_asked_again_) {
            has_asked_again_ = true; // the lie may be about this very answer
            throw crn::LinkError("another hash than the recording's");
        }
        check(is_same, "final hash %016llx at tick %u, undisturbed %016llx",
              static_cast<unsigned long long>(hash.hash), unsigned{hash.tick},
              static_cast<unsigned long long>(undisturbed_.lockstep_hash));
    }

    // The recording must equal that of the undisturbed session, except for the content of the one frame that
    // the fault falsified.
    void take(const crn_wire_tick_state &state)
    {
        const std::size_t i = state.tick - 1;
        if (i < recorded_.size()) return;
        check(i == recorded_.size(), "the recording has a gap before tick %u", unsigned{state.tick});
        recorded_.push_back(state);
        if (same_state(state, undisturbed_.lockstep[i])) return;
        lied_ticks_++;
        check(fault_.is("device.lies") && lied_ticks_ == 1, "tick %u has another hash", unsigned{state.tick});
    }

    // In LOCKSTEP sessions the motors never have power.
    void check_motors()
    {
        bench_->advance(5);
        check(!bench_->plant().is_stage_on() && bench_->plant().motor_peak_N() == 0.0,
              "a motor has power in LOCKSTEP");
    }

    const Fault &fault_;
    const Undisturbed &undisturbed_;
    std::unique_ptr<Bench> bench_;
    FaultyPipe pipe_;
    std::optional<crn::Link> link_;
    std::vector<crn_wire_tick_state> recorded_;
    bool has_begun_ = false, has_met_ = false, has_asked_again_ = false;
    int lied_ticks_ = 0;
};

} // namespace

void run_asked(Level &level, const Fault &fault, const Undisturbed &undisturbed, Outcome &outcome)
{
    Host(level, fault, undisturbed).run(outcome);
}

} // namespace hil
