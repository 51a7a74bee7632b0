// Sends a station's sessions to the centre's server. A session is stored in the station's own file first, in
// one transaction with its row of the table `outbox`. The row is deleted after the server has committed the
// session. So a crash of either side repeats a session at most, and the session's UUID makes repeats
// harmless.
#pragma once
#include "host/records/store.hpp"

namespace crn
{

struct Shipment {
    std::size_t sent = 0;             // sessions that the server did not have before
    std::size_t known = 0;            // sessions that it had already
    std::int64_t erased_here = 0;     // sessions of trainees whose data was erased at the centre
    std::vector<std::string> refused; // one line for each session or trainee that the server refused
};

// Sends erasures, then changes of trainees, then the waiting sessions; takes the centre's erasures. Throws
// RecordsError (unreachable) when the connection breaks; what was sent until then is not sent again.
Shipment ship(RecordStore &station, RecordStore &centre);

// Opens the server and ships. If the connection breaks, it waits 0.1 s, 0.2 s ... 2 s and tries again, at
// most `attempts` times without progress.
Shipment ship_to(RecordStore &station, const std::string &url, int attempts = 3);

// Stores the session in the station's own file, and tries once to ship to `url`, if that is not empty. The
// result of the shipment, or why there was none, is in `note` for the user. Throws RecordsError only if the
// station's own file cannot store the session.
std::string save_and_ship(RecordStore &station, const SessionRecord &record, const std::string &url,
                          std::string &note);

} // namespace crn
