// Exports the X-ray runs of a session as a folder of DICOM files. Frames are written to temporary files on
// disk as they are made. The DICOM files are written at the end of the session, when all their attributes are
// known. Files are named run_01_fluoro.dcm, run_02_dsa.dcm; a long run continues in run_01_fluoro_2.dcm.
#pragma once
#include "host/dicom/xa_file.hpp"
#include "host/xray/run.hpp"
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct DicomSettings {
    std::string folder; // empty: none
    std::string values =
        "log"; // log or linear in the X-ray intensity, or display: as on the screen (docs/output.md)
    std::string patient_name, patient_id, study_date; // empty: anonymous
};

// Throws UsageError when the export cannot use the folder, or when a DICOM file may not contain the given
// patient's name, number or date.
void check_dicom_settings(const DicomSettings &settings);

struct ExportProgress {
    std::size_t file = 0, files = 0; // the current file, counted from 1
    std::string name;
    std::size_t bytes_done = 0, bytes = 0; // of all files
};

class DicomExport
{
  public:
    // `session` is a text about scene and tools by which this session differs from others. Makes the folder.
    // Throws OutputError.
    DicomExport(const DicomSettings &settings, const std::string &session);
    ~DicomExport(); // removes unfinished files, and the folder if it made it and it is empty

    // Begins an X-ray run; `run` describes the run, but has no frames yet. Converts linear pixel values to
    // logarithmic ones when the settings require it.
    void begin(XrayRun run);
    void add(RunFrame frame); // throws OutputError
    void end();               // ends the run; a run without frames is dropped
    bool is_in_run() const { return is_in_run_; }
    std::size_t run_count() const { return run_count_; }
    // Adds a complete run, with all its frames.
    void add_run(const XrayRun &run);

    // Sets the subtraction mask of the run with this index, counted from 0. If a run has several files, its
    // first file contains the mask.
    void set_mask(std::size_t run, const RunMask &mask);

    // Stores in each file how much contrast medium was injected during its frames. The function `given` is
    // called with the ticks of the file's first and last frame, and returns the injected medium.
    void set_contrast(const std::function<std::optional<RunContrast>(std::uint32_t, std::uint32_t)> &given);

    // Writes the files; no function of this object may be called afterwards. The function `report` receives
    // the progress of the export, and returns whether the export must continue. Returns the names of the
    // files that were written: all files, or only those that were complete before the export was stopped.
    // Throws OutputError.
    std::vector<std::string> finish(const std::function<bool(const ExportProgress &)> &report);

  private:
    struct Part {
        XrayRun run;
        XaPixels pixels;
        std::string name;
    };
    void begin_part();
    void end_part();
    std::string study_key() const;

    DicomSettings settings_;
    std::string session_;
    bool made_folder_ = false;
    std::unique_ptr<XaSpool> spool_;
    std::vector<Part> parts_;
    std::vector<std::uint32_t> histogram_; // of the current part, by value
    XrayRun header_;
    bool is_in_run_ = false;
    std::size_t run_count_ = 0;
    int part_of_run_ = 0;
};

} // namespace crn
