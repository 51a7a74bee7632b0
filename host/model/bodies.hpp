// Declares the closed meshes (bodies) from which the picture of the patient is made: skin, lungs, bones,
// heart and vessels. Each body names its parent, which is the body in which it lies. The volume of a body is
// subtracted from that of its parent, so that no volume is counted twice. Bodies are read from the BODY
// sections of an `X.bodies` file, together with the tree of their vessels; docs/frames.md describes the axes.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct CtVolume;

struct Body {
    std::string name;
    std::string material;                                // as written in the file; xray checks it
    int parent = -1;                                     // index of the enclosing body, -1 for none (air)
    std::vector<Eigen::Vector3i> vertices_um;            // patient frame
    std::vector<std::array<std::uint32_t, 3>> triangles; // counter-clockwise seen from outside
    bool moves = false;                                  // moves with the scene's motion (motion.hpp)
    std::vector<Eigen::Vector3i> breath_um = {}; // displacement of each vertex by a full breath; empty: none
    bool is_trabecular = false;                  // has the texture of trabeculae in X-ray pictures
};

// Identifies a scene file by size and checksum, as recordings do.
struct SceneName {
    std::size_t size_bytes = 0;
    std::uint32_t crc32 = 0; // checksum of the whole file
    bool operator==(const SceneName &) const = default;
};

struct Bodies {
    std::vector<Body> bodies;
    VesselTree vessels = {}; // empty: the file has none
    std::optional<SceneName> baked_with = {};
    // The patient's CT (ct_volume.hpp), through which X-rays are cast; null if the patient consists of meshes
    // alone.
    std::shared_ptr<const CtVolume> ct = {};
};

// Reads a body file. On failure the function returns false, `error` names the file, the section and the
// remedy, and `bodies` does not change. A file with the same name and the ending .ct beside the body file is
// the patient's CT, and is read with the bodies.
bool read_bodies(const std::string &path, Bodies &bodies, std::string &error);

// Reads bodies that are shown together with a scene; the bodies must have been baked (computed) together with
// this scene. The program `bake` writes the scene and the bodies together. A tree of vessels from another
// scene would be wrong, and no user could notice the error. Without a scene (an empty path) the function
// accepts any bodies.
bool read_bodies_of(const std::string &scene_path, const std::string &path, Bodies &bodies,
                    std::string &error);

// Checks what reading alone cannot guarantee: parents exist and form no cycle, vertex indices are in range,
// there are at most 8 million triangles, and coordinates are within 2 m.
bool check_bodies(const Bodies &bodies, std::string &error);

} // namespace crn
