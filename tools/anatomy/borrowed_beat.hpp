/* Applies the beat of the shipped heart to another heart whose mesh exists in one phase only, for example
 * from a scan or an atlas. Three landmarks, which exist on both hearts, determine the rotation, scale and
 * shift between the shipped heart and the other heart. When the landmarks are known, the map of the shipped
 * heart's motion (heart_beat.hpp) moves the mesh of the other heart. The resulting motion is an assumption,
 * not a measurement, because the real beat of the other heart is unknown. */
#pragma once
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/mesh.hpp"
#include <filesystem>

namespace anatomy
{

/* Holds the positions of three landmarks of a heart at the end of diastole, in the patient frame of that
 * heart. */
struct HeartLandmarks {
    Vec3 left_ostium_mm, right_ostium_mm, apex_mm;
};

HeartLandmarks shipped_landmarks();

/* Holds the rotation, scale and shift that map the other heart onto the shipped heart. The transformation
 * between the hearts is the least-squares fit over three landmarks (Umeyama, IEEE PAMI 1991;13:376). */
struct HeartPlacement {
    double scale = 1.0; // size of the shipped heart divided by the size of the other heart
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 shift_mm = Vec3::Zero();
    double residual_mm[3] = {
        0.0, 0.0, 0.0}; // residuals at left ostium, right ostium and apex, in the size of the other heart

    Vec3 to_shipped(const Vec3 &point) const { return scale * (rotation * point) + shift_mm; }
    Vec3 from_shipped(const Vec3 &point) const { return rotation.transpose() * (point - shift_mm) / scale; }
};

/* Throws std::invalid_argument when the three landmarks are impossible for a human heart; the message names
 * the command-line option that may be wrong. The shipped heart must be 0.6 to 1.6 times as large as the other
 * heart. After the fit, no landmark may be more than 20 mm away from its counterpart on the shipped heart.
 * The three landmarks that a borrowed heartbeat needs must not lie on one straight line. */
HeartPlacement place_heart(const HeartLandmarks &other);

/* Writes the vertex positions of the mesh in the 24 frames of the beat to FOLDER/NAME_00.ply ...
 * NAME_23.ply, and those at the end of inspiration to FOLDER_inhaled.ply beside the folder. The program
 * `bake` reads the 24 files of the beat and the file of inspiration. Each vertex moves like the
 * corresponding point of the shipped heart, and the displacement is scaled to the size of the other heart.
 * The displacement by breathing is not scaled. Returns the largest displacement of any vertex from its
 * position in the mesh `rest`, in mm. */
double write_borrowed_beat(const std::filesystem::path &folder, const std::string &name, const Mesh &rest,
                           const HeartPlacement &placement);

} // namespace anatomy
