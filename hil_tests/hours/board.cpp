#include "hil_tests/hours/board.hpp"
#include "host/base/format.hpp"
#include "host/link/link.hpp"
#include <cmath>
#include <new>
#include <stdexcept>

namespace hours
{

namespace
{

constexpr int polls_per_frame = 2;                     // bInterval 3 at high speed: every 500 us
constexpr std::int64_t packet_ps = 10 * ps_per_us;     // a packet of 512 bytes at high speed
constexpr std::int64_t retry_ps = 125 * ps_per_us;     // a microframe
constexpr int retries_max = 40000, waits_max = 100000; // 5 s; polls of the device
constexpr std::uint32_t rest_us = 20;                  // an edge without a tick

// The distribution is that of the aorta session on the emulated board at 600 instructions per us
// (docs/hil.md).
constexpr std::uint32_t tick_us_min = 420, tick_us_range = 160, slow_every = 1000, slow_us_min = 600,
                        slow_us_range = 330, late_us_min = 1100, late_us_range = 800, edge_us = 1000;

} // namespace

Board::Board(const BoardSettings &settings)
    : Station(settings.seed), settings_(settings), random_(settings.seed * 3 + 1), frames_(settings.seed),
      mailbox_(BusHost::mailbox_bytes)
{
    const hours_hardware around = hardware();
    device_.reset(hours_device_create(&around, mailbox_.data()));
    if (!device_) throw std::bad_alloc();
    bus_ = std::make_unique<BusHost>(
        mailbox_.data(), [this] { return hours_device_poll(device_.get()), ++waits_ < waits_max; },
        [this] { waits_ = 0; });
    begin_life();
}

Board::~Board() = default;

// --- the hardware ---

hours_hardware Board::hardware()
{
    hours_hardware around{};
    around.context = this;
    around.pass = [](void *context, std::uint32_t us) {
        static_cast<Board *>(context)->pass_ps(us * ps_per_us);
    };
    around.now_us = [](void *context) { return static_cast<Board *>(context)->now_us(); };
    around.frame = [](void *context) {
        Board &board = *static_cast<Board *>(context);
        Look &look = board.look_;
        if (!look.is_there) look.frames_begin = board.frames_seen_;
        look.is_there = true;
        look.ps = board.now_ps_;
        look.frames = board.frames_seen_;
        look.edges = board.edges_given_;
        return static_cast<std::uint32_t>(board.frames_seen_ % frame_numbers);
    };
    around.work_us = [](void *context, bool is_ticking) {
        return static_cast<Board *>(context)->draw_work_us(is_ticking);
    };
    around.sample = [](void *context, crn_port_inputs *inputs) {
        *inputs = static_cast<Board *>(context)->plant_.inputs();
    };
    around.drive = [](void *context, const crn_port_outputs *outputs) {
        static_cast<Board *>(context)->outputs_ = *outputs;
    };
    return around;
}

std::uint32_t Board::now_us() const
{
    return static_cast<std::uint32_t>(settings_.begin_ms * 1000 +
                                      static_cast<std::uint64_t>(now_ps_ / ps_per_us));
}

// The work of a late tick is counted here, independently of the device: what a millisecond cannot hold is
// left for the next one.
std::uint32_t Board::draw_work_us(bool is_ticking)
{
    if (!is_ticking) {
        backlog_us_ = 0;
        return rest_us;
    }
    ledger_.ticks++;
    std::uint32_t us = tick_us_min + random_.below(tick_us_range);
    if (random_.below(slow_every) == 0) us = slow_us_min + random_.below(slow_us_range);
    if (settings_.late_every > 0 && random_.below(settings_.late_every) == 0)
        us = late_us_min + random_.below(late_us_range);
    const std::uint32_t spent = backlog_us_ + us;
    backlog_us_ = spent > edge_us ? spent - edge_us : 0;
    overruns_given_ += backlog_us_ > 0;
    return us;
}

void Board::make_edge()
{
    edge_ps_ += ps_per_ms;
    edges_made_++;
    plant_.step(outputs_);
    if (!has_power_) return;
    edges_given_++;
    hours_device_edge(device_.get());
}

void Board::make_frame()
{
    frames_.begin_next();
    if (!bus_ || !bus_->is_plugged()) return;
    frames_seen_ = frames_.count();
    ledger_.frames++;
    polls_due_ = polls_per_frame;
}

void Board::pass_ps(std::int64_t ps)
{
    const std::int64_t end_ps = now_ps_ + ps;
    for (;;) {
        const std::int64_t next_ps = std::min(edge_ps_, frames_.next_ps());
        if (next_ps > end_ps) break;
        now_ps_ = next_ps;
        if (edge_ps_ == next_ps)
            make_edge();
        else
            make_frame();
    }
    now_ps_ = end_ps;
}

// --- the processor, and the host's controller ---

void Board::poll_bus()
{
    if (!bus_->is_plugged() || polls_due_ == 0) return;
    for (; polls_due_ > 0; polls_due_--) {
        if (!bus_->poll_report()) continue;
        reports_++;
        ledger_.reports++;
    }
    while (bus_->poll_stream()) {
    }
}

void Board::run_until(std::int64_t ps)
{
    while (now_ps_ < ps) {
        const bool has_more = hours_device_round(device_.get());
        poll_bus();
        if (has_more || hours_device_edges_due(device_.get()) > 0) continue;
        const std::int64_t next_ps = std::min({edge_ps_, frames_.next_ps(), ps});
        if (next_ps > now_ps_) pass_ps(next_ps - now_ps_);
    }
    finish_edges();
}

void Board::finish_edges()
{
    while (hours_device_edges_due(device_.get()) > 0) {
        hours_device_round(device_.get());
        poll_bus();
    }
}

void Board::pass_ms(std::uint32_t milliseconds)
{
    if (milliseconds > 0) run_until(edge_ps_ + (milliseconds - 1) * ps_per_ms);
}

void Board::stall(std::uint32_t milliseconds)
{
    pass_ps(milliseconds * ps_per_ms);
    finish_edges();
}

// --- the cable and the power ---

void Board::plug()
{
    bus_->plug();
    reports_ = 0;
    plugged_ = hours_device_read(device_.get());
}

void Board::pull_cable(std::uint32_t milliseconds)
{
    const hours_counts counts = hours_device_read(device_.get());
    check_reports(counts);
    ledger_.reports_dropped += counts.reports_waiting; // they wait for a host that is gone
    bus_->unplug();
    run_until(now_ps_ + milliseconds * ps_per_ms);
    plug();
}

void Board::begin_life()
{
    has_power_ = true;
    edges_begin_ = edges_made_;
    edges_given_ = overruns_given_ = 0;
    look_ = {};
    plug();
}

void Board::end_life()
{
    look();
    before_ = ledger_;
    before_.reports_dropped += hours_device_read(device_.get()).reports_waiting;
    ledger_.reports_dropped = before_.reports_dropped;
    bus_->unplug();
    has_power_ = false;
    outputs_ = {};
}

void Board::restart(std::uint32_t milliseconds)
{
    end_life();
    pass_ps(milliseconds * ps_per_ms);
    hours_device_power_up(device_.get());
    ledger_.restarts++;
    begin_life();
}

// --- the stream ---

// Lets the device work until it has nothing more to do, and takes what it has sent.
void Board::settle()
{
    do {
        for (int i = 0; i < waits_max && hours_device_poll(device_.get()); i++) {
        }
        finish_edges();
    } while (bus_->poll_stream());
}

void Board::write(std::span<const std::uint8_t> bytes)
{
    if (!bus_->is_plugged()) throw crn::LinkError("the cable is out");
    while (!bytes.empty()) {
        const auto packet = bytes.first(std::min(bytes.size(), BusHost::packet_bytes));
        for (int i = 0; !bus_->send(packet); i++) {
            if (i == retries_max) throw crn::LinkError("the device takes no more bytes");
            while (bus_->poll_stream()) {
            }
            run_until(now_ps_ + retry_ps);
        }
        bytes = bytes.subspan(packet.size());
        run_until(now_ps_ + packet_ps);
    }
    settle();
}

std::size_t Board::read(std::span<std::uint8_t> bytes)
{
    if (!bus_->is_plugged()) throw crn::LinkError("the cable is out");
    if (!bus_->has_bytes()) settle();
    return bus_->read(bytes);
}

// --- the judge ---

// Every frame that reached the device must be counted, though the register has only eleven bits, and edges
// and frames must differ by what the two crystals make, less than one of either.
void Board::check_frames(const hours_counts &counts)
{
    if (!look_.is_there || !bus_->is_plugged()) return;
    const std::uint64_t counted = look_.frames_begin + counts.frames;
    if (counted != look_.frames) {
        ledger_.frames_missed += counted > look_.frames ? counted - look_.frames : look_.frames - counted;
        note(crn::formatted("the device counted frame %llu where the host sent frame %llu",
                            static_cast<unsigned long long>(counted),
                            static_cast<unsigned long long>(look_.frames)));
    }
}

void Board::check_reports(const hours_counts &counts)
{
    if (!bus_->is_plugged()) return;
    const std::uint32_t dropped = counts.reports_dropped - plugged_.reports_dropped;
    const std::uint64_t expected = counts.edges_done - plugged_.edges_done;
    const std::uint64_t found = reports_ + dropped + counts.reports_waiting;
    if (found == expected) return;
    ledger_.reports_lost += expected > found ? expected - found : found - expected;
    note(crn::formatted("%llu edges made %llu state reports", static_cast<unsigned long long>(expected),
                        static_cast<unsigned long long>(found)));
}

const Ledger &Board::look()
{
    const hours_counts counts = hours_device_read(device_.get());
    ledger_.edges = before_.edges + edges_given_;
    ledger_.edges_done = before_.edges_done + counts.edges_done;
    ledger_.overruns = before_.overruns + counts.overruns;
    ledger_.overruns_given = before_.overruns_given + overruns_given_;
    ledger_.us_wraps =
        (settings_.begin_ms + edges_made_) * 1000 / us_per_wrap - settings_.begin_ms * 1000 / us_per_wrap;
    ledger_.frame_wraps = frames_.count() / frame_numbers;
    if (counts.edges != edges_given_ || counts.edges_done != counts.edges)
        note(crn::formatted("%u edges, of which the interrupt counted %u and the app did %u", edges_given_,
                            counts.edges, counts.edges_done));
    if (counts.overruns != overruns_given_)
        note(crn::formatted("the device noticed %u late edges, and %u were late", counts.overruns,
                            overruns_given_));
    if (counts.clock_error != 0)
        note(crn::formatted("the check of the clock found a difference of %d", counts.clock_error));
    check_frames(counts);
    check_reports(counts);
    if (look_.is_there && bus_->is_plugged()) {
        // By the numbers that the device counted, against the time of both crystals when it read them.
        const double passed = static_cast<double>(look_.ps) / static_cast<double>(ps_per_ms);
        const double counted = static_cast<double>(edges_begin_ + look_.edges) -
                               static_cast<double>(look_.frames_begin + counts.frames);
        const double made = passed - frames_.at(look_.ps);
        ledger_.drift_ms = std::max(ledger_.drift_ms, std::abs(counted - made));
    }
    if (!is_sound()) note("memory beside the device's was written");
    return ledger_;
}

} // namespace hours
