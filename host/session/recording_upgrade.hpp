// Recordings of protocol 4 (versions 2 and 3), made into recordings of this program's version: the same
// ticks, hashes and states, so that a replay ends with the same hash.
#pragma once
#include "host/session/recording.hpp"

namespace crn
{

// What was cut off stays cut off. Throws RecordingError for what is damaged, has this version already, or was
// written with another wire schema than the last one of protocol 4.
std::vector<std::uint8_t> upgraded_recording(std::span<const std::uint8_t> bytes, const std::string &name);

// The same for files: the new one has its name when it is whole. Throws RecordingError, OutputError.
Recording upgrade_recording(const std::string &path, const std::string &new_path);

} // namespace crn
