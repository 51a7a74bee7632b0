// Reads a DICOM series slice by slice, by direct calls of ITK's class for DICOM files.
#include "host/base/format.hpp"
#include "tools/lab/ct/volume/dicom_kind.hpp"
#include "tools/lab/ct/volume/volume_reading.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <map>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

struct Slice {
    std::string name; // name of the file, without folders
    fs::path file;
    Head head;
    std::string series;
    DicomOwner owner;
    std::vector<std::string> doubts; // but those about the distance of slices
    double thickness_mm = 0.0;       // 0: not declared
    long in_series = 0;              // number of images that the series declares (0: not declared)
    std::uint64_t pixel_bytes = 0;
};

DicomTag tags_of(const itk::MetaDataDictionary &tags)
{
    return [&tags](const char *element) {
        std::string text;
        itk::ExposeMetaData<std::string>(tags, element, text);
        const std::size_t end = text.find_last_not_of(std::string(" \0", 2));
        return end == std::string::npos ? std::string() : text.substr(0, end + 1);
    };
}

Slice slice_of(const fs::path &file)
{
    const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
    io->SetFileName(file.string());
    io->ReadImageInformation();
    Slice slice;
    slice.name = file.filename().string();
    slice.file = file;
    const DicomTag tag = tags_of(io->GetMetaDataDictionary());
    check_dicom_kind(tag, file.string());
    slice.head = head_of(*io, file.string());
    slice.series = tag("0020|000e");
    slice.owner = dicom_owner(tag);
    slice.doubts = dicom_doubts(tag);
    slice.thickness_mm = std::strtod(tag("0018|0050").c_str(), nullptr);
    slice.in_series = std::strtol(tag("0020|1002").c_str(), nullptr, 10);
    check_dicom_places(tag, file.string());
    slice.pixel_bytes = dicom_pixel_bytes(tag);
    return slice;
}

std::vector<Slice> slices_in(const fs::path &folder)
{
    std::vector<fs::path> files;
    std::error_code ignored; // such as a link to itself
    for (const fs::directory_entry &entry : fs::directory_iterator(folder))
        if (entry.is_regular_file(ignored) && entry.path().filename().string()[0] != '.' &&
            lower_name(entry.path()) != "dicomdir")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<Slice> slices;
    for (const fs::path &file : files) {
        const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
        dicom_syntax(file); // GDCM ends the process at some headers
        if (!io->CanReadFile(file.string().c_str())) {
            if (lower_name(file).ends_with(".dcm"))
                throw Fault(file.string() +
                            ": is no DICOM file in spite of its name, or truncated: export it again");
            continue; // skips other files, such as a note
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
    // The identifier of a series leads to its patient, so the message names the series by their files.
    std::map<std::string, std::pair<std::size_t, std::string>> series;
    for (const Slice &slice : slices) ++series.try_emplace(slice.series, 0, slice.name).first->second.first;
    if (series.size() > 1) {
        std::string list;
        for (const auto &[uid, of] : series)
            list += "\n  " + std::to_string(of.first) + " images, such as " + of.second;
        throw Fault(folder + ": " + std::to_string(series.size()) + " series in one folder: keep one of" +
                    list);
    }
    long said = 0;
    for (const Slice &slice : slices) {
        const Head &first = slices.front().head;
        if (slice.head.size[0] != first.size[0] || slice.head.size[1] != first.size[1] ||
            slice.head.size[2] != 1 ||
            (slice.head.spacing_mm - first.spacing_mm).head<2>().cwiseAbs().maxCoeff() > 1e-4 ||
            (slice.head.direction - first.direction).leftCols<2>().cwiseAbs().maxCoeff() > 1e-3)
            throw Fault(folder + ": " + slice.name + " has another size, spacing or direction than " +
                        slices.front().name + ": the folder mixes series; keep one");
        const std::string differs = difference_of(slice.owner, slices.front().owner);
        if (!differs.empty())
            throw Fault(folder + ": " + slice.name + " and " + slices.front().name + " are of different " +
                        differs + ": keep the files of one");
        said = std::max(said, slice.in_series);
    }
    if (said > static_cast<long>(slices.size()))
        throw Fault(folder + ": the series is truncated: " + std::to_string(slices.size()) + " of " +
                    std::to_string(said) + " images are there: copy the whole series");
}

std::vector<std::string> doubts_about(const std::vector<Slice> &slices, double distance_mm)
{
    std::vector<std::string> all;
    double thickness_mm = 0.0;
    for (const Slice &slice : slices) {
        thickness_mm = std::max(thickness_mm, slice.thickness_mm);
        for (const std::string &doubt : slice.doubts)
            if (std::find(all.begin(), all.end(), doubt) == all.end()) all.push_back(doubt);
    }
    if (thickness_mm > 0.0 && distance_mm > 1.25 * thickness_mm)
        all.push_back(formatted("has slices of %.2f mm, %.2f mm apart: what is between them was not scanned",
                                thickness_mm, distance_mm));
    return all;
}

} // namespace

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
    Volume volume = checked_volume(head, name);
    volume.notes = doubts_about(slices, order.distance_mm);
    take_head(volume);
    const std::size_t pixels = volume.count() / slices.size();
    for (std::size_t i = 0; i < slices.size(); ++i) {
        const Slice &slice = slices[order.order[i]];
        const itk::GDCMImageIO::Pointer io = itk::GDCMImageIO::New();
        io->SetFileName(slice.file.string());
        try {
            check_dicom_length(slice.file, slice.pixel_bytes);
            io->ReadImageInformation();
            read_values(*io, take_values, pixels, slice.file.string());
        } catch (const itk::ExceptionObject &error) {
            throw Fault(slice.file.string() + ": cannot be read: " + cause_of(error) +
                        ": the file is truncated or damaged; export it again");
        }
    }
}

} // namespace crn::ct
