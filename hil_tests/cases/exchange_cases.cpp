// Tests random exchanges of tools, legal and illegal. Random exchanges must give the same answers and state
// hashes at this test level as on the host alone, and no order may cause a fault or put a tool into the wall.
#include "firmware/tests/reference/random.h"
#include "hil_tests/cases/conversation.hpp"
#include "host/link/sim_transport.hpp"
#include <array>

namespace hil
{

namespace
{

constexpr std::uint64_t seed = 20261126;
constexpr std::uint32_t batch_ticks = 16;
constexpr double wall_max_mm = 1.0; // cournand run stops a session beyond it
constexpr std::size_t positions = 3, tools_count = 8;

// Returns a straight tool of 300 mm: a solid wire, or a tube.
crn_wire_instrument tool_of(std::uint32_t bend_nN_m2, std::uint32_t outer_um, std::uint32_t bore_um,
                            std::uint32_t whole_um)
{
    crn_wire_instrument tool{};
    tool.axial_stiffness_max_N = 5000;
    tool.element_tip_um = 2000;
    tool.element_shaft_um = 4000;
    tool.element_fine_um = 20000;
    tool.lumen_friction_milli = bore_um > 0 ? 50 : 0;
    tool.whole_um = whole_um;
    tool.knots_count = 2;
    for (std::uint32_t i = 0; i < 2; i++) {
        tool.knots[i].arc_um = i * 300000;
        tool.knots[i].bend_stiffness_nN_m2 = bend_nN_m2;
        tool.knots[i].twist_stiffness_nN_m2 = bend_nN_m2 / 5 * 4;
        tool.knots[i].mass_mg_per_m = 4000;
        tool.knots[i].radius_outer_um = outer_um;
        tool.knots[i].radius_inner_um = bore_um;
        tool.knots[i].friction_kinetic_milli = 100;
        tool.knots[i].friction_static_milli = 120;
    }
    return tool;
}

void set_up_table(crn::Link &link)
{
    const std::array<crn_wire_instrument, tools_count> tools = {
        tool_of(60000, 178, 0, 3000000),    tool_of(20000, 178, 0, 400000),
        tool_of(10000, 450, 210, 400000),   tool_of(15000, 460, 210, 400000),
        tool_of(300000, 1040, 900, 300000), tool_of(200000, 1040, 700, 300000),
        tool_of(100000, 400, 0, 2600000),   tool_of(30000, 600, 430, 0)};
    const std::array<std::uint8_t, positions> line = {1, 0, 5};
    link.hello();
    link.load_scene(tube_scene());
    link.load_tools(tools, line);
    crn_wire_entry entry{};
    entry.direction_x_q30 = 1 << 30;
    entry.inserted_um_count = positions;
    entry.inserted_um[0] = 30000;
    entry.inserted_um[2] = 20000;
    link.set_entry(entry);
    link.set_rig(crn::host_rig());
}

struct Exchanges {
    Ending ending;
    std::uint32_t done = 0, refused = 0;
    std::array<std::uint32_t, CRN_WIRE_EXCHANGE_BURST + 1> answers{};
    double wall_mm = 0.0;
};

// Every tick has an order. Each random hand keeps its speed for some ticks, so that the tools really advance
// and withdraw.
class RandomHands
{
  public:
    crn_wire_tick_input next()
    {
        crn_wire_tick_input input{};
        input.hands_count = positions;
        for (std::size_t k = 0; k < positions; k++) {
            if (below(100) == 0) speed_[k] = static_cast<std::int32_t>(below(800)) - 400;
            at_[k] += speed_[k];
            input.hands[k] = {at_[k], at_[k] / 4};
        }
        const auto position = static_cast<std::uint8_t>(below(positions));
        const auto tool = static_cast<std::uint8_t>(below(tools_count + 1));
        input.orders.items_count = 1;
        input.orders.items[0] = crn_wire_order_of_exchange({position, tool});
        return input;
    }

  private:
    std::uint32_t below(std::uint32_t bound) { return reference_random_below(&random_, bound); }

    reference_random random_ = reference_random_seed(seed);
    std::array<std::int32_t, positions> at_{}, speed_{};
};

Exchanges exchanges_on(crn::Link &link, std::uint32_t ticks)
{
    Exchanges result;
    RandomHands hands;
    set_up_table(link);
    result.ending =
        lockstep_session(link, ticks, batch_ticks, {}, [&](std::uint32_t) { return hands.next(); });
    for (const crn_wire_tick_state &state : result.ending.states) {
        result.answers.at(state.exchange)++;
        (state.exchange == CRN_WIRE_EXCHANGE_DONE ? result.done : result.refused)++;
        result.wall_mm = std::max(result.wall_mm, state.penetration_max_m_q30 / 1073741824.0 * 1e3);
    }
    return result;
}

void random_exchanges_give_the_hash_of_the_host_alone(Level &level, const CaseOptions &options,
                                                      Report &report)
{
    const auto bench = level.make({});
    crn::Link link(bench->pipe());
    const Exchanges here = exchanges_on(link, options.ticks);
    crn::SimTransport pipe;
    crn::Link alone(pipe);
    const Exchanges there = exchanges_on(alone, options.ticks);
    check_same(there.ending, here.ending, "host alone and this level");
    check(here.answers == there.answers, "the answers to exchanges differ");
    check(here.wall_mm < wall_max_mm, "a tool is %.2f mm in the wall", here.wall_mm);
    check(here.done > 0 && here.refused > 0, "%u exchanges done, %u refused", here.done, here.refused);
    const crn_wire_fault_log faults = link.read_fault_log();
    for (std::uint16_t i = 0; i < faults.entries_count; i++)
        check(faults.entries[i].code != CRN_FAULT_CODE_INTERNAL &&
                  faults.entries[i].code != CRN_FAULT_CODE_CORE_SATURATED,
              "fault %s", crn_wire_fault_name(faults.entries[i].code));
    report.add(text("%u orders, %u carried out, %.2f mm in the wall at most, hash %016llx",
                    here.done + here.refused, here.done, here.wall_mm,
                    static_cast<unsigned long long>(here.ending.hash)));
}

constexpr Case exchange_list[] = {
    {"random_exchanges_give_the_hash_of_the_host_alone", random_exchanges_give_the_hash_of_the_host_alone},
};

} // namespace

std::span<const Case> exchange_cases()
{
    return exchange_list;
}

} // namespace hil
