// Reads the number arrays of VTK's XML files. An array is stored as text, or as base64 with or without zlib,
// inside its element or at the end of the file. See Kitware, "VTK XML Formats".
#pragma once
#include "tools/centreline/formats.hpp"

#include <pugixml.hpp>

namespace crn::centreline
{

constexpr std::size_t array_bytes_max = std::size_t{256} << 20;

class VtkFile
{
  public:
    // Parses the text of a VTK file and checks the root element. Throws Fault.
    VtkFile(const std::string &text, const std::string &name);

    const pugi::xml_document &document() const { return document_; }
    const std::string &name() const { return name_; }

    // Returns the numbers that a DataArray element holds. Throws a Fault with the array's name when its
    // values cannot be read, or when their number differs from `count` (if `count` is not 0).
    std::vector<double> values(const pugi::xml_node &array, std::size_t count) const;

    [[noreturn]] void fail(const std::string &what) const { throw Fault(name_ + ": " + what); }

  private:
    std::string bytes_of(const pugi::xml_node &array, const std::string &what) const;

    std::string name_;
    pugi::xml_document document_;
    bool is_big_end_first_ = false, is_compressed_ = false;
    std::size_t header_bytes_ = 4;
};

} // namespace crn::centreline
