#include "host/records/outbox.hpp"
#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

namespace crn
{

namespace
{

using Cause = RecordsError::Cause;

void exchange_erasures(RecordStore &station, RecordStore &centre, Shipment &shipment)
{
    for (const RecordStore::Erasure &erasure : station.erasures())
        if (!erasure.is_shipped) {
            centre.take_erasure(erasure);
            station.shipped_erasure(erasure.trainee_id);
        }
    std::set<std::string> known;
    for (const RecordStore::Erasure &erasure : station.erasures()) known.insert(erasure.trainee_id);
    for (const RecordStore::Erasure &erasure : centre.erasures())
        if (!known.count(erasure.trainee_id)) shipment.erased_here += station.take_erasure(erasure);
}

std::map<std::string, Trainee> send_trainees(RecordStore &station, RecordStore &centre, Shipment &shipment)
{
    std::map<std::string, Trainee> by_pseudonym;
    for (const TraineeLine &line : station.trainees()) {
        by_pseudonym[line.trainee.pseudonym] = line.trainee;
        try {
            centre.take_trainee(line.trainee);
        } catch (const RecordsError &error) {
            if (error.cause != Cause::refused) throw;
            shipment.refused.push_back("trainee " + line.trainee.pseudonym + ": " + error.what());
        }
    }
    return by_pseudonym;
}

} // namespace

Shipment ship(RecordStore &station, RecordStore &centre)
{
    Shipment shipment;
    exchange_erasures(station, centre, shipment);
    const std::vector<RecordStore::Waiting> waiting = station.outbox();
    const std::map<std::string, Trainee> trainees = send_trainees(station, centre, shipment);
    std::map<std::string, Station> stations;
    for (const RecordStore::Waiting &one : waiting) {
        const std::vector<SessionRecord> found = station.sessions({"", "", one.session_id});
        if (found.empty()) continue; // erased in the meantime
        const SessionRecord &record = found.front();
        const std::string &station_id = record.station;
        if (!stations.count(station_id)) stations[station_id] = station.station(station_id);
        try {
            const bool is_new = centre.take(record, trainees.at(record.trainee), stations.at(station_id));
            ++(is_new ? shipment.sent : shipment.known);
            station.sent(one.session_id);
        } catch (const RecordsError &error) {
            station.not_sent(one.session_id, error.what());
            if (error.cause != Cause::refused) throw;
            shipment.refused.push_back("session " + one.session_id + ": " + error.what());
        }
    }
    return shipment;
}

Shipment ship_to(RecordStore &station, const std::string &url, int attempts)
{
    Shipment total;
    std::size_t waiting = station.outbox().size();
    for (int failed = 0;;) {
        try {
            RecordStore centre = open_store(url);
            const Shipment one = ship(station, centre);
            total.sent += one.sent;
            total.known += one.known;
            total.erased_here += one.erased_here;
            total.refused = one.refused;
            return total;
        } catch (const RecordsError &error) {
            const std::size_t remaining = station.outbox().size();
            total.sent += waiting - std::min(waiting, remaining);
            failed = remaining < waiting ? 1 : failed + 1;
            waiting = remaining;
            if (error.cause != Cause::unreachable || failed >= attempts) throw;
            std::this_thread::sleep_for(
                std::chrono::milliseconds(std::min(100 << std::min(failed, 5), 2000)));
        }
    }
}

std::string save_and_ship(RecordStore &station, const SessionRecord &record, const std::string &url,
                          std::string &note)
{
    const std::string id = station.save(record);
    note.clear();
    if (url.empty()) return id;
    try {
        const Shipment shipment = ship_to(station, url, 1);
        for (const std::string &line : shipment.refused) note += line + "\n";
    } catch (const RecordsError &error) {
        note = error.what();
    }
    return id;
}

} // namespace crn
