/* Reads trees of vessels from TOML files (docs/vessels.md), both those that ship and those of users. */
#pragma once
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

/* Reads the file and the files that it extends. Throws crn::FileError: "FILE:LINE:COLUMN: vessel, station:
 * what is wrong". */
VesselTree read_vessels(const std::string &file);

/* Returns the path of the file NAME among those that ship. They are in shared/examples/anatomies, and
 * `make install` puts them into share/cournand/examples/anatomies. Both are searched for in the folders
 * above the program, and the former also in the working folder. Throws std::runtime_error when the file is
 * in none of them. */
std::string shipped_vessel_file(const std::string &name);

/* Reads the file NAME.toml that ships. */
VesselTree shipped_vessels(const std::string &name);

} // namespace anatomy
