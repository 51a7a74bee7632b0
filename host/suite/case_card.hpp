// Describes what the start screen offers: one card per case or practice, and the stored recordings.
#pragma once
#include "host/command/view_options.hpp"
#include "host/picture/picture.hpp"
#include <map>
#include <string>
#include <vector>

namespace crn
{

// One card. Any code that has cases (from files, a server or a test) makes cards of them; the window only
// shows cards and begins sessions with their options.
struct CaseCard {
    std::string name;      // "Free practice: aorta"
    std::string story;     // one or two sentences about the patient
    std::string goal;      // what must be true at the end
    std::string best;      // best score so far, as text; empty: none
    std::string trouble;   // why it cannot begin, and the remedy; empty: it can
    WindowOptions options; // scene, tools, stents and start lengths of the session; the case, if it is one
    Image picture{};       // grey and square; without pixels: none
};

// Returns the cards of all cases: those of the user's own folder and those that come with the program. The
// scene of a case is made later, so the card's options do not name a scene. A case file that cannot be read
// gives a card that states the reason. `best` holds the best score of each case, keyed by the case's name.
std::vector<CaseCard> case_cards(const WindowOptions &options, const std::map<std::string, double> &best);
CaseCard case_card(const WindowOptions &options, const Case &lesson);

// Returns the cards for free practice in the scene that comes with the program, and in free space. `options`
// holds what the user has stated on the command line, such as the scene, the size of pictures and the device.
std::vector<CaseCard> practice_cards(const WindowOptions &options);

struct KeptRecording {
    std::string path, name, when; // when: "2026-11-24 21:19"
    std::uintmax_t bytes = 0;
};
// Returns the newest recordings in the user's folder, newest first; the list is empty if this folder does not
// exist.
std::vector<KeptRecording> kept_recordings(std::size_t count_max);

} // namespace crn
