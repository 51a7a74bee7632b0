#include "tools/chip/twin.hpp"
#include "host/session/set_up.hpp"
#include <algorithm>

namespace chip
{

Twin::Twin(ChipDevice &chip, const TwinSetUp &set_up)
    : chip_(chip), scene_(crn::read_scene(set_up.scene)),
      line_(crn::line_or_table(set_up.line, set_up.tools.size())), there_pipe_(chip.open()),
      here_(here_pipe_), there_(*there_pipe_)
{
    here_pipe_.share_scene(scene_.bytes, scene_.crc32);
    for (crn::Link *link : {&here_, &there_}) {
        link->hello();
        crn::set_up_session(*link, {scene_, set_up.tools, line_, set_up.entry, set_up.rig});
    }
    chip_.find_scene(scene_.bytes);
}

std::span<const crn_wire_tick_state> Twin::advance(std::span<const crn_wire_tick_input> inputs)
{
    return here_.step(inputs, false);
}

std::optional<PricedTick> Twin::price(const crn_wire_tick_input &before, const crn_wire_tick_input &input)
{
    const std::span<std::uint8_t> bytes =
        chip_.processor().memory_of("chip_in").first(crn::SimTransport::snapshot_bytes());
    if (!here_pipe_.take_snapshot(bytes)) throw PriceError("the session has ended before this tick");
    if (chip_.processor().call("chip_restore") == 0) {
        advance({&before, 1});
        advance({&input, 1});
        return {};
    }
    there_.continue_at(here_.tick());
    chip_.price(true);
    chip_.pricer().keep_spent(false);
    there_.step({&before, 1}, false);
    chip_.pricer().take_ticks();
    chip_.pricer().take_rest();
    chip_.pricer().keep_spent(true);
    PricedTick result{there_.step({&input, 1}, false).front(), {}, {}};
    chip_.price(false);
    const std::vector<TickPrice> prices = chip_.pricer().take_ticks();
    advance({&before, 1});
    const crn_wire_tick_state here = advance({&input, 1}).front();
    if (prices.size() != 1 || here.hash_lane0 != result.state.hash_lane0 ||
        here.hash_lane1 != result.state.hash_lane1)
        throw PriceError("the emulated processor computes another state than this process; build both anew");
    result.price = prices.front();
    result.around = chip_.pricer().take_rest();
    return result;
}

TwinSetUp set_up_of(const crn::Recording &recording)
{
    const crn::RecordingHeader &header = recording.header;
    return {header.scene_path, header.tools, header.line, header.entry, header.rig};
}

std::vector<PricedTick> price_recording(ChipDevice &chip, const crn::Recording &recording,
                                        const std::vector<std::uint32_t> &ticks)
{
    Twin twin(chip, set_up_of(recording));
    std::vector<PricedTick> priced;
    std::vector<crn_wire_tick_input> inputs;
    for (const std::uint32_t tick : ticks) {
        while (twin.tick() + 2 < tick) {
            inputs.clear();
            for (std::uint32_t at = twin.tick(); at + 2 < tick && inputs.size() < crn::Link::steps_max; at++)
                inputs.push_back(recording.ticks[at].input);
            twin.advance(inputs);
        }
        const auto one = twin.price(recording.ticks[tick - 2].input, recording.ticks[tick - 1].input);
        if (!one) throw PriceError("the core refuses a state of the recording; make it anew");
        priced.push_back(*one);
        const crn::RecordedTick &recorded = recording.ticks[tick - 1];
        if (priced.back().state.hash_lane0 != recorded.hash_lane[0])
            throw PriceError("the recording was made by another core; make it anew");
    }
    return priced;
}

} // namespace chip
