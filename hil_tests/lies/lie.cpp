#include "hil_tests/lies/lie.hpp"
#include <algorithm>
#include <initializer_list>
#include <sstream>
#include <stdexcept>

namespace hil
{

namespace
{

struct Kind {
    const char *name;
    std::vector<unsigned> at, values;
};

const std::vector<unsigned> frames = {1, 2, 3, 5, 9, 30}, first = {1}, some = {1, 3, 20}, no = {0};

const std::vector<Kind> frame_kinds = {
    {"stream.zeros", frames, no},
    {"stream.ones", frames, no},
    {"stream.garbage", frames, no},
    {"stream.same_frame", frames, no},
    {"stream.half_frames", {1, 3, 9}, no},
    {"stream.notices", {1, 3, 9}, no},
    {"stream.live", {1, 3, 9}, no},
    {"stream.refusals", {1, 3, 9}, no},
    {"stream.silence", frames, no},
    {"stream.drip_zeros", {1, 2, 9}, no},
    {"stream.drip_garbage", {1, 2, 9}, no},
    {"stream.drip_frames", {1, 9}, no},
    {"stream.late_ms", {1, 5}, {450, 700, 1900}},
    {"frame.flip", frames, no},
    {"frame.lost", frames, no},
    {"frame.twice", frames, no},
    {"frame.swapped", {1, 2, 9}, no},
    {"frame.cut", frames, no},
    {"frame.too_long", {1, 2, 9}, no},
    {"frame.answers", frames, {1, 0x7fff}},
    {"frame.sequence", {2, 5}, no},
    {"frame.refused", frames, {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 0xffff}},
    {"message.half", {1, 2, 5, 9}, no},
    {"message.longer", {1, 2, 5, 9}, no},
    {"message.type", {1, 2, 5, 9}, no},
    {"message.ones", {1, 2, 3, 5, 9}, no},
    {"message.negative", {1, 2, 3, 5, 9}, no},
    {"message.large", {1, 2, 3, 5, 9}, no},
    {"message.count", {1, 2, 3, 5, 9}, no},
    {"message.random", {1, 2, 3, 5, 9}, no},
};

const std::vector<Kind> field_kinds = {
    {"hello.refused", first, no},
    {"hello.schema", first, no},
    {"hello.core", first, {0, 1, 3, 0x7fffffff, 0xffffffff}},
    {"hello.tick_us", first, {0, 1, 999, 1001, 0x7fffffff, 0xffffffff}},
    {"hello.capabilities", first, {0, 1, 0x7fffffff, 0x80000000, 0xffffffff}},
    {"hello.snapshot_bytes", first, {0, 1, 64, 0x7fffffff, 0xffffffff}},
    {"hello.serial", first, {0, 1}},
    {"status.state", {1, 3, 9}, {0, 3, 4, 99}},
    {"status.tick", {1, 9}, {0, 1000, 0xffffffff}},
    {"status.arm_code", {1}, {0xffffffff}},
    {"set_up.scene_is_there", first, no},
    {"set_up.scene_is_another", first, no},
    {"set_up.upload_is_there", first, no},
    {"set_up.upload_is_beyond", first, no},
    {"rig.tracks", first, no},
    {"rig.limits", first, {0, 0xffffffff}},
    {"rig.scale", first, {0, 0xffffffff}},
    {"ticks.lane0", {1, 3, 20, 60}, no},
    {"ticks.lane1", {1, 3, 20, 60}, no},
    {"ticks.backwards", some, no},
    {"ticks.fewer", some, no},
    {"ticks.none", some, no},
    {"ticks.repeated", {2, 20}, no},
    {"ticks.forces", some, {0x7fffffff, 0x80000000}},
    {"ticks.inserted", some, {0x7fffffff, 0x80000000}},
    {"ticks.core_faults", {3}, {0xffffffff}},
    {"hash.value", {1, 2, 5}, no},
    {"hash.tick", {1, 2}, {0, 1, 50, 0xffffffff}},
    {"hash.twice_with_another_tick", {1, 2}, no},
    {"final_hash.value", first, no},
    {"final_hash.zero", first, no},
    {"final_hash.tick", first, {0, 1, 0xffffffff}},
    {"snapshot.core", first, {400, 1000, 3000}},
    {"snapshot.head", first, {12, 24, 60}},
    {"snapshot.tick", first, {1, 0xffffffff}},
    {"snapshot.begin_tick", first, no},
    {"snapshot.short", first, no},
    {"snapshot.empty", first, no},
    {"nodes.count", {1, 3}, {0, 1, 384}},
    {"nodes.inserted", {1, 3}, {0x7fffffff, 0x80000000}},
    {"nodes.positions", {1, 3}, {0x7fffffff, 0x80000000}},
    {"nodes.tick", {1, 3}, {0, 0xffffffff}},
    {"node_table.count", first, {0, 1}},
    {"node_table.arcs", first, {0x7fffffff, 0x80000000}},
    {"sensors.tracks", {1, 2}, no},
    {"sensors.absent", {1, 2}, no},
    {"sensors.values", {1, 2}, {0x7fffffff, 0x80000000}},
    {"fault_log.codes", first, {0, 0xffff}},
    {"live.lane0", some, no},
    {"live.gap", some, {1, 100, 0x7fffffff}},
    {"live.backwards", {2, 20}, no},
    {"live.none", some, no},
    {"live.input", some, {1, 0x7fffffff}},
    {"live.states", some, {0x7fffffff, 0x80000000}},
    {"live.hands", some, no},
};

const std::vector<Kind> hid_kinds = {
    {"hid.silent", {1, 5, 300}, no},
    {"hid.busy_silence", {1, 5, 300}, no}, // answers at once that there is no data
    {"hid.flood_short", {1, 5, 300}, no},
    {"hid.flood_other_id", {1, 5, 300}, no},
    {"hid.flood_long", {1, 5}, no},
    {"hid.gone", {1, 5, 300}, no},
    {"hid.slow_ms", {1, 5}, {90, 190}},
    {"hid.tick", {1, 5, 300}, {0, 0x7fffffff, 0xffffffff}},
    {"hid.values", {1, 5, 300}, {0x7f, 0x80, 0xff}},
    {"hid.identity_short", first, no},
    {"hid.identity_long", first, no},
    {"hid.identity_id", first, no},
    {"hid.identity_hash", first, no},
    {"hid.identity_gone", first, no},
    {"hid.no_path", first, no},
    {"hid.names", first, no},
    {"hid.forbidden", first, no},
};

std::vector<Lie> all_of(std::initializer_list<const std::vector<Kind> *> tables)
{
    std::vector<Lie> lies;
    for (const auto *kinds : tables)
        for (const Kind &kind : *kinds)
            for (const unsigned at : kind.at)
                for (const unsigned value : kind.values) lies.push_back({kind.name, at, value});
    return lies;
}

unsigned number(const std::string &word)
{
    const std::string text = word.substr(word.find('=') + 1);
    try {
        std::size_t end = 0;
        const unsigned long value = std::stoul(text, &end);
        if (end == text.size() && value <= 0xffffffff) return static_cast<unsigned>(value);
    } catch (const std::exception &) {
    }
    throw std::invalid_argument("'" + word + "' has no number from 0 to 4294967295");
}

} // namespace

std::string line_of(const Lie &lie)
{
    return lie.name + " at=" + std::to_string(lie.at) + " value=" + std::to_string(lie.value);
}

Lie lie_of_line(const std::string &line)
{
    std::istringstream words(line);
    std::string word;
    Lie lie;
    words >> lie.name;
    bool is_known = false;
    for (const auto *kinds : {&frame_kinds, &field_kinds, &hid_kinds})
        for (const Kind &kind : *kinds) is_known = is_known || lie.name == kind.name;
    if (!is_known) throw std::invalid_argument("no lie is called '" + lie.name + "'; --list names them");
    while (words >> word) {
        if (word.rfind("at=", 0) == 0)
            lie.at = number(word);
        else if (word.rfind("value=", 0) == 0)
            lie.value = number(word);
        else
            throw std::invalid_argument("'" + word + "' is neither at= nor value=");
    }
    return lie;
}

std::vector<Lie> stream_lies()
{
    return all_of({&frame_kinds, &field_kinds});
}

std::vector<Lie> hid_lies()
{
    return all_of({&hid_kinds});
}

std::vector<Lie> spread_lies(const std::vector<Lie> &all, std::size_t count)
{
    std::vector<Lie> chosen;
    const std::size_t wanted = std::min(count, all.size());
    for (std::size_t i = 0; i < wanted; i++) chosen.push_back(all[i * all.size() / wanted]);
    return chosen;
}

} // namespace hil
