#include "hil_tests/soak/campaign.hpp"
#include "hil_tests/soak/process.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <poll.h>
#include <stdexcept>
#include <unistd.h>

namespace soak
{

namespace
{

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t spare_ticks = 2000; // behind the tick of the break, in trials of a shorter session

double seconds_since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string script_path(const CampaignSettings &settings, const DrawnSession &session)
{
    return (fs::path(settings.folder) /
            (std::to_string(session.seed) + "_" + std::to_string(session.index) + ".session"))
        .string();
}

void write_script(const std::string &path, const Shrunk &shrunk, const Verdict &found)
{
    std::string text =
        "# " + name_of(shrunk.session) + ", shrunk in " + std::to_string(shrunk.trials) + " trials\n";
    text += "# tick " + std::to_string(shrunk.verdict.tick) + ": " + shrunk.verdict.text +
            " (whole session: tick " + std::to_string(found.tick) + ", " + found.text + ")\n";
    text += "# " + command_of(shrunk.session, path) + "\n";
    crn::write_whole_file(path, text + script_of(shrunk.session));
}

// Holds the worker processes and the output that they have written so far.
class Pool
{
  public:
    Pool(const Catalogue &catalogue, const CampaignSettings &settings, RowsFile &rows)
        : catalogue_(catalogue), settings_(settings), rows_(rows)
    {
        for (const auto &[index, row] : rows.rows()) ticks_ += row.verdict.ticks;
    }

    void run()
    {
        while (true) {
            const bool may_start = !crn::is_interrupted() && !is_done();
            while (may_start && !is_done() && workers_.size() < static_cast<std::size_t>(settings_.jobs))
                start();
            if (workers_.empty()) break;
            if (crn::is_interrupted() && !was_told_) tell_workers();
            wait_for_news();
            progress();
        }
        if (settings_.shows_progress && isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\x1b[K");
    }

  private:
    struct Worker {
        Process process;
        DrawnSession session;
        std::string text;
    };

    // A session in progress counts towards the number of sessions, but its ticks count only when it has
    // ended.
    bool is_done() const
    {
        if (settings_.hours > 0) return seconds_since(begin_) >= settings_.hours * 3600;
        return rows_.rows().size() + workers_.size() >= settings_.sessions && ticks_ >= settings_.ticks;
    }

    void start()
    {
        while (rows_.has(next_)) next_++;
        const DrawnSession session = draw_session(catalogue_, settings_.seed, next_++, settings_.draw);
        const Process process = start_process([&] { return work(session); });
        workers_.push_back({process, session, ""});
    }

    // Returns the results of the session as one line of the file, or nothing if the session could not be
    // judged.
    std::optional<std::string> work(const DrawnSession &session) const
    {
        try {
            const std::optional<Row> row = judge_session(catalogue_, settings_, session);
            return row ? line_of(*row) : std::string();
        } catch (const std::exception &error) {
            std::fprintf(stderr, "soak: %s: %s\n", name_of(session).c_str(), error.what());
            return {};
        }
    }

    void tell_workers()
    {
        was_told_ = true;
        for (const Worker &worker : workers_) kill(worker.process.who, SIGINT);
    }

    void wait_for_news()
    {
        std::vector<pollfd> polls;
        for (const Worker &worker : workers_) polls.push_back({worker.process.pipe, POLLIN, 0});
        if (poll(polls.data(), polls.size(), check_every_ms) <= 0) return;
        for (std::size_t i = polls.size(); i-- > 0;) {
            if (polls[i].revents == 0) continue;
            char bytes[4096];
            const ssize_t count = read(polls[i].fd, bytes, sizeof bytes);
            if (count > 0) workers_[i].text.append(bytes, static_cast<std::size_t>(count));
            if (count == 0) finish(i);
        }
    }

    void finish(std::size_t i)
    {
        const Worker worker = workers_[i];
        workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(i));
        close(worker.process.pipe);
        const int status = status_of_end(worker.process.who);
        if (status != 0 && !crn::is_interrupted())
            throw std::runtime_error(name_of(worker.session) + ": its judge ended by itself");
        if (worker.text.empty() || status != 0) return; // interrupted: the session is repeated next time
        const Row row = row_of(worker.text);
        rows_.add(row);
        ticks_ += row.verdict.ticks;
        ticks_now_ += row.verdict.ticks;
        broken_ += row.verdict.broken.empty() ? 0 : 1;
        if (!row.verdict.broken.empty()) tell_break(row);
    }

    void tell_break(const Row &row) const
    {
        if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\x1b[K");
        std::printf("broken   seed %llu session %u, tick %u: %s\n         %s; %s; shrunk: %s\n",
                    static_cast<unsigned long long>(settings_.seed), unsigned{row.index},
                    unsigned{row.verdict.tick}, row.verdict.text.c_str(), row.scene.c_str(),
                    row.tools.c_str(), row.script.c_str());
        std::fflush(stdout);
    }

    void progress()
    {
        if (!settings_.shows_progress || seconds_since(told_) < (isatty(STDERR_FILENO) ? 1 : 60)) return;
        told_ = Clock::now();
        const double seconds = seconds_since(begin_);
        std::fprintf(stderr, "%sseed %llu: %zu sessions, %.2f million ticks, %llu broken, %.0f ticks/s%s",
                     isatty(STDERR_FILENO) ? "\r\x1b[K" : "", static_cast<unsigned long long>(settings_.seed),
                     rows_.rows().size(), static_cast<double>(ticks_) * 1e-6,
                     static_cast<unsigned long long>(broken_), static_cast<double>(ticks_now_) / seconds,
                     isatty(STDERR_FILENO) ? "" : "\n");
    }

    const Catalogue &catalogue_;
    const CampaignSettings &settings_;
    RowsFile &rows_;
    std::vector<Worker> workers_;
    std::uint32_t next_ = 0;
    std::uint64_t ticks_ = 0, ticks_now_ = 0, broken_ = 0; // all, of this call, of this call
    bool was_told_ = false;
    const Clock::time_point begin_ = Clock::now();
    Clock::time_point told_ = begin_;
};

} // namespace

std::optional<Row> judge_session(const Catalogue &catalogue, const CampaignSettings &settings,
                                 const DrawnSession &session)
{
    const auto judge = [&](const DrawnSession &one, const TrialSettings &trial) {
        return run_isolated([&] { return run_trial(catalogue, one, trial); }, settings.trial_seconds_max);
    };
    const Verdict found = judge(session, settings.trial);
    if (found.was_interrupted) return {};
    Row row{session.index, session.scene, tools_of(session), found, ""};
    if (found.broken.empty()) return row;
    TrialSettings shorter = settings.trial;
    shorter.replays = found.broken == "replay";
    if (found.tick > 0) shorter.ticks_max = std::min(shorter.ticks_max, found.tick + spare_ticks);
    const Shrunk shrunk = shrink(
        session, found, [&](const DrawnSession &one) { return judge(one, shorter); }, settings.shrink);
    row.script = script_path(settings, session);
    write_script(row.script, shrunk, found);
    return row;
}

void run_campaign(const Catalogue &catalogue, const CampaignSettings &settings, RowsFile &rows)
{
    Pool(catalogue, settings, rows).run();
}

} // namespace soak
