// A run as a DICOM file: X-Ray Angiographic Image Storage, multi-frame (PS3.3 A.14), through DCMTK.
//
//   XaFile file("out/run_01_fluoro.dcm");
//   for (frame of the run) file.add(frame);            // pixels go to disk, not to memory
//   file.write(run, study, 1, nullptr);                // now it has its name
//
// Attributes, units and what each means: docs/output.md. May include: host/xray, host/model. Called by: host/app, tests.
#pragma once
#include "host/dicom/dicom_uid.hpp"
#include "host/model/pending_file.hpp"
#include "host/xray/run.hpp"
#include <functional>
#include <memory>
#include <string>

namespace seld
{

// What all files of one export share.
struct XaStudy {
    std::string
        key; // content-derived, as Digest::hex(): names the study, its series and the patient's number
    std::string patient_name; // empty: "Anonymous^"
    std::string patient_id;   // empty: "ANON-" and the key's first eight digits
    std::string date;         // YYYYMMDD; empty: none
    std::string description;  // of the study
};

// Frames and bytes that one file may hold; longer runs go on in the next. Vectors with a number per frame have at most
// 65,534 characters, and viewers load a file whole.
inline constexpr std::size_t xa_frames_max = 2000;
inline constexpr std::size_t xa_bytes_max = std::size_t{1} << 31;

// Called now and then with bytes done and in all; false stops the export.
using XaProgress = std::function<bool(std::size_t done, std::size_t total)>;

// Thrown when the progress function said stop; nothing is left behind.
class XaInterrupted : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

class XaFile
{
  public:
    // Throws OutputError when nothing can be written there.
    explicit XaFile(const std::string &path);
    ~XaFile(); // removes what is unfinished

    // The pixels of the next frame. Throws OutputError; std::invalid_argument when the frames differ in size.
    void add(const RunFrame &frame);
    bool has_room_for_another() const;
    std::size_t frame_count() const { return frame_count_; }
    // Of everything added so far.
    const Digest &digest() const { return digest_; }
    const std::string &path() const { return path_; }

    // `run` describes the frames that were added, in order (its own pixels are not used). `instance` counts the files of
    // the study from 1. Throws OutputError, XaInterrupted, and std::invalid_argument when the run contradicts itself.
    void write(const XrayRun &run, const XaStudy &study, int instance, const XaProgress &progress);

  private:
    std::string path_, spool_path_;
    std::FILE *spool_ = nullptr;
    std::size_t frame_count_ = 0, pixels_per_frame_ = 0;
    Digest digest_;
};

// A whole run that is in memory.
void write_xa(const std::string &path, const XrayRun &run, const XaStudy &study, int instance = 1,
              const XaProgress &progress = nullptr);

} // namespace seld
