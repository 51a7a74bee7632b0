#include "host/command/cli_records.hpp"
namespace crn
{
int command_records_curve(RecordStore &, const RecordsOptions &)
{
    return 1;
}
int command_records_cohort(RecordStore &, const RecordsOptions &)
{
    return 1;
}
} // namespace crn
