// Reads a sequence of meshes, checks that their triangles are equal and that no vertex jumps, and measures
// how far a fitted lattice deviates from the sequence.
#include "host/base/format.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/measure.hpp"
#include "tools/bake/motion.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace crn::bake
{
namespace
{

std::vector<std::filesystem::path> frame_files(const std::filesystem::path &folder)
{
    std::vector<std::filesystem::path> files;
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        std::string ending = entry.path().extension().string();
        for (char &c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (ending == ".obj" || ending == ".ply" || ending == ".stl") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    if (files.size() != frames_count)
        throw Fault(folder.string() + ": holds " + std::to_string(files.size()) + " meshes, a cycle has " +
                    std::to_string(frames_count) + ": give one mesh per 1/24 of the cycle, named in order");
    return files;
}

// Returns the vertices of one frame in the patient's coordinates, as for the lumen; the frame's triangles
// must equal the triangles of the reference mesh.
std::vector<Eigen::Vector3d> frame_vertices(const std::filesystem::path &file, const MeshText &lumen,
                                            const Mesh &reference)
{
    MeshText text = lumen;
    text.file = file;
    const Mesh mesh = load_mesh(text);
    if (mesh.vertices_mm.size() != reference.vertices_mm.size() || mesh.triangles != reference.triangles)
        throw Fault(file.string() + ": has other triangles than " + reference.name + " (" +
                    std::to_string(mesh.vertices_mm.size()) + " and " +
                    std::to_string(reference.vertices_mm.size()) +
                    " vertices): every frame must be the same mesh with its vertices moved");
    return mesh.vertices_mm;
}

// Checks that no vertex moves farther between two frames than a vessel wall can move in 1/24 of a heartbeat.
// The first frame counts as the successor of the last frame.
void check_jumps(const Sequence &frames, const std::vector<std::filesystem::path> &files)
{
    constexpr double jump_mm = 8.0; // faster than any wall: 0.2 m/s over 1/24 s
    for (std::size_t k = 0; k < frames_count; ++k) {
        const std::size_t next = (k + 1) % frames_count;
        for (std::size_t i = 0; i < frames.moved_mm[0].size(); ++i) {
            const double step = (frames.moved_mm[next][i] - frames.moved_mm[k][i]).norm();
            if (step <= jump_mm) continue;
            const std::string size = formatted("%.1f", step);
            throw Fault(files[next].string() + ": vertex " + std::to_string(i) + " jumps by " + size +
                        " mm from " + files[k].filename().string() + " at " +
                        place_text(frames.moved_mm[k][i]) +
                        ": check the order of the frames and that the last goes on to the first");
        }
    }
}

// Returns the radius of the lumen in the reference pose at a point of its wall; the radius is taken as the
// greatest depth along the inward normal.
double radius_mm(const crn_lumen *lumen, const Eigen::Vector3d &wall_mm)
{
    const crn_vec3 q = to_q30(wall_mm);
    const crn_lumen_sample sample = crn_lumen_contact(lumen, &q);
    Eigen::Vector3d inward;
    for (int k = 0; k < 3; ++k) inward[k] = std::ldexp(sample.normal_q30.v[k], -30);
    double deepest = 0;
    for (double way = 0.25; way <= small_vessel_mm + 0.25; way += 0.25)
        deepest = std::max(deepest, -contact_mm(lumen, wall_mm + way * inward));
    return deepest;
}

crn_motion_pose pose_of(const crn_motion *motion, std::size_t key, bool inhaled)
{
    crn_rhythm rhythm{};
    rhythm.heart_phase32 = static_cast<std::uint32_t>((std::uint64_t{key} << 32) / frames_count);
    rhythm.breath_phase32 = inhaled ? 1u << 31 : 0u;
    crn_motion_pose pose;
    crn_motion_pose_begin(motion, &pose, &rhythm, &rhythm);
    return pose;
}

// Converts a point that is given in another pose to its position in the reference pose.
Eigen::Vector3d pulled_mm(const crn_motion *motion, crn_motion_pose &pose, const Eigen::Vector3d &at_mm)
{
    const crn_vec3 q = to_q30(at_mm), back = crn_motion_pull(motion, &pose, &q);
    Eigen::Vector3d reference;
    for (int k = 0; k < 3; ++k) reference[k] = back.v[k] * mm_per_q30;
    return reference;
}

// Loads one mesh per frame; the triangles of every mesh must equal those of the first mesh.
Sequence load_sequence(const std::filesystem::path &folder, const std::filesystem::path &inhaled,
                       const MeshText &placed, Mesh &first)
{
    const std::vector<std::filesystem::path> files = frame_files(folder);
    MeshText text = placed;
    text.file = files[0];
    first = load_mesh(text);
    Sequence sequence;
    for (const std::filesystem::path &file : files)
        sequence.moved_mm.push_back(frame_vertices(file, placed, first));
    if (!inhaled.empty()) sequence.inhaled_mm = frame_vertices(inhaled, placed, first);
    check_jumps(sequence, files);
    return sequence;
}

} // namespace

Frames load_frames(const MotionText &text, const LumenText &lumen)
{
    constexpr double same_mm = 0.05;
    Frames frames;
    Mesh first, guide;
    frames.lumen = load_sequence(text.frames, text.inhaled, lumen.mesh, first);
    frames.triangles = first.triangles;
    const Mesh described = load_mesh(lumen.mesh);
    bool is_same = described.triangles == first.triangles;
    for (std::size_t i = 0; is_same && i < first.vertices_mm.size(); ++i)
        is_same = (described.vertices_mm[i] - first.vertices_mm[i]).norm() < same_mm;
    if (!is_same)
        throw Fault(lumen.mesh.file.string() + ": is not the first frame of " + text.frames.string() +
                    ": the scene is described as it is in that frame; give it as the lumen's mesh");
    if (!text.guides.empty()) {
        MeshText placed = lumen.mesh;
        placed.parts.clear();
        placed.pieces_mm.setEmpty();
        placed.pieces_min_mm = 0;
        frames.guides = load_sequence(text.guides, text.inhaled_guides, placed, guide);
    }
    frames.lumen.retime(text.end_systole);
    frames.guides.retime(text.end_systole);
    frames.pose = middle_pose(frames.lumen);
    frames.lumen.reference_mm = frames.lumen.moved_mm[frames.pose];
    if (!text.guides.empty()) frames.guides.reference_mm = frames.guides.moved_mm[frames.pose];
    return frames;
}

const crn_motion *Motion::view()
{
    lattices.rows = rows.data();
    lattices.inhaled = inhaled.empty() ? nullptr : inhaled.data();
    return &lattices;
}

Eigen::Vector3d Motion::to_reference_mm(const Eigen::Vector3d &at_mm) const
{
    crn_motion_pose pose = pose_of(&lattices, 0, false);
    return pulled_mm(&lattices, pose, at_mm);
}

namespace
{

// Returns the position at which the displacement stored in a lattice changes most steeply; the lattice stores
// `numbers` numbers per node.
Worst steepest_of(const crn_lattice &lattice, const std::vector<std::int16_t> &rows, std::size_t numbers)
{
    const std::size_t steps[3] = {1, lattice.count_xyz[0],
                                  std::size_t{lattice.count_xyz[0]} * lattice.count_xyz[1]};
    const double spacing =
        std::ldexp(1.0, static_cast<int>(lattice.spacing_log2_q30) - CRN_MOTION_UNIT_LOG2_Q30);
    Worst steepest;
    for (std::size_t node = 0; node < rows.size() / numbers; ++node)
        for (int axis = 0; axis < 3; axis++) {
            if (node / steps[axis] % lattice.count_xyz[axis] + 1 == lattice.count_xyz[axis]) continue;
            const std::int16_t *here = &rows[node * numbers], *next = here + steps[axis] * numbers;
            Eigen::Vector3d place;
            for (int k = 0; k < 3; ++k)
                place[k] = (lattice.origin_m_q30[k] +
                            std::ldexp(static_cast<double>(node / steps[k] % lattice.count_xyz[k]),
                                       static_cast<int>(lattice.spacing_log2_q30))) *
                           mm_per_q30;
            for (std::size_t i = 0; i < numbers; ++i)
                steepest.take(std::abs(next[i] - here[i]) / spacing, place);
        }
    return steepest;
}

} // namespace

Steepness steepness(const Motion &motion)
{
    return {steepest_of(motion.lattices.beat, motion.rows, std::size_t{3} * CRN_MOTION_ROW),
            steepest_of(motion.lattices.breath, motion.inhaled, 3)};
}

void refuse_steep(const Motion &motion)
{
    const Steepness steepest = steepness(motion);
    const auto check = [](const Worst &worst, double most, const char *what) {
        if (worst.mm <= most) return;
        const std::string text =
            formatted("%.2f of their distance to each other in a %s, more than %.3f", worst.mm, what, most);
        throw Fault("[motion]: at " + place_text(worst.place_mm) + " neighbours move by " + text +
                    ": let the motion fade out more slowly in the frames");
    };
    check(steepest.heart, heart_steepness_max, "beat");
    check(steepest.breath, breath_steepness_max, "breath");
}

std::vector<FrameError> measure_motion(const crn_lumen *lumen, const crn_motion *motion, const Frames &frames,
                                       const std::vector<bool> &left_out)
{
    const auto is_out = [&](std::size_t vertex) { return !left_out.empty() && left_out[vertex]; };
    std::vector<bool> is_small;
    for (const Eigen::Vector3d &wall : frames.lumen.reference_mm)
        is_small.push_back(radius_mm(lumen, wall) < small_vessel_mm);
    std::vector<FrameError> errors;
    for (std::size_t key = 0; key < frames_count + !frames.lumen.inhaled_mm.empty(); ++key) {
        const bool is_breath = key == frames_count;
        const auto &moved = is_breath ? frames.lumen.inhaled_mm : frames.lumen.moved_mm[key];
        crn_motion_pose pose = pose_of(motion, is_breath ? 0 : key, is_breath);
        FrameError error;
        double squares = 0;
        std::size_t count = 0;
        const auto look = [&](const Eigen::Vector3d &p, bool small) {
            const crn_vec3 q = to_q30(p);
            const double off =
                std::abs(crn_motion_contact(lumen, motion, &pose, &q).distance_m_q30) * mm_per_q30;
            (small ? error.small : error.large).take(off, p);
            squares += off * off;
            ++count;
        };
        for (std::size_t i = 0; i < moved.size(); ++i) {
            if (is_out(i)) continue;
            look(moved[i], is_small[i]);
            const Eigen::Vector3d reference = pulled_mm(motion, pose, moved[i]);
            error.along.take((reference - frames.lumen.reference_mm[i]).norm(), moved[i]);
        }
        for (const Triangle &t : frames.triangles)
            if (!is_out(t[0]) && !is_out(t[1]) && !is_out(t[2]))
                look((moved[t[0]] + moved[t[1]] + moved[t[2]]) / 3,
                     is_small[t[0]] && is_small[t[1]] && is_small[t[2]]);
        error.rms_mm = std::sqrt(squares / static_cast<double>(count));
        errors.push_back(error);
    }
    return errors;
}

} // namespace crn::bake
