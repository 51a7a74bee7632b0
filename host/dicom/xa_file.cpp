#include "host/dicom/xa_file.hpp"
#include "host/dicom/xa_attributes.hpp"
#include <bit>
#include <cerrno>
#include <dcmtk/dcmdata/dcdeftag.h>
#include <dcmtk/dcmdata/dcfilefo.h>
#include <dcmtk/dcmdata/dcistrmf.h>
#include <dcmtk/dcmdata/dcmetinf.h>
#include <dcmtk/dcmdata/dcostrmb.h>
#include <dcmtk/dcmdata/dcpixel.h>
#include <dcmtk/dcmdata/dcwcache.h>
#include <unistd.h>

namespace crn
{

namespace
{

constexpr std::size_t piece_bytes = std::size_t{1} << 20;
static_assert(std::endian::native == std::endian::little, "pixels go to the file as they lie in memory");

// Copies DCMTK's output to the DICOM file piece by piece, so that a full disk is reported with its cause and
// Ctrl-C works.
class Encoder
{
  public:
    Encoder(PendingFile &file, const XaProgress &progress, std::size_t total)
        : file_(file), progress_(progress), total_(total), buffer_(piece_bytes),
          stream_(buffer_.data(), buffer_.size())
    {
    }

    void encode(DcmFileFormat &format)
    {
        DcmWriteCache cache;
        format.transferInit();
        OFCondition condition = EC_Normal;
        do {
            condition = format.write(stream_, EXS_LittleEndianExplicit, EET_UndefinedLength, &cache,
                                     EGL_recalcGL, EPD_noChange, 0, 0, 0, EWM_createNewMeta);
            flush();
        } while (condition == EC_StreamNotifyClient);
        format.transferEnd();
        if (condition.bad())
            throw OutputError(file_.path() + ": DCMTK cannot encode it: " + condition.text());
    }

  private:
    void flush()
    {
        void *bytes = nullptr;
        offile_off_t count = 0;
        stream_.flushBuffer(bytes, count);
        file_.write(bytes, static_cast<std::size_t>(count));
        done_ += static_cast<std::size_t>(count);
        if (progress_ && !progress_(std::min(done_, total_), total_))
            throw XaInterrupted(file_.path() + ": interrupted; not written");
    }

    PendingFile &file_;
    const XaProgress &progress_;
    std::size_t total_, done_ = 0;
    std::vector<char> buffer_;
    DcmOutputBufferStream stream_;
};

void check_sizes(const XrayRun &run, const XaPixels &pixels)
{
    const std::size_t wanted = static_cast<std::size_t>(run.size) * run.size;
    if (run.frames.size() == pixels.frame_count && wanted == pixels.pixels_per_frame) return;
    throw std::invalid_argument("run: it describes " + std::to_string(run.frames.size()) + " frames of " +
                                std::to_string(wanted) + " pixels, " + std::to_string(pixels.frame_count) +
                                " of " + std::to_string(pixels.pixels_per_frame) + " were added");
}

} // namespace

XaSpool::XaSpool(const std::string &path) : path_(path)
{
    const OpenPending opened = open_pending(path, ".pixels");
    file_ = opened.name;
    stream_ = ::fdopen(opened.file, "wb");
    if (stream_) return;
    const int error_number = errno;
    ::close(opened.file);
    discard_pending(file_);
    throw OutputError(path, error_number);
}

XaSpool::~XaSpool()
{
    std::fclose(stream_);
    discard_pending(file_);
}

void XaSpool::add(const std::vector<std::uint16_t> &raw)
{
    if (std::fwrite(raw.data(), sizeof raw[0], raw.size(), stream_) != raw.size())
        throw OutputError(path_, errno);
    size_bytes_ += raw.size() * sizeof raw[0];
}

void XaSpool::flush()
{
    if (std::fflush(stream_) != 0) throw OutputError(path_, errno);
}

bool XaPixels::has_room_for_another() const
{
    return frame_count < xa_frames_max && (frame_count + 1) * pixels_per_frame * 2 <= xa_bytes_max;
}

void add_frame(XaSpool &spool, XaPixels &pixels, const RunFrame &frame)
{
    if (pixels.frame_count == 0) {
        pixels.offset_bytes = spool.size_bytes();
        pixels.pixels_per_frame = frame.raw.size();
    }
    if (frame.raw.empty() || frame.raw.size() != pixels.pixels_per_frame) {
        throw std::invalid_argument("run: frame " + std::to_string(pixels.frame_count) + " has " +
                                    std::to_string(frame.raw.size()) + " pixels, the first one " +
                                    std::to_string(pixels.pixels_per_frame));
    }
    pixels.digest.add(&frame.tick, sizeof frame.tick);
    pixels.digest.add(frame.raw.data(), frame.raw.size() * sizeof frame.raw[0]);
    spool.add(frame.raw);
    pixels.frame_count++;
}

void write_xa(const std::string &path, const XrayRun &run, XaSpool &spool, const XaPixels &pixels,
              const XaStudy &study, int instance, const XaProgress &progress)
{
    check_run(run);
    check_sizes(run, pixels);
    spool.flush();
    const std::size_t bytes = pixels.frame_count * pixels.pixels_per_frame * 2;
    DcmFileFormat format;
    put_attributes(*format.getDataset(), run, study, pixels.digest, instance);
    // DCMTK reads the pixels from the spool (a temporary file) only when it copies them into the DICOM file.
    auto data = std::make_unique<DcmPixelData>(DcmTag(DCM_PixelData, EVR_OW));
    auto *source =
        new DcmInputFileStreamFactory(spool.file().c_str(), static_cast<offile_off_t>(pixels.offset_bytes));
    if (data->createValueFromTempFile(source, static_cast<Uint32>(bytes), EBO_LittleEndian).bad() ||
        format.getDataset()->insert(data.get()).bad())
        throw std::logic_error("DICOM pixel data cannot be made");
    data.release();
    PendingFile file(path);
    Encoder(file, progress, bytes).encode(format);
    file.commit();
}

void write_xa(const std::string &path, const XrayRun &run, const XaStudy &study, int instance,
              const XaProgress &progress)
{
    XaSpool spool(path);
    XaPixels pixels;
    for (const RunFrame &frame : run.frames) add_frame(spool, pixels, frame);
    write_xa(path, run, spool, pixels, study, instance, progress);
}

} // namespace crn
