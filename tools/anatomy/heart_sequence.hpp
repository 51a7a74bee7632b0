/* The heart over one beat. Each body of the heart has one set of triangles and the positions of its vertices
 * in every frame. Each artery of the heart has a centreline in every frame. The figures of the beat, such as
 * volumes and displacements, are measured on the bodies and the centrelines. */
#pragma once
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/heart_beat.hpp"
#include <filesystem>

namespace anatomy
{

struct MovingBody {
    std::string name;
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<std::vector<Vec3>>
        frames_mm;                // BEAT_FRAMES lists of all vertices; the first is the end of diastole
    std::vector<Vec3> inhaled_mm; // the first frame at the end of inspiration
};

struct MovingVessel {
    std::string name;
    std::vector<Curve> frames;
};

struct HeartSequence {
    std::vector<MovingBody> bodies;
    std::vector<MovingVessel> vessels;
};

/* is_of_heart() is true for the heart and its vessels; moves_with_heart() is also true for bodies beside the
 * heart that move with it. */
bool is_of_heart(const std::string &body);
bool moves_with_heart(const std::string &body);

MovingBody moving_body(const std::string &name, const Mesh &rest, const HeartBeat &beat);
MovingVessel moving_vessel(const Vessel &vessel, const HeartBeat &beat);

/* Holds the measured figures (such as volumes and displacements) of a heartbeat that takes BEAT_MS
 * milliseconds. The function heart_figures() computes the figures of the beat from the meshes and centrelines
 * of the frames, without using the map of the motion. */
struct VesselFigures {
    std::string name;
    double length_mm, excursion_mm; // length at the end of diastole; largest displacement between two frames
    double systole_rest_ms, diastole_rest_ms; // longest time in which no point moves by more than 1 mm
};

struct HeartFigures {
    std::vector<double> left_ml, right_ml; // ventricles, per frame
    std::vector<double> left_atrium_ml, right_atrium_ml;
    int systole_frame = 0;                            // frame of the smallest left ventricle
    double left_ejection = 0.0, right_ejection = 0.0; // shares
    double base_descent_mm = 0.0, twist_deg = 0.0, base_turn_deg = 0.0, apex_turn_deg = 0.0;
    double radial_share = 0.0;   // share of the inner wall's motion towards one centre; mean over the steps
    double centre_path_mm = 0.0; // displacement of that centre over systole
    double least_volume_factor = 0.0; // of HeartBeat::least_volume_factor()
    std::vector<VesselFigures> vessels;
};

/* Measures all figures but `least_volume_factor`. Throws std::runtime_error when a chamber of the heart is
 * missing. */
HeartFigures heart_figures(const HeartSequence &sequence);

/* Writes the moved mesh of every frame as FOLDER/lumen_00.ply ... lumen_23.ply. The program writes the mesh
 * at the end of inspiration to FOLDER_inhaled.ply beside the folder. The program `bake` fits a lattice of
 * displacements to the mesh files of the frames. All positions are multiplied by `scale` after they moved. */
void write_lumen_frames(const std::filesystem::path &folder, const Mesh &rest, const HeartBeat &beat,
                        double scale = 1.0);

/* Writes FOLDER/frame_00.obj ... frame_23.obj with one object per body. The program writes the centrelines to
 * FOLDER/centrelines_00.mrk.json ..., and the bodies at the end of inspiration to FOLDER_inhaled.obj beside
 * the folder. */
void write_sequence(const std::filesystem::path &folder, const HeartSequence &sequence);
std::string figures_json(const HeartFigures &figures);

} // namespace anatomy
