#include "hil_tests/hours/campaign.hpp"
#include "hil_tests/cases/cases.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include "host/link/link.hpp"
#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace hours
{

namespace
{

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double ms_per_hour = 3.6e6;

// The sums as words, in the order of the struct.
template <typename S, typename Each> void for_each(S &sums, Each each)
{
    each("simulated_ms", sums.simulated_ms), each("edges", sums.edges), each("edges_done", sums.edges_done);
    each("ticks", sums.ticks), each("live_ticks", sums.live_ticks), each("late_ticks", sums.late_ticks);
    each("frames", sums.frames), each("frames_missed", sums.frames_missed), each("reports", sums.reports);
    each("reports_dropped", sums.reports_dropped), each("reports_lost", sums.reports_lost);
    each("overruns", sums.overruns), each("overruns_given", sums.overruns_given);
    each("us_wraps", sums.us_wraps), each("frame_wraps", sums.frame_wraps), each("restarts", sums.restarts);
    each("drift_us", sums.drift_us), each("sessions", sums.sessions), each("runs", sums.runs);
    each("arms", sums.arms), each("faults", sums.faults), each("faults_unplanned", sums.faults_unplanned);
    each("repeated_ticks", sums.repeated_ticks), each("broken", sums.broken),
        each("leak_bytes", sums.leak_bytes);
    each("leak_files", sums.leak_files), each("growth_bytes", sums.growth_bytes), each("hash", sums.hash);
    each("calls", sums.calls), each("edge_us_max", sums.edge_us_max), each("stack_free", sums.stack_free);
    each("stack_growth", sums.stack_growth);
}

std::string columns()
{
    Sums sums;
    std::string text;
    for_each(sums, [&](const char *name, auto &) { text += (text.empty() ? "" : "\t") + std::string(name); });
    return text + "\tlast_session\n";
}

std::string line_of(const Sums &sums, const std::string &last)
{
    std::string text;
    for_each(sums, [&](const char *, const auto &value) { text += std::to_string(value) + "\t"; });
    return text + last + "\n";
}

// The sums are those of the file's last whole line.
Sums read_sums(const std::string &path, const std::string &head)
{
    std::ifstream in(path, std::ios::binary);
    std::ostringstream whole;
    whole << in.rdbuf();
    std::string text = whole.str();
    Sums sums;
    if (!text.empty() && !text.starts_with(head)) {
        fs::rename(path, path + ".old");
        std::printf("%s.old: the figures of another program, scene or setting are put aside\n", path.c_str());
        text.clear();
    }
    text.erase(text.rfind('\n') + 1);
    if (text.size() <= head.size()) {
        crn::write_whole_file(path, head);
        return sums;
    }
    crn::write_whole_file(path, text);
    const std::size_t begin = text.rfind('\n', text.size() - 2) + 1;
    std::istringstream words(text.substr(begin));
    for_each(sums, [&](const char *, auto &value) {
        if (!(words >> value))
            throw std::runtime_error(path + ": the last row has no figures; remove the file");
    });
    return sums;
}

void append(const std::string &path, const std::string &line)
{
    std::FILE *file = std::fopen(path.c_str(), "ab");
    const bool is_written = file && std::fwrite(line.data(), 1, line.size(), file) == line.size();
    if ((file && std::fclose(file) != 0) || !is_written)
        throw std::runtime_error(path + ": cannot be written");
}

// The sums of the former calls, and those of this station.
Sums joined(const Sums &before, const Sums &now, const Ledger &ledger, std::uint64_t simulated_ms)
{
    Sums sums = now;
    sums.simulated_ms = before.simulated_ms + simulated_ms;
    sums.edges = before.edges + ledger.edges;
    sums.edges_done = before.edges_done + ledger.edges_done;
    sums.ticks = before.ticks + ledger.ticks;
    sums.frames = before.frames + ledger.frames;
    sums.frames_missed = before.frames_missed + ledger.frames_missed;
    sums.reports = before.reports + ledger.reports;
    sums.reports_dropped = before.reports_dropped + ledger.reports_dropped;
    sums.reports_lost = before.reports_lost + ledger.reports_lost;
    sums.overruns = before.overruns + ledger.overruns;
    sums.overruns_given = before.overruns_given + ledger.overruns_given;
    sums.us_wraps = before.us_wraps + ledger.us_wraps;
    sums.frame_wraps = before.frame_wraps + ledger.frame_wraps;
    sums.restarts = before.restarts + ledger.restarts;
    sums.drift_us = std::max(before.drift_us, static_cast<std::uint64_t>(ledger.drift_ms * 1e3));
    sums.edge_us_max = std::max(before.edge_us_max, static_cast<std::uint64_t>(ledger.edge_us_max));
    return sums;
}

class Campaign
{
  public:
    Campaign(const soak::Catalogue &catalogue, const CampaignSettings &settings)
        : catalogue_(catalogue), settings_(settings), head_("# " + settings.key + "\n" + columns()),
          before_(read_sums(settings.path, head_)), sums_(before_)
    {
    }

    Sums run(const std::function<std::unique_ptr<Station>(std::uint64_t)> &make)
    {
        if (is_enough()) return sums_;
        const std::unique_ptr<Station> station = make(before_.simulated_ms);
        sums_.calls++;
        last_.reserve(1000);
        for (std::uint32_t played = 1; !is_enough() && !crn::is_interrupted(); played++) {
            if (!play_next(*station)) break;
            measure_memory(played, *station);
            append(settings_.path, line_of(sums_, last_));
            show_progress();
        }
        if (settings_.shows_progress) std::fprintf(stderr, "\r%78s\r", "");
        return sums_;
    }

  private:
    bool is_enough() const
    {
        return static_cast<double>(sums_.simulated_ms) >= settings_.hours * ms_per_hour || sums_.broken > 0;
    }

    // False: interrupted in the middle of a session, which does not count.
    bool play_next(Station &station)
    {
        const auto index = static_cast<std::uint32_t>(sums_.sessions);
        Plan plan = draw_plan(catalogue_, settings_.seed, index, settings_.seconds_max);
        if (settings_.long_every > 0 && index % settings_.long_every == settings_.long_every / 4) {
            plan.run_ms = settings_.long_s * 1000;
            plan.is_repeated = false;
        }
        last_.clear(); // it keeps its memory, or the heap would seem to change
        last_ += soak::name_of(plan.drawn) + ", " + name_of(plan.disturbance);
        std::string trouble;
        try {
            take(play(station, catalogue_, plan));
        } catch (const std::exception &error) {
            if (crn::is_interrupted()) return false;
            trouble = error.what();
        }
        const Ledger &ledger = station.look();
        sums_ = joined(before_, sums_, ledger, station.simulated_ms());
        sums_.sessions++;
        if (trouble.empty()) trouble = ledger.trouble;
        if (trouble.empty()) return true;
        std::fprintf(stderr, "\n%s: %s\n", last_.c_str(), trouble.c_str());
        last_ += ": " + trouble;
        std::replace(last_.begin(), last_.end(), '\n', ' ');
        sums_.broken++;
        return true;
    }

    void take(const Played &played)
    {
        sums_.live_ticks += played.live_ticks;
        sums_.late_ticks += played.late_ticks;
        sums_.runs += played.runs;
        sums_.arms += played.arms;
        sums_.faults += played.faults;
        sums_.faults_unplanned += played.faults_unplanned;
        sums_.repeated_ticks += played.repeated_ticks;
        sums_.hash = played.hash;
        if (played.faults_unplanned > 0) last_ += ", " + played.why_unplanned;
    }

    void measure_memory(std::uint32_t played, Station &station)
    {
        const Memory memory = memory_now();
        sums_.stack_free = station.stack_free();
        if (played <= settings_.warm_sessions) {
            warm_ = memory;
            stack_warm_ = sums_.stack_free;
            return;
        }
        if (sums_.stack_free < stack_warm_)
            sums_.stack_growth = std::max(before_.stack_growth, stack_warm_ - sums_.stack_free);
        sums_.leak_bytes = std::max(before_.leak_bytes, memory.heap_bytes - warm_.heap_bytes);
        sums_.leak_files = std::max(before_.leak_files, memory.files - warm_.files);
        sums_.growth_bytes = std::max(before_.growth_bytes, memory.resident_bytes - warm_.resident_bytes);
    }

    void show_progress()
    {
        if (!settings_.shows_progress) return;
        const double wall_s = std::chrono::duration<double>(Clock::now() - begin_).count();
        const double done_h = static_cast<double>(sums_.simulated_ms) / ms_per_hour;
        const double speed =
            (done_h - static_cast<double>(before_.simulated_ms) / ms_per_hour) * 3600 / wall_s;
        std::fprintf(stderr, "\r%7.3f of %g h, %" PRIu64 " sessions, %.0f times real time, %.0f min left   ",
                     done_h, settings_.hours, sums_.sessions, speed, (settings_.hours - done_h) * 60 / speed);
    }

    const soak::Catalogue &catalogue_;
    const CampaignSettings &settings_;
    const std::string head_;
    const Sums before_;
    Sums sums_;
    Memory warm_;
    std::uint64_t stack_warm_ = 0;
    std::string last_;
    const Clock::time_point begin_ = Clock::now();
};

} // namespace

Sums run_campaign(const soak::Catalogue &catalogue, const CampaignSettings &settings,
                  const std::function<std::unique_ptr<Station>(std::uint64_t begin_ms)> &make)
{
    fs::create_directories(fs::path(settings.path).parent_path());
    return Campaign(catalogue, settings).run(make);
}

std::string bench_rows(const Sums &sums, const std::string &place)
{
    std::ostringstream text;
    const auto row = [&](const char *name, auto value, const char *unit) {
        text << "hours." << name << "\t" << value << "\t" << unit << "\tat=" << place << "\n";
    };
    const double ticks = std::max<double>(1.0, static_cast<double>(sums.ticks));
    row("simulated_h", static_cast<double>(sums.simulated_ms) / ms_per_hour, "h");
    row("sessions", sums.sessions, "1");
    row("broken", sums.broken, "1");
    row("edges", sums.edges, "1");
    row("edges_missed", sums.edges - sums.edges_done, "1");
    row("ticks", std::max(sums.ticks, sums.live_ticks),
        "ticks"); // only the board in this process counts them itself
    row("overruns", sums.overruns - sums.overruns_given, "1");
    row("late_share_ppm", static_cast<double>(sums.overruns) * 1e6 / ticks, "ppm");
    row("frames", sums.frames, "1");
    row("frames_missed", sums.frames_missed, "1");
    row("frame_drift_ticks", sums.drift_us / 1000, "ticks");
    row("reports", sums.reports, "1");
    row("reports_lost", sums.reports_lost, "1");
    row("clock_wraps", sums.us_wraps, "1");
    row("leak_bytes", std::max<std::int64_t>(0, sums.leak_bytes), "byte");
    row("leak_files", std::max<std::int64_t>(0, sums.leak_files), "1");
    row("resident_growth_kB", std::max<std::int64_t>(0, sums.growth_bytes) / 1000, "kB");
    if (sums.edge_us_max > 0) row("edge_us_max", sums.edge_us_max, "us");
    if (sums.stack_free > 0) row("stack_free_bytes", sums.stack_free, "byte");
    if (sums.stack_free > 0) row("stack_growth_bytes", sums.stack_growth, "byte");
    row("runs", sums.runs, "1");
    row("faults", sums.faults, "1");
    row("faults_unplanned", sums.faults_unplanned, "1");
    row("repeated_ticks", sums.repeated_ticks, "ticks");
    return text.str();
}

bool is_kept(const Sums &sums, std::string &why)
{
    why.clear();
    const auto expect = [&](bool is_true, const std::string &text) {
        if (!is_true) why += "hours: " + text + "\n";
    };
    expect(sums.broken == 0, "a session was broken; the last row of the file names it");
    expect(sums.edges == sums.edges_done, "edges of the timer were lost");
    expect(sums.overruns == sums.overruns_given, "edges were late without a cause, or the device missed one");
    expect(static_cast<double>(sums.overruns) <= late_share_max * static_cast<double>(sums.ticks) + 10,
           "more edges were late than the stated share");
    expect(sums.frames_missed == 0, "the device counted the frames of the bus wrongly");
    expect(sums.drift_us < 1000, "the ticks drifted against the frames");
    expect(sums.reports_lost == 0, "state reports were lost");
    expect(sums.leak_bytes <= 0,
           "the heap grew by " + std::to_string(sums.leak_bytes) + " bytes after the warm-up");
    expect(sums.stack_growth <= stack_growth_max_bytes,
           "the device's stack reached further after the warm-up");
    expect(sums.leak_files <= 0, "files were left open");
    return why.empty();
}

} // namespace hours
