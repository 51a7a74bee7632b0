// Describes the geometry of the C-arm: the positions of source and detector in the patient frame
// (docs/frames.md). Angles are those of DICOM PS3.3 C.8.7.5.1.2. The primary angle is positive for LAO and
// negative for RAO, and the secondary angle is positive for cranial and negative for caudal.
#pragma once
#include <Eigen/Core>
#include <string>

namespace crn
{

struct CArm {
    double primary_deg = 0.0;   // + LAO, - RAO, -180 .. 180
    double secondary_deg = 0.0; // + CRA, - CAU, -90 .. 90
    Eigen::Vector3d isocentre_m =
        Eigen::Vector3d::Zero();      // patient point at the isocentre: the table's position
    double source_detector_m = 1.05;  // SID, 0.90 .. 1.30
    double source_isocentre_m = 0.75; // SOD, less than SID
    double field_m = 0.32;            // width of the square field at the detector: .42 .32 .25 .20 .15

    bool operator==(const CArm &) const = default;
};

// Describes the geometry of the C-arm by points and unit vectors in the patient frame. The geometry is
// computed without libm, so that every compiler gives results that are equal bit for bit.
struct View {
    Eigen::Vector3d source_m;
    Eigen::Vector3d right;   // picture's right, patient left in AP
    Eigen::Vector3d up;      // picture's up, head in AP
    Eigen::Vector3d forward; // from the source to the detector
    double source_detector_m = 0.0;
    double source_isocentre_m = 0.0;
    double pixel_m = 0.0; // pixel pitch at the detector
    int size = 0;         // pixels along each edge
};

View make_view(const CArm &carm, int size);

// Computes where a point of the patient appears in the picture: x to the right, y downwards, with pixel
// centres at .5. Returns false if the point is behind the source.
bool project(const View &view, const Eigen::Vector3d &point_m, Eigen::Vector2d &pixel);

// Returns the letters with which DICOM names a direction in the patient (C.7.6.1.1.1): R or L, A or P, and H
// or F for head or feet. The letter of the largest component comes first, and components below sin 22.5
// degrees are left out. For example, "LP" names a direction to the left and somewhat to the back.
std::string patient_side(const Eigen::Vector3d &direction);

// Limits the angles, SID, SOD and field to the ranges that a C-arm has.
CArm clamp_carm(const CArm &carm);

} // namespace crn
