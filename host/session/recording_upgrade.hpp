// Converts recordings of the wire protocols 4, 5 and 6 (versions 2 to 5 of the file format) to this program's
// version.
// The conversion does not change ticks, hashes and states, so a replay of the converted recording ends with
// the hash of the original session.
#pragma once
#include "host/session/recording.hpp"

namespace crn
{

// If the old recording was cut off, the converted recording is cut off too. Throws RecordingError if the
// recording is damaged, already has this program's version, or has a schema other than that of protocol 5 or
// 6 or the last one of protocol 4.
std::vector<std::uint8_t> upgraded_recording(std::span<const std::uint8_t> bytes, const std::string &name);

// Converts a file. The new file gets its final name only when it is complete. Throws RecordingError,
// OutputError.
Recording upgrade_recording(const std::string &path, const std::string &new_path);

} // namespace crn
