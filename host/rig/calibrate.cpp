// Implements the command cournand rig calibrate: the user moves a tool as instructed, and the program
// computes how much motion one encoder count means. The program first makes all measurements and then sends
// all results in one message, which the device accepts completely or not at all. The settings of the device
// therefore do not change if the user stops the calibration in the middle.
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/rig/rig.hpp"
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

constexpr double counts_min = 100.0; // fewer would be noise
constexpr int force_samples = 50;
constexpr double gravity_m_per_s2 = 9.80665;

// Lists the fields of a rig's settings that this command calibrates, with their names in the wire protocol.
struct Field {
    const char *name;
    std::uint32_t crn_wire_track::*value;
};
constexpr Field fields[] = {{"translation_pm_per_count", &crn_wire_track::translation_pm_per_count},
                            {"rotation_counts_per_turn", &crn_wire_track::rotation_counts_per_turn},
                            {"options", &crn_wire_track::options},
                            {"force_uN_per_count", &crn_wire_track::force_uN_per_count},
                            {"damping_mN_s_per_m", &crn_wire_track::damping_mN_s_per_m},
                            {"damping_nN_m_s_per_rad", &crn_wire_track::damping_nN_m_s_per_rad},
                            {"actuator_lag_us", &crn_wire_track::actuator_lag_us}};
constexpr const char *zero_name = "force_zero_counts";

class Guide
{
  public:
    Guide(Link &link, const RigOptions &options, const RigTalk &talk)
        : link_(link), options_(options), talk_(talk)
    {
    }

    void translation(crn_wire_track &track)
    {
        const auto read = [](const crn_wire_track_sensors &now) { return now.translation_counts; };
        const auto good = [](const crn_wire_track_sensors &now) { return now.translation_sensor == 0; };
        const double counts = way("Put the carriage at the first mark and press Enter.",
                                  "Push it " + number_text(options_.distance_mm) +
                                      " mm into the patient, to the second mark, and press Enter.",
                                  "translation encoder", read, good);
        const double pm = options_.distance_mm * 1e9 / std::abs(counts);
        set(track.translation_pm_per_count, pm, 1e3, 5e8, "pm/count");
        set_bit(track.options, CRN_WIRE_OPTION_TRANSLATION_REVERSED, counts < 0.0);
    }

    void rotation(crn_wire_track &track)
    {
        const auto read = [](const crn_wire_track_sensors &now) { return now.rotation_counts; };
        const auto good = [](const crn_wire_track_sensors &now) { return now.rotation_sensor == 0; };
        const double counts =
            way("Hold the handle at its mark and press Enter.",
                "Turn it " + number_text(options_.turns) +
                    " turns, right-handed about the direction of insertion, and press Enter.",
                "rotation encoder", read, good);
        set(track.rotation_counts_per_turn, std::abs(counts) / options_.turns, 16.0, 16777216.0,
            "counts/turn");
        set_bit(track.options, CRN_WIRE_OPTION_ROTATION_REVERSED, counts < 0.0);
    }

    void force(crn_wire_track &track)
    {
        talk_.ask("Take the hands off the track and press Enter.");
        const double zero = mean_force();
        talk_.ask("Let " + number_text(options_.weight_g) +
                  " g pull the handle back out along the track (a thread over a pulley) and press Enter.");
        const double loaded = mean_force();
        if (std::abs(loaded - zero) < 10.0) {
            throw LinkError("the force sensor changed by " + number_text(loaded - zero) +
                            " counts only. Remedy: check the thread, or take a larger --weight");
        }
        if (loaded < zero) {
            throw LinkError(
                "the force sensor counts down when the handle is pulled out, and it has to count up. "
                "Remedy: swap its signal wires");
        }
        track.force_zero_counts = static_cast<std::int32_t>(std::lround(zero));
        set(track.force_uN_per_count, options_.weight_g * gravity_m_per_s2 * 1e3 / (loaded - zero), 1.0, 1e6,
            "uN/count");
    }

  private:
    crn_wire_track_sensors sample()
    {
        if (talk_.is_interrupted()) throw RigStopped("interrupted; nothing was changed");
        const crn_wire_sensors sensors = link_.read_sensors();
        if (!sensors.has_rig || options_.track > sensors.tracks_count)
            throw LinkError("the rig does not report track " + std::to_string(options_.track) +
                            ". Remedy: cournand rig selftest");
        return sensors.tracks[options_.track - 1];
    }

    template <class Read, class Good>
    double way(const std::string &first, const std::string &second, const std::string &what, Read read,
               Good good)
    {
        talk_.ask(first);
        const crn_wire_track_sensors begin = sample();
        talk_.ask(second);
        const crn_wire_track_sensors end = sample();
        if (!good(begin) || !good(end))
            throw LinkError("the " + what + " gives no good signal. Remedy: cournand rig selftest");
        // The counts of an encoder may wrap round, but the difference of two counts in 32-bit arithmetic is
        // still the displacement.
        const auto counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(read(end)) -
                                                      static_cast<std::uint32_t>(read(begin)));
        if (std::abs(static_cast<double>(counts)) < counts_min) {
            throw LinkError("the " + what + " moved by " + std::to_string(counts) +
                            " counts only. Remedy: check its coupling, or use a longer distance");
        }
        return counts;
    }

    double mean_force()
    {
        double sum = 0.0;
        for (int i = 0; i < force_samples; i++) {
            link_.free_run(2);
            const crn_wire_track_sensors now = sample();
            if (now.force_sensor != 0) {
                throw LinkError("the force sensor is " + sensor_name(now.force_sensor) +
                                ". Remedy: cournand rig selftest");
            }
            sum += now.force_raw;
        }
        return sum / force_samples;
    }

    static void set(std::uint32_t &field, double value, double low, double high, const char *unit)
    {
        if (value < low || value > high) {
            throw LinkError("measured " + number_text(value) + " " + unit + ", which is outside " +
                            number_text(low) + " to " + number_text(high) +
                            ". Remedy: check that distance and weight are the ones given");
        }
        field = static_cast<std::uint32_t>(std::llround(value));
    }

    static void set_bit(std::uint32_t &options, std::uint32_t bit, bool on)
    {
        options = on ? options | bit : options & ~bit;
    }

    Link &link_;
    const RigOptions &options_;
    const RigTalk &talk_;
};

void print_changes(const RigTalk &talk, const crn_wire_rig &before, const crn_wire_rig &after)
{
    std::fprintf(talk.out, "%-8s %-26s %14s %14s\n", "track", "", "before", "after");
    for (std::uint16_t k = 0; k < before.tracks_count; k++) {
        const crn_wire_track &old = before.tracks[k], &fresh = after.tracks[k];
        for (const Field &field : fields) {
            if (old.*field.value == fresh.*field.value) continue;
            std::fprintf(talk.out, "%-8d %-26s %14u %14u\n", k + 1, field.name, unsigned{old.*field.value},
                         unsigned{fresh.*field.value});
        }
        if (old.force_zero_counts != fresh.force_zero_counts)
            std::fprintf(talk.out, "%-8d %-26s %14d %14d\n", k + 1, zero_name, old.force_zero_counts,
                         fresh.force_zero_counts);
    }
}

bool is_same(const crn_wire_rig &a, const crn_wire_rig &b)
{
    if (a.tracks_count != b.tracks_count) return false;
    for (std::uint16_t k = 0; k < a.tracks_count; k++) {
        for (const Field &field : fields)
            if (a.tracks[k].*field.value != b.tracks[k].*field.value) return false;
        if (a.tracks[k].force_zero_counts != b.tracks[k].force_zero_counts) return false;
    }
    return true;
}

// Sends the settings to the device in one message and reads them back. If the device returns other settings
// than those sent, the function restores the former settings.
void write(Link &link, const crn_wire_rig &before, const crn_wire_rig &after)
{
    link.set_rig(after);
    if (is_same(link.read_rig(), after)) return;
    link.set_rig(before);
    throw LinkError("the rig keeps other values than it was given; the old ones were written again. Remedy: "
                    "report it with the firmware's release");
}

void save(const std::string &path, const crn_wire_rig &rig)
{
    nlohmann::ordered_json file;
    file["tracks"] = nlohmann::json::array();
    for (std::uint16_t k = 0; k < rig.tracks_count; k++) {
        nlohmann::ordered_json track;
        for (const Field &field : fields) track[field.name] = rig.tracks[k].*field.value;
        track[zero_name] = rig.tracks[k].force_zero_counts;
        file["tracks"].push_back(track);
    }
    write_whole_file(path, file.dump(2) + "\n");
}

crn_wire_rig load(const std::string &path, crn_wire_rig rig)
{
    std::ifstream in(path);
    if (!in) throw LinkError(path + ": cannot read: " + std::strerror(errno));
    try {
        const nlohmann::json tracks = nlohmann::json::parse(in).at("tracks");
        if (!tracks.is_array() || tracks.size() > rig.tracks_count)
            throw LinkError(path + ": it holds " + std::to_string(tracks.size()) + " tracks, the rig has " +
                            std::to_string(rig.tracks_count));
        for (std::size_t k = 0; k < tracks.size(); k++) {
            for (const Field &field : fields) {
                const auto value = tracks[k].at(field.name).get<std::int64_t>();
                if (value < 0 || value > UINT32_MAX)
                    throw LinkError(path + ": " + field.name + " is out of range: " + std::to_string(value));
                rig.tracks[k].*field.value = static_cast<std::uint32_t>(value);
            }
            const auto zero = tracks[k].at(zero_name).get<std::int64_t>();
            if (zero < INT32_MIN || zero > INT32_MAX)
                throw LinkError(path + ": " + zero_name + " is out of range");
            rig.tracks[k].force_zero_counts = static_cast<std::int32_t>(zero);
        }
    } catch (const nlohmann::json::exception &error) {
        throw LinkError(path + ": is no calibration that --save wrote: " + error.what());
    }
    return rig;
}

crn_wire_rig measure(Link &link, const crn_wire_rig &before, const RigOptions &options, const RigTalk &talk)
{
    crn_wire_rig after = before;
    crn_wire_track &track = after.tracks[options.track - 1];
    Guide guide(link, options, talk);
    const auto wants = [&](const char *what) { return options.what == "all" || options.what == what; };
    if (wants("translation")) guide.translation(track);
    if (wants("rotation")) guide.rotation(track);
    if (wants("force")) guide.force(track);
    return after;
}

} // namespace

int rig_calibrate(Link &link, const RigOptions &options, const RigTalk &talk)
{
    check_outputs({{"--load", options.load}}, {{"--save", options.save}});
    require_ready(link, options.reset);
    const crn_wire_rig before = link.read_rig();
    if (options.track > before.tracks_count)
        throw LinkError("the rig has no track " + std::to_string(options.track));
    const crn_wire_rig after =
        options.load.empty() ? measure(link, before, options, talk) : load(options.load, before);
    if (is_same(before, after)) {
        std::fprintf(talk.out, "the rig has these values already\n");
    } else {
        print_changes(talk, before, after);
        if (!options.yes && talk.ask("Type yes to write this to the rig:") != "yes")
            throw RigStopped("not confirmed; nothing was changed");
        write(link, before, after);
        std::fprintf(talk.out, "written and read back\n");
    }
    if (!options.save.empty()) {
        save(options.save, link.read_rig());
        std::fprintf(talk.out, "saved in %s; --load writes it to the rig after power-up\n",
                     options.save.c_str());
    }
    return 0;
}

} // namespace crn
