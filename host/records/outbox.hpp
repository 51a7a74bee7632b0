// Sends the sessions of a station (a simulator's computer) to the centre's server. A session is stored in the
// station's own file first, in one transaction with its row of the table `outbox`. The outbox row of a
// session is deleted after the server has committed the session. After a crash of station or server a session
// is at most sent twice, and its UUID makes a second delivery harmless.
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

// Sends first the station's erasures, then the changes of trainees, then the waiting sessions; finally
// carries out the centre's erasures. Throws RecordsError (unreachable) when the connection breaks; the items
// sent before that are not sent again.
Shipment ship(RecordStore &station, RecordStore &centre);

// Opens the server and ships. If the connection breaks, the function tries again after 0.1 s, 0.2 s ... 2 s;
// it gives up after `attempts` tries without progress.
Shipment ship_to(RecordStore &station, const std::string &url, int attempts = 3);

// Stores the session in the station's own file, and tries once to send it to the server `url`, if `url` is
// not empty. `note` receives a text for the user: the result of the sending, or why nothing was sent. Throws
// RecordsError only if the station's own file cannot store the session.
std::string save_and_ship(RecordStore &station, const SessionRecord &record, const std::string &url,
                          std::string &note);

} // namespace crn
