/* Applies the shipped heart's beat to a heart that is available in one phase only, such as a scan's or an
 * atlas'. Three places that both hearts have determine how the shipped heart lies in the other one; its
 * map (heart_beat.hpp) then moves the given mesh. This is an assumption, not a measurement: the real beat
 * of this heart is unknown. */
#pragma once
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/mesh.hpp"
#include <filesystem>

namespace anatomy
{

/* Places in the patient frame of the other heart, at the end of diastole. */
struct HeartLandmarks {
    Vec3 left_ostium_mm, right_ostium_mm, apex_mm;
};

HeartLandmarks shipped_landmarks();

/* Rotation, one scale and shift from the other heart to the shipped one: least squares over the three
 * places (Umeyama, IEEE PAMI 1991;13:376). */
struct HeartPlacement {
    double scale = 1.0; // shipped size divided by the other's
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 shift_mm = Vec3::Zero();
    double residual_mm[3] = {
        0.0, 0.0, 0.0}; // residuals at left ostium, right ostium and apex, in the other heart's size

    Vec3 to_shipped(const Vec3 &point) const { return scale * (rotation * point) + shift_mm; }
    Vec3 from_shipped(const Vec3 &point) const { return rotation.transpose() * (point - shift_mm) / scale; }
};

/* Throws std::invalid_argument naming what to check when no man's heart can be like that: a size beyond
 * 0.6 to 1.6 times the shipped one's, a place that is off by more than 20 mm, or places on one line. */
HeartPlacement place_heart(const HeartLandmarks &other);

/* Writes FOLDER/NAME_00.ply ... NAME_23.ply with the mesh's vertices in every frame, and
 * FOLDER_inhaled.ply beside the folder, as bake reads them. The displacement of a vertex is the shipped
 * heart's there, in the other heart's size; the displacement by breath is not scaled. Returns the largest
 * displacement from the first frame, mm. */
double write_borrowed_beat(const std::filesystem::path &folder, const std::string &name, const Mesh &rest,
                           const HeartPlacement &placement);

} // namespace anatomy
