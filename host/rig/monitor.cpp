// cournand rig monitor: shows the state reports as a table that stays in place, as plain lines, and as CSV.
#include "host/base/text.hpp"
#include "host/rig/rig.hpp"
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>

namespace crn
{

namespace
{

using Clock = std::chrono::steady_clock;
constexpr auto show_every = std::chrono::milliseconds(100); // the table; plain lines come every second
constexpr unsigned plain_every = 10;
constexpr unsigned silent_max = 3; // seconds without a report

struct FileEnd {
    void operator()(std::FILE *file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileEnd>;

File open_csv(const std::string &path)
{
    if (path.empty()) return nullptr;
    File file(std::fopen(path.c_str(), "w"));
    if (!file) throw LinkError(path + ": cannot write: " + std::strerror(errno));
    std::fprintf(file.get(), "tick,state,mode,fault_code,buttons,lines,fault_count");
    for (int k = 1; k <= 3; k++) {
        std::fprintf(file.get(),
                     ",translation%d_counts,rotation%d_counts,motor_axial%d_mN,motor_torque%d_uN_m,"
                     "sensor_axial%d_mN",
                     k, k, k, k, k);
    }
    std::fprintf(file.get(), ",syringe_counts,inflator_raw\n");
    return file;
}

void write_csv(std::FILE *file, const crn_hid_state &state)
{
    std::fprintf(file, "%u,%u,%u,%u,%u,%u,%u", unsigned{state.tick}, unsigned{state.state},
                 unsigned{state.mode}, unsigned{state.fault_code}, unsigned{state.buttons},
                 unsigned{state.lines}, unsigned{state.fault_count});
    for (const crn_hid_track &track : state.tracks) {
        std::fprintf(file, ",%d,%d,%d,%d,%d", track.translation_counts, track.rotation_counts,
                     track.motor_axial_mN, track.motor_torque_uN_m, track.sensor_axial_mN);
    }
    std::fprintf(file, ",%d,%d\n", state.syringe_counts, state.inflator_raw);
}

struct Count {
    std::uint64_t reports = 0, lost = 0;
    unsigned backwards = 0; // the rig restarted
    std::uint32_t tick = 0;
    void take(std::uint32_t now)
    {
        if (reports > 0 && now > tick) lost += now - tick - 1;
        if (reports > 0 && now < tick) backwards++;
        reports++;
        tick = now;
    }
};

std::string head_of(const crn_hid_state &state)
{
    std::string text = "tick " + std::to_string(state.tick) + "  " + state_name(state.state) +
                       (state.mode == CRN_WIRE_MODE_FREE_RUN ? "  FREE_RUN" : "  LOCKSTEP");
    if (state.fault_code != 0) text += std::string("  ") + crn_wire_fault_name(state.fault_code);
    return text;
}

void show_table(std::FILE *out, const crn_hid_state &state, const Count &count, bool is_first)
{
    if (!is_first) std::fprintf(out, "\x1b[6A");
    std::fprintf(out, "\x1b[K%s  lost %llu\n", head_of(state).c_str(),
                 static_cast<unsigned long long>(count.lost));
    std::fprintf(out, "\x1b[K%-6s %12s %12s %10s %12s %10s\n", "track", "along", "about", "motor mN",
                 "motor uN m", "sensor mN");
    for (int k = 0; k < 3; k++) {
        const crn_hid_track &track = state.tracks[k];
        std::fprintf(out, "\x1b[K%-6d %12d %12d %10d %12d %10d\n", k + 1, track.translation_counts,
                     track.rotation_counts, track.motor_axial_mN, track.motor_torque_uN_m,
                     track.sensor_axial_mN);
    }
    std::fprintf(out, "\x1b[Ksyringe %d counts, inflator %d counts, buttons 0x%02x, %s%s%s\n",
                 state.syringe_counts, state.inflator_raw, unsigned{state.buttons},
                 (state.lines & 1) != 0 ? "EMERGENCY STOP" : "stop released",
                 (state.lines & 2) != 0 ? "" : ", supply out of range",
                 (state.lines & 16) != 0 ? ", MOTORS DRIVEN" : "");
    std::fflush(out);
}

void show_line(std::FILE *out, const crn_hid_state &state)
{
    std::fprintf(out, "%s", head_of(state).c_str());
    for (int k = 0; k < 3; k++) {
        const crn_hid_track &track = state.tracks[k];
        std::fprintf(out, "  | %d: %d %d counts, motor %d mN, sensor %d mN", k + 1, track.translation_counts,
                     track.rotation_counts, track.motor_axial_mN, track.sensor_axial_mN);
    }
    std::fprintf(out, "\n");
    std::fflush(out);
}

} // namespace

int rig_monitor(const StateSource &next, const RigOptions &options, const RigTalk &talk)
{
    const File csv = open_csv(options.csv);
    const Clock::time_point begin = Clock::now();
    Clock::time_point due = begin;
    Count count;
    unsigned shown = 0, silent = 0;
    std::string wrong;
    const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
    while (!talk.is_interrupted() && (options.seconds <= 0.0 || seconds() < options.seconds)) {
        std::optional<crn_hid_state> state;
        try {
            state = next();
        } catch (const LinkError &error) { // earlier reports are shown and written nevertheless
            wrong = error.what();
            break;
        }
        if (!state) {
            if (++silent < silent_max) continue;
            wrong = "the rig has sent no state report for " + std::to_string(silent_max) +
                    " s. Remedy: plug it out and in; cournand rig list";
            break;
        }
        silent = 0;
        count.take(state->tick);
        if (csv) write_csv(csv.get(), *state);
        if (Clock::now() < due) continue;
        due = Clock::now() + show_every;
        if (talk.is_terminal) show_table(talk.out, *state, count, shown == 0);
        if (!talk.is_terminal && shown % plain_every == 0) show_line(talk.out, *state);
        shown++;
    }
    std::fprintf(talk.out, "%llu reports in %.3f s, %llu ticks lost%s\n",
                 static_cast<unsigned long long>(count.reports), seconds(),
                 static_cast<unsigned long long>(count.lost),
                 count.backwards > 0 ? "; the rig restarted meanwhile" : "");
    if (csv && std::ferror(csv.get()) != 0)
        wrong = options.csv + ": could not be written whole; is the disk full?";
    if (wrong.empty()) return 0;
    std::fprintf(stderr, "cournand: %s\n", wrong.c_str());
    return 1;
}

} // namespace crn
