// Writes the attributes of an X-ray run, module by module, in the order in which PS3.3 A.14 lists the
// modules. Needs DCMTK.
#pragma once
#include "host/dicom/xa_file.hpp"
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcdatset.h>

namespace crn
{

// Throws std::invalid_argument when the data of the run contradict each other; the message names the
// contradiction.
void check_run(const XrayRun &run);

// Puts everything but the pixels.
void put_attributes(DcmDataset &dataset, const XrayRun &run, const XaStudy &study, const Digest &content,
                    int instance);

} // namespace crn
