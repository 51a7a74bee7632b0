// Defines the actions that a person can carry out in the X-ray room: pedals, geometry, modes and review. For
// the X-ray room, a session is a list of these commands with their ticks; nothing else determines what the
// room does (docs/room.md). The values of a command are whole numbers, so that a recording contains them
// exactly.
#pragma once
#include "host/base/state_archive.hpp"
#include <cstdint>
#include <string>

namespace crn
{

// Recordings contain the numbers of these actions, so the meaning of a number must never change.
enum class RoomAction : std::uint16_t {
    fluoro_pedal = 1,  // 1 down, 0 up
    acquire_pedal = 2, // 1 down, 0 up: acquires a run of the selected program
    program = 3,       // 0 cine, 1 DSA
    fluoro_rate = 4,   // 1/100 pulses per s: 375, 750, 1500, 3000
    cine_rate = 5,     // 1/100 frames per s: 750, 1500, 3000
    dsa_rate = 6,      // 1/100 frames per s: 50, 100, 200, 300, 600, 750
    angles = 7, // patient point at the isocentre, um: patient left, head, anterior; ends following of the tip
    table = 8,  // 1: the table follows, and brings the tip back when it leaves the middle of the field
    follow = 9, // 1: the table brings the tip back when it leaves the middle of the field
    field = 10, // width of the square field at the detector, um
    distance = 11, // source to detector (SID), source to isocentre (SOD), um
    blades = 12,   // open width, open height, 1/1000 of the field
    iris = 13,     // keep the last so many ms of fluoroscopy as a run
    store = 14,    // keep the last so many ms of fluoroscopy as a run
    mask = 15,     // of the DSA run shown: first, last frame from 0; their mean is the mask
    shift = 16,    // of the mask: to the right, upwards, 1/100 pixel; always relative to its acquired place
    roadmap = 17,  // 0 off, 1 of the last DSA run, 2 of the next press of the fluoroscopy pedal
    review = 18,   // 0 off, 1 loop, 2 one frame; run number (0: the last); frame from 0
    acknowledge = 19, // the dose alert was acknowledged
    halt = 20,        // every motor stops where it is
    // The X-ray room passes the commands below, which are for the syringe, to host/patient/contrast.hpp.
    inject = 21, // ul (0: stop), ul/s, tool from the innermost 1 ... (0: the outermost with a lumen)
    contrast_strength = 22, // mg iodine per ml of the fluid injected from now on
    load_stent = 23,        // loads the next one onto the balloon: host/patient/stents.hpp
    aspirate = 24, // ul of blood through the outermost tool with a lumen: host/patient/catheter_air.hpp
    // What the vessels bear (host/complications/limits.hpp).
    complications = 25,      // 1: walls are dissected and perforated, 0: they bear everything
    complication_limit = 26, // number of the limit, its value in thousandths
};

struct RoomCommand {
    RoomAction action = RoomAction::halt;
    std::int32_t values[3] = {0, 0, 0};

    bool operator==(const RoomCommand &) const = default;
};

// Describes a command to the X-ray room that was not carried out, with its tick and the reason.
struct Refusal {
    std::uint32_t tick = 0;
    std::string why;
};

// Returns the reason why a command is impossible in every state of the room (an unknown action, or a value
// out of range), or an empty string if it is possible. In some states the room may also refuse possible
// commands, for example a review when there is no run. If a command is possible but the present state of the
// room forbids it, class Room reports the refusal when it happens.
std::string refusal(const RoomCommand &command);

// Saves or restores a command. An archive with a command that refusal() does not allow is refused.
void archive_command(StateArchive &state, RoomCommand &command);
void archive_refusal(StateArchive &state, Refusal &refusal);

// The values of commands to the X-ray room must lie within the limits below, whether they come from a script,
// a key or a recording.
inline constexpr std::int32_t primary_max_mdeg = 120'000, secondary_max_mdeg = 50'000;
inline constexpr std::int32_t table_max_um = 1'900'000;
inline constexpr std::int32_t field_min_um = 100'000, field_max_um = 450'000;
inline constexpr std::int32_t sid_min_um = 900'000, sid_max_um = 1'300'000;
inline constexpr std::int32_t sod_min_um = 600'000, sod_max_um = 850'000;
inline constexpr std::int32_t blade_min_permille = 50, blade_max_permille = 1000;
inline constexpr std::int32_t shift_max_centipixels = 2'000;
inline constexpr std::int32_t inject_max_ul = 200'000, inject_rate_max_ul_s = 50'000;
inline constexpr std::int32_t complication_limit_count = 24, complication_max_milli = 100'000'000;
inline constexpr std::int32_t aspirate_max_ul = 50'000;
inline constexpr std::int32_t strength_min_mg_ml = 10, strength_max_mg_ml = 350;
inline constexpr std::int32_t store_min_ms = 500, store_max_ms = 20'000;
inline constexpr std::int32_t fluoro_rates_centihertz[] = {375, 750, 1500, 3000};
inline constexpr std::int32_t cine_rates_centihertz[] = {750, 1500, 3000};
inline constexpr std::int32_t dsa_rates_centihertz[] = {50, 100, 200, 300, 600, 750};

} // namespace crn
