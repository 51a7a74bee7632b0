// Stores the sessions of cases in the records of trainees (docs/records.md), and reads best scores and
// learning curves for the GUI window.
#pragma once
#include "host/cases/case.hpp"
#include "host/command/recorded_score.hpp"
#include "host/records/learning.hpp"
#include <map>
#include <string>

namespace crn
{

inline constexpr char guest_name[] = "guest"; // pseudonym of a trainee who gives none

// Returns the pseudonym that remember_trainee() has stored in the user's state folder, or an empty text if
// there is none.
std::string remembered_trainee();
void remember_trainee(const std::string &trainee); // an error of the disk is ignored

// Returns the best score of this trainee for each case, by the case's name. The result is empty if there are
// no records or they cannot be read.
std::map<std::string, double> best_scores(const std::string &trainee);

// States which session is stored, and when the session began.
struct PlayedCase {
    const Case *lesson = nullptr;
    std::string trainee;    // empty: guest
    std::string started_at; // UTC, as records write it
    std::string recording;
};
struct StoredSession {
    std::string trainee, id;
    std::string note;    // of the shipment to a server; may be empty
    std::string trouble; // why the session is not stored, with the remedy; empty: it is
    LearningCurve curve; // of the score, over the trainee's sessions in this case
};
// Returns the record of a scored session. The stored score is the mark of the case, the stored metrics are
// those of the assessment and of the motion, and the stored events are errors and beginnings of phases.
SessionRecord record_of(const PlayedCase &played, const RecordedScore &score);
// Stores the session and sends it to the server that COURNAND_RECORDS names, if it names one. The recording
// gets a second name in the user's data folder, so that it is not deleted with the oldest kept recordings.
StoredSession store_session(const PlayedCase &played, const RecordedScore &score);

} // namespace crn
