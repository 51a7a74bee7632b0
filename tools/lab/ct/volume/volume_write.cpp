// Writes NRRD, NIfTI and MetaImage files, and DICOM series in the form of a CT scanner, with the ImageIO
// classes of the library ITK.
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <unistd.h>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

std::vector<std::int16_t> whole_numbers(const Volume &volume)
{
    std::vector<std::int16_t> values(volume.hu.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::int16_t>(std::lround(std::clamp(volume.hu[i], -32768.0f, 32767.0f)));
    return values;
}

// Passes the sizes and positions of a volume to a writer of ITK; `slice` selects one slice of a series.
void describe(itk::ImageIOBase &io, const Volume &volume, int slice)
{
    const bool is_slice = slice >= 0;
    io.SetNumberOfDimensions(3);
    itk::ImageIORegion region(3);
    const Eigen::Vector3d origin = is_slice ? volume.lps({0, 0, double(slice)}) : volume.origin_mm;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const auto row = static_cast<Eigen::Index>(axis);
        const auto size = static_cast<std::size_t>(is_slice && axis == 2 ? 1 : volume.size[axis]);
        io.SetDimensions(axis, size);
        region.SetSize(axis, size);
        io.SetSpacing(axis, volume.spacing_mm[row]);
        io.SetOrigin(axis, origin[row]);
        io.SetDirection(axis, std::vector<double>{volume.direction(0, row), volume.direction(1, row),
                                                  volume.direction(2, row)});
    }
    io.SetIORegion(region);
    io.SetPixelType(itk::IOPixelEnum::SCALAR);
    io.SetComponentType(itk::IOComponentEnum::SHORT);
    io.SetNumberOfComponents(1);
}

// "name.nii.gz" has the extension ".nii.gz".
std::string ending_of(const fs::path &path)
{
    const std::string name = path.filename().string();
    if (name.ends_with(".nii.gz")) return ".nii.gz";
    return path.extension().string();
}

void write_file(const Volume &volume, const fs::path &path, const std::string &ending)
{
    itk::ImageIOBase::Pointer io;
    if (ending == ".nrrd") io = itk::NrrdImageIO::New().GetPointer();
    if (ending == ".nii" || ending == ".nii.gz") io = itk::NiftiImageIO::New().GetPointer();
    if (ending == ".mha") io = itk::MetaImageIO::New().GetPointer();
    if (io.IsNull())
        throw Fault(path.string() +
                    ": this ending cannot be written: give .nrrd, .nii, .nii.gz, .mha, or a name without "
                    "one for a DICOM series");
    describe(*io, volume, -1);
    io->SetUseCompression(ending != ".nii");
    const std::vector<std::int16_t> values = whole_numbers(volume);
    // ITK's writers check the extension of a file's name, so an unfinished file has a temporary name with the
    // final extension.
    const OpenPending pending = open_pending(path.string(), ending);
    ::close(pending.file);
    try {
        io->SetFileName(pending.name);
        io->Write(values.data());
    } catch (...) {
        discard_pending(pending.name);
        throw;
    }
    commit_pending(pending.name, path.string());
}

void put(itk::MetaDataDictionary &tags, const std::string &tag, const std::string &value)
{
    itk::EncapsulateMetaData<std::string>(tags, tag, value);
}

// The identifiers of a DICOM series begin with DICOM's prefix for UUIDs and are derived from the volume, so
// that equal scans have equal identifiers.
std::string uid_of(const Volume &volume, std::uint64_t kind, std::uint64_t number)
{
    std::uint64_t hash = 1469598103934665603u;
    for (const float value : volume.hu)
        hash = (hash ^ static_cast<std::uint64_t>(std::lround(value) + 40000)) * 1099511628211u;
    return "2.25." + std::to_string(hash) + "." + std::to_string(kind) + "." + std::to_string(number + 1);
}

void write_series(const Volume &volume, const fs::path &folder)
{
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure) throw Fault(folder.string() + ": the folder cannot be made: " + failure.message());
    for (const fs::directory_entry &entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".dcm") fs::remove(entry.path());
    const std::vector<std::int16_t> values = whole_numbers(volume);
    const std::size_t pixels = volume.count() / static_cast<std::size_t>(volume.size[2]);
    const std::string study = uid_of(volume, 1, 0), series = uid_of(volume, 2, 0),
                      frame = uid_of(volume, 3, 0), images = uid_of(volume, 4, 0);
    for (int slice = 0; slice < volume.size[2]; ++slice) {
        const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
        describe(*io, volume, slice);
        io->KeepOriginalUIDOn();
        itk::MetaDataDictionary &tags = io->GetMetaDataDictionary();
        put(tags, "0008|0016", "1.2.840.10008.5.1.4.1.1.2"); // CT image
        put(tags, "0008|0018", images + "." + std::to_string(slice + 1));
        put(tags, "0008|0060", "CT");
        put(tags, "0008|0008", "ORIGINAL\\PRIMARY\\AXIAL");
        put(tags, "0008|0070", "Cournand");
        put(tags, "0018|0050", number_text(volume.spacing_mm.z()));
        put(tags, "0018|5100", "HFS");
        put(tags, "0020|0010", "1");
        put(tags, "0020|0011", "1");
        put(tags, "0020|0012", "1");
        put(tags, "0020|1040", "");
        put(tags, "0028|0004", "MONOCHROME2");
        put(tags, "0028|1054", "HU");
        put(tags, "0008|103e", "Cournand virtual scanner");
        put(tags, "0010|0010", "Phantom^Silicone");
        put(tags, "0010|0020", "COURNAND");
        put(tags, "0018|0060", "120");
        put(tags, "0020|000d", study);
        put(tags, "0020|000e", series);
        put(tags, "0020|0052", frame);
        put(tags, "0020|0013", std::to_string(slice + 1));
        put(tags, "0020|1002", std::to_string(volume.size[2]));
        put(tags, "0028|1052", "-1024");
        put(tags, "0028|1053", "1");
        const std::string name = formatted("%04d.dcm", slice + 1);
        io->SetFileName((folder / name).string());
        io->Write(values.data() + static_cast<std::size_t>(slice) * pixels);
    }
}

} // namespace

void write_volume(const Volume &volume, const fs::path &path)
{
    itk::Object::GlobalWarningDisplayOff();
    try {
        const std::string ending = ending_of(path);
        if (ending.empty())
            write_series(volume, path);
        else
            write_file(volume, path, ending);
    } catch (const itk::ExceptionObject &error) {
        throw Fault(path.string() + ": cannot be written: " + error.GetDescription());
    }
}

} // namespace crn::ct
