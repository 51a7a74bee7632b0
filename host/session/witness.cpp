#include "host/session/witness.hpp"
#include "host/base/number_text.hpp"
#include "host/session/set_up.hpp"
#include <algorithm>

namespace crn
{

namespace
{

std::string lanes(const crn_wire_tick_state &state)
{
    return hex_text(std::uint64_t{state.hash_lane0} << 32 | state.hash_lane1);
}

std::string line_text(const crn_wire_tick_state &state)
{
    std::string text = "tools";
    for (const std::uint8_t number : line_of(state)) text += " " + std::to_string(number);
    return text + ", answer " + std::to_string(state.exchange);
}

template <class Message, class Put> std::vector<std::uint8_t> bytes_of(const Message &message, Put put)
{
    std::vector<std::uint8_t> bytes(CRN_WIRE_PAYLOAD_MAX);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    put(&writer, &message);
    bytes.resize(writer.length);
    return bytes;
}

std::string place_of_difference(const std::vector<std::uint8_t> &a, const std::vector<std::uint8_t> &b)
{
    const auto at = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin();
    return std::to_string(a.size()) + " bytes, another one at byte " + std::to_string(at);
}

} // namespace

std::uint32_t own_core_version()
{
    SimTransport pipe(0);
    return Link(pipe).hello().core_version;
}

Witness::Witness(const SceneFile &scene, const std::vector<Instrument> &tools, const LineNumbers &line,
                 const crn_wire_entry &entry, const crn_wire_rig &rig, const std::string &who)
    : link_(pipe_), who_(who)
{
    link_.hello();
    set_up_session(link_, {scene, tools, line, entry, rig});
}

void Witness::differ(const char *what, std::uint32_t tick, const std::string &told,
                     const std::string &ours) const
{
    throw LinkError(
        who_ + " says a false " + what + " of tick " + std::to_string(tick) + ": " + told +
        ", and this machine's core has " + ours +
        ". What was recorded before is true. Remedy: cournand rig selftest; install this release's "
        "firmware; if it stays so, do not use the rig");
}

void Witness::keep_hash()
{
    const std::optional<Hash64> hash = link_.last_hash64();
    if (!hash || (!hashes_.empty() && hashes_.back().tick == hash->tick)) return;
    hashes_.push_back(*hash);
    if (hashes_.size() > hashes_kept) hashes_.pop_front();
}

void Witness::step(std::span<const crn_wire_tick_input> inputs, std::span<const crn_wire_tick_state> states,
                   const crn_wire_nodes *nodes)
{
    const auto ours = link_.step(inputs, nodes != nullptr);
    for (std::size_t i = 0; i < states.size(); i++) {
        if (ours[i].hash_lane0 != states[i].hash_lane0 || ours[i].hash_lane1 != states[i].hash_lane1)
            differ("hash", ours[i].tick, lanes(states[i]), lanes(ours[i]));
        const auto told = bytes_of(states[i], crn_wire_put_tick_state),
                   own = bytes_of(ours[i], crn_wire_put_tick_state);
        if (told != own) differ("result", ours[i].tick, place_of_difference(told, own), "its own");
    }
    keep_hash();
    if (nodes == nullptr) return;
    const auto told = bytes_of(*nodes, crn_wire_put_nodes), own = bytes_of(link_.nodes(), crn_wire_put_nodes);
    if (told != own) differ("shape", link_.tick(), place_of_difference(told, own), "its own");
}

void Witness::tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state)
{
    const crn_wire_tick_state ours = link_.step({&input, 1}, false).front();
    if (ours.tick != state.tick)
        differ("tick", ours.tick, std::to_string(state.tick), std::to_string(ours.tick));
    if (ours.hash_lane0 != state.hash_lane0 || ours.hash_lane1 != state.hash_lane1)
        differ("hash", ours.tick, lanes(state), lanes(ours));
    if (line_of(ours) != line_of(state) || ours.exchange != state.exchange)
        differ("line of tools", ours.tick, line_text(state), line_text(ours));
    keep_hash();
}

void Witness::hash(const Hash64 &told)
{
    if (told.tick == link_.tick()) {
        const Hash64 ours = link_.read_hash64();
        if (ours.hash != told.hash) differ("full hash", told.tick, hex_text(told.hash), hex_text(ours.hash));
        return;
    }
    for (const Hash64 &ours : hashes_) {
        if (ours.tick != told.tick) continue;
        if (ours.hash != told.hash) differ("full hash", told.tick, hex_text(told.hash), hex_text(ours.hash));
        return;
    }
    differ("full hash", told.tick, hex_text(told.hash),
           "none of that tick: " + std::to_string(link_.tick()) + " are done, and one comes every 100");
}

void Witness::snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes, bool is_lockstep)
{
    if (tick != link_.tick())
        differ("snapshot", tick, "of that tick", std::to_string(link_.tick()) + " ticks done");
    if (is_lockstep) {
        const std::vector<std::uint8_t> ours = link_.read_snapshot(), told(bytes.begin(), bytes.end());
        if (told != ours) differ("snapshot", tick, place_of_difference(told, ours), "its own");
        return;
    }
    // The first part of the snapshot describes the rig's own hands and motors, which the core on this machine
    // does not have. The effect of the hands and motors is checked by the hashes of the following ticks.
    const std::uint64_t before = link_.read_hash64().hash;
    restore(bytes);
    const std::uint64_t after = link_.read_hash64().hash;
    if (link_.tick() != tick || after != before) differ("snapshot", tick, hex_text(after), hex_text(before));
}

void Witness::restore(std::span<const std::uint8_t> bytes)
{
    link_.stop();
    link_.write_snapshot(bytes);
    link_.start();
}

} // namespace crn
