// These cases test the pedals. Every case checks that a press of a pedal at the rig reaches the host's X-ray
// room in the same tick and starts fluoroscopy, a roadmap or a cine run. The pictures in these cases are
// blank; host/xray/tests has the tests of real X-ray pictures.
#include "hil_tests/cases/conversation.hpp"
#include "host/rig/pedals.hpp"
#include "host/room/room_screen.hpp"

namespace hil
{

namespace
{

constexpr int picture_size = 16;
constexpr std::uint32_t message_every_ms = 4;

crn::XrayPicture blank_picture(std::uint32_t tick)
{
    crn::XrayPicture picture;
    picture.size = picture_size;
    picture.tick = tick;
    picture.grey.assign(picture_size * picture_size, 128);
    picture.raw.assign(picture_size * picture_size, 1024);
    return picture;
}

// Holds the times at which a pedal was pressed and released, on the clock of the simulated rig, and the ticks
// in which the X-ray room received these events.
struct Press {
    std::uint64_t down_ms = 0, up_ms = 0;
    std::uint32_t down_tick = 0, up_tick = 0, pulses = 0;
};

// Runs a session in which the rig sets the pace. The session has an X-ray room that obeys the rig's pedals,
// as in run_free.cpp.
class Suite
{
  public:
    explicit Suite(Level &level) : bench_(level.make({})), link_(bench_->pipe())
    {
        set_up(link_);
        start_free_run(*bench_, link_);
        last_ = link_.tick();
    }

    crn::Room &room() { return room_; }
    const crn::RoomScreen &screen() const { return screen_; }
    std::uint32_t tick() const { return last_; }

    void go(std::uint32_t milliseconds)
    {
        const std::uint64_t end = bench_->plant().milliseconds() + milliseconds;
        while (bench_->plant().milliseconds() < end) {
            link_.send_input(sample_input(0));
            link_.free_run(std::min<std::uint32_t>(
                message_every_ms, static_cast<std::uint32_t>(end - bench_->plant().milliseconds())));
            for (const crn_wire_live_tick &tick : link_.live_ticks()) take(tick);
        }
    }

    Press press(std::uint32_t button, std::uint32_t milliseconds)
    {
        press_ = {};
        press_.down_ms = bench_->plant().milliseconds();
        bench_->plant().buttons |= button;
        go(milliseconds);
        press_.up_ms = bench_->plant().milliseconds();
        bench_->plant().buttons &= ~button;
        go(20);
        return press_;
    }

  private:
    void take(const crn_wire_live_tick &live)
    {
        const std::uint32_t tick = live.state.tick;
        check(tick == last_ + 1, "tick %u came after tick %u", unsigned{tick}, unsigned{last_});
        last_ = tick;
        room_.advance(tick, nullptr);
        if (room_.is_pulse_due()) {
            press_.pulses++;
            room_.expose({{}, false, 1.0, 0.0});
        }
        const crn::XrayPicture picture = blank_picture(tick);
        for (const crn::RoomEvent &event : room_.events())
            screen_.take(event, event.kind == crn::RoomEvent::Kind::pulse ? &picture : nullptr);
        room_.forget_events();
        for (const crn::RoomCommand &command : pedals_.changes(live.input.buttons)) {
            (command.values[0] ? press_.down_tick : press_.up_tick) = tick;
            const std::string why = room_.give(tick + 1, command);
            check(why.empty(), "the room refuses a pedal: %s", why.c_str());
        }
    }

    std::unique_ptr<Bench> bench_;
    crn::Link link_;
    crn::Room room_;
    crn::RoomScreen screen_{room_};
    crn::RigPedals pedals_;
    Press press_;
    std::uint32_t last_ = 0;
};

void check_press(const Press &press, const char *what, std::uint32_t pulses_per_s)
{
    const std::uint64_t asked = press.up_ms - press.down_ms, heard = press.up_tick - press.down_tick;
    check(press.down_tick > 0 && heard == asked, "%s: the pedal was down for %llu ms, the room heard of %llu",
          what, static_cast<unsigned long long>(asked), static_cast<unsigned long long>(heard));
    // The k-th X-ray pulse of a press (k = 0, 1, ...) begins ceil(1000 k / pulses per second) ms after the
    // press (docs/room.md).
    const auto pulses = static_cast<std::uint32_t>((asked * pulses_per_s + 999) / 1000);
    check(press.pulses == pulses, "%s: %u pulses in %llu ms, %u expected", what, unsigned{press.pulses},
          static_cast<unsigned long long>(asked), unsigned{pulses});
}

void pedals_make_fluoroscopy_a_roadmap_and_a_cine_run(Level &level, const CaseOptions &, Report &report)
{
    Suite suite(level);
    suite.go(4);
    const Press fluoro = suite.press(CRN_WIRE_BUTTON_XRAY, 80);
    check_press(fluoro, "fluoroscopy", 15);
    check(!suite.room().is_beam_on(), "the beam stays on after the pedal");

    check(suite.room().give(suite.tick() + 1, {crn::RoomAction::roadmap, {2, 0, 0}}).empty(),
          "no new roadmap");
    check_press(suite.press(CRN_WIRE_BUTTON_XRAY, 72), "roadmap", 15);
    check(suite.screen().status().roadmap == crn::RoadmapState::shown, "the press made no roadmap");

    const Press cine = suite.press(CRN_WIRE_BUTTON_CINE, 80);
    check_press(cine, "cine", 15);
    check(suite.screen().status().runs_kept == 1, "%d runs are kept, not the cine run alone",
          suite.screen().status().runs_kept);
    check(fluoro.down_tick - fluoro.down_ms == cine.down_tick - cine.down_ms,
          "the pedals come with different delays");
    const auto presses = suite.room().dose().irradiations().size();
    check(presses == 3, "%zu presses made X-rays, not 3", presses);
    report.add(text("fluoroscopy %u, cine %u pulses, each at its millisecond", unsigned{fluoro.pulses},
                    unsigned{cine.pulses}));
}

constexpr Case pedal_list[] = {
    {"pedals_make_fluoroscopy_a_roadmap_and_a_cine_run", pedals_make_fluoroscopy_a_roadmap_and_a_cine_run},
};

} // namespace

std::span<const Case> pedal_cases()
{
    return pedal_list;
}

} // namespace hil
