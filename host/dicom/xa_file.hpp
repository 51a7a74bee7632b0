// Writes a run as a DICOM file: X-Ray Angiographic Image Storage, multi-frame (PS3.3 A.14), through DCMTK.
//
//   XaSpool spool("out/dicom/pixels");
//   XaPixels pixels;
//   for (frame of the run) add_frame(spool, pixels, frame);                        // to the disk, not to memory
//   write_xa("out/dicom/run_01_fluoro.dcm", run, spool, pixels, study, 1, nullptr);
//
// docs/output.md lists the attributes of the DICOM file with units and meaning.
#pragma once
#include "host/base/digest.hpp"
#include "host/base/pending_file.hpp"
#include "host/xray/run.hpp"
#include <functional>
#include <memory>
#include <string>

namespace crn
{

// Holds the data that are common to all files of one export.
struct XaStudy {
    std::string key; // derived from the content, as Digest::hex(): names the study, its series and the
                     // patient's number
    std::string patient_name; // empty: "Anonymous^"
    std::string patient_id;   // empty: "ANON-" and the key's first eight digits
    std::string date;         // YYYYMMDD; empty: none
    std::string description;  // description of the study
};

// One DICOM file has at most this number of frames and this number of bytes; a longer run is continued in the
// next file. The limits for a DICOM file have two reasons: an attribute with one number per frame has at most
// 65,534 characters, and viewers load a whole file into memory.
inline constexpr std::size_t xa_frames_max = 2000;
inline constexpr std::size_t xa_bytes_max = std::size_t{1} << 31;

// The export calls this function repeatedly with the numbers of bytes done and of bytes in total; if the
// function returns false, the export stops.
using XaProgress = std::function<bool(std::size_t done, std::size_t total)>;

// write_xa() throws XaInterrupted when the progress function stops the export; no file of the export is left
// behind.
class XaInterrupted : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// The spool is a temporary file that holds the pixels of a whole export until the DICOM files are written.
// Pixels in the spool take up no main memory. One spool serves many runs.
class XaSpool
{
  public:
    // The spool is a temporary file beside `path`, but never gets the name `path` itself. Throws OutputError
    // when the spool cannot be written.
    explicit XaSpool(const std::string &path);
    ~XaSpool(); // removes it
    XaSpool(const XaSpool &) = delete;
    XaSpool &operator=(const XaSpool &) = delete;

    void add(const std::vector<std::uint16_t> &raw); // throws OutputError
    void flush();                                    // throws OutputError
    std::size_t size_bytes() const { return size_bytes_; }
    const std::string &file() const { return file_; }

  private:
    std::string path_, file_;
    std::FILE *stream_ = nullptr;
    std::size_t size_bytes_ = 0;
};

// Describes the frames of one DICOM file in the spool (a temporary file): the position of the first frame,
// the number of frames, and the number of pixels per frame.
struct XaPixels {
    std::size_t offset_bytes = 0;
    std::size_t frame_count = 0, pixels_per_frame = 0;
    Digest digest;

    bool has_room_for_another() const;
};

// Appends a frame to the spool (a temporary file) and to its description `pixels`; the frames in `pixels`
// must be the last ones in the spool. Throws OutputError when the spool cannot be written, and
// std::invalid_argument when the frames differ in size.
void add_frame(XaSpool &spool, XaPixels &pixels, const RunFrame &frame);

// `run` describes the added frames in order; the pixels in `run` itself are not used. `instance` counts the
// files of the study from 1. Throws OutputError, XaInterrupted, and std::invalid_argument when the data of
// the run contradict each other.
void write_xa(const std::string &path, const XrayRun &run, XaSpool &spool, const XaPixels &pixels,
              const XaStudy &study, int instance, const XaProgress &progress);

// Writes a whole run, whose pixels are in memory, as one DICOM file.
void write_xa(const std::string &path, const XrayRun &run, const XaStudy &study, int instance = 1,
              const XaProgress &progress = nullptr);

} // namespace crn
