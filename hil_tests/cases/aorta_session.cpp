#include "hil_tests/cases/aorta_session.hpp"
#include "host/base/interrupt.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include "host/script/session.hpp"
#include "host/session/device.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

namespace hil
{

using Clock = std::chrono::steady_clock;

void set_up_aorta(crn::Link &link, const AortaFiles &files, const crn::Session &session,
                  const crn_wire_rig &rig)
{
    const crn::SceneFile scene = crn::read_scene(files.scene);
    crn::Instrument wire = crn::read_instrument(files.instrument);
    if (files.element_shaft_um > 0) wire.table.element_shaft_um = files.element_shaft_um;
    link.hello();
    link.load_scene(scene.bytes);
    link.load_tools({&wire.table, 1});
    link.set_entry(crn::entry_of(scene, 1, session.inserted_um));
    link.set_rig(rig);
}

std::unique_ptr<crn::TipPlaces> vessels_of(const AortaFiles &files)
{
    const std::string bodies = std::filesystem::path(files.scene).replace_extension(".bodies").string();
    return crn::read_tip_places(bodies, files.scene);
}

void look_at_aorta(crn::Link &link, const AortaFiles &files, const crn::TipPlaces &vessels,
                   crn::SessionPlayer &player, double inserted_m)
{
    std::vector<crn::TipPlace> tips;
    if (player.wants_tips()) {
        const crn::Instrument wire = crn::read_instrument(files.instrument);
        tips = vessels.at(crn::wire_frame(link.read_nodes(), link.node_table(), {&wire, 1}));
    }
    player.observe({{&inserted_m, 1}, tips, nullptr});
}

AortaRun run_aorta(crn::Transport &pipe, const AortaFiles &files, std::uint32_t ticks_max,
                   const std::function<double()> &instructions)
{
    const crn::Session session = crn::read_session(files.session);
    crn::Link link(pipe);
    set_up_aorta(link, files, session, crn::host_rig());
    link.use_lockstep();
    link.arm();
    link.start();
    AortaRun run;
    run.elements = static_cast<std::uint32_t>(link.node_table().arcs_m_q30_count) - 1;
    const std::unique_ptr<crn::TipPlaces> vessels = vessels_of(files);
    crn::SessionPlayer player(session, 1, &vessels->map());
    const std::uint32_t batch = instructions ? 1 : crn::SessionPlayer::observe_every_ticks;
    const Clock::time_point begin = Clock::now();
    std::vector<crn_wire_tick_input> inputs;
    double inserted_m = 0.0;
    while (!player.is_done() && link.tick() < ticks_max && !crn::is_interrupted()) {
        inputs.clear();
        while (inputs.size() < batch && link.tick() + inputs.size() < ticks_max && !player.is_done())
            inputs.push_back(player.next());
        const double before = instructions ? instructions() : 0.0;
        for (const crn_wire_tick_state &state : link.step(inputs, false)) {
            inserted_m = crn::units::metres(state.tools[0].inserted_m_q30);
            run.tick_solves.push_back(state.solve_count);
        }
        if (instructions) run.tick_instructions.push_back(instructions() - before);
        if (link.tick() % crn::SessionPlayer::observe_every_ticks == 0)
            look_at_aorta(link, files, *vessels, player, inserted_m);
    }
    run.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    run.ticks = link.tick();
    run.hash = link.read_hash64().hash;
    return run;
}

std::uint32_t shaft_of(const AortaFiles &files, std::uint32_t elements)
{
    const crn::Session session = crn::read_session(files.session);
    AortaFiles tried = files;
    std::uint32_t low_um = 1000, high_um = 8000; // too many elements, few enough
    while (high_um - low_um > 1) {
        tried.element_shaft_um = (low_um + high_um) / 2;
        crn::SimTransport pipe;
        crn::Link link(pipe);
        set_up_aorta(link, tried, session, crn::host_rig());
        link.arm();
        const bool is_few = link.node_table().arcs_m_q30_count <= elements + 1;
        (is_few ? high_um : low_um) = tried.element_shaft_um;
    }
    return high_um;
}

double quantile_of(std::vector<double> values, double quantile)
{
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    const auto rank = static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(values.size())));
    return values[std::max<std::size_t>(rank, 1) - 1];
}

} // namespace hil
