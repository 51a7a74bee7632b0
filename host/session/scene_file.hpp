// A baked scene for the host: its bytes for the device, and the place where the instrument enters.
#pragma once
#include "host/model/instrument.hpp"
#include <cstdint>
#include <string>
#include <vector>

namespace crn
{

struct SceneFile {
    std::string path; // empty: free space
    std::vector<std::uint8_t> bytes;
    std::uint32_t crc32 = 0;
    crn_wire_entry entry{}; // the session sets inserted_um
    std::string name;
};

// Throws FileError with the validator's message when the file is not a valid scene. An empty path gives free
// space with the entry at the origin, towards the head.
SceneFile read_scene(const std::string &path);

} // namespace crn
