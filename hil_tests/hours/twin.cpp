#include "hil_tests/hours/twin.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "host/session/set_up.hpp"

namespace hours
{

Twin::Twin(const crn::SceneFile &scene, const std::vector<crn::Instrument> &tools,
           const crn_wire_entry &entry)
    : pipe_(0), link_(pipe_)
{
    link_.hello();
    if (!scene.bytes.empty())
        hil::check(pipe_.share_scene(scene.bytes, scene.crc32), "the twin refuses the scene");
    crn::set_up_session(link_, {scene, tools, {}, entry, hil::plant_rig()});
}

void Twin::take(const crn_wire_live_tick &tick)
{
    inputs_.push_back(tick.input);
    states_.push_back(tick.state);
    if (inputs_.size() == crn::Link::steps_max) repeat();
}

void Twin::repeat()
{
    if (inputs_.empty()) return;
    const std::span<const crn_wire_tick_state> twins = link_.step(inputs_, false);
    for (std::size_t i = 0; i < states_.size(); i++) {
        const crn_wire_tick_state &state = states_[i], &twin = twins[i];
        hil::check(state.tick == twin.tick && state.hash_lane0 == twin.hash_lane0 &&
                       state.hash_lane1 == twin.hash_lane1,
                   "tick %u: hash %08x %08x, repeated %08x %08x", unsigned{state.tick},
                   unsigned{state.hash_lane0}, unsigned{state.hash_lane1}, unsigned{twin.hash_lane0},
                   unsigned{twin.hash_lane1});
    }
    inputs_.clear();
    states_.clear();
}

std::uint64_t Twin::finish(std::optional<std::uint64_t> hash)
{
    repeat();
    if (hash) {
        const std::uint64_t twin = link_.read_hash64().hash;
        hil::check(twin == *hash, "final hash %016llx, repeated %016llx",
                   static_cast<unsigned long long>(*hash), static_cast<unsigned long long>(twin));
    }
    return link_.tick();
}

} // namespace hours
