// Includes OpenVDB for `bake`. OpenVDB's own headers cause warnings, so they are included here as system
// headers.
#pragma once
#pragma GCC system_header
#include <openvdb/openvdb.h>

namespace crn::bake
{

inline void start_openvdb()
{
    openvdb::initialize(); // may be called again
}

} // namespace crn::bake
