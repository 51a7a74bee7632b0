// Geometry of the C-arm: where source and detector stand, in the patient frame (docs/frames.md).
// Angles follow DICOM PS3.3 C.8.7.5.1.2: primary + = LAO, - = RAO; secondary + = cranial, - = caudal.
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

// The same as unit vectors and points. Uses no libm: equal bytes from every compiler.
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

// Picture coordinates of a patient point: x to the right, y downwards, pixel centres at .5. False behind the
// source.
bool project(const View &view, const Eigen::Vector3d &point_m, Eigen::Vector2d &pixel);

// Where the patient lies along a direction, as DICOM names it (C.7.6.1.1.1): R or L, H or F, A or P; the
// larger part first, parts below sin 22.5 deg left out. "LP": to the left, somewhat to the back.
std::string patient_side(const Eigen::Vector3d &direction);

// Holds the angles, SID, SOD and field inside what a C-arm can do.
CArm clamp_carm(const CArm &carm);

} // namespace crn
