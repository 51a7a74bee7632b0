/* Makes random variants of the coronary arteries, each from a seed. The drawn arteries lie on the shipped
   heart and leave the shipped aorta (docs/vessels.md, "Drawn coronary arteries"). */
#pragma once
#include "tools/anatomy/heart_course.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anatomy
{

/* States which artery supplies the back of the heart. Right: the RCA has the posterior descending and the
 * posterolateral artery. Left: the circumflex artery has both. Balanced: the RCA has the first, and the
 * circumflex artery the second. */
enum class Dominance { right, left, balanced };

/* Describes one drawn artery as the vessel file states it. */
struct CoronaryArtery {
    std::string name, parent;
    std::optional<Bed> side;       // of an artery that leaves the aorta
    std::vector<Station> stations; // in space, before those on the heart
    std::vector<HeartMark> marks;  // on the heart
    double flow_ml_min = 0;        // out of its end; 0: its branches carry all of its flow
};

struct DrawnCoronaries {
    std::uint64_t seed = 0;
    Dominance dominance = Dominance::right;
    bool has_ramus = false; // the left main artery divides into three
    unsigned diagonals = 2, marginals = 2;
    double past_apex_mm = 0;              // length of the LAD beyond the apex; 0: it ends before
    std::vector<CoronaryArtery> arteries; // parents first
    TreeDraft draft;                      // the shipped aorta with these arteries
    unsigned refused = 0;                 // earlier attempts with this seed that broke a rule
};

/* Makes the arteries that belong to a seed, on the shipped aorta. Every seed has some. Throws crn::FileError
 * if the shipped files cannot be read. */
DrawnCoronaries drawn_coronaries(std::uint64_t seed);

/* Makes the arteries that belong to a seed, on a drawn aorta, with diameters of `calibre` times the usual
 * ones. Throws std::runtime_error if no plausible arteries are found. */
DrawnCoronaries drawn_coronaries(std::uint64_t seed, const TreeDraft &aorta, double calibre);

/* Returns the arteries as the text of a vessel file, which extends the shipped aorta.toml. */
std::string coronary_file_text(const DrawnCoronaries &drawn);

/* Returns where the LAD ends, as in "12 mm beyond the apex". */
std::string end_of_lad(const DrawnCoronaries &drawn);

const char *dominance_name(Dominance dominance);

} // namespace anatomy
