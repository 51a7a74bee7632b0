// Repeats a rig's session on this machine's core in parallel, and accepts the rig's results only where both
// agree. So no hash, snapshot or picture of a device that lies, is broken, or computes with damaged memory
// gets into a recording. The witness finds before writing what `replay --verify` would find later.
#pragma once
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/instrument.hpp"
#include "host/session/scene_file.hpp"
#include <deque>
#include <span>
#include <string>
#include <vector>

namespace crn
{

class Witness
{
  public:
    // Sets up a core as replay sets its device up. `who` is the rig's name in messages. Throws LinkError.
    Witness(const SceneFile &scene, const std::vector<Instrument> &tools, const crn_wire_entry &entry,
            const crn_wire_rig &rig, const std::string &who);

    // Each throws LinkError with tick, both values and the remedy when the rig reports something else. In
    // LOCKSTEP whole results are compared, and the line's shape where it was requested (`nodes`, else
    // nullptr).
    void step(std::span<const crn_wire_tick_input> inputs, std::span<const crn_wire_tick_state> states,
              const crn_wire_nodes *nodes);
    // In FREE_RUN the hashes are compared; forces of motors are the rig's own.
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    // Compares the hash of the present tick, or of one of the last multiples of 100 ticks.
    void hash(const Hash64 &told);
    // Compares the snapshot of the present tick, from which the session may continue. In LOCKSTEP every byte
    // counts; otherwise the core's state in it.
    void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes, bool is_lockstep);
    void restore(std::span<const std::uint8_t> bytes);
    std::uint32_t tick() const { return link_.tick(); }

  private:
    static constexpr std::size_t hashes_kept = 64; // one every 100 ticks

    void keep_hash();
    [[noreturn]] void differ(const char *what, std::uint32_t tick, const std::string &told,
                             const std::string &ours) const;

    SimTransport pipe_;
    Link link_;
    std::string who_;
    std::deque<Hash64> hashes_;
};

// Returns the core's version on this machine.
std::uint32_t own_core_version();

} // namespace crn
