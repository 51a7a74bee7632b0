// Repeats a session of FREE_RUN on another device in LOCKSTEP while it runs: from the inputs that the stream
// reports, the twin must come to the same hash in every tick.
#pragma once
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/instrument.hpp"
#include "host/session/scene_file.hpp"
#include <optional>
#include <vector>

namespace hours
{

class Twin
{
  public:
    // The bytes of the scene must exist as long as the twin.
    Twin(const crn::SceneFile &scene, const std::vector<crn::Instrument> &tools, const crn_wire_entry &entry);
    void take(const crn_wire_live_tick &tick); // throws hil::Failure
    // Compares the hash over the whole state, if the device has one. Returns the number of ticks. Throws
    // hil::Failure.
    std::uint64_t finish(std::optional<std::uint64_t> hash);

  private:
    void repeat();

    crn::SimTransport pipe_;
    crn::Link link_;
    std::vector<crn_wire_tick_input> inputs_;
    std::vector<crn_wire_tick_state> states_;
};

} // namespace hours
