// The session of a rig once more, on this machine's core beside it: what a rig says is only believed where
// both agree, so that no hash, snapshot or picture of a device that lies, is broken, or computes with damaged
// memory gets into a recording. It is what `replay --verify` would find out later, found out before it is
// written.
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
    // As replay sets its device up. `who` is the rig in messages. Throws LinkError.
    Witness(const SceneFile &scene, const std::vector<Instrument> &tools, const crn_wire_entry &entry,
            const crn_wire_rig &rig, const std::string &who);

    // Each throws LinkError that names tick, both values and what to do when the rig says something else.
    // LOCKSTEP: whole results, and the line's shape where it was asked for (`nodes`, else nullptr).
    void step(std::span<const crn_wire_encoders> inputs, std::span<const crn_wire_tick_state> states,
              const crn_wire_nodes *nodes);
    // FREE_RUN: the hashes; forces of motors are the rig's own.
    void tick(const crn_wire_encoders &input, const crn_wire_tick_state &state);
    // Of the present tick, or of one of the last hundreds.
    void hash(const Hash64 &told);
    // Of the present tick, which the session may go on from. LOCKSTEP: every byte; else the core's state in
    // it.
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

// The release of the core on this machine.
std::uint32_t own_core_version();

} // namespace crn
