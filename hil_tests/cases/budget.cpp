#include "hil_tests/cases/budget.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include "host/base/interrupt.hpp"
#include "host/script/hand_motion.hpp"
#include "host/script/session.hpp"
#include "host/session/device.hpp"
#include <algorithm>

namespace hil
{

AortaRun count_aorta(const AortaFiles &files, std::uint32_t ticks_max)
{
    crn::Emulator emulator({.icount_shift = 7});
    crn::EmulatedTransport pipe(emulator);
    rig_page &page = emulator.page();
    std::uint32_t last = 0;
    double sum = 0.0;
    return run_aorta(pipe, files, ticks_max, [&] {
        const auto is_idle = [&] {
            return rig_read(&page.device.to_device_tail) == page.host.to_device_head;
        };
        emulator.wait(is_idle, "the end of a step");
        const std::uint32_t now = rig_read(&page.device.receive_counts);
        sum += emulator.instructions(now - last);
        last = now;
        return sum;
    });
}

std::size_t Overruns::count() const
{
    return static_cast<std::size_t>(
        std::count_if(edge_us.begin(), edge_us.end(), [](double us) { return us > 1000.0; }));
}

double Overruns::worst_us() const
{
    return edge_us.empty() ? 0.0 : *std::max_element(edge_us.begin(), edge_us.end());
}

Overruns overruns_of_aorta(const AortaFiles &files, int icount_shift, std::uint32_t ticks_max)
{
    const crn::Session session = crn::read_session(files.session);
    EmulatedBench bench({}, {.icount_shift = icount_shift});
    crn::Link link(bench.pipe());
    set_up_aorta(link, files, session, plant_rig());
    start_free_run(bench, link);
    const std::unique_ptr<crn::TipPlaces> vessels = vessels_of(files);
    crn::SessionPlayer player(session, 1, &vessels->map());
    Overruns result;
    double inserted_m = 0.0;
    crn_wire_hand before{};
    Plant::Track &track = bench.plant().track(0);
    while (!player.is_done() && result.edge_us.size() < ticks_max && !crn::is_interrupted()) {
        const crn_wire_hand hand = player.next().hands[0];
        track.translation.move_hand((hand.translation_counts - before.translation_counts) * 1e3 /
                                    crn::counts_per_m);
        track.rotation.move_hand((hand.rotation_counts - before.rotation_counts) * 1e3 * 6.283185307179586 /
                                 crn::counts_per_turn);
        before = hand;
        bench.advance(1);
        result.edge_us.push_back(bench.emulator().page().device.edge_counts * crn::Emulator::count_ns * 1e-3);
        if (result.edge_us.size() % 8 == 0) keep_talking(link);
        if (result.edge_us.size() % crn::SessionPlayer::observe_every_ticks != 0) continue;
        inserted_m = link.read_nodes().inserted_m_q30[0] * 0x1p-30;
        look_at_aorta(link, files, *vessels, player, inserted_m);
    }
    check(link.read_status().state == CRN_WIRE_STATE_RUNNING, "the session ended by itself after %zu ticks",
          result.edge_us.size());
    return result;
}

} // namespace hil
