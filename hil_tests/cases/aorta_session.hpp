// Runs the aorta session of `make run` on a device that is connected by any kind of pipe. The functions of
// this header report the state hash and the cost of every tick of the session.
#pragma once
#include "host/link/link.hpp"
#include "host/script/session.hpp"
#include "host/script/tip_places.hpp"
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hil
{

struct AortaFiles {
    std::string scene = "out/aorta.scene";
    std::string instrument = "shared/examples/instruments/j_wire.toml";
    std::string session = "shared/examples/sessions/demo.session";
    std::uint32_t element_shaft_um = 0; // longest element of the wire; 0: the value of its file
};

struct AortaRun {
    std::uint32_t ticks = 0;
    std::uint64_t hash = 0;
    std::uint32_t elements = 0;
    double seconds = 0.0;                  // of wall-clock time, without set-up
    std::vector<double> tick_instructions; // per tick, where they are counted
    std::vector<std::uint16_t> tick_solves;
};

// Takes the device from HELLO to READY with the session's scene, wire and entry.
void set_up_aorta(crn::Link &link, const AortaFiles &files, const crn::Session &session,
                  const crn_wire_rig &rig);

// Returns the vessels whose names the session script uses for steering. The vessels are read from the file of
// bodies that lies beside the scene file.
std::unique_ptr<crn::TipPlaces> vessels_of(const AortaFiles &files);
// Reads the wire's shape from the device if the session script needs it at this tick, and passes it to the
// script's player.
void look_at_aorta(crn::Link &link, const AortaFiles &files, const crn::TipPlaces &vessels,
                   crn::SessionPlayer &player, double inserted_m);

// Runs the session. If the function `instructions` is given, it must return the number of processor
// instructions that the device has executed so far, and every request to the device computes only one tick.
// Without `instructions`, every request computes as many ticks as possible.
AortaRun run_aorta(crn::Transport &pipe, const AortaFiles &files, std::uint32_t ticks_max,
                   const std::function<double()> &instructions = {});

// Returns an element length for the wire's shaft, in um, at which the wire has at most `elements` elements.
std::uint32_t shaft_of(const AortaFiles &files, std::uint32_t elements);

// Returns the given quantile (0 to 1) of `values`; 0.5 gives the median.
double quantile_of(std::vector<double> values, double quantile);

} // namespace hil
