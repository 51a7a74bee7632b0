// Takes the place of the server in a program that was built without OpenIGTLink.
#include "host/base/output_files.hpp"
#include "host/igtl/server.hpp"

namespace crn
{

std::unique_ptr<IgtlServer> open_igtl(const IgtlAddress &, const IgtlLimits &)
{
    throw UsageError("--igtl: this program was built without OpenIGTLink: `make igtl` builds it");
}

} // namespace crn
