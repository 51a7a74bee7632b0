// Simulates a station (a simulator's computer) that tests may kill at any moment. The program stores sessions
// one by one in the station's own file, prints each session's number, and sends the session to the server.
// The program ends when every session is sent and the file HOLD does not exist; a test removes HOLD after its
// last kill.
//   records_station FILE URL STATION FIRST COUNT HOLD
#include "host/records/outbox.hpp"
#include "host/records/tests/sample_records.hpp"
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace
{

constexpr int patience_rounds = 600; // of 0.1 s, while the server is away

// Half of the sessions belong to a trainee who practises at all stations.
crn::SessionRecord session_of(int station, int number)
{
    const std::string trainee = number % 2 == 0 ? "shared" : "trainee " + std::to_string(station);
    return crn::sample_record(trainee, 10000 * station + number);
}

void ship_all(crn::RecordStore &store, const std::string &url, const std::string &hold)
{
    std::size_t sent = 0, known = 0;
    for (int failures = 0;
         failures < patience_rounds && (std::filesystem::exists(hold) || !store.outbox().empty());) {
        try {
            const crn::Shipment shipment = crn::ship_to(store, url, 1);
            sent += shipment.sent;
            known += shipment.known;
            failures += !shipment.refused.empty();
            for (const std::string &line : shipment.refused) std::fprintf(stderr, "%s\n", line.c_str());
        } catch (const crn::RecordsError &error) {
            if (error.cause != crn::RecordsError::Cause::unreachable) throw;
            failures++;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    std::printf("shipped %zu known %zu\n", sent, known);
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 7) return 2;
    const std::string url = argv[2];
    const int station = std::atoi(argv[3]), first = std::atoi(argv[4]), count = std::atoi(argv[5]);
    try {
        crn::RecordStore store = crn::open_store(argv[1]);
        for (int number = first; number < count; number++) {
            std::string note;
            crn::save_and_ship(store, session_of(station, number), url, note);
            std::printf("stored %d\n", number);
            std::fflush(stdout);
        }
        ship_all(store, url, argv[6]);
        return store.outbox().empty() ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
