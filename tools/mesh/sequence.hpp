/* Reads a heartbeat from a folder of 24 OBJ files, as animation programs write them. Each file is one frame,
 * and the files' names give the order of the frames. All files must have the same bodies (keyword o, or g if
 * there is no o), the same faces and the same number of vertices. */
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace crn::mesh
{

constexpr size_t sequence_frames = 24;

struct SequenceBody {
    std::string name;
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<std::vector<Eigen::Vector3d>> frames; // every vertex in every frame, in the unit of the files
};

struct Sequence {
    std::vector<std::string> files;
    std::vector<SequenceBody> bodies;
};

/* Throws a std::runtime_error that names file and line if a text is unreadable or if the number of files is
 * wrong. The error is also thrown if the faces of a file differ from those of the first file. Faces with more
 * than three corners become fans of triangles; normals, textures and materials are ignored. */
Sequence read_sequence(const std::filesystem::path &folder);

/* Describes the motion of a body from frame to frame, including the step from the last frame back to the
 * first. */
struct SequenceReport {
    std::string body;
    size_t vertices = 0, triangles = 0;
    double step_max = 0.0,
           wrap_max =
               0.0;      // largest displacement of a vertex in one step; in the step back to the first frame
    size_t inverted = 0; // faces that turn by more than a right angle in one step
    size_t inverted_frame = 0,
           inverted_triangle = 0; // the first of them, and the frame in which it is turned
    std::string fault; // empty when the body can be used; otherwise inverted faces, or a jump at the wrap
};

std::vector<SequenceReport> check_sequence(const Sequence &sequence);

} // namespace crn::mesh
