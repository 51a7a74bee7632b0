#include "tools/anatomy/lesions.hpp"
#include "host/base/number_text.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/mesh/lesion_ranges.hpp"
#include <array>
#include <sstream>
#include <stdexcept>

namespace anatomy
{
namespace
{

constexpr const char *FORM = "BRANCH:PERCENT:LENGTH_MM:AT_MM[:ECCENTRICITY[:PLAQUE_DEG[:CALCIFIED_DEG]]]";

double number_from(const std::string &wish, const std::string &word)
{
    std::size_t used = 0;
    double value = 0;
    try {
        value = std::stod(word, &used);
    } catch (const std::exception &) {
        used = 0;
    }
    if (used == 0 || used != word.size())
        throw std::invalid_argument("--lesion " + wish + ": '" + word + "' is no number; give " + FORM);
    return value;
}

struct Number {
    const char *name;
    double Lesion::*value;
    crn::NumberRange range; /* what `bake` accepts: checked here before minutes of meshing, not after them */
};
constexpr std::array<Number, 6> NUMBERS = {
    {{"PERCENT", &Lesion::stenosis_percent, crn::lesion_stenosis_percent},
     {"LENGTH_MM", &Lesion::length_mm, crn::lesion_length_mm},
     {"AT_MM", &Lesion::at_mm, crn::lesion_at_mm},
     {"ECCENTRICITY", &Lesion::eccentricity, crn::lesion_eccentricity},
     {"PLAQUE_DEG", &Lesion::plaque_deg, crn::lesion_plaque_deg},
     {"CALCIFIED_DEG", &Lesion::calcified_deg, crn::lesion_calcified_deg}}};

} // namespace

Lesion lesion_from(const std::string &wish)
{
    std::vector<std::string> words;
    std::istringstream stream(wish);
    for (std::string word; std::getline(stream, word, ':');) words.push_back(word);
    if (words.size() < 4 || words.size() > 7 || words[0].empty())
        throw std::invalid_argument("--lesion " + wish + ": give " + FORM + ", like LAD:75:14:22");
    Lesion lesion;
    lesion.branch = words[0];
    for (std::size_t i = 1; i < words.size(); i++) {
        const Number &number = NUMBERS[i - 1];
        const double value = number_from(wish, words[i]);
        if (!(value >= number.range.low && value <= number.range.high))
            throw std::invalid_argument("--lesion " + wish + ": " + number.name + " must be " +
                                        crn::number_text(number.range.low) + " to " +
                                        crn::number_text(number.range.high));
        lesion.*number.value = value;
    }
    return lesion;
}

std::string lesions_text(const std::vector<Lesion> &lesions, const VesselTree &tree,
                         const std::string &inside)
{
    std::string text;
    int count = 0;
    for (const Lesion &lesion : lesions) {
        std::string known;
        bool is_known = false;
        for (const Vessel &vessel : tree.vessels) {
            is_known = is_known || file_stem(vessel.name) == lesion.branch;
            known += (known.empty() ? "" : ", ") + file_stem(vessel.name);
        }
        if (!is_known)
            throw std::invalid_argument("--lesion " + lesion.branch + ": no such vessel; there are " + known);
        text += "\n[[lesion]]\nname = \"lesion_" + std::to_string(++count) + "\"\nbranch = \"" +
                lesion.branch + "\"\n";
        text += "at_mm = " + crn::number_text(lesion.at_mm) +
                "\nlength_mm = " + crn::number_text(lesion.length_mm) +
                "\nstenosis_percent = " + crn::number_text(lesion.stenosis_percent) + " # of the diameter\n";
        if (lesion.eccentricity != 0)
            text += "eccentricity = " + crn::number_text(lesion.eccentricity) + "\n";
        if (lesion.plaque_deg != 0) text += "plaque_deg = " + crn::number_text(lesion.plaque_deg) + "\n";
        if (lesion.calcified_deg == 0) continue;
        text += "calcified_deg = " + crn::number_text(lesion.calcified_deg) + "\n";
        if (!inside.empty()) text += "inside = \"" + inside + "\"\n";
    }
    return text;
}

} // namespace anatomy
