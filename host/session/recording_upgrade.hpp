// Converts recordings of protocol 4 (versions 2 and 3) to this program's version. Ticks, hashes and states
// are the same, so a replay ends with the same hash.
#pragma once
#include "host/session/recording.hpp"

namespace crn
{

// A cut-off recording stays cut off. Throws RecordingError for a recording that is damaged, already has this
// version, or was written with a wire schema other than the last one of protocol 4.
std::vector<std::uint8_t> upgraded_recording(std::span<const std::uint8_t> bytes, const std::string &name);

// Converts a file. The new file gets its name only when it is complete. Throws RecordingError, OutputError.
Recording upgrade_recording(const std::string &path, const std::string &new_path);

} // namespace crn
