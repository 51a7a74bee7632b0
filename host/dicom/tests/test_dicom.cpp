// These tests check the following. An X-ray run becomes a valid DICOM file. DCMTK reads the file back pixel
// for pixel. dciodvfy and dctopnm (from dicom3tools, which shares no code with DCMTK) accept the file. The
// attributes equal the inputs, and a failure never leaves an incomplete file.
#include "host/base/tests/folder.hpp"
#include "host/dicom/xa_file.hpp"
#include "host/xray/tests/xray_runs.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <filesystem>
#include <fstream>
#include <set>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
namespace fs = std::filesystem;

namespace
{

// Each test works in its own folder.
struct Folder : tests::Folder {
    Folder() : tests::Folder("dicom") {}
};

XaStudy study_of(const std::string &text)
{
    Digest digest;
    digest.add(text);
    XaStudy study;
    study.key = digest.hex();
    return study;
}

std::string bytes_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Reader {
    explicit Reader(const std::string &path)
    {
        const OFCondition condition = format.loadFile(path.c_str());
        if (condition.bad()) fail_msg("%s: %s", path.c_str(), condition.text());
        item = format.getDataset();
    }
    std::string text(const DcmTagKey &tag)
    {
        OFString value;
        if (item->findAndGetOFStringArray(tag, value).bad()) return "absent";
        return value.c_str();
    }
    double number(const DcmTagKey &tag, unsigned long index = 0)
    {
        OFString value;
        if (item->findAndGetOFString(tag, value, index).bad()) return NAN;
        return std::atof(value.c_str());
    }
    std::vector<std::uint16_t> pixels()
    {
        const Uint16 *values = nullptr;
        unsigned long count = 0;
        assert_true(item->findAndGetUint16Array(DCM_PixelData, values, &count).good());
        return {values, values + count};
    }
    DcmFileFormat format;
    DcmItem *item;
};

void assert_text(Reader &reader, const DcmTagKey &tag, const char *expected)
{
    const std::string value = reader.text(tag);
    if (value != expected)
        fail_msg("%s is '%s', expected '%s'", tag.toString().c_str(), value.c_str(), expected);
}

void assert_near(const char *name, double value, double expected, double allowed)
{
    if (!(std::abs(value - expected) <= allowed))
        fail_msg("%s = %.9g, expected %.9g, allowed %.2g", name, value, expected, allowed);
}

std::vector<std::uint16_t> all_pixels(const XrayRun &run)
{
    std::vector<std::uint16_t> all;
    for (const RunFrame &frame : run.frames) all.insert(all.end(), frame.raw.begin(), frame.raw.end());
    return all;
}

std::string output_of(const std::string &command, int *exit_code = nullptr)
{
    std::FILE *pipe = popen((command + " 2>&1").c_str(), "r");
    std::string text;
    char piece[512];
    while (std::size_t count = std::fread(piece, 1, sizeof piece, pipe)) text.append(piece, count);
    const int status = pclose(pipe);
    if (exit_code) *exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return text;
}

// Fails the test when a line of dciodvfy's output contains "Error". The test also fails when the program
// dciodvfy is missing.
void assert_valid(const std::string &path)
{
    const std::string said = output_of("dciodvfy " + path);
    if (said.find("XAImage") == said.npos)
        fail_msg("dciodvfy (package dicom3tools) did not recognise an XA image: %s", said.c_str());
    if (said.find("Error") != said.npos) fail_msg("%s", said.c_str());
}

// Returns the message of the exception that `call` must throw.
template <class Error, class Work> std::string message_of(const Work &work)
{
    try {
        work();
    } catch (const Error &error) {
        return error.what();
    }
    fail_msg("nothing was thrown");
    return "";
}

bool contains(const std::string &text, const std::string &part)
{
    return text.find(part) != text.npos;
}

} // namespace

static void pixels_of_every_kind_read_back_as_they_were(void **)
{
    Folder folder;
    for (RunKind kind : {RunKind::fluoro, RunKind::cine, RunKind::dsa}) {
        const XrayRun run = sample_run(kind, 5, kind == RunKind::cine);
        write_xa(folder.file("a.dcm"), run, study_of("a"));
        Reader reader(folder.file("a.dcm"));
        assert_true(reader.pixels() == all_pixels(run));
        assert_text(reader, DCM_SOPClassUID,
                    "1.2.840.10008.5.1.4.1.1.12.1"); // X-Ray Angiographic Image Storage
        assert_text(reader, DCM_NumberOfFrames, "5");
        assert_text(reader, DCM_BitsStored, "16");
        assert_int_equal(folder.count(), 1);
    }
}

// The pixels are the last bytes of the file, frame after frame, little-endian, so the test reads them without
// a library.
static void pixels_lie_in_the_file_as_in_memory(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::fluoro, 3);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    const std::string bytes = bytes_of(folder.file("a.dcm"));
    const std::vector<std::uint16_t> pixels = all_pixels(run);
    const std::size_t length = pixels.size() * 2;
    assert_memory_equal(bytes.data() + bytes.size() - length, pixels.data(), length);
}

static void another_implementation_reads_the_same_pixels(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::cine, 1);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    const std::string said =
        output_of("dctopnm -output-byteorder little " + folder.file("a.dcm") + " " + folder.file("a.pnm"));
    const std::string bytes = bytes_of(folder.file("a.pnm"));
    const std::size_t length = run.frames[0].raw.size() * 2;
    if (bytes.size() < length) fail_msg("dctopnm (package dicom3tools) wrote no picture: %s", said.c_str());
    assert_memory_equal(bytes.data() + bytes.size() - length, run.frames[0].raw.data(), length);
}

static void dciodvfy_finds_no_error_in_fluoro_cine_and_dsa(void **)
{
    Folder folder;
    for (RunKind kind : {RunKind::fluoro, RunKind::cine, RunKind::dsa})
        for (bool moves : {false, true}) {
            write_xa(folder.file("a.dcm"), sample_run(kind, 4, moves), study_of("a"));
            assert_valid(folder.file("a.dcm"));
        }
}

static void dciodvfy_finds_no_error_in_the_other_forms(void **)
{
    Folder folder;
    XrayRun logarithmic = sample_run(RunKind::dsa, 4);
    make_logarithmic(logarithmic);
    XrayRun round = sample_run(RunKind::fluoro, 1);
    round.collimator = {true, 0, 0, 0, 0, 32.0, 31.0, 30.0};
    XrayRun display = sample_run(RunKind::cine, 2);
    display.relation = PixelRelation::display;
    XrayRun bare; // only what every run needs
    bare.size = run_size;
    bare.pulses_per_s = 7.5;
    bare.collimator.right = bare.collimator.bottom = run_size;
    bare.frames = {display.frames[0]};
    bare.frames[0].tube_voltage_kV = bare.frames[0].tube_current_mA = bare.frames[0].pulse_ms = 0.0;
    bare.frames[0].air_kerma_uGy = bare.frames[0].kap_Gy_cm2 = 0.0;
    XaStudy named = study_of("a");
    named.patient_name = "Phantom^Renal";
    named.patient_id = "P7";
    named.date = "20200229";
    named.description = "Practice";
    for (const XrayRun &run : {logarithmic, round, display, bare}) {
        write_xa(folder.file("a.dcm"), run, named);
        assert_valid(folder.file("a.dcm"));
    }
}

static void angles_distances_and_spacing_are_those_of_the_c_arm(void **)
{
    Folder folder;
    XrayRun run = sample_run(RunKind::fluoro, 2);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_PositionerMotion, "STATIC");
    assert_text(reader, DCM_PositionerPrimaryAngle, "40");    // + LAO
    assert_text(reader, DCM_PositionerSecondaryAngle, "-30"); // - CAU
    assert_text(reader, DCM_PositionerPrimaryAngleIncrement, "absent");
    assert_text(reader, DCM_DistanceSourceToDetector, "1050");
    assert_text(reader, DCM_DistanceSourceToPatient, "750");
    assert_text(reader, DCM_EstimatedRadiographicMagnificationFactor, "1.4");
    assert_text(reader, DCM_TableMotion, "STATIC");
    assert_text(reader, DCM_FieldOfViewDimensions, "320\\320");
    assert_text(reader, DCM_ImagerPixelSpacing, "5\\5"); // 320 mm / 64
    assert_near("pixel at the isocentre", reader.number(DCM_PixelSpacing), 5.0 / 1.4, 1e-8);
    // In a view of 40 LAO 30 CAU the right side of the picture points mainly towards the patient's left, and
    // less towards the back. The bottom of the picture points mainly towards the feet, less towards the back,
    // and least towards the patient's right (docs/frames.md).
    assert_text(reader, DCM_PatientOrientation, "LP\\FPR");
}

static void a_moving_arm_and_table_have_an_offset_per_frame(void **)
{
    Folder folder;
    write_xa(folder.file("a.dcm"), sample_run(RunKind::cine, 4, true), study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_PositionerMotion, "DYNAMIC");
    assert_text(reader, DCM_PositionerPrimaryAngle, "10");
    assert_text(reader, DCM_PositionerPrimaryAngleIncrement, "0\\2.5\\5\\7.5");
    assert_text(reader, DCM_PositionerSecondaryAngleIncrement, "0\\-1.25\\-2.5\\-3.75");
    // In each frame the isocentre moves in the patient by 1 mm to the right, 2 mm to the head and 3 mm to the
    // front. The table therefore moves 1 mm left, 2 mm to the feet and 3 mm down. In DICOM, longitudinal
    // table motion is positive towards LAO, and lateral motion towards cranial (C.8.7.4.1).
    assert_text(reader, DCM_TableMotion, "DYNAMIC");
    assert_text(reader, DCM_TableLongitudinalIncrement, "0\\1\\2\\3");
    assert_text(reader, DCM_TableLateralIncrement, "0\\-2\\-4\\-6");
    assert_text(reader, DCM_TableVerticalIncrement, "0\\3\\6\\9");
}

static void tube_and_dose_are_sums_and_means_in_the_units_of_the_standard(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::cine, 5);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_RadiationSetting, "GR");
    assert_near("kVp", reader.number(DCM_KVP), 77.0, 0.0);                                  // 75 .. 79
    assert_near("tube current, uA", reader.number(DCM_XRayTubeCurrentInuA), 101000.0, 0.0); // 100 .. 102 mA
    assert_near("exposure time, us", reader.number(DCM_ExposureTimeInuS), 25000.0, 0.0); // 5 pulses of 5 ms
    assert_near("exposure, uAs", reader.number(DCM_ExposureInuAs), 2525.0, 0.0);         // 101 mA x 25 ms
    assert_near("pulse, ms", reader.number(DCM_AveragePulseWidth), 5.0, 0.0);
    // Five frames of 0.004 Gy cm2 give a kerma-area product of 0.02 Gy cm2, which is 0.2 dGy cm2. The kerma
    // of the five frames is the sum 20 + .. + 24 uGy = 0.11 mGy.
    assert_near("KAP, dGy cm2", reader.number(DCM_ImageAndFluoroscopyAreaDoseProduct), 0.2, 1e-9);
    assert_near("kerma, mGy", reader.number(DCM_EntranceDoseInmGy), 0.11, 1e-9);
    assert_text(reader, DCM_FilterMaterial, "ALUMINUM\\COPPER");
    assert_text(reader, DCM_FilterThicknessMaximum, "2.5\\0.2");
    write_xa(folder.file("b.dcm"), sample_run(RunKind::fluoro, 1), study_of("a"));
    Reader fluoro(folder.file("b.dcm"));
    assert_text(fluoro, DCM_RadiationSetting, "SC");
}

// DICOM counts rows and columns from 1, and the attributes of the collimator name the last row or column that
// each blade covers. In this test, no blade may therefore cover columns 2 to 63 and rows 3 to 62 of the
// picture.
static void collimator_edges_are_the_last_covered_columns_and_rows(void **)
{
    Folder folder;
    write_xa(folder.file("a.dcm"), sample_run(RunKind::fluoro, 1), study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_CollimatorShape, "RECTANGULAR");
    assert_text(reader, DCM_CollimatorLeftVerticalEdge, "1");
    assert_text(reader, DCM_CollimatorRightVerticalEdge, "64");
    assert_text(reader, DCM_CollimatorUpperHorizontalEdge, "2");
    assert_text(reader, DCM_CollimatorLowerHorizontalEdge, "63");
}

static void even_frames_have_one_frame_time_uneven_ones_a_vector(void **)
{
    Folder folder;
    XrayRun run = sample_run(RunKind::fluoro, 4);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    Reader even(folder.file("a.dcm"));
    assert_text(even, DCM_FrameIncrementPointer, "(0018,1063)");
    assert_near("frame time, ms", even.number(DCM_FrameTime), 1000.0 / 15.0, 1e-6);
    assert_text(even, DCM_FrameTimeVector, "absent");
    run.frames[2].tick += 50;
    run.frames[3].tick += 50;
    write_xa(folder.file("b.dcm"), run, study_of("a"));
    Reader uneven(folder.file("b.dcm"));
    assert_text(uneven, DCM_FrameIncrementPointer, "(0018,1065)");
    assert_text(uneven, DCM_FrameTimeVector, "0\\67\\117\\66");
    assert_text(uneven, DCM_CineRate, "15");
}

static void a_dsa_run_names_its_mask_shift_and_contrast(void **)
{
    Folder folder;
    write_xa(folder.file("a.dcm"), sample_run(RunKind::dsa, 6), study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_RecommendedViewingMode, "SUB");
    DcmItem *mask = nullptr;
    assert_true(reader.item->findAndGetSequenceItem(DCM_MaskSubtractionSequence, mask).good());
    reader.item = mask;
    assert_text(reader, DCM_MaskOperation, "AVG_SUB");
    assert_text(reader, DCM_MaskFrameNumbers, "1\\2");
    assert_text(reader, DCM_ApplicableFrameRange, "3\\6");
    assert_text(reader, DCM_MaskSubPixelShift, "-0.25\\-1.5"); // rows down, then columns to the left
    assert_text(reader, DCM_MaskOperationExplanation,
                "mean of the mask frames, moved 1.5 pixels right and 0.25 up");
    reader.item = reader.format.getDataset();
    assert_text(reader, DCM_ContrastBolusAgent, "iohexol");
    assert_text(reader, DCM_ContrastBolusVolume, "12");
    assert_text(reader, DCM_ContrastFlowRate, "6");
    assert_text(reader, DCM_ContrastBolusIngredientConcentration, "350");
    // If the only mask frame is in the middle of the run (for example, because the user chose another mask),
    // the mask is subtracted from every frame.
    XrayRun late = sample_run(RunKind::dsa, 6);
    late.mask->frames = {4};
    write_xa(folder.file("b.dcm"), late, study_of("a"));
    Reader other(folder.file("b.dcm"));
    assert_true(other.item->findAndGetSequenceItem(DCM_MaskSubtractionSequence, mask).good());
    other.item = mask;
    assert_text(other, DCM_MaskFrameNumbers, "5");
    assert_text(other, DCM_ApplicableFrameRange, "absent");
}

// After make_logarithmic() the difference of two pixels is the logarithm of the ratio of their intensities.
// The table in the file converts the pixels back to linear values.
static void logarithmic_runs_subtract_plainly_and_lead_back_to_linear(void **)
{
    XrayRun run = sample_run(RunKind::dsa, 2);
    const std::vector<std::uint16_t> linear = run.frames[0].raw;
    make_logarithmic(run);
    double worst = 0.0, worst_log = 0.0;
    for (std::size_t i = 0; i < linear.size(); i++) {
        const double value = linear[i], log_value = run.frames[0].raw[i];
        worst_log = std::max(worst_log, std::abs(log_value - 65535.0 / 16.0 * std::log2(1.0 + value)));
        worst = std::max(worst, std::abs(run.to_linear[run.frames[0].raw[i]] - value) / std::max(value, 1.0));
    }
    assert_near("steps off the logarithm", worst_log, 0.0, 1.0);
    assert_near("share lost on the way back", worst, 0.0, 1e-3);
    for (std::size_t i = 1; i < run.to_linear.size(); i++)
        assert_true(run.to_linear[i] >= run.to_linear[i - 1]);
    Folder folder;
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_PixelIntensityRelationship, "LOG");
    DcmItem *table = nullptr;
    assert_true(reader.item->findAndGetSequenceItem(DCM_ModalityLUTSequence, table).good());
    const Uint16 *values = nullptr;
    unsigned long count = 0;
    assert_true(table->findAndGetUint16Array(DCM_LUTData, values, &count).good());
    assert_int_equal(count, 65536);
    assert_memory_equal(values, run.to_linear.data(), count * 2);
}

static void ticks_and_figures_of_every_frame_are_kept(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::cine, 3);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DcmTagKey(0x0023, 0x0010), "COURNAND 1.0");
    const Uint32 *ticks = nullptr;
    unsigned long count = 0;
    assert_true(reader.item->findAndGetUint32Array(DcmTagKey(0x0023, 0x1001), ticks, &count).good());
    assert_int_equal(count, 3);
    assert_int_equal(ticks[2], run.frames[2].tick);
    const Float64 *kerma_uGy = nullptr;
    assert_true(reader.item->findAndGetFloat64Array(DcmTagKey(0x0023, 0x1005), kerma_uGy, &count).good());
    assert_true(count == 3 && kerma_uGy[2] == run.frames[2].air_kerma_uGy);
}

static void files_are_anonymous_unless_a_patient_is_named(void **)
{
    Folder folder;
    write_xa(folder.file("a.dcm"), sample_run(RunKind::fluoro, 1), study_of("a"));
    Reader reader(folder.file("a.dcm"));
    assert_text(reader, DCM_PatientName, "Anonymous^");
    assert_text(reader, DCM_PatientIdentityRemoved, "YES");
    assert_true(reader.text(DCM_PatientID) == "ANON-" + study_of("a").key.substr(0, 8));
    for (const DcmTagKey &tag : {DCM_PatientBirthDate, DCM_PatientSex, DCM_StudyDate, DCM_StudyTime,
                                 DCM_ReferringPhysicianName, DCM_AccessionNumber})
        assert_text(reader, tag, "");
    XaStudy named = study_of("a");
    named.patient_name = "Phantom^Renal";
    named.patient_id = "P7";
    named.date = "20200229";
    write_xa(folder.file("b.dcm"), sample_run(RunKind::fluoro, 1), named);
    Reader other(folder.file("b.dcm"));
    assert_text(other, DCM_PatientName, "Phantom^Renal");
    assert_text(other, DCM_PatientID, "P7");
    assert_text(other, DCM_StudyDate, "20200229");
    assert_text(other, DCM_PatientIdentityRemoved, "absent");
    // Files of different patients belong to different studies.
    assert_true(other.text(DCM_StudyInstanceUID) != reader.text(DCM_StudyInstanceUID));
}

static void the_same_run_gives_the_same_bytes_and_another_one_other_uids(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::fluoro, 2);
    write_xa(folder.file("a.dcm"), run, study_of("a"));
    write_xa(folder.file("b.dcm"), run, study_of("a"));
    assert_true(bytes_of(folder.file("a.dcm")) == bytes_of(folder.file("b.dcm")));
    XrayRun other = run;
    other.frames[1].raw[77]++;
    write_xa(folder.file("c.dcm"), other, study_of("a"));
    write_xa(folder.file("d.dcm"), run, study_of("a"), 2);
    std::set<std::string> images, studies;
    for (const char *name : {"a.dcm", "c.dcm", "d.dcm"}) {
        Reader reader(folder.file(name));
        images.insert(reader.text(DCM_SOPInstanceUID));
        studies.insert(reader.text(DCM_StudyInstanceUID));
    }
    assert_int_equal(images.size(), 3);
    assert_int_equal(studies.size(), 1);
}

// A UID is "2.25." and a decimal number below 2^128 that does not begin with 0 (PS3.5 B.2).
static void uids_have_the_form_of_the_standard(void **)
{
    std::set<std::string> all;
    for (int i = 0; i < 2000; i++) {
        const int value = i;
        Digest digest;
        digest.add(&value, sizeof value);
        const std::string uid = digest.uid();
        assert_true(uid.compare(0, 5, "2.25.") == 0 && uid.size() <= 44 && uid[5] != '0');
        assert_true(uid.find_first_not_of("0123456789", 5) == uid.npos);
        all.insert(uid);
    }
    assert_int_equal(all.size(), 2000);
    Digest one, two;
    one.add("ab");
    one.add("c");
    two.add("a");
    two.add("bc");
    assert_true(one.uid() != two.uid());
}

static void a_run_that_contradicts_itself_is_refused(void **)
{
    Folder folder;
    const auto refused = [&](const XrayRun &run, const char *part) {
        const std::string said =
            message_of<std::invalid_argument>([&] { write_xa(folder.file("a.dcm"), run, study_of("a")); });
        if (!contains(said, part)) fail_msg("'%s' does not say '%s'", said.c_str(), part);
        assert_int_equal(folder.count(), 0);
    };
    const XrayRun good = sample_run(RunKind::dsa, 3);
    XrayRun run = good;
    run.frames.clear();
    refused(run, "no frames");
    run = good;
    run.frames[1].raw.pop_back();
    refused(run, "frame 1 has 4095 pixels, the first one 4096");
    run = good;
    run.size = 32;
    refused(run, "3 frames of 1024 pixels, 3 of 4096 were added");
    run = good;
    run.mask.reset();
    refused(run, "DSA without a mask");
    run = good;
    run.mask->frames = {3};
    refused(run, "mask frame 3 is not in the run of 3");
    run = good;
    run.frames[2].tick = 1;
    refused(run, "frame 2 is before the last one");
    run = good;
    run.bits = 14;
    refused(run, "14 bits");
    run = good;
    run.relation = PixelRelation::logarithmic;
    refused(run, "a table");
    run = good;
    run.pulses_per_s = 0.0;
    refused(run, "pulse rate");
    run = good;
    run.frames[0].carm.primary_deg = NAN;
    refused(run, "place at frame 0 is not a finite number");
    run = good;
    run.frames[0].carm.field_m = INFINITY;
    refused(run, "place at frame 0 is not a finite number");
    run = good;
    run.frames[0].tube_voltage_kV = NAN;
    refused(run, "not be a finite number");
}

static void an_interrupted_export_leaves_nothing_and_keeps_what_was_there(void **)
{
    Folder folder;
    const std::string path = folder.file("a.dcm");
    std::ofstream(path) << "what was there";
    const XrayRun run = sample_run(RunKind::cine, 300); // three pieces of a megabyte
    int calls = 0;
    message_of<XaInterrupted>([&] {
        write_xa(path, run, study_of("a"), 1, [&](std::size_t done, std::size_t total) {
            assert_true(done <= total && total == 300 * 4096 * 2);
            return ++calls < 2;
        });
    });
    assert_int_equal(calls, 2);
    assert_int_equal(folder.count(), 1);
    assert_true(bytes_of(path) == "what was there");
    write_xa(path, run, study_of("a"));
    assert_true(bytes_of(path).size() > 300 * 4096 * 2);
    assert_int_equal(folder.count(), 1);
}

// A limit on the size of written files simulates a full disk: a write fails in the middle of the file.
static void a_full_disk_is_told_and_leaves_nothing(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::cine, 40);
    for (rlim_t limit : {rlim_t{20000}, rlim_t{40 * 4096 * 2 + 1000}}) { // while spooling; while writing
        const pid_t child = fork();
        if (child == 0) {
            const struct rlimit small = {limit, limit};
            setrlimit(RLIMIT_FSIZE, &small);
            try {
                write_xa(folder.file("a.dcm"), run, study_of("a"));
            } catch (const OutputError &error) {
                const std::string said = error.what();
                _exit(contains(said, "a.dcm: cannot be written: File too large; make room") ? 7 : 8);
            }
            _exit(9);
        }
        int status = 0;
        waitpid(child, &status, 0);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 7);
        assert_int_equal(folder.count(), 0);
    }
}

static void a_name_that_cannot_be_a_file_is_refused(void **)
{
    Folder folder;
    const XrayRun run = sample_run(RunKind::fluoro, 1);
    const auto said = [&](const std::string &path) {
        return message_of<OutputError>([&] { write_xa(path, run, study_of("a")); });
    };
    assert_true(contains(said(folder.path), "is a folder"));
    assert_true(contains(said("/dev/null"), "is a device or pipe"));
    assert_true(
        contains(said(folder.file("no/a.dcm")), "No such file or directory; check that the folder exists"));
    assert_int_equal(folder.count(), 0);
}

int main()
{
    dcmDataDict.isDictionaryLoaded(); // once, before child processes start
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_of_every_kind_read_back_as_they_were),
        cmocka_unit_test(pixels_lie_in_the_file_as_in_memory),
        cmocka_unit_test(another_implementation_reads_the_same_pixels),
        cmocka_unit_test(dciodvfy_finds_no_error_in_fluoro_cine_and_dsa),
        cmocka_unit_test(dciodvfy_finds_no_error_in_the_other_forms),
        cmocka_unit_test(angles_distances_and_spacing_are_those_of_the_c_arm),
        cmocka_unit_test(a_moving_arm_and_table_have_an_offset_per_frame),
        cmocka_unit_test(tube_and_dose_are_sums_and_means_in_the_units_of_the_standard),
        cmocka_unit_test(collimator_edges_are_the_last_covered_columns_and_rows),
        cmocka_unit_test(even_frames_have_one_frame_time_uneven_ones_a_vector),
        cmocka_unit_test(a_dsa_run_names_its_mask_shift_and_contrast),
        cmocka_unit_test(logarithmic_runs_subtract_plainly_and_lead_back_to_linear),
        cmocka_unit_test(ticks_and_figures_of_every_frame_are_kept),
        cmocka_unit_test(files_are_anonymous_unless_a_patient_is_named),
        cmocka_unit_test(the_same_run_gives_the_same_bytes_and_another_one_other_uids),
        cmocka_unit_test(uids_have_the_form_of_the_standard),
        cmocka_unit_test(a_run_that_contradicts_itself_is_refused),
        cmocka_unit_test(an_interrupted_export_leaves_nothing_and_keeps_what_was_there),
        cmocka_unit_test(a_full_disk_is_told_and_leaves_nothing),
        cmocka_unit_test(a_name_that_cannot_be_a_file_is_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
