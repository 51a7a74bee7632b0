// Reads NRRD, NIfTI and MetaImage files, and DICOM series slice by slice, by direct calls of ITK's ImageIO
// classes. We do not use ITK's image and pipeline templates, because they take a minute to compile and report
// less about errors.
#include "tools/lab/ct/volume/volume_declared.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <map>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

// Returns the last part of the error message about a header, without ITK's file names and line numbers.
std::string cause_of(const itk::ExceptionObject &error)
{
    std::string text = error.GetDescription();
    std::replace(text.begin(), text.end(), '\n', ' ');
    const std::size_t begin = text.find("): ");
    if (begin != std::string::npos) text = text.substr(begin + 3);
    return text.substr(0, 200);
}

// Returns the grid of a file, in three dimensions, as reported by the ITK class that reads the file.
struct Head {
    std::array<long, 3> size = {1, 1, 1};
    Eigen::Vector3d spacing_mm = Eigen::Vector3d::Ones(), origin_mm = Eigen::Vector3d::Zero();
    Eigen::Matrix3d direction = Eigen::Matrix3d::Identity();
};

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
template <class Value> void take(const std::vector<char> &bytes, const TakeValues &out, std::size_t count)
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

// Reads the values of an open file as HU.
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

itk::ImageIOBase::Pointer reader_for(const fs::path &path)
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

Volume volume_of(const Head &head, const std::string &name)
{
    Volume volume;
    for (std::size_t axis = 0; axis < 3; ++axis) volume.size[axis] = static_cast<int>(head.size[axis]);
    volume.spacing_mm = head.spacing_mm;
    volume.origin_mm = head.origin_mm;
    volume.direction = head.direction;
    volume.name = name;
    return volume;
}

void check_head(const Head &head, const std::string &name)
{
    check_grid(head.size, head.spacing_mm, head.origin_mm, head.direction, name);
}

void read_file(const fs::path &path, const TakeHead &take_head, const TakeValues &take_values)
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
        check_head(head, name);
        if (lower_name(path).find(".nii") != std::string::npos)
            check_nifti_length(name, declared.value_bytes);
        const Volume volume = volume_of(head, name);
        take_head(volume);
        read_values(*io, take_values, volume.count(), name);
    } catch (const itk::ExceptionObject &error) {
        throw Fault(name + ": cannot be read: " + cause_of(error) +
                    ": the file is truncated or damaged; export it again");
    }
}

// --- DICOM ---
struct Slice {
    std::string name; // name of the file, without folders
    fs::path file;
    Head head;
    std::string series;
    long number = 0,
         in_series = 0; // instance number; number of images that the series declares (0: not declared)
};

long whole_number(const itk::MetaDataDictionary &tags, const std::string &tag)
{
    std::string text;
    return itk::ExposeMetaData<std::string>(tags, tag, text) ? std::strtol(text.c_str(), nullptr, 10) : 0;
}

Slice slice_of(const fs::path &file)
{
    const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
    io->SetFileName(file.string());
    io->ReadImageInformation();
    Slice slice;
    slice.name = file.filename().string();
    slice.file = file;
    slice.head = head_of(*io, file.string());
    const itk::MetaDataDictionary &tags = io->GetMetaDataDictionary();
    itk::ExposeMetaData<std::string>(tags, "0020|000e", slice.series);
    slice.number = whole_number(tags, "0020|0013");
    slice.in_series = whole_number(tags, "0020|1002");
    std::string place;
    if (!itk::ExposeMetaData<std::string>(tags, "0020|0032", place) || place.find('\\') == std::string::npos)
        throw Fault(file.string() +
                    ": says no position of its slice (0020,0032), so that places in it are unknown: "
                    "export the series again as CT images");
    if (!itk::ExposeMetaData<std::string>(tags, "0028|0030", place) || place.find('\\') == std::string::npos)
        throw Fault(file.string() +
                    ": says no spacing of its pixels (0028,0030): export the series again as CT images");
    return slice;
}

std::vector<Slice> slices_in(const fs::path &folder)
{
    std::vector<fs::path> files;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<Slice> slices;
    for (const fs::path &file : files) {
        const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
        if (!io->CanReadFile(file.string().c_str())) {
            if (lower_name(file).ends_with(".dcm"))
                throw Fault(file.string() +
                            ": is no DICOM file in spite of its name, or truncated: export it again");
            continue; // skips other files, such as a note or a DICOMDIR
        }
        try {
            slices.push_back(slice_of(file));
        } catch (const itk::ExceptionObject &error) {
            throw Fault(file.string() + ": cannot be read: " + cause_of(error) +
                        ": the file is truncated or damaged; export it again");
        }
    }
    if (slices.empty())
        throw Fault(folder.string() + ": no DICOM image in this folder: give the folder of a series");
    return slices;
}

// Checks that the folder has a single series with slices of equal size, and that the series is as complete as
// it declares.
void check_series(const std::vector<Slice> &slices, const std::string &folder)
{
    std::map<std::string, std::size_t> series;
    for (const Slice &slice : slices) ++series[slice.series];
    if (series.size() > 1) {
        std::string list;
        for (const auto &[uid, count] : series)
            list += "\n  " + uid + " (" + std::to_string(count) + " images)";
        throw Fault(folder + ": " + std::to_string(series.size()) + " series in one folder: keep one of" +
                    list);
    }
    std::vector<long> numbers;
    long said = 0;
    for (const Slice &slice : slices) {
        const Head &first = slices.front().head;
        if (slice.head.size[0] != first.size[0] || slice.head.size[1] != first.size[1] ||
            slice.head.size[2] != 1 ||
            (slice.head.spacing_mm - first.spacing_mm).head<2>().cwiseAbs().maxCoeff() > 1e-4 ||
            (slice.head.direction - first.direction).leftCols<2>().cwiseAbs().maxCoeff() > 1e-3)
            throw Fault(folder + ": " + slice.name + " has another size, spacing or direction than " +
                        slices.front().name + ": the folder mixes series; keep one");
        numbers.push_back(slice.number);
        said = std::max(said, slice.in_series);
    }
    std::sort(numbers.begin(), numbers.end());
    if (said > static_cast<long>(slices.size()))
        throw Fault(folder + ": the series is truncated: " + std::to_string(slices.size()) + " of " +
                    std::to_string(said) + " images are there: copy the whole series");
}

void read_series(const fs::path &folder, const TakeHead &take_head, const TakeValues &take_values)
{
    const std::string name = folder.string();
    const std::vector<Slice> slices = slices_in(folder);
    check_series(slices, name);
    Head head = slices.front().head;
    const Eigen::Vector3d row = head.direction.col(0), column = head.direction.col(1);
    head.direction.col(2) = Eigen::Vector3d(row.y() * column.z() - row.z() * column.y(),
                                            row.z() * column.x() - row.x() * column.z(),
                                            row.x() * column.y() - row.y() * column.x());
    std::vector<Eigen::Vector3d> places;
    std::vector<std::string> names;
    for (const Slice &slice : slices) {
        places.push_back(slice.head.origin_mm);
        names.push_back(slice.name);
        if (!slice.head.origin_mm.allFinite())
            throw Fault(slice.file.string() + ": the slice's position is no place: mend (0020,0032)");
    }
    const SliceOrder order = order_slices(places, head.direction.col(2), names, name);
    head.size[2] = static_cast<long>(slices.size());
    head.spacing_mm[2] = order.distance_mm;
    head.origin_mm = places[order.order.front()];
    check_head(head, name);
    const Volume volume = volume_of(head, name);
    take_head(volume);
    const std::size_t pixels = volume.count() / slices.size();
    for (std::size_t i = 0; i < slices.size(); ++i) {
        const Slice &slice = slices[order.order[i]];
        const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
        io->SetFileName(slice.file.string());
        try {
            check_dicom_length(slice.file);
            io->ReadImageInformation();
            read_values(*io, take_values, pixels, slice.file.string());
        } catch (const itk::ExceptionObject &error) {
            throw Fault(slice.file.string() + ": cannot be read: " + cause_of(error) +
                        ": the file is truncated or damaged; export it again");
        }
    }
}

} // namespace

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
        throw Fault(volume.name + ": is empty: all voxels are " + std::to_string(int(low)) + " HU");
    if (low < -40000 || high > 70000)
        throw Fault(volume.name + ": has values from " + std::to_string(low) + " to " + std::to_string(high) +
                    ", which are no Hounsfield units: is the byte order right?");
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
