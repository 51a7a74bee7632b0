#include "host/picture/dicom_export.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

std::string kind_word(RunKind kind)
{
    return kind == RunKind::fluoro ? "fluoro" : kind == RunKind::cine ? "cine" : "dsa";
}

// Returns the number of bytes of the UTF-8 character that begins at this position (RFC 3629), or 0 if no
// character begins there.
std::size_t utf8_length(const std::string &text, std::size_t at)
{
    const auto byte = [&](std::size_t k) {
        return at + k < text.size() ? static_cast<unsigned char>(text[at + k]) : 0u;
    };
    const unsigned first = byte(0);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    unsigned long code = first & (0x7fu >> length);
    for (std::size_t k = 1; k < length; k++) {
        if ((byte(k) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(k) & 0x3f);
    }
    constexpr unsigned long least[] = {
        0, 0, 0x80, 0x800, 0x10000}; // smallest code for each length: a longer form than needed is invalid
    const bool is_surrogate = code >= 0xd800 && code < 0xe000;
    return first >= 0xc0 && first < 0xf8 && code >= least[length] && code < 0x110000 && !is_surrogate ? length
                                                                                                      : 0;
}

bool is_utf8(const std::string &text)
{
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = utf8_length(text, at);
        if (length == 0) return false;
        at += length;
    }
    return true;
}

// Throws an exception unless the standard PS3.5 6.2 allows the text: no backslash, no control characters, and
// at most 64 characters.
void check_text(const std::string &option, const std::string &text)
{
    const bool has_bad = std::any_of(text.begin(), text.end(), [](char letter) {
        return letter == '\\' || static_cast<unsigned char>(letter) < 32 || letter == 127;
    });
    if (has_bad) throw UsageError(option + ": a DICOM text has no backslash and no control characters");
    if (!is_utf8(text)) throw UsageError(option + ": a DICOM text is UTF-8 here, and this one is not");
    if (text.size() > 64)
        throw UsageError(option + ": a DICOM text has at most 64 bytes, this one " +
                         std::to_string(text.size()));
}

void check_date(const std::string &date)
{
    const UsageError error("--study-date " + date + " is not a date: write YYYYMMDD, such as 20260131");
    if (date.size() != 8 || date.find_first_not_of("0123456789") != date.npos) throw error;
    const int year = std::stoi(date.substr(0, 4)), month = std::stoi(date.substr(4, 2)),
              day = std::stoi(date.substr(6));
    const bool is_leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    const int days[] = {31, is_leap ? 29 : 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    if (year < 1 || month < 1 || month > 12 || day < 1 || day > days[month - 1]) throw error;
}

// Counts how often each pixel value occurs in the field that the collimator leaves open; only every third
// pixel is counted. The edges of the field are not counted, because they lie in the half shadow of the
// collimator blades.
void count_values(const XrayRun &run, const RunFrame &frame, std::vector<std::uint32_t> &histogram)
{
    const RunCollimator &field = run.collimator;
    const int inset = run.size / 32;
    const int reach = static_cast<int>(field.radius_px * 0.7); // half the square in a circle
    const int x0 = static_cast<int>(field.centre_x_px), y0 = static_cast<int>(field.centre_y_px);
    const int left = field.is_circular ? x0 - reach : field.left + inset;
    const int right = field.is_circular ? x0 + reach : field.right - inset;
    const int top = field.is_circular ? y0 - reach : field.top + inset;
    const int bottom = field.is_circular ? y0 + reach : field.bottom - inset;
    for (int y = std::max(top, 0); y < std::min(bottom, run.size); y++)
        for (int x = std::max(left, 0); x < std::min(right, run.size); x += 3)
            histogram[frame.raw[static_cast<std::size_t>(y) * run.size + x]]++;
}

// Returns the pixel value below which the given fraction of the counted values lies.
double value_at(const std::vector<std::uint32_t> &histogram, std::uint64_t count, double share)
{
    const auto wanted = static_cast<std::uint64_t>(static_cast<double>(count) * share);
    std::uint64_t passed = 0;
    for (std::size_t value = 0; value < histogram.size(); value++) {
        passed += histogram[value];
        if (passed > wanted) return static_cast<double>(value);
    }
    return static_cast<double>(histogram.size() - 1);
}

// Sets the display window to the range of pixel values of the run, without the darkest and the brightest
// hundredth of them. If at least one pixel in 200 has the largest value, this is the value of saturated
// pixels beside the patient. The function does not count the pixels of saturated detector elements beside the
// patient.
void set_window(XrayRun &run, std::vector<std::uint32_t> histogram)
{
    if (run.window_width > 0.0) return;
    std::uint64_t count = 0;
    std::size_t largest = 0;
    for (std::size_t value = 0; value < histogram.size(); value++) {
        count += histogram[value];
        if (histogram[value] > 0) largest = value;
    }
    if (count == 0) return;
    if (histogram[largest] > count / 200 && histogram[largest] < count) {
        count -= histogram[largest];
        histogram[largest] = 0;
    }
    const double low = value_at(histogram, count, 0.01), high = value_at(histogram, count, 0.99);
    run.window_centre = (low + high) / 2;
    run.window_width = std::max(high - low, 1.0);
}

} // namespace

void check_dicom_settings(const DicomSettings &settings)
{
    check_text("--patient-name", settings.patient_name);
    check_text("--patient-id", settings.patient_id);
    if (!settings.study_date.empty()) check_date(settings.study_date);
    if (settings.folder.empty()) return;
    std::error_code failed;
    const fs::file_status status = fs::status(settings.folder, failed);
    if (!fs::exists(status)) return check_output_folder({"--dicom", settings.folder});
    if (!fs::is_directory(status))
        throw UsageError("--dicom " + settings.folder + " is not a folder: name a folder, new or empty");
    for (const fs::directory_entry &entry : fs::directory_iterator(settings.folder, failed)) {
        if (entry.path().extension() != ".dcm") continue;
        throw UsageError("--dicom " + settings.folder + " already holds " + entry.path().filename().string() +
                         ": name another folder, or remove its .dcm files first");
    }
    check_output_folder({"--dicom", settings.folder});
}

DicomExport::DicomExport(const DicomSettings &settings, const std::string &session)
    : settings_(settings), session_(session)
{
    std::error_code failed;
    made_folder_ = fs::create_directories(settings.folder, failed);
    if (failed) throw OutputError(settings.folder, failed.value());
    spool_ = std::make_unique<XaSpool>((fs::path(settings.folder) / "runs").string());
}

DicomExport::~DicomExport()
{
    spool_.reset();
    std::error_code ignored;
    if (made_folder_) fs::remove(settings_.folder, ignored); // only if it is empty
}

void DicomExport::begin(XrayRun run)
{
    end();
    header_ = std::move(run);
    header_.frames.clear();
    header_.number = static_cast<int>(run_count_) + 1;
    is_in_run_ = true;
    part_of_run_ = 0;
}

void DicomExport::begin_part()
{
    end_part();
    if (part_of_run_++ == 0) run_count_++;
    const std::string name = formatted("run_%02d_%s", header_.number, kind_word(header_.kind).c_str());
    parts_.push_back({header_, {}, name});
    if (part_of_run_ > 1) parts_.back().name += "_" + std::to_string(part_of_run_);
    parts_.back().name += ".dcm";
    histogram_.assign(65536, 0);
}

void DicomExport::end_part()
{
    if (!histogram_.empty()) set_window(parts_.back().run, std::move(histogram_));
    histogram_.clear();
}

void DicomExport::add(RunFrame frame)
{
    if (frame.raw.size() != static_cast<std::size_t>(header_.size) * header_.size)
        throw std::invalid_argument("run: a frame of " + std::to_string(frame.raw.size()) + " pixels, not " +
                                    std::to_string(header_.size) + " x " + std::to_string(header_.size));
    // A frame with another field size has pixels of another size, and so belongs in another file.
    const bool fits = part_of_run_ > 0 && parts_.back().pixels.has_room_for_another() &&
                      parts_.back().run.frames.front().carm.field_m == frame.carm.field_m;
    if (!fits) {
        begin_part();
        if (settings_.values == "log") make_logarithmic(parts_.back().run);
    }
    Part &part = parts_.back();
    if (header_.relation == PixelRelation::linear && part.run.relation == PixelRelation::logarithmic)
        for (std::uint16_t &value : frame.raw) value = logarithm_table()[value];
    add_frame(*spool_, part.pixels, frame);
    count_values(part.run, frame, histogram_);
    frame.raw = {};
    part.run.frames.push_back(std::move(frame));
}

void DicomExport::end()
{
    end_part();
    is_in_run_ = false;
}

void DicomExport::add_run(const XrayRun &run)
{
    begin(run);
    for (const RunFrame &frame : run.frames) add(frame);
    end();
}

void DicomExport::set_mask(std::size_t run, const RunMask &mask)
{
    for (Part &part : parts_) {
        if (part.run.number != static_cast<int>(run) + 1) continue;
        part.run.mask = mask;
        return;
    }
}

void DicomExport::set_contrast(
    const std::function<std::optional<RunContrast>(std::uint32_t, std::uint32_t)> &given)
{
    for (Part &part : parts_)
        part.run.contrast = given(part.run.frames.front().tick, part.run.frames.back().tick);
}

std::string DicomExport::study_key() const
{
    Digest digest;
    digest.add(session_);
    for (const Part &part : parts_) digest.add(part.name + part.pixels.digest.hex());
    return digest.hex();
}

std::vector<std::string> DicomExport::finish(const std::function<bool(const ExportProgress &)> &report)
{
    end();
    XaStudy study;
    study.key = study_key();
    study.patient_name = settings_.patient_name;
    study.patient_id = settings_.patient_id;
    study.date = settings_.study_date;
    study.description = "Simulated session";
    ExportProgress progress;
    progress.files = parts_.size();
    for (const Part &part : parts_)
        progress.bytes += part.pixels.frame_count * part.pixels.pixels_per_frame * 2;
    std::vector<std::string> written;
    std::size_t bytes_before = 0;
    for (const Part &part : parts_) {
        progress.file++;
        progress.name = (fs::path(settings_.folder) / part.name).string();
        try {
            write_xa(progress.name, part.run, *spool_, part.pixels, study, static_cast<int>(progress.file),
                     [&](std::size_t done, std::size_t) {
                         progress.bytes_done = bytes_before + done;
                         return report(progress);
                     });
        } catch (const XaInterrupted &) {
            break;
        }
        bytes_before += part.pixels.frame_count * part.pixels.pixels_per_frame * 2;
        written.push_back(progress.name);
    }
    parts_.clear();
    spool_.reset();
    return written;
}

} // namespace crn
