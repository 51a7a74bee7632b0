// Reads NRRD, NIfTI and MetaImage files by direct calls of ITK's ImageIO classes. We do not use ITK's image
// and pipeline templates, because they take a minute to compile and report less about errors.
#include "tools/lab/ct/volume/volume_declared.hpp"
#include "tools/lab/ct/volume/volume_reading.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

namespace crn::ct
{

namespace fs = std::filesystem;

std::string cause_of(const itk::ExceptionObject &error)
{
    std::string text = error.GetDescription();
    std::replace(text.begin(), text.end(), '\n', ' ');
    const std::size_t begin = text.find("): ");
    if (begin != std::string::npos) text = text.substr(begin + 3);
    return text.substr(0, 200);
}

Head head_of(const itk::ImageIOBase &io, const std::string &name)
{
    Head head;
    const unsigned dimensions = io.GetNumberOfDimensions();
    for (unsigned axis = 3; axis < dimensions; ++axis)
        if (io.GetDimensions(axis) > 1)
            throw Fault(name + ": has " + std::to_string(io.GetDimensions(axis)) +
                        " volumes in one file: export the one with the instrument");
    if (dimensions < 2) throw Fault(name + ": is no volume: give a 3D scan");
    if (io.GetNumberOfComponents() != 1)
        throw Fault(name + ": has " + std::to_string(io.GetNumberOfComponents()) +
                    " values per voxel: give Hounsfield units, one value each");
    const unsigned axes = std::min(dimensions, 3u);
    for (unsigned axis = 0; axis < axes; ++axis) {
        const auto row = static_cast<Eigen::Index>(axis);
        head.size[axis] = static_cast<long>(io.GetDimensions(axis));
        head.spacing_mm[row] = io.GetSpacing(axis);
        head.origin_mm[row] = io.GetOrigin(axis);
        const std::vector<double> column = io.GetDirection(axis);
        for (unsigned i = 0; i < axes && i < column.size(); ++i)
            head.direction(static_cast<Eigen::Index>(i), row) = column[i];
    }
    return head;
}

// The values of a scan are passed on in blocks, so that memory never holds the scan twice.
template <class Value>
static void take(const std::vector<char> &bytes, const TakeValues &out, std::size_t count)
{
    constexpr std::size_t block_values = 1 << 18;
    std::vector<float> block(std::min(count, block_values));
    const auto *values = reinterpret_cast<const Value *>(bytes.data());
    for (std::size_t begin = 0; begin < count; begin += block.size()) {
        const std::size_t now = std::min(block.size(), count - begin);
        for (std::size_t i = 0; i < now; ++i) block[i] = static_cast<float>(values[begin + i]);
        out(block.data(), now);
    }
}

void read_values(itk::ImageIOBase &io, const TakeValues &out, std::size_t count, const std::string &name)
{
    const std::size_t bytes = static_cast<std::size_t>(io.GetImageSizeInBytes());
    if (bytes != count * static_cast<std::size_t>(io.GetComponentSize()))
        throw Fault(name + ": the header's sizes do not fit together: export it again");
    // Some of ITK's reading functions write slightly more bytes than they declare if the file is damaged.
    std::vector<char> raw(bytes + 4096);
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis)
        region.SetSize(axis, io.GetDimensions(axis));
    io.SetIORegion(region);
    io.Read(raw.data());
    using Type = itk::IOComponentEnum;
    switch (io.GetComponentType()) {
    case Type::UCHAR:
        return take<std::uint8_t>(raw, out, count);
    case Type::CHAR:
        return take<std::int8_t>(raw, out, count);
    case Type::USHORT:
        return take<std::uint16_t>(raw, out, count);
    case Type::SHORT:
        return take<std::int16_t>(raw, out, count);
    case Type::UINT:
        return take<std::uint32_t>(raw, out, count);
    case Type::INT:
        return take<std::int32_t>(raw, out, count);
    case Type::ULONG:
        return take<unsigned long>(raw, out, count);
    case Type::LONG:
        return take<long>(raw, out, count);
    case Type::FLOAT:
        return take<float>(raw, out, count);
    case Type::DOUBLE:
        return take<double>(raw, out, count);
    default:
        throw Fault(name + ": its type of numbers is not known: export 16-bit whole numbers");
    }
}

std::string lower_name(const fs::path &path)
{
    std::string name = path.filename().string();
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return name;
}

static itk::ImageIOBase::Pointer reader_for(const fs::path &path)
{
    const std::string name = lower_name(path);
    const auto ends = [&](const char *ending) { return name.ends_with(ending); };
    if (ends(".nrrd") || ends(".nhdr")) return itk::NrrdImageIO::New().GetPointer();
    if (ends(".nii") || ends(".nii.gz")) return itk::NiftiImageIO::New().GetPointer();
    if (ends(".mha") || ends(".mhd")) return itk::MetaImageIO::New().GetPointer();
    if (ends(".dcm") || ends(".ima"))
        throw Fault(path.string() + ": is one slice of a DICOM series: give the folder with all of them");
    throw Fault(path.string() +
                ": its ending is not known: give .nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd, or the "
                "folder of a DICOM series");
}

Volume checked_volume(const Head &head, const std::string &name)
{
    check_grid(head.size, head.spacing_mm, head.origin_mm, head.direction, name);
    Volume volume;
    for (std::size_t axis = 0; axis < 3; ++axis) volume.size[axis] = static_cast<int>(head.size[axis]);
    volume.spacing_mm = head.spacing_mm;
    volume.origin_mm = head.origin_mm;
    volume.direction = head.direction;
    volume.name = name;
    return volume;
}

static void read_file(const fs::path &path, const TakeHead &take_head, const TakeValues &take_values)
{
    const std::string name = path.string();
    const itk::ImageIOBase::Pointer io = reader_for(path);
    const DeclaredVolume declared = declared_volume(path);
    check_plausible(declared.size, declared.spacing_mm, name);
    try {
        if (!io->CanReadFile(name.c_str()))
            throw Fault(name +
                        ": its header cannot be read: the file is truncated, or not what its ending says; "
                        "export it again");
        io->SetFileName(name);
        io->ReadImageInformation();
        const Head head = head_of(*io, name);
        check_agreement(declared, head.size, head.spacing_mm, name);
        Volume volume = checked_volume(head, name);
        if (!declared.has_place)
            volume.notes.push_back(
                "says neither position nor direction (qform and sform are 0): left and right "
                "may be swapped");
        if (lower_name(path).find(".nii") != std::string::npos)
            check_nifti_length(name, declared.value_bytes);
        take_head(volume);
        read_values(*io, take_values, volume.count(), name);
    } catch (const itk::ExceptionObject &error) {
        throw Fault(name + ": cannot be read: " + cause_of(error) +
                    ": the file is truncated or damaged; export it again");
    }
}

void check_values(const Volume &volume)
{
    float low = 1e30f, high = -1e30f;
    for (const float value : volume.hu) {
        if (!std::isfinite(value))
            throw Fault(volume.name +
                        ": has values that are no numbers: export it again as 16-bit whole numbers");
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (high - low < 1)
        throw Fault(volume.name + ": is empty: all voxels are " + std::to_string(int(low)) +
                    ": export it again");
    if (low < -40000 || high > 70000)
        throw Fault(volume.name + ": has values from " + std::to_string(low) + " to " + std::to_string(high) +
                    ", which are no Hounsfield units: is the byte order right? Export it again in HU");
}

void read_volume_here(const fs::path &path, const TakeHead &take_head, const TakeValues &take_values)
{
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        read_series(path, take_head, take_values);
    else
        read_file(path, take_head, take_values);
}

} // namespace crn::ct
