// Holds a baked scene as the host uses it: the bytes that the device receives, and the point where the
// instruments enter.
#pragma once
#include "host/model/instrument.hpp"
#include <cstdint>
#include <string>
#include <vector>

namespace crn
{

inline constexpr std::uint32_t start_default_um = 20000; // of scenes that state no length

struct SceneFile {
    std::string path; // empty: free space
    std::vector<std::uint8_t> bytes;
    std::uint32_t crc32 = 0;
    crn_wire_entry entry{}; // the session sets inserted_um
    // A session begins with this inserted length if neither script nor user states another length.
    std::uint32_t start_um = start_default_um;
    std::string name;
};

// Throws FileError with the validator's message if the file is not a valid scene. If the path is empty, the
// scene is free space without vessels; its entry is at the origin and points towards the patient's head.
SceneFile read_scene(const std::string &path);

} // namespace crn
