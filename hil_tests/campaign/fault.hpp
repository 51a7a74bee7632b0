// Faults on purpose; one line names each of them completely:
//
//   link.flip session=lockstep way=to_host frame=12 bit=37 seed=1
//   rig.encoder_jump session=free_run tick=33 um=7000 seed=1
//
// Every kind of fault belongs to one of the groups link, host, device and rig. A fault happens either at the
// n-th frame that goes in the given direction, or at the tick with the given number. Frames and ticks are
// numbered from the START message, or, if the fault's line of text contains `session=setup`, from the first
// HELLO message. A fault has at most one parameter, its `value`.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace hil
{

enum class Session { setup, lockstep, free_run };

struct FaultKind {
    const char *name;
    const char *when;  // "frame" or "tick"
    const char *value; // name of the value, or NULL
};

struct Fault {
    const FaultKind *kind = nullptr;
    Session session = Session::lockstep;
    bool to_host = false; // direction of the frame: from the device to the host
    std::uint32_t at = 1;
    std::uint32_t value = 0;
    std::uint32_t seed = 1;
    bool is(const char *name) const;
    bool is_group(const char *prefix) const; // "link."
};

std::span<const FaultKind> fault_kinds();
std::string line_of(const Fault &fault);
// Makes a Fault from a line of text in the format that line_of() writes. Throws std::invalid_argument if a
// word of the line is unknown; the message contains that word.
Fault fault_of(const std::string &line);

// Returns a list of all faults of the campaign without repetitions, in a fixed order.
std::vector<Fault> all_faults();
// Selects `count` of the given faults so that every kind of fault is represented.
std::vector<Fault> spread_of(const std::vector<Fault> &faults, std::size_t count);

// The following constants number the lies, which are false messages of a device. Most lies can be applied to
// any frame; lies 9 to 11 change the message `set_up`, which is the third frame of a set-up.
inline constexpr std::uint32_t lies = 9, lie_scene_is_there = 9, lie_scene_is_another = 10,
                               lie_upload_is_there = 11, set_up_frame = 3;
inline constexpr std::uint32_t second_actions = 7, hostile_types = 14;
inline constexpr std::uint32_t lockstep_ticks = 40, free_ticks = 120;

} // namespace hil
