#include "host/dicom/xa_attributes.hpp"
#include "host/base/format.hpp"
#include "host/dicom/xa_put.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <dcmtk/dcmdata/dcuid.h>
#include <stdexcept>

namespace crn
{

namespace
{

std::string kind_name(RunKind kind)
{
    return kind == RunKind::fluoro ? "Fluoroscopy"
           : kind == RunKind::cine ? "Cine"
                                   : "Digital subtraction angiography";
}

std::string derived_uid(const XaStudy &study, std::string_view what)
{
    Digest digest;
    digest.add("cournand " + std::string(what));
    digest.add(study.key);
    digest.add(study.patient_name);
    digest.add(study.patient_id);
    digest.add(study.date);
    return digest.uid();
}

// C.7.1.1
void put_patient(XaItem &item, const XaStudy &study)
{
    const bool is_anonymous = study.patient_name.empty() && study.patient_id.empty();
    item.text(DCM_PatientName, study.patient_name.empty() ? "Anonymous^" : study.patient_name);
    item.text(DCM_PatientID, study.patient_id.empty() ? "ANON-" + study.key.substr(0, 8) : study.patient_id);
    item.empty(DCM_PatientBirthDate);
    item.empty(DCM_PatientSex);
    if (!is_anonymous) return;
    item.text(DCM_PatientIdentityRemoved, "YES");
    item.text(DCM_DeidentificationMethod, "simulated: there is no person");
}

// C.7.2.1, C.7.3.1, C.7.5.1
void put_study(XaItem &item, const XrayRun &run, const XaStudy &study)
{
    item.text(DCM_StudyInstanceUID, derived_uid(study, "study"));
    if (study.date.empty())
        item.empty(DCM_StudyDate);
    else
        item.text(DCM_StudyDate, study.date);
    item.empty(DCM_StudyTime);
    item.empty(DCM_ReferringPhysicianName);
    item.text(DCM_StudyID, "1");
    item.empty(DCM_AccessionNumber);
    if (!study.description.empty()) item.text(DCM_StudyDescription, study.description);
    item.text(DCM_Modality, "XA");
    item.text(DCM_SeriesInstanceUID, derived_uid(study, "series"));
    item.whole(DCM_SeriesNumber, 1);
    item.empty(DCM_Laterality); // the whole person is on the table
    item.text(DCM_Manufacturer, "Cournand");
    item.text(DCM_ManufacturerModelName, "Cournand simulator");
    item.text(DCM_SeriesDescription, "Simulated angiography");
    item.text(DCM_ProtocolName, kind_name(run.kind));
}

// Returns the letters of the patient directions along which an axis of the picture points, the most closely
// aligned direction first (C.7.6.1.1.1).
std::string direction_letters(const Eigen::Vector3d &axis)
{
    constexpr double least = 0.26; // cosine of 75 degrees: directions farther away are not named
    const std::array<std::pair<double, char>, 3> parts = {{{std::abs(axis.x()), axis.x() > 0 ? 'L' : 'R'},
                                                           {std::abs(axis.y()), axis.y() > 0 ? 'H' : 'F'},
                                                           {std::abs(axis.z()), axis.z() > 0 ? 'A' : 'P'}}};
    auto sorted = parts;
    std::stable_sort(sorted.begin(), sorted.end(), [](auto &a, auto &b) { return a.first > b.first; });
    std::string letters;
    for (const auto &[share, letter] : sorted)
        if (share > least) letters += letter;
    return letters;
}

// Writes the attributes of the DICOM modules C.7.6.1, C.8.7.1 and SOP common.
void put_image(XaItem &item, const XrayRun &run, const Digest &content, const XaStudy &study, int instance)
{
    const View view = make_view(run.frames.front().carm, run.size);
    Digest uid = content;
    uid.add(derived_uid(study, "image " + std::to_string(instance)));
    item.text(DCM_SOPClassUID, UID_XRayAngiographicImageStorage);
    item.text(DCM_SOPInstanceUID, uid.uid());
    item.text(DCM_SpecificCharacterSet, "ISO_IR 192");
    item.whole(DCM_InstanceNumber, instance);
    item.whole(DCM_AcquisitionNumber, run.number);
    item.text(DCM_PatientOrientation, direction_letters(view.right) + "\\" + direction_letters(-view.up));
    item.text(DCM_ImageType, "ORIGINAL\\PRIMARY\\SINGLE PLANE");
    item.text(DCM_ImageComments, "Simulated by Cournand; not a picture of a person");
    item.text(DCM_QualityControlImage, "YES"); // a phantom, in the words of the standard
    item.text(DCM_BurnedInAnnotation, "NO");
    item.text(DCM_LossyImageCompression, "00");
}

// C.7.6.3
void put_pixel_format(XaItem &item, const XrayRun &run)
{
    const auto size = static_cast<std::uint16_t>(run.size);
    const auto bits = static_cast<std::uint16_t>(run.bits);
    item.shorts(DCM_SamplesPerPixel, {1});
    item.text(DCM_PhotometricInterpretation, "MONOCHROME2");
    item.shorts(DCM_Rows, {size});
    item.shorts(DCM_Columns, {size});
    item.shorts(DCM_BitsAllocated, {16});
    item.shorts(DCM_BitsStored, {bits});
    item.shorts(DCM_HighBit, {static_cast<std::uint16_t>(bits - 1)});
    item.shorts(DCM_PixelRepresentation, {0});
}

// Writes the attributes for the relation of pixel value to X-ray intensity (C.8.7.1.1.2). For the relation
// LOG, the function adds a table (C.11.1) that converts pixel values back to values proportional to the
// intensity. It is not for display.
void put_relation(XaItem &item, const XrayRun &run)
{
    if (run.relation == PixelRelation::linear) item.text(DCM_PixelIntensityRelationship, "LIN");
    if (run.relation == PixelRelation::display) item.text(DCM_PixelIntensityRelationship, "DISP");
    if (run.window_width > 0.0) {
        item.decimal(DCM_WindowCenter, run.window_centre);
        item.decimal(DCM_WindowWidth, run.window_width);
    }
    if (run.relation != PixelRelation::logarithmic) return;
    item.text(DCM_PixelIntensityRelationship, "LOG");
    DcmItem *lut = nullptr;
    if (item.item().findOrCreateSequenceItem(DCM_ModalityLUTSequence, lut).bad())
        throw std::logic_error("DICOM modality LUT cannot be made");
    XaItem table(*lut);
    table.shorts(DCM_LUTDescriptor, {static_cast<std::uint16_t>(run.to_linear.size() & 0xffff), 0, 16});
    table.text(DCM_LUTExplanation, "proportional to X-ray intensity");
    table.text(DCM_ModalityLUTType, "US");
    DcmTag data(DCM_LUTData, EVR_OW);
    if (lut->putAndInsertUint16Array(data, run.to_linear.data(), run.to_linear.size()).bad())
        throw std::logic_error("DICOM modality LUT cannot be filled");
}

// Returns true if the frames are equally spaced in time, apart from rounding to whole ticks (milliseconds).
// For frames equally spaced in time, one number describes all frame times (C.7.6.5).
bool is_even(const XrayRun &run, double period_ms)
{
    for (std::size_t i = 0; i < run.frames.size(); i++) {
        const double since_first_ms = run.frames[i].tick - static_cast<double>(run.frames.front().tick);
        if (std::abs(since_first_ms - period_ms * static_cast<double>(i)) > 1.0) return false;
    }
    return true;
}

// C.7.6.5, C.7.6.6
void put_times(XaItem &item, const XrayRun &run)
{
    const double period_ms = 1000.0 / run.pulses_per_s;
    const std::uint32_t length_ms = run.frames.back().tick - run.frames.front().tick;
    item.whole(DCM_NumberOfFrames, static_cast<long>(run.frames.size()));
    item.item().putAndInsertTagKey(DCM_FrameIncrementPointer,
                                   is_even(run, period_ms) ? DCM_FrameTime : DCM_FrameTimeVector);
    if (is_even(run, period_ms)) {
        item.decimal(DCM_FrameTime, period_ms);
    } else {
        std::vector<double> steps_ms = {0.0};
        for (std::size_t i = 1; i < run.frames.size(); i++)
            steps_ms.push_back(static_cast<double>(run.frames[i].tick - run.frames[i - 1].tick));
        item.decimals(DCM_FrameTimeVector, steps_ms);
    }
    const long rate = std::max(1L, std::lround(run.pulses_per_s));
    item.whole(DCM_CineRate, rate);
    item.whole(DCM_RecommendedDisplayFrameRate, rate);
    item.whole(DCM_StartTrim, 1);
    item.whole(DCM_StopTrim, static_cast<long>(run.frames.size()));
    item.decimal(DCM_FrameDelay, 0.0);
    item.decimal(DCM_EffectiveDuration, (length_ms + period_ms) * 1e-3);
    item.whole(DCM_ActualFrameDuration, std::lround(period_ms));
    item.shorts(DCM_PreferredPlaybackSequencing, {0}); // repeatedly from the first to the last
}

// Also describes the shift of the mask in words, so that a reader knows its direction.
std::string mask_in_words(const RunMask &mask)
{
    if (mask.shift_x_px == 0.0 && mask.shift_y_px == 0.0) return "mean of the mask frames, not moved";
    return formatted("mean of the mask frames, moved %g pixels %s and %g %s", std::abs(mask.shift_x_px),
                     mask.shift_x_px < 0.0 ? "left" : "right", std::abs(mask.shift_y_px),
                     mask.shift_y_px < 0.0 ? "up" : "down");
}

// According to DICOM C.7.6.10, the mean of the mask frames is subtracted from every other frame.
void put_mask(XaItem &item, const XrayRun &run)
{
    if (!run.mask) return;
    item.text(DCM_RecommendedViewingMode, "SUB");
    DcmItem *sequence = nullptr;
    if (item.item().findOrCreateSequenceItem(DCM_MaskSubtractionSequence, sequence).bad())
        throw std::logic_error("DICOM mask sequence cannot be made");
    XaItem mask(*sequence);
    std::vector<std::uint16_t> numbers; // counted from 1
    for (int frame : run.mask->frames) numbers.push_back(static_cast<std::uint16_t>(frame + 1));
    std::sort(numbers.begin(), numbers.end());
    mask.text(DCM_MaskOperation, "AVG_SUB");
    mask.shorts(DCM_MaskFrameNumbers, numbers);
    // The mean is not subtracted from mask frames at the start of the run.
    const auto count = static_cast<std::uint16_t>(run.frames.size());
    if (numbers.back() == numbers.size() && numbers.back() < count)
        mask.shorts(DCM_ApplicableFrameRange, {static_cast<std::uint16_t>(numbers.back() + 1), count});
    // C.7.6.10.1.2 requires the row shift of the mask first, positive towards the lower row, and then the
    // column shift, positive towards the left.
    mask.floats(DCM_MaskSubPixelShift,
                {static_cast<float>(run.mask->shift_y_px), static_cast<float>(0.0 - run.mask->shift_x_px)});
    mask.text(DCM_MaskOperationExplanation, mask_in_words(*run.mask));
}

// C.7.6.4
void put_contrast(XaItem &item, const XrayRun &run)
{
    if (!run.contrast) return;
    const RunContrast &contrast = *run.contrast;
    item.text(DCM_ContrastBolusAgent, contrast.agent);
    item.text(DCM_ContrastBolusRoute, "INTRA-ARTERIAL");
    item.text(DCM_ContrastBolusIngredient, "IODINE");
    if (contrast.iodine_mg_ml > 0.0)
        item.decimal(DCM_ContrastBolusIngredientConcentration, contrast.iodine_mg_ml);
    if (contrast.volume_ml > 0.0) item.decimal(DCM_ContrastBolusVolume, contrast.volume_ml);
    if (contrast.flow_ml_s > 0.0) item.decimal(DCM_ContrastFlowRate, contrast.flow_ml_s);
    if (contrast.duration_s > 0.0) item.decimal(DCM_ContrastFlowDuration, contrast.duration_s);
}

void require(bool holds, const std::string &what)
{
    if (!holds) throw std::invalid_argument("run: " + what);
}

void check_mask(const XrayRun &run)
{
    require(run.kind != RunKind::dsa || run.mask.has_value(), "DSA without a mask");
    if (!run.mask) return;
    require(!run.mask->frames.empty(), "a mask needs a frame");
    for (int frame : run.mask->frames)
        require(frame >= 0 && frame < static_cast<int>(run.frames.size()),
                "mask frame " + std::to_string(frame) + " is not in the run of " +
                    std::to_string(run.frames.size()));
}

} // namespace

void check_run(const XrayRun &run)
{
    require(!run.frames.empty(), "no frames");
    require(run.frames.size() <= xa_frames_max, std::to_string(run.frames.size()) +
                                                    " frames, a file holds at most " +
                                                    std::to_string(xa_frames_max));
    require(run.size >= 1 && run.size <= 65535, "a size of " + std::to_string(run.size) + " pixels");
    require(run.bits == 8 || run.bits == 10 || run.bits == 12 || run.bits == 16,
            std::to_string(run.bits) + " bits; XA has 8, 10, 12 or 16");
    require(run.pulses_per_s > 0.0, "a pulse rate of 0");
    require(run.relation != PixelRelation::logarithmic || run.to_linear.size() == std::size_t{1} << run.bits,
            "logarithmic values need a table with an entry for each");
    for (std::size_t i = 1; i < run.frames.size(); i++)
        require(run.frames[i].tick >= run.frames[i - 1].tick,
                "frame " + std::to_string(i) + " is before the last one");
    for (std::size_t i = 0; i < run.frames.size(); i++) {
        const CArm &carm = run.frames[i].carm; // a view of angles without number is undefined
        require(std::isfinite(carm.primary_deg) && std::isfinite(carm.secondary_deg) &&
                    carm.isocentre_m.allFinite() && std::isfinite(carm.source_detector_m) &&
                    std::isfinite(carm.source_isocentre_m) && std::isfinite(carm.field_m),
                "the C-arm's place at frame " + std::to_string(i) + " is not a finite number");
    }
    check_mask(run);
}

void put_attributes(DcmDataset &dataset, const XrayRun &run, const XaStudy &study, const Digest &content,
                    int instance)
{
    XaItem item(dataset);
    put_patient(item, study);
    put_study(item, run, study);
    put_image(item, run, content, study, instance);
    put_pixel_format(item, run);
    put_relation(item, run);
    put_times(item, run);
    put_mask(item, run);
    put_contrast(item, run);
    put_acquisition(item, run);
    put_collimator(item, run);
    put_table(item, run);
    put_positioner(item, run);
    put_frames_private(item, run);
}

} // namespace crn
