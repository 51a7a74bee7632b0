// This header runs the aorta session of `make run` on a device at the other end of any pipe, tick by tick,
// and reports hashes and the cost of a tick.
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

// Returns the vessels whose names the session uses for steering. They are read from the file of bodies that
// lies beside the scene file.
std::unique_ptr<crn::TipPlaces> vessels_of(const AortaFiles &files);
// Reads from the device the state by which the session decides when it checks the tip.
void look_at_aorta(crn::Link &link, const AortaFiles &files, const crn::TipPlaces &vessels,
                   crn::SessionPlayer &player, double inserted_m);

// Runs the session. When `counts` is given, which returns the instructions spent so far, each step is one
// tick; otherwise steps are as long as possible.
AortaRun run_aorta(crn::Transport &pipe, const AortaFiles &files, std::uint32_t ticks_max,
                   const std::function<double()> &instructions = {});

// Returns the shaft's element length in um that gives the wire at most this many elements.
std::uint32_t shaft_of(const AortaFiles &files, std::uint32_t elements);

// Returns the value that a share `quantile` of the values does not exceed.
double quantile_of(std::vector<double> values, double quantile);

} // namespace hil
