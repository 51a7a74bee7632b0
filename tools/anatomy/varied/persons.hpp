/* Draws whole persons, each from one seed: sex, age, size and weight, the aorta with its branches, and on
 * request the coronary arteries (docs/anatomy.md, "One person per seed"). */
#pragma once
#include "tools/anatomy/person.hpp"
#include "tools/anatomy/varied/coronaries.hpp"
#include "tools/anatomy/varied/variety.hpp"
#include <optional>

namespace anatomy
{

/* What is asked for; the rest is drawn. What is asked for changes nothing else that the seed draws. */
struct PersonWish {
    std::optional<Sex> sex;
    std::optional<double> age_years, height_cm, weight_kg;
    std::optional<ArchType> arch;
    bool has_common_trunk = false;
    std::optional<double> tortuosity, calcium;
    bool has_coronaries = false;
    Arms arms = Arms::raised;
    Clutter clutter;
};

constexpr double AGE_LEAST = 18, AGE_MOST = 95, HEIGHT_LEAST_CM = 140, HEIGHT_MOST_CM = 205,
                 WEIGHT_LEAST_KG = 32, WEIGHT_MOST_KG = 180, BMI_LEAST = 16, BMI_MOST = 42,
                 TORTUOSITY_LEAST = 1.08, TORTUOSITY_MOST = 1.4, KYPHOSIS_LEAST_DEG = -6,
                 KYPHOSIS_MOST_DEG = 13;

struct DrawnPerson {
    std::uint64_t seed = 0;
    Person person;
    DrawnAorta aorta;
    std::optional<DrawnCoronaries> coronaries;
    double arch_width_mm = 0, arch_width_wanted_mm = 0; // of this person, at full size

    /* The tree in the shipped frame, in which the bodies are made. */
    VesselTree tree() const;
};

/* Draws sex, age, size and weight alone. Throws std::invalid_argument if a height and a weight do not belong
 * together. */
Person drawn_body(std::uint64_t seed, const PersonWish &wish);

/* Draws a whole person. Throws what drawn_body(), drawn_aorta() and drawn_coronaries() throw. */
DrawnPerson drawn_person(std::uint64_t seed, const PersonWish &wish);

/* Returns the mean diameters of a person's aorta, in the shipped frame. */
AortaCalibre mean_calibre(const Person &person);

/* Returns the mean width of the arch by sex and age, at full size. */
double mean_arch_width_mm(const Person &person);

/* Returns the tree with all positions and diameters multiplied by a factor. */
VesselTree enlarged(VesselTree tree, double factor);

/* Returns what was drawn as TOML, with the command that makes this person again. `making` are further options
 * of this command, such as " --lumen-mm 0.6". */
std::string person_text(const DrawnPerson &drawn, const PersonWish &wish, const std::string &making);

/* Returns the vessels in the shipped frame as a vessel file. */
std::string person_vessels_text(const DrawnPerson &drawn);

/* Returns one line about the person, such as "woman, 71 years, 158 cm, 63 kg, arch of type III". */
std::string person_line(const DrawnPerson &drawn);

} // namespace anatomy
