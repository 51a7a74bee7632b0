// Tests the export of a session's X-ray runs as DICOM files: which frames go into which file, how values are
// converted, and what remains after an export was stopped. The tests read the pixels of the exported files
// with the library DCMTK; the frames are tiny.
#include "host/base/output_files.hpp"
#include "host/base/tests/folder.hpp"
#include "host/picture/dicom_export.hpp"
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdlib>
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <filesystem>
#include <fstream>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
namespace fs = std::filesystem;

namespace
{

constexpr int tiny = 4; // pixels along each edge

struct Folder : tests::Folder {
    Folder() : tests::Folder("export") { settings.folder = file("dicom"); }
    std::vector<std::string> names() const
    {
        std::vector<std::string> all;
        if (!fs::exists(settings.folder)) return all;
        for (const auto &entry : fs::directory_iterator(settings.folder))
            all.push_back(entry.path().filename());
        std::sort(all.begin(), all.end());
        return all;
    }
    DicomSettings settings;
};

XrayRun header_of(RunKind kind)
{
    XrayRun run;
    run.kind = kind;
    run.size = tiny;
    run.pulses_per_s = 15.0;
    run.collimator.right = run.collimator.bottom = tiny;
    return run;
}

RunFrame frame_at(std::uint32_t tick, std::uint16_t value)
{
    RunFrame frame;
    frame.tick = tick;
    frame.raw.assign(tiny * tiny, value);
    return frame;
}

bool go_on(const ExportProgress &)
{
    return true;
}

struct Read {
    explicit Read(const std::string &path)
    {
        if (format.loadFile(path.c_str()).bad()) fail_msg("%s cannot be read", path.c_str());
    }
    std::string text(const DcmTagKey &tag)
    {
        OFString value;
        format.getDataset()->findAndGetOFStringArray(tag, value);
        return value.c_str();
    }
    std::uint16_t pixel(std::size_t index)
    {
        const Uint16 *values = nullptr;
        unsigned long count = 0;
        format.getDataset()->findAndGetUint16Array(DCM_PixelData, values, &count);
        assert_true(index < count);
        return values[index];
    }
    DcmFileFormat format;
};

void assert_names(const Folder &folder, const std::vector<std::string> &expected)
{
    const std::vector<std::string> names = folder.names();
    if (names == expected) return;
    std::string all;
    for (const std::string &name : names) all += " " + name;
    fail_msg("the folder holds%s", all.c_str());
}

} // namespace

static void runs_are_numbered_in_order_and_named_by_their_kind(void **)
{
    Folder folder;
    folder.settings.values = "linear";
    DicomExport out(folder.settings, "wire");
    for (RunKind kind : {RunKind::fluoro, RunKind::cine, RunKind::dsa}) {
        XrayRun run = header_of(kind);
        if (kind == RunKind::dsa) run.mask = RunMask{{0}, 0.0, 0.0};
        run.frames = {frame_at(100, 7), frame_at(167, 8)};
        out.add_run(run);
    }
    const std::vector<std::string> written = out.finish(go_on);
    assert_int_equal(written.size(), 3);
    assert_names(folder, {"run_01_fluoro.dcm", "run_02_cine.dcm", "run_03_dsa.dcm"});
    Read first(written[0]), last(written[2]);
    assert_string_equal(last.text(DCM_AcquisitionNumber).c_str(), "3");
    assert_string_equal(last.text(DCM_InstanceNumber).c_str(), "3");
    assert_string_equal(last.text(DCM_NumberOfFrames).c_str(), "2");
    assert_true(first.text(DCM_StudyInstanceUID) == last.text(DCM_StudyInstanceUID));
    assert_true(first.text(DCM_SeriesInstanceUID) == last.text(DCM_SeriesInstanceUID));
    assert_true(first.text(DCM_SOPInstanceUID) != last.text(DCM_SOPInstanceUID));
    assert_int_equal(last.pixel(tiny * tiny), 8);
}

static void a_press_without_a_frame_is_no_run(void **)
{
    Folder folder;
    DicomExport out(folder.settings, "wire");
    out.begin(header_of(RunKind::fluoro));
    out.end();
    out.begin(header_of(RunKind::fluoro));
    out.add(frame_at(5, 1));
    out.end();
    assert_int_equal(out.run_count(), 1);
    out.finish(go_on);
    assert_names(folder, {"run_01_fluoro.dcm"});
}

// Frames whose pixels have different sizes on the detector must go into different files.
static void another_field_begins_another_file_of_the_same_run(void **)
{
    Folder folder;
    DicomExport out(folder.settings, "wire");
    out.begin(header_of(RunKind::fluoro));
    for (double field_m : {0.32, 0.32, 0.20}) {
        RunFrame frame = frame_at(field_m > 0.3 ? 10 : 20, 100);
        frame.carm.field_m = field_m;
        out.add(frame);
    }
    const std::vector<std::string> written = out.finish(go_on);
    assert_names(folder, {"run_01_fluoro.dcm", "run_01_fluoro_2.dcm"});
    Read wide(written[0]), narrow(written[1]);
    assert_string_equal(wide.text(DCM_ImagerPixelSpacing).c_str(), "80\\80");
    assert_string_equal(narrow.text(DCM_ImagerPixelSpacing).c_str(), "50\\50");
    assert_string_equal(narrow.text(DCM_AcquisitionNumber).c_str(), "1");
    assert_string_equal(narrow.text(DCM_InstanceNumber).c_str(), "2");
}

static void a_run_of_more_than_2000_frames_goes_on_in_the_next_file(void **)
{
    Folder folder;
    folder.settings.values = "linear";
    DicomExport out(folder.settings, "wire");
    out.begin(header_of(RunKind::fluoro));
    for (std::uint32_t i = 0; i < 2003; i++) {
        RunFrame frame = frame_at(i * 67, static_cast<std::uint16_t>(i));
        frame.carm.primary_deg = 0.001 * i; // a vector with a value per frame
        out.add(frame);
    }
    const std::vector<std::string> written = out.finish(go_on);
    assert_names(folder, {"run_01_fluoro.dcm", "run_01_fluoro_2.dcm"});
    Read first(written[0]), second(written[1]);
    assert_string_equal(first.text(DCM_NumberOfFrames).c_str(), "2000");
    assert_string_equal(second.text(DCM_NumberOfFrames).c_str(), "3");
    assert_int_equal(first.pixel(1999 * tiny * tiny), 1999);
    assert_int_equal(second.pixel(2 * tiny * tiny), 2002);
}

// The expected logarithm is log2(1 + 255) = 8, which is half of the scale's range of 16 octaves.
static void values_are_logarithmic_unless_asked_otherwise(void **)
{
    for (const char *values : {"log", "linear"}) {
        Folder folder;
        folder.settings.values = values;
        DicomExport out(folder.settings, "wire");
        XrayRun run = header_of(RunKind::cine);
        run.frames = {frame_at(1, 255)};
        out.add_run(run);
        Read read(out.finish(go_on)[0]);
        const bool is_log = std::string(values) == "log";
        // The computed logarithm is accurate to 2e-5, which here is one step of the stored value.
        assert_in_range(read.pixel(0), is_log ? 32767 : 255, is_log ? 32769 : 255);
        assert_string_equal(read.text(DCM_PixelIntensityRelationship).c_str(), is_log ? "LOG" : "LIN");
    }
}

// The run has 1,000 frames with the values 1, 2, .. 1,000. The display window must leave out the lowest and
// the highest hundredth of the run's values. Pixel values of a saturated detector must not count for the
// display window.
static void the_window_spans_the_run(void **)
{
    for (bool is_bright : {false, true}) {
        Folder folder;
        folder.settings.values = "linear";
        DicomExport out(folder.settings, "wire");
        XrayRun run = header_of(RunKind::cine);
        for (std::uint16_t i = 1; i <= 1000; i++) run.frames.push_back(frame_at(i, i));
        for (std::uint16_t i = 0; is_bright && i < 50; i++) run.frames.push_back(frame_at(2000, 16383));
        out.add_run(run);
        Read read(out.finish(go_on)[0]);
        assert_string_equal(read.text(DCM_WindowCenter).c_str(), "501"); // (11 + 991) / 2
        assert_string_equal(read.text(DCM_WindowWidth).c_str(), "980");
    }
}

// Pixels behind the collimator blades are dark and must not count for the display window.
static void the_window_looks_inside_the_collimator(void **)
{
    Folder folder;
    folder.settings.values = "linear";
    DicomExport out(folder.settings, "wire");
    XrayRun run = header_of(RunKind::cine);
    run.collimator = {false, 0, 4, 1, 3, 0.0, 0.0, 0.0}; // rows 1 and 2
    run.frames = {frame_at(1, 500), frame_at(2, 600)};
    for (RunFrame &frame : run.frames)
        for (int x = 0; x < tiny; x++) frame.raw[x] = frame.raw[3 * tiny + x] = 0;
    out.add_run(run);
    Read read(out.finish(go_on)[0]);
    assert_string_equal(read.text(DCM_WindowCenter).c_str(),
                        "500"); // 600 is the saturation value: as frequent as 500
    assert_string_equal(read.text(DCM_WindowWidth).c_str(), "1");
}

// This test covers a former error: the files did not state volume, flow and strength of the contrast medium
// injected between their first and last frame.
static void each_file_names_the_medium_given_during_its_frames(void **)
{
    Folder folder;
    DicomExport out(folder.settings, "wire");
    for (std::uint32_t begin : {1000, 5000}) {
        XrayRun run = header_of(RunKind::cine);
        run.frames = {frame_at(begin, 7), frame_at(begin + 2000, 7)};
        out.add_run(run);
    }
    out.set_contrast([](std::uint32_t first, std::uint32_t last) -> std::optional<RunContrast> {
        if (first > 1000) return {};
        assert_int_equal(last, 3000);
        return RunContrast{"iohexol", 300.0, 8.0, 4.0, 1100, 2.0};
    });
    const std::vector<std::string> written = out.finish(go_on);
    Read with(written[0]), without(written[1]);
    assert_string_equal(with.text(DCM_ContrastBolusAgent).c_str(), "iohexol");
    assert_string_equal(with.text(DCM_ContrastBolusVolume).c_str(), "8");
    assert_string_equal(with.text(DCM_ContrastFlowRate).c_str(), "4");
    assert_string_equal(with.text(DCM_ContrastFlowDuration).c_str(), "2");
    assert_string_equal(with.text(DCM_ContrastBolusIngredientConcentration).c_str(), "300");
    assert_string_equal(without.text(DCM_ContrastBolusAgent).c_str(), "");
}

static void a_stopped_export_leaves_whole_files_only(void **)
{
    Folder folder;
    DicomExport out(folder.settings, "wire");
    for (int i = 0; i < 3; i++) {
        XrayRun run = header_of(RunKind::fluoro);
        run.frames = {frame_at(1, 255)};
        out.add_run(run);
    }
    const std::vector<std::string> written =
        out.finish([](const ExportProgress &now) { return now.file < 2 && now.files == 3; });
    assert_int_equal(written.size(), 1);
    Read read(written[0]);
    assert_in_range(read.pixel(0), 32767, 32769);
    assert_names(folder, {"run_01_fluoro.dcm"});
}

static void an_export_given_up_leaves_no_folder(void **)
{
    Folder folder;
    {
        DicomExport out(folder.settings, "wire");
        out.begin(header_of(RunKind::fluoro));
        out.add(frame_at(1, 1));
        assert_int_equal(folder.names().size(), 1);
    }
    assert_false(fs::exists(folder.settings.folder));
    fs::create_directory(folder.settings.folder); // an existing folder stays
    {
        DicomExport out(folder.settings, "wire");
    }
    assert_true(fs::exists(folder.settings.folder));
    assert_names(folder, {});
}

// This test covers a former error: bytes that form no UTF-8 character produced a file with unreadable text,
// without a message.
static void a_name_that_is_not_utf8_is_refused(void **)
{
    const auto is_refused = [](const char *name) {
        DicomSettings settings;
        settings.patient_name = name;
        try {
            check_dicom_settings(settings);
        } catch (const UsageError &) {
            return true;
        }
        return false;
    };
    for (const char *good : {"", "Phantom^Aorta", "M\xc3\xbcller^\xe5\xb1\xb1", "\xf0\x9f\x98\x80"})
        if (is_refused(good)) fail_msg("'%s' is refused", good);
    // The invalid texts contain a byte that cannot begin a character, a truncated character, an overlong
    // encoding, half of a surrogate pair, or a code beyond the last character.
    for (const char *bad : {"a\xff", "\x80", "\xc3", "\xe5\xb1", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80",
                            "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80"})
        if (!is_refused(bad)) fail_msg("'%s' is taken", bad);
}

static void another_tool_is_another_study(void **)
{
    std::vector<std::string> uids;
    for (const char *session : {"wire", "wire", "catheter"}) {
        Folder folder;
        DicomExport out(folder.settings, session);
        XrayRun run = header_of(RunKind::fluoro);
        run.frames = {frame_at(1, 255)};
        out.add_run(run);
        uids.push_back(Read(out.finish(go_on)[0]).text(DCM_StudyInstanceUID));
    }
    assert_true(uids[0] == uids[1] && uids[0] != uids[2]);
}

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(runs_are_numbered_in_order_and_named_by_their_kind),
        cmocka_unit_test(a_press_without_a_frame_is_no_run),
        cmocka_unit_test(another_field_begins_another_file_of_the_same_run),
        cmocka_unit_test(a_run_of_more_than_2000_frames_goes_on_in_the_next_file),
        cmocka_unit_test(values_are_logarithmic_unless_asked_otherwise),
        cmocka_unit_test(the_window_spans_the_run),
        cmocka_unit_test(the_window_looks_inside_the_collimator),
        cmocka_unit_test(each_file_names_the_medium_given_during_its_frames),
        cmocka_unit_test(a_stopped_export_leaves_whole_files_only),
        cmocka_unit_test(an_export_given_up_leaves_no_folder),
        cmocka_unit_test(a_name_that_is_not_utf8_is_refused),
        cmocka_unit_test(another_tool_is_another_study),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
