// In these test cases the cable is pulled in the middle of a transfer. A device on USB disconnects itself
// from the bus during one packet of the transfer (docs/usb.md). With any other kind of pipe, the test closes
// the pipe in the middle of a frame. All bytes that have been sent but not yet received when the cable is
// pulled are lost, in both directions.
#include "hil_tests/cases/conversation.hpp"
#include <algorithm>
#include <optional>

namespace hil
{

namespace
{

constexpr std::uint32_t away_ms = 60, batch = 64, pulls_per_session = 2;
constexpr int attempts_max = 6;
// A device in an emulator beside other work may need long for a scene; a pulled cable is told, not waited
// for.
constexpr crn::Patience::Span patience{60000};

// Simulates a cable for test benches that have no real cable.
class Cable final : public crn::Transport
{
  public:
    explicit Cable(Bench &bench) : bench_(bench) {}

    void pull(std::uint32_t bytes)
    {
        if (!bench_.pull_cable(bytes, away_ms)) left_ = bytes;
    }

    // Plugs the cable in again after the device has been unplugged for `away_ms`. After the cable is plugged
    // in, the host can reach the same device or a device that replaces it.
    void plug()
    {
        bench_.advance(away_ms + 1);
        is_out_ = false;
        left_.reset();
        std::uint8_t lost[4096];
        try {
            while (bench_.pipe().read(lost) > 0) {
            }
        } catch (const crn::LinkError &) { // it reports once that the device was away
        }
    }

    void write(std::span<const std::uint8_t> bytes) override
    {
        if (is_out_) gone();
        if (!left_ || *left_ >= bytes.size()) {
            bench_.pipe().write(bytes);
            if (left_) *left_ -= static_cast<std::uint32_t>(bytes.size());
            return;
        }
        bench_.pipe().write(bytes.first(*left_));
        is_out_ = true;
        gone();
    }

    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        if (is_out_) gone();
        return bench_.pipe().read(bytes);
    }

    void pass_time_ms(std::uint32_t milliseconds) override { bench_.pipe().pass_time_ms(milliseconds); }

  private:
    [[noreturn]] static void gone()
    {
        throw crn::LinkError("the device is gone: its cable was pulled. Remedy: plug it in");
    }

    Bench &bench_;
    std::optional<std::uint32_t> left_;
    bool is_out_ = false;
};

// Simulates a host whose cable is pulled once during the upload of the scene and once during the session. The
// host continues after both interruptions.
class Traveller
{
  public:
    Traveller(Bench &bench, std::uint32_t upload_bytes, std::uint32_t session_bytes)
        : cable_(bench), bytes_{upload_bytes, session_bytes}
    {
    }

    Ending travel(std::uint32_t ticks)
    {
        for (int attempt = 0; attempt < attempts_max; attempt++) {
            try {
                link_.emplace(cable_, patience);
                link_->hello();
                if (!goes_on()) begin();
                return finish(ticks);
            } catch (const crn::LinkError &error) {
                check(*error.what() != '\0', "an error without a message");
                lost_++;
                cable_.plug();
            }
        }
        throw Failure("no end after " + std::to_string(attempts_max) + " attempts");
    }

    std::uint32_t lost() const { return lost_; }
    std::uint32_t resumed() const { return resumed_; }

  private:
    void pull(std::uint32_t which)
    {
        if (pulled_ != which) return;
        pulled_++;
        cable_.pull(bytes_[which]);
    }

    // Returns true if the device has executed the host's last request, and if the device's tick is the last
    // tick that the host has received; the session can then continue.
    bool goes_on()
    {
        const crn_wire_status status = link_->read_status();
        const bool is_built = status.state == CRN_WIRE_STATE_RUNNING || status.state == CRN_WIRE_STATE_ARMED;
        if (!is_built || status.tick != ending_.states.size()) {
            if (status.state != CRN_WIRE_STATE_READY) link_->reset();
            return false;
        }
        if (status.state == CRN_WIRE_STATE_RUNNING) link_->stop();
        link_->start();
        resumed_++;
        return true;
    }

    void begin()
    {
        pull(0);
        set_up(*link_);
        link_->use_lockstep();
        link_->arm();
        link_->start();
        ending_ = {};
    }

    Ending finish(std::uint32_t ticks)
    {
        std::vector<crn_wire_tick_input> inputs;
        while (link_->tick() < ticks) {
            if (link_->tick() >= ticks / 2) pull(1);
            inputs.clear();
            for (std::uint32_t i = 0; i < batch && link_->tick() + i < ticks; i++)
                inputs.push_back(sample_input(link_->tick() + i));
            const auto states = link_->step(inputs, false);
            ending_.states.insert(ending_.states.end(), states.begin(), states.end());
        }
        ending_.tick = link_->tick();
        ending_.hash = link_->read_hash64().hash;
        return ending_;
    }

    Cable cable_;
    std::uint32_t bytes_[pulls_per_session], pulled_ = 0, lost_ = 0, resumed_ = 0;
    std::optional<crn::Link> link_;
    Ending ending_;
};

void a_cable_pulled_in_mid_transfer_costs_no_bit(Level &level, const CaseOptions &options, Report &report)
{
    const std::uint32_t ticks =
        std::max<std::uint32_t>(4 * batch, std::min<std::uint32_t>(options.ticks, 400));
    const Ending alone = host_only_session(ticks, batch);
    std::uint32_t pulls = 0, resumed = 0;
    // The test pulls the cable in the middle of a frame of the upload, in the middle of a frame of the
    // session, and between two frames.
    static constexpr std::uint32_t places[][2] = {{9000, 1}, {700, 700}, {30000, 1300}};
    for (std::size_t i = 0; i < std::size(places); i += options.spread) {
        const auto bench = level.make({});
        Traveller traveller(*bench, places[i][0], places[i][1]);
        check_same(alone, traveller.travel(ticks), "undisturbed and with the cable pulled");
        check(traveller.lost() == pulls_per_session, "the host lost the device %u times, not %u",
              unsigned{traveller.lost()}, unsigned{pulls_per_session});
        pulls += traveller.lost();
        resumed += traveller.resumed();
    }
    report.add(text("%u pulls, %u sessions resumed, %u played again", unsigned{pulls}, unsigned{resumed},
                    unsigned{pulls - resumed}));
}

// The motor forces must be zero 50 ms after the host's last byte. The device continues the session without a
// host; when the host returns, the motor forces return.
void a_cable_pulled_under_power_fades_the_forces(Level &level, const CaseOptions &, Report &report)
{
    constexpr std::uint32_t push_ms = 200, silent_ms = 50;
    constexpr double none_N = 0.02;
    const auto bench = level.make({});
    Cable cable(*bench);
    std::optional<crn::Link> link(cable);
    set_up(*link);
    start_free_run(*bench, *link);
    push_by_spring_hand(bench->plant());
    keep_running(*link, push_ms);
    const double before_N = bench->plant().motor_peak_N();
    cable.pull(3);
    std::uint32_t ms = 0;
    try {
        for (; ms < silent_ms; ms++) {
            if (ms % 8 == 0) keep_talking(*link);
            bench->advance(1);
        }
    } catch (const crn::LinkError &) {
        bench->advance(silent_ms - ms);
        ms = UINT32_MAX;
    }
    check(ms == UINT32_MAX, "nothing told the host that the cable is out");
    const double left_N = bench->plant().motor_peak_N();
    check(before_N > 0.05 && left_N <= none_N,
          "%.3f N before, %.3f N %u ms after the cable was pulled, allowed %.2f", before_N, left_N,
          unsigned{silent_ms}, none_N);
    cable.plug();
    link.emplace(cable);
    link->hello();
    const crn_wire_status status = link->read_status();
    check(status.state == CRN_WIRE_STATE_RUNNING, "the session ended by itself: %s",
          crn_wire_state_name(status.state));
    double back_N = 0.0;
    for (std::uint32_t i = 0; i < push_ms; i += 8) {
        keep_running(*link, 8);
        back_N = std::max(back_N, bench->plant().motor_peak_N());
    }
    check(back_N > none_N, "no force comes back with the host: %.3f N", back_N);
    report.add(text("%.2f N before, %.3f N after %u ms, %.2f N with the host back", before_N, left_N,
                    unsigned{silent_ms}, back_N));
}

constexpr Case unplug_list[] = {
    {"a_cable_pulled_in_mid_transfer_costs_no_bit", a_cable_pulled_in_mid_transfer_costs_no_bit},
    {"a_cable_pulled_under_power_fades_the_forces", a_cable_pulled_under_power_fades_the_forces},
};

} // namespace

std::span<const Case> unplug_cases()
{
    return unplug_list;
}

} // namespace hil
