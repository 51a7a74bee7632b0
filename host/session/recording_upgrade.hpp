// Converts recordings of protocol 4 (versions 2 and 3) to this program's version. Ticks, hashes and states
// stay the same, so a replay ends with the same hash.
#pragma once
#include "host/session/recording.hpp"

namespace crn
{

// A recording that was cut off stays cut off. Throws RecordingError for a recording that is damaged, that
// already has this version, or whose schema of the byte protocol is not the last one of protocol 4.
std::vector<std::uint8_t> upgraded_recording(std::span<const std::uint8_t> bytes, const std::string &name);

// Converts a file. The new file gets its final name only when it is complete. Throws RecordingError,
// OutputError.
Recording upgrade_recording(const std::string &path, const std::string &new_path);

} // namespace crn
