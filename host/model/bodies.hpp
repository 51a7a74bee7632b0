// The closed meshes that make the picture of the patient: skin, lungs, bones, heart, vessels. A body names
// the body in which it lies; its volume is then subtracted from that parent, so that nothing is counted
// twice. They are read from the BODY sections of an `X.bodies` file (docs/frames.md for the axes), with the
// tree of its vessels.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct Body {
    std::string name;
    std::string material;                                // as written in the file; xray checks it
    int parent = -1;                                     // index of the enclosing body, -1 for none (air)
    std::vector<Eigen::Vector3i> vertices_um;            // patient frame
    std::vector<std::array<std::uint32_t, 3>> triangles; // counter-clockwise seen from outside
    bool moves = false;                                  // moves with the scene's motion (motion.hpp)
};

// The name of a scene file, as in a recording.
struct SceneName {
    std::size_t size_bytes = 0;
    std::uint32_t crc32 = 0; // checksum of the whole file
    bool operator==(const SceneName &) const = default;
};

struct Bodies {
    std::vector<Body> bodies;
    VesselTree vessels = {}; // empty: the file has none
    std::optional<SceneName> baked_with = {};
};

// Reads a body file. On failure it returns false and says in `error` which file, which section and what to
// do; `bodies` is then unchanged.
bool read_bodies(const std::string &path, Bodies &bodies, std::string &error);

// Reads bodies that are shown together with a scene, which must be the one with which they were baked. `bake`
// writes both at once, and a tree of vessels over another lumen would be wrong without any sign of it.
// Without a scene (no path) any bodies are accepted.
bool read_bodies_of(const std::string &scene_path, const std::string &path, Bodies &bodies,
                    std::string &error);

// Checks what reading alone cannot guarantee: parents in range and without a cycle, vertex indices in range,
// at most 8 million triangles in all, coordinates within 2 m.
bool check_bodies(const Bodies &bodies, std::string &error);

} // namespace crn
