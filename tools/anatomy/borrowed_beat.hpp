/* The shipped heart's beat for a heart that is at hand in one phase only: a scan's or an atlas'. Three places
 * that both hearts have say where the shipped one lies in it; its map (heart_beat.hpp) then moves whatever
 * mesh is given. That is an assumption, not a measurement: how this heart beats is not known. */
#pragma once
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/mesh.hpp"
#include <filesystem>

namespace anatomy
{

/* In the patient frame of the other heart, at the end of diastole. */
struct HeartLandmarks {
    Vec3 left_ostium_mm, right_ostium_mm, apex_mm;
};

HeartLandmarks shipped_landmarks();

/* Rotation, one scale and shift from the other heart to the shipped one: least squares over the three places
 * (Umeyama, IEEE PAMI 1991;13:376). */
struct HeartPlacement {
    double scale = 1.0; // shipped size over the other's
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 shift_mm = Vec3::Zero();
    double residual_mm[3] = {
        0.0, 0.0, 0.0}; // what is left at left ostium, right ostium, apex, in the other heart's size

    Vec3 to_shipped(const Vec3 &point) const { return scale * (rotation * point) + shift_mm; }
    Vec3 from_shipped(const Vec3 &point) const { return rotation.transpose() * (point - shift_mm) / scale; }
};

/* Throws std::invalid_argument with what to look at when no heart of a man is like that: a size beyond 0.6
 * to 1.6 times the shipped one's, a place that is off by more than 20 mm, places on one line. */
HeartPlacement place_heart(const HeartLandmarks &other);

/* FOLDER/NAME_00.ply ... NAME_23.ply with the mesh's vertices in every frame, and FOLDER_inhaled.ply beside
 * it, as bake reads them. The way of a vertex is the shipped heart's there, in the other heart's size;
 * breath's is not scaled. Returns the longest way from the first frame, mm. */
double write_borrowed_beat(const std::filesystem::path &folder, const std::string &name, const Mesh &rest,
                           const HeartPlacement &placement);

} // namespace anatomy
