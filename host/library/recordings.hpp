// Holds recordings for the API, as they were read from their files.
#pragma once
#include "host/library/handles.hpp"
#include "host/library/world.hpp"

namespace crn::library
{

void describe(const Recording &recording, cournand_recording_info &info);
void copy_inputs(const Recording &recording, std::uint32_t first, std::span<cournand_input> inputs);
// Returns the settings of a world in which the recording can be replayed. Throws Refused if the scene is not
// that of the recording.
WorldSettings settings_of(const Recording &recording, std::shared_ptr<const Scene> scene,
                          std::uint32_t flags);

template <> struct HandleOf<cournand_recording> {
    using Object = Recording;
    static constexpr HandleKind kind = HandleKind::recording;
    static constexpr char name[] = "recording";
};

} // namespace crn::library
