// Repeats the computation of a rig's session on this machine's core at the same time, and accepts the rig's
// results only if both results agree. The recording therefore cannot contain a hash, snapshot or picture from
// a device that is broken, sends false data, or computes with faulty memory. The command `replay --verify`
// would find wrong results of the rig later, whereas the class Witness finds them before they are recorded.
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
    // Sets up this machine's core in the same way in which a replay sets up its device. `who` is the name by
    // which messages refer to the rig. Throws LinkError.
    Witness(const SceneFile &scene, const std::vector<Instrument> &tools, const LineNumbers &line,
            const crn_wire_entry &entry, const crn_wire_rig &rig, const std::string &who);

    // The functions of this class throw LinkError if the rig's results differ; the message gives the tick,
    // both values and the remedy. In LOCKSTEP the complete results are compared, and also the shape of the
    // tools if it was requested (otherwise `nodes` is nullptr).
    void step(std::span<const crn_wire_tick_input> inputs, std::span<const crn_wire_tick_state> states,
              const crn_wire_nodes *nodes);
    // In FREE_RUN only the hashes are compared, because only the rig computes the forces of its motors.
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    // Compares the rig's hash of the present tick, or of one of the last multiples of 100, with the hash that
    // this machine's core computed.
    void hash(const Hash64 &told);
    // Compares the rig's snapshot of the present tick, from which the session may continue later, with the
    // snapshot of this machine's core. In LOCKSTEP every byte of the snapshot is compared; in FREE_RUN only
    // the core's state in it is compared.
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

// Returns the version of the core on this machine.
std::uint32_t own_core_version();

} // namespace crn
