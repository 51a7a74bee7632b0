// What the reader of files (volume_read.cpp) and that of DICOM series (volume_series.cpp) share. Both run in
// the child process of volume_apart.cpp.
#pragma once
#include "tools/lab/ct/volume/volume_io.hpp"

namespace itk
{
class ExceptionObject;
class ImageIOBase;
} // namespace itk

namespace crn::ct
{

// Returns the grid of a file, in three dimensions, as reported by the ITK class that reads the file.
struct Head {
    std::array<long, 3> size = {1, 1, 1};
    Eigen::Vector3d spacing_mm = Eigen::Vector3d::Ones(), origin_mm = Eigen::Vector3d::Zero();
    Eigen::Matrix3d direction = Eigen::Matrix3d::Identity();
};
Head head_of(const itk::ImageIOBase &io, const std::string &name);

// Throws Fault if the grid is impossible.
Volume checked_volume(const Head &head, const std::string &name);

// Reads the values of an open file as HU.
void read_values(itk::ImageIOBase &io, const TakeValues &out, std::size_t count, const std::string &name);

// Returns the last part of ITK's error message, without its file names and line numbers.
std::string cause_of(const itk::ExceptionObject &error);

std::string lower_name(const std::filesystem::path &path);

void read_series(const std::filesystem::path &folder, const TakeHead &take_head,
                 const TakeValues &take_values);

} // namespace crn::ct
