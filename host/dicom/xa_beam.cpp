// Writes the attributes of tube, dose, filter, collimator, table and C-arm of an X-ray run: PS3.3 C.8.7.2 to
// C.8.7.5.
#include "host/dicom/xa_put.hpp"
#include "host/xray/run.hpp"
#include <algorithm>
#include <cctype>
#include <cmath>

namespace crn
{

namespace
{

double mean_of(const XrayRun &run, double RunFrame::*value)
{
    double sum = 0.0;
    for (const RunFrame &frame : run.frames) sum += frame.*value;
    return sum / static_cast<double>(run.frames.size());
}

double sum_of(const XrayRun &run, double RunFrame::*value)
{
    return mean_of(run, value) * static_cast<double>(run.frames.size());
}

std::vector<double> each_of(const XrayRun &run, double RunFrame::*value)
{
    std::vector<double> values;
    for (const RunFrame &frame : run.frames) values.push_back(frame.*value);
    return values;
}

// Returns the difference between each frame's value and that of the first frame; C.8.7.5.1.3 requires one
// value per frame.
template <class Value> std::vector<double> offsets(const XrayRun &run, const Value &value)
{
    std::vector<double> all;
    const double first = value(run.frames.front().carm);
    for (const RunFrame &frame : run.frames) {
        // Values are rounded to a thousandth, because the text of each number (DICOM type DS) has to be
        // short, and no C-arm is more precise.
        all.push_back(std::round((value(frame.carm) - first) * 1e3) / 1e3);
    }
    return all;
}

bool moves(const std::vector<double> &offsets)
{
    return std::any_of(offsets.begin(), offsets.end(), [](double offset) { return offset != 0.0; });
}

bool is_same_everywhere(const XrayRun &run, double CArm::*value)
{
    return std::all_of(run.frames.begin(), run.frames.end(), [&](const RunFrame &frame) {
        return frame.carm.*value == run.frames.front().carm.*value;
    });
}

std::string upper(std::string text)
{
    for (char &letter : text) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    return text;
}

// Puts the dose. DICOM uses dGy cm2 (1 Gy cm2 = 10 dGy cm2) for the kerma-area product, and mGy for the
// entrance dose.
void put_dose(XaItem &item, const XrayRun &run)
{
    const double kap_Gy_cm2 = sum_of(run, &RunFrame::kap_Gy_cm2);
    const double kerma_uGy = sum_of(run, &RunFrame::air_kerma_uGy);
    if (kap_Gy_cm2 > 0.0) item.decimal(DCM_ImageAndFluoroscopyAreaDoseProduct, kap_Gy_cm2 * 10.0);
    if (kerma_uGy <= 0.0) return;
    item.decimal(DCM_EntranceDoseInmGy, kerma_uGy * 1e-3);
    item.text(
        DCM_CommentsOnRadiationDose,
        "Entrance dose is the air kerma of the run at the reference point, 15 cm from the isocentre toward "
        "the tube, without backscatter");
}

void put_filters(XaItem &item, const XrayRun &run)
{
    if (run.filters.empty()) return;
    std::string materials;
    std::vector<double> thickness_mm;
    for (const RunFilter &filter : run.filters) {
        materials += (materials.empty() ? "" : "\\") + upper(filter.material);
        thickness_mm.push_back(filter.thickness_mm);
    }
    item.text(DCM_FilterType, run.filters.size() > 1 ? "MULTIPLE" : "FLAT");
    item.text(DCM_FilterMaterial, materials);
    item.decimals(DCM_FilterThicknessMinimum, thickness_mm);
    item.decimals(DCM_FilterThicknessMaximum, thickness_mm);
}

// Writes the pixel pitch at the detector, and also the pitch at the isocentre if that is equal in all frames.
void put_spacing(XaItem &item, const XrayRun &run)
{
    const CArm &carm = run.frames.front().carm;
    const double pixel_mm = carm.field_m * 1e3 / run.size;
    item.decimals(DCM_ImagerPixelSpacing, {pixel_mm, pixel_mm});
    if (!is_same_everywhere(run, &CArm::source_detector_m) ||
        !is_same_everywhere(run, &CArm::source_isocentre_m))
        return;
    const double at_isocentre_mm = pixel_mm * carm.source_isocentre_m / carm.source_detector_m;
    item.decimals(DCM_PixelSpacing, {at_isocentre_mm, at_isocentre_mm});
    item.text(DCM_PixelSpacingCalibrationType, "GEOMETRY");
    item.text(DCM_PixelSpacingCalibrationDescription, "in the plane through the isocentre");
}

} // namespace

void put_acquisition(XaItem &item, const XrayRun &run)
{
    const double current_mA = mean_of(run, &RunFrame::tube_current_mA);
    const double time_ms = sum_of(run, &RunFrame::pulse_ms); // C.8.7.2.1.1: of all pulses together
    double charge_mAs = 0.0;
    for (const RunFrame &frame : run.frames) charge_mAs += frame.tube_current_mA * frame.pulse_ms * 1e-3;
    item.decimal_if_known(DCM_KVP, std::round(mean_of(run, &RunFrame::tube_voltage_kV) * 100.0) / 100.0);
    item.text(DCM_RadiationSetting, run.kind == RunKind::fluoro ? "SC" : "GR");
    item.text(DCM_RadiationMode, "PULSED");
    if (current_mA > 0.0 && time_ms > 0.0) {
        item.whole(DCM_XRayTubeCurrent, std::lround(current_mA));
        item.decimal(DCM_XRayTubeCurrentInuA, std::round(current_mA * 1e3));
        item.whole(DCM_ExposureTime, std::lround(time_ms));
        item.decimal(DCM_ExposureTimeInuS, std::round(time_ms * 1e3));
        item.whole(DCM_Exposure, std::lround(charge_mAs));
        item.whole(DCM_ExposureInuAs, std::lround(charge_mAs * 1e3));
        item.decimal(DCM_AveragePulseWidth, time_ms / static_cast<double>(run.frames.size()));
    } else {
        item.empty(DCM_Exposure);
        item.empty(DCM_ExposureTime);
        item.empty(DCM_XRayTubeCurrent);
    }
    if (run.focal_spot_mm > 0.0) item.decimal(DCM_FocalSpots, run.focal_spot_mm);
    const long field_mm = std::lround(run.frames.front().carm.field_m * 1e3);
    item.text(DCM_FieldOfViewShape, run.collimator.is_circular ? "ROUND" : "RECTANGLE");
    item.text(DCM_FieldOfViewDimensions, run.collimator.is_circular
                                             ? std::to_string(field_mm)
                                             : std::to_string(field_mm) + "\\" + std::to_string(field_mm));
    put_spacing(item, run);
    put_filters(item, run);
    put_dose(item, run);
}

// Writes the attributes of the collimator (C.8.7.3), whose rows and columns are counted from 1. The position
// of a collimator edge is the last column or row that a blade covers: 0 or size+1 where the blade covers
// nothing.
void put_collimator(XaItem &item, const XrayRun &run)
{
    const RunCollimator &shape = run.collimator;
    if (shape.is_circular) {
        item.text(DCM_CollimatorShape, "CIRCULAR");
        item.text(DCM_CenterOfCircularCollimator, std::to_string(std::lround(shape.centre_y_px + 0.5)) +
                                                      "\\" +
                                                      std::to_string(std::lround(shape.centre_x_px + 0.5)));
        item.whole(DCM_RadiusOfCircularCollimator, std::lround(shape.radius_px));
        return;
    }
    item.text(DCM_CollimatorShape, "RECTANGULAR");
    item.whole(DCM_CollimatorLeftVerticalEdge, shape.left);
    item.whole(DCM_CollimatorRightVerticalEdge, shape.right + 1);
    item.whole(DCM_CollimatorUpperHorizontalEdge, shape.top);
    item.whole(DCM_CollimatorLowerHorizontalEdge, shape.bottom + 1);
}

// Puts the table's motion (C.8.7.4). The patient lies on the back with the head at the table's head end. The
// table's longitudinal position is therefore positive towards LAO (the patient's left), and its lateral
// position towards cranial. When the table moves in one direction, the patient's point at the isocentre moves
// in the opposite direction. Down is positive for the table's vertical position, as in C.8.19.6.11, because
// the classic DICOM module does not define the sign.
void put_table(XaItem &item, const XrayRun &run)
{
    const std::vector<double> left_mm = offsets(run, [](const CArm &c) { return -c.isocentre_m.x() * 1e3; });
    const std::vector<double> head_mm = offsets(run, [](const CArm &c) { return -c.isocentre_m.y() * 1e3; });
    const std::vector<double> down_mm = offsets(run, [](const CArm &c) { return c.isocentre_m.z() * 1e3; });
    if (!moves(left_mm) && !moves(head_mm) && !moves(down_mm)) {
        item.text(DCM_TableMotion, "STATIC");
        return;
    }
    item.text(DCM_TableMotion, "DYNAMIC");
    item.decimals(DCM_TableVerticalIncrement, down_mm);
    item.decimals(DCM_TableLongitudinalIncrement, left_mm);
    item.decimals(DCM_TableLateralIncrement, head_mm);
}

// Writes the C-arm's angles in the first frame, and how the angles of the other frames differ from these
// (C.8.7.5).
void put_positioner(XaItem &item, const XrayRun &run)
{
    const CArm &carm = run.frames.front().carm;
    item.decimal(DCM_DistanceSourceToDetector, carm.source_detector_m * 1e3);
    item.decimal(DCM_DistanceSourceToPatient, carm.source_isocentre_m * 1e3);
    if (is_same_everywhere(run, &CArm::source_detector_m) &&
        is_same_everywhere(run, &CArm::source_isocentre_m))
        item.decimal(DCM_EstimatedRadiographicMagnificationFactor,
                     carm.source_detector_m / carm.source_isocentre_m);
    item.decimal(DCM_PositionerPrimaryAngle, carm.primary_deg);
    item.decimal(DCM_PositionerSecondaryAngle, carm.secondary_deg);
    const std::vector<double> primary_deg = offsets(run, [](const CArm &c) { return c.primary_deg; });
    const std::vector<double> secondary_deg = offsets(run, [](const CArm &c) { return c.secondary_deg; });
    if (!moves(primary_deg) && !moves(secondary_deg)) {
        item.text(DCM_PositionerMotion, "STATIC");
        return;
    }
    item.text(DCM_PositionerMotion, "DYNAMIC");
    item.decimals(DCM_PositionerPrimaryAngleIncrement, primary_deg);
    item.decimals(DCM_PositionerSecondaryAngleIncrement, secondary_deg);
}

void put_frames_private(XaItem &item, const XrayRun &run)
{
    item.text(DcmTagKey(private_group, 0x0010), private_creator);
    std::vector<std::uint32_t> ticks;
    std::vector<double> table_mm, distances_mm;
    for (const RunFrame &frame : run.frames) {
        ticks.push_back(frame.tick);
        for (int axis = 0; axis < 3; axis++) table_mm.push_back(frame.carm.isocentre_m[axis] * 1e3);
        distances_mm.push_back(frame.carm.source_detector_m * 1e3);
    }
    item.private_longs(0x1001, ticks);
    item.private_doubles(0x1002, each_of(run, &RunFrame::tube_voltage_kV));
    item.private_doubles(0x1003, each_of(run, &RunFrame::tube_current_mA));
    item.private_doubles(0x1004, each_of(run, &RunFrame::pulse_ms));
    item.private_doubles(0x1005, each_of(run, &RunFrame::air_kerma_uGy));
    item.private_doubles(0x1006, each_of(run, &RunFrame::kap_Gy_cm2));
    item.private_doubles(0x1007, table_mm);
    item.private_doubles(0x1008, distances_mm);
}

} // namespace crn
