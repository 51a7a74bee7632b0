#include "hil_tests/campaign/fault.hpp"
#include <algorithm>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>

namespace hil
{

namespace
{

constexpr FaultKind kinds[] = {
    {"link.drop", "frame", nullptr},
    {"link.duplicate", "frame", nullptr},
    {"link.reorder", "frame", nullptr},
    {"link.truncate", "frame", "bytes"},
    {"link.flip", "frame", "bit"},
    {"link.garbage", "frame", "bytes"},
    {"link.stall", "frame", "ms"},
    {"link.cut", "frame", "bytes"},
    {"host.second", "tick", "action"},
    {"host.wrong_schema", "tick", nullptr},
    {"host.hostile", "tick", "message"},
    {"device.lies", "frame", "lie"},
    {"rig.encoder_jump", "tick", "um"},
    {"rig.encoder_turn_jump", "tick", "counts"},
    {"rig.encoder_turn_stuck", "tick", "hand"},
    {"rig.encoder_turn_reversed", "tick", "hand"},
    {"rig.encoder_stuck", "tick", "hand"},
    {"rig.encoder_reversed", "tick", "hand"},
    {"rig.encoder_lost", "tick", "axis"},
    {"rig.force_sensor_range", "tick", nullptr},
    {"rig.force_sensor_silent", "tick", nullptr},
    {"rig.force_jump", "tick", "mN"},
    {"rig.over_current", "tick", nullptr},
    {"rig.actuator_stuck_on", "tick", "axis"},
    {"rig.supply_lost", "tick", nullptr},
    {"rig.emergency_stop", "tick", nullptr},
    {"rig.brown_out", "tick", "ms"},
    {"rig.freeze", "tick", "ms"},
};

constexpr const char *session_names[] = {"setup", "lockstep", "free_run"};

std::uint32_t number(const std::string &word, const std::string &text)
{
    std::size_t end = 0;
    unsigned long value = 0;
    try {
        value = std::stoul(text, &end);
    } catch (const std::exception &) {
        end = 0;
    }
    if (end == 0 || end != text.size() || value > UINT32_MAX)
        throw std::invalid_argument("'" + word + "' has no number from 0 to 4294967295");
    return static_cast<std::uint32_t>(value);
}

const FaultKind *kind_of(const std::string &name)
{
    for (const FaultKind &kind : kinds) {
        if (name == kind.name) return &kind;
    }
    throw std::invalid_argument("no fault is called '" + name + "'; --list names them");
}

void set_word(Fault &fault, const std::string &word)
{
    const std::size_t equal = word.find('=');
    if (equal == std::string::npos)
        throw std::invalid_argument("'" + word + "' is not of the form key=value");
    const std::string key = word.substr(0, equal), text = word.substr(equal + 1);
    if (key == "session") {
        const auto *found = std::find(std::begin(session_names), std::end(session_names), text);
        if (found == std::end(session_names))
            throw std::invalid_argument("session is setup, lockstep or free_run, not '" + text + "'");
        fault.session = static_cast<Session>(found - std::begin(session_names));
    } else if (key == "way") {
        if (text != "to_host" && text != "to_device")
            throw std::invalid_argument("way is to_host or to_device, not '" + text + "'");
        fault.to_host = text == "to_host";
    } else if (key == fault.kind->when) {
        fault.at = number(word, text);
    } else if (fault.kind->value != nullptr && key == fault.kind->value) {
        fault.value = number(word, text);
    } else if (key == "seed") {
        fault.seed = number(word, text);
    } else {
        throw std::invalid_argument(std::string(fault.kind->name) + " has no '" + key + "'");
    }
}

// This class collects the faults of the list that all_faults() returns.
class Catalogue
{
  public:
    void add(const char *name, Session session, std::uint32_t at, std::uint32_t value = 0,
             bool to_host = false)
    {
        faults.push_back({kind_of(name), session, to_host, at, value, 1});
    }
    std::vector<Fault> faults;
};

// Adds faults for each of the first `count` frames of a session in which the device sends frames only as
// answers to requests.
void add_frames(Catalogue &c, Session session, std::uint32_t count)
{
    for (bool to_host : {false, true}) {
        for (std::uint32_t at = 1; at <= count; at++) {
            for (const char *name : {"link.drop", "link.duplicate", "link.reorder"})
                c.add(name, session, at, 0, to_host);
            for (std::uint32_t bytes : {1u, 9u + at}) c.add("link.truncate", session, at, bytes, to_host);
            for (std::uint32_t k = 0; k < 5; k++)
                c.add("link.flip", session, at, (at * 37 + k * 101) % 640, to_host);
            c.add("link.garbage", session, at, 1 + at * 7 % 60, to_host);
            c.add("link.cut", session, at, at * 5 % 24, to_host);
        }
    }
    for (std::uint32_t at = 1; at <= count; at++) {
        for (std::uint32_t lie = 0; lie < lies; lie++) c.add("device.lies", session, at, lie, true);
    }
}

void add_hosts(Catalogue &c, Session session, std::uint32_t step, std::uint32_t end)
{
    for (std::uint32_t at = 1; at <= end; at += step) {
        c.add("host.wrong_schema", session, at);
        for (std::uint32_t action = 0; action < second_actions; action++)
            c.add("host.second", session, at, action);
        for (std::uint32_t k = 0; k < 3; k++)
            c.add("host.hostile", session, at, (at + 5 * k) % hostile_types);
    }
}

void add_free_run(Catalogue &c)
{
    for (bool to_host : {false, true}) {
        for (std::uint32_t at = 1; at <= (to_host ? 6u : 12u); at++) {
            for (const char *name : {"link.drop", "link.duplicate", "link.reorder"})
                c.add(name, Session::free_run, at, 0, to_host);
            for (std::uint32_t k = 0; k < 3; k++) {
                c.add("link.truncate", Session::free_run, at, 1 + 11 * k, to_host);
                c.add("link.flip", Session::free_run, at, at * 13 + k * 71, to_host);
                c.add("link.garbage", Session::free_run, at, 1 + at + 9 * k, to_host);
            }
            c.add("link.cut", Session::free_run, at, at, to_host);
            if (to_host) {
                for (std::uint32_t lie = 0; lie < lies; lie++)
                    c.add("device.lies", Session::free_run, at, lie, true);
            }
        }
    }
    for (std::uint32_t at = 1; at <= 9; at++) {
        for (std::uint32_t ms = 10; ms <= 100; ms += 10) c.add("link.stall", Session::free_run, at, ms);
    }
}

void add_rig(Catalogue &c)
{
    for (std::uint32_t i = 0; i < 20; i++) {
        const std::uint32_t at = i < 10 ? i + 1 : i * 7 - 57; // tick 1, 2, 3 ... and then into the hard push
        c.add("rig.encoder_jump", Session::free_run, at, 5500 + 500 * i);
        c.add("rig.encoder_turn_jump", Session::free_run, at, 17000 + 500 * i);
        for (const char *name : {"rig.force_sensor_range", "rig.force_sensor_silent", "rig.over_current",
                                 "rig.supply_lost", "rig.emergency_stop"})
            c.add(name, Session::free_run, at);
        for (std::uint32_t hand : {0u, 1u}) { // the hand releases, or holds on
            c.add("rig.encoder_turn_stuck", Session::free_run, at, hand);
            c.add("rig.encoder_turn_reversed", Session::free_run, at, hand);
            c.add("rig.encoder_stuck", Session::free_run, at, hand);
            c.add("rig.encoder_reversed", Session::free_run, at, hand);
        }
        for (std::uint32_t axis : {0u, 1u}) {
            c.add("rig.encoder_lost", Session::free_run, at, axis);
            c.add("rig.actuator_stuck_on", Session::free_run, at, axis);
        }
        c.add("rig.force_jump", Session::free_run, at, 10000 + 250 * i);
        for (std::uint32_t ms : {3u, 20u}) {
            c.add("rig.brown_out", Session::free_run, at, ms);
            c.add("rig.freeze", Session::free_run, at + 1, ms * 3); // nothing has power before the first edge
        }
    }
}

} // namespace

bool Fault::is(const char *name) const
{
    return std::strcmp(kind->name, name) == 0;
}

bool Fault::is_group(const char *prefix) const
{
    return std::strncmp(kind->name, prefix, std::strlen(prefix)) == 0;
}

std::span<const FaultKind> fault_kinds()
{
    return kinds;
}

std::string line_of(const Fault &fault)
{
    std::ostringstream text;
    text << fault.kind->name << " session=" << session_names[static_cast<int>(fault.session)];
    if (std::strcmp(fault.kind->when, "frame") == 0)
        text << " way=" << (fault.to_host ? "to_host" : "to_device");
    text << ' ' << fault.kind->when << '=' << fault.at;
    if (fault.kind->value != nullptr) text << ' ' << fault.kind->value << '=' << fault.value;
    text << " seed=" << fault.seed;
    return text.str();
}

Fault fault_of(const std::string &line)
{
    std::istringstream words(line);
    std::string word;
    Fault fault;
    if (!(words >> word)) throw std::invalid_argument("an empty line names no fault");
    fault.kind = kind_of(word);
    if (fault.is_group("rig.")) fault.session = Session::free_run;
    if (fault.is("device.lies")) fault.to_host = true;
    while (words >> word) set_word(fault, word);
    if (fault.is_group("rig.") && fault.session != Session::free_run)
        throw std::invalid_argument("faults of the rig need session=free_run, where motors have power");
    return fault;
}

std::vector<Fault> all_faults()
{
    Catalogue c;
    add_frames(c, Session::setup, 12);
    for (std::uint32_t lie : {lie_scene_is_there, lie_scene_is_another, lie_upload_is_there})
        c.add("device.lies", Session::setup, set_up_frame, lie, true);
    add_frames(c, Session::lockstep, lockstep_ticks);
    add_hosts(c, Session::lockstep, 3, lockstep_ticks);
    add_hosts(c, Session::free_run, 6, free_ticks / 2);
    add_free_run(c);
    add_rig(c);
    return c.faults;
}

std::vector<Fault> spread_of(const std::vector<Fault> &faults, std::size_t count)
{
    std::map<std::string, std::vector<Fault>> by_kind;
    for (const Fault &fault : faults)
        by_kind[fault.kind->name + std::string(session_names[static_cast<int>(fault.session)])].push_back(
            fault);
    std::vector<Fault> chosen;
    for (std::size_t round = 0; chosen.size() < std::min(count, faults.size()); round++) {
        for (const auto &[name, group] : by_kind) {
            // Within each kind of fault, every 7919th fault is selected. The number 7919 has no common
            // divisor with the sizes of most groups, so the selected faults cover all ticks and both
            // directions of the frames.
            if (round < group.size() && chosen.size() < count)
                chosen.push_back(group[(round * 7919 + 13) % group.size()]);
        }
    }
    return chosen;
}

} // namespace hil
