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

namespace seld
{

namespace
{

constexpr std::size_t piece_bytes = std::size_t{1} << 20;
static_assert(std::endian::native == std::endian::little, "pixels go to the file as they lie in memory");

// Hands what DCMTK encodes to the file, piece by piece, so that a full disk has its reason and Ctrl-C is heard.
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

} // namespace

XaFile::XaFile(const std::string &path) : path_(path), spool_path_(pending_path(path) + ".pixels")
{
    watch_pending(spool_path_);
    spool_ = std::fopen(spool_path_.c_str(), "wb");
    if (spool_) return;
    const int error_number = errno;
    forget_pending(spool_path_);
    throw OutputError(path, error_number);
}

XaFile::~XaFile()
{
    if (spool_) std::fclose(spool_);
    ::unlink(spool_path_.c_str());
    forget_pending(spool_path_);
}

void XaFile::add(const RunFrame &frame)
{
    if (frame_count_ == 0) pixels_per_frame_ = frame.raw.size();
    if (frame.raw.empty() || frame.raw.size() != pixels_per_frame_)
        throw std::invalid_argument("run: frame " + std::to_string(frame_count_) + " has " +
                                    std::to_string(frame.raw.size()) + " pixels, the first one " +
                                    std::to_string(pixels_per_frame_));
    const std::size_t bytes = frame.raw.size() * sizeof frame.raw[0];
    digest_.add(&frame.tick, sizeof frame.tick);
    digest_.add(frame.raw.data(), bytes);
    if (std::fwrite(frame.raw.data(), 1, bytes, spool_) != bytes) throw OutputError(path_, errno);
    frame_count_++;
}

bool XaFile::has_room_for_another() const
{
    return frame_count_ < xa_frames_max && (frame_count_ + 1) * pixels_per_frame_ * 2 <= xa_bytes_max;
}

void XaFile::write(const XrayRun &run, const XaStudy &study, int instance, const XaProgress &progress)
{
    check_run(run);
    const std::size_t pixels = static_cast<std::size_t>(run.size) * run.size;
    if (run.frames.size() != frame_count_ || pixels != pixels_per_frame_)
        throw std::invalid_argument("run: it describes " + std::to_string(run.frames.size()) + " frames of " +
                                    std::to_string(pixels) + " pixels, " + std::to_string(frame_count_) +
                                    " of " + std::to_string(pixels_per_frame_) + " were added");
    if (std::fflush(spool_) != 0) throw OutputError(path_, errno);
    const std::size_t bytes = frame_count_ * pixels * 2;
    DcmFileFormat format;
    put_attributes(*format.getDataset(), run, study, digest_, instance);
    // The pixels stay on the disk until they are copied.
    auto data = std::make_unique<DcmPixelData>(DcmTag(DCM_PixelData, EVR_OW));
    if (data->createValueFromTempFile(new DcmInputFileStreamFactory(spool_path_.c_str(), 0),
                                      static_cast<Uint32>(bytes), EBO_LittleEndian)
            .bad() ||
        format.getDataset()->insert(data.get()).bad())
        throw std::logic_error("DICOM pixel data cannot be made");
    data.release();
    PendingFile file(path_);
    Encoder(file, progress, bytes).encode(format);
    file.commit();
}

void write_xa(const std::string &path, const XrayRun &run, const XaStudy &study, int instance,
              const XaProgress &progress)
{
    XaFile file(path);
    for (const RunFrame &frame : run.frames) file.add(frame);
    file.write(run, study, instance, progress);
}

} // namespace seld
