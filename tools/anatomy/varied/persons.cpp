#include "tools/anatomy/varied/persons.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/anatomy/chance.hpp"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace anatomy
{

namespace
{

/* Each quantity has its own stream of chance, so that an option that replaces one changes no other. */
enum class Stream : std::uint64_t {
    sex = 1000,
    age,
    height,
    weight,
    calcium,
    osteophytes,
    cartilage,
    gas,
    bowel,
    kyphosis,
    scoliosis
};

Chance chance_of(std::uint64_t seed, Stream stream)
{
    return Chance(seed, static_cast<std::uint64_t>(stream));
}

double to_unit(double value, double unit)
{
    return std::round(value / unit) * unit;
}

/* Interpolates four means by age: below 45, 45 to 54, 55 to 64, and 65 and above. Each mean belongs to the
 * middle of its age group. */
double by_age(const double (&means)[4], double age_years)
{
    constexpr double AGES[4] = {38, 50, 60, 72}; // the outer two are assumed
    if (age_years <= AGES[0]) return means[0];
    for (int i = 1; i < 4; ++i)
        if (age_years < AGES[i])
            return std::lerp(means[i - 1], means[i], (age_years - AGES[i - 1]) / (AGES[i] - AGES[i - 1]));
    return means[3];
}

/* PMC9894311, table 3: diameters from areas, and the width of the arch. Rogers 2013: the infrarenal aorta. */
constexpr double ASCENDING_MM[2][4] = {{32.3, 34.4, 35.8, 37.2}, {30.4, 31.6, 33.1, 33.9}},
                 DESCENDING_MM[2][4] = {{24.4, 25.9, 27.3, 29.5}, {22.1, 23.1, 24.4, 26.0}},
                 ARCH_WIDTH_MM[2][4] = {{71, 78, 84, 93}, {63, 68, 73, 81}}, ARCH_WIDTH_SD_MM[2] = {8.5, 7.5},
                 INFRARENAL_MM[2] = {19.3, 16.7}, BRANCHES[2] = {1.0, 0.9},
                 RENAL_CALIBRE[2] = {1.0, 0.855}; // root of the areas 22.9 over 31.3 mm2

size_t number(Sex sex)
{
    return sex == Sex::woman ? 1 : 0;
}

void refuse_size(const Person &person, const PersonWish &wish)
{
    if (person.bmi() >= BMI_LEAST && person.bmi() <= BMI_MOST) return;
    const double square = person.height_m * person.height_m;
    throw std::invalid_argument(crn::formatted("--height %.0f and --weight %.0f%s give a body mass index of "
                                               "%.1f; at this height, choose --weight %.0f to "
                                               "%.0f",
                                               100 * person.height_m, person.weight_kg,
                                               wish.height_cm && wish.weight_kg ? "" : " (one of them drawn)",
                                               person.bmi(), std::ceil(BMI_LEAST * square),
                                               std::floor(BMI_MOST * square)));
}

/* Draws the bend of a spine. The spread of the kyphosis is that of Fon 1980, from memory, in a person who
 * lies on the back; the limits are those within which the chest and the vessels of the shipped man follow. Of
 * asymptomatic adults, 13 % have a scoliosis of more than 10 degrees in an upright chest picture (PMID
 * 26329652); here everyone has a smaller one, more often to the right (assumed). */
SpineBend drawn_bend(std::uint64_t seed, const SpineBend &usual)
{
    constexpr double KYPHOSIS_SD_DEG = 5.5, SCOLIOSIS_MEAN_DEG = 1.0, SCOLIOSIS_SD_DEG = 2.0;
    const double kyphosis_deg = chance_of(seed, Stream::kyphosis).normal(usual.kyphosis_deg, KYPHOSIS_SD_DEG);
    return {to_unit(std::clamp(kyphosis_deg, KYPHOSIS_LEAST_DEG, KYPHOSIS_MOST_DEG), 0.1),
            to_unit(chance_of(seed, Stream::scoliosis).normal(SCOLIOSIS_MEAN_DEG, SCOLIOSIS_SD_DEG), 0.1)};
}

} // namespace

Person drawn_body(std::uint64_t seed, const PersonWish &wish)
{
    constexpr double WOMEN = 0.4; // of patients in a catheter laboratory; assumed
    constexpr double HEIGHT_CM[2] = {176, 163}, HEIGHT_SD_CM[2] = {7, 6.5}, BMI_MEAN = 26.5, BMI_SD = 4.5;
    Person person;
    person.sex =
        wish.sex.value_or(chance_of(seed, Stream::sex).uniform(0, 1) < WOMEN ? Sex::woman : Sex::man);
    const size_t sex = number(person.sex);
    person.age_years = wish.age_years.value_or(
        to_unit(std::clamp(chance_of(seed, Stream::age).normal(62, 15), AGE_LEAST, AGE_MOST), 1));
    person.height_m =
        0.01 * wish.height_cm.value_or(
                   to_unit(chance_of(seed, Stream::height).normal(HEIGHT_CM[sex], HEIGHT_SD_CM[sex]), 1));
    const double bmi = std::clamp(chance_of(seed, Stream::weight).normal(BMI_MEAN, BMI_SD), 18.0, 36.0);
    person.weight_kg = wish.weight_kg.value_or(to_unit(bmi * person.height_m * person.height_m, 1));
    refuse_size(person, wish);
    // Chance multiplies what is usual for the age by a factor around 1.
    const SkeletonShape usual = usual_skeleton(person.sex, person.age_years);
    const double over = std::clamp((person.age_years - 40) / 45, 0.0, 1.0); // 0 at 40, 1 at 85 years
    person.wall_calcium = wish.calcium.value_or(
        to_unit(std::clamp(over * chance_of(seed, Stream::calcium).uniform(0.2, 1.3), 0.0, 1.0), 0.01));
    person.osteophytes = to_unit(
        std::clamp(usual.osteophytes * chance_of(seed, Stream::osteophytes).uniform(0.4, 1.6), 0.0, 1.0),
        0.01);
    person.cartilage_calcium = to_unit(
        std::clamp(usual.cartilage_calcium * chance_of(seed, Stream::cartilage).uniform(0.5, 1.5), 0.0, 1.0),
        0.01);
    person.bend = drawn_bend(seed, usual.bend);
    person.gas = to_unit(chance_of(seed, Stream::gas).uniform(0.75, 1.1), 0.01);
    person.arms = wish.arms;
    person.clutter = wish.clutter;
    person.seed = 1 + static_cast<std::uint32_t>(chance_of(seed, Stream::bowel).uniform(0, 1e9));
    return person;
}

AortaCalibre mean_calibre(const Person &person)
{
    const size_t sex = number(person.sex);
    const double scale = person.scale();
    const double ascending = by_age(ASCENDING_MM[sex], person.age_years),
                 descending = by_age(DESCENDING_MM[sex], person.age_years);
    const double aged = descending / DESCENDING_MM[sex][1];
    AortaCalibre calibre;
    calibre.annulus_mm = 24.0 * (sex ? 0.93 : 1.0) / scale;
    calibre.ascending_mm = ascending / scale;
    calibre.descending_mm = descending / scale;
    calibre.infrarenal_mm = INFRARENAL_MM[sex] * std::sqrt(aged) / scale; // half of the growth; assumed
    calibre.branches = BRANCHES[sex] / scale;
    calibre.renals = RENAL_CALIBRE[sex] / scale;
    return calibre;
}

double mean_arch_width_mm(const Person &person)
{
    return by_age(ARCH_WIDTH_MM[number(person.sex)], person.age_years);
}

VesselTree enlarged(VesselTree tree, double factor)
{
    for (Vessel &vessel : tree.vessels)
        for (Station &station : vessel.stations) {
            station.position_mm *= factor;
            station.diameter_mm *= factor;
        }
    tree.fillet_mm *= factor;
    tree.coronary_fillet_mm *= factor;
    tree.entry_position_mm *= factor;
    return tree;
}

DrawnPerson drawn_person(std::uint64_t seed, const PersonWish &wish)
{
    constexpr double WIDTH_LEAST = 0.8, WIDTH_MOST = 1.2; // of the shipped arch
    static const std::vector<Vessel> shipped = shipped_vessels("aorta").vessels;
    DrawnPerson drawn;
    drawn.seed = seed;
    drawn.person = drawn_body(seed, wish);
    AortaWish aorta;
    aorta.type = wish.arch;
    aorta.has_common_trunk = wish.has_common_trunk;
    aorta.tortuosity = wish.tortuosity;
    aorta.calibre = mean_calibre(drawn.person);
    drawn.arch_width_wanted_mm =
        Chance(seed, 2000)
            .normal(mean_arch_width_mm(drawn.person), ARCH_WIDTH_SD_MM[number(drawn.person.sex)]);
    const double shipped_width_mm = arch_width_mm(moved_with_spine(shipped, drawn.person.bend));
    aorta.arch_width = std::clamp(drawn.arch_width_wanted_mm / drawn.person.scale() / shipped_width_mm,
                                  WIDTH_LEAST, WIDTH_MOST);
    aorta.skeleton = skeleton_shape(drawn.person);
    aorta.skeleton.arms = Arms::raised; // other arms change no artery of the lumen
    drawn.aorta = drawn_aorta(seed, aorta);
    std::vector<Vessel> vessels;
    for (const GivenVessel &given : drawn.aorta.draft.vessels) vessels.push_back(given.vessel);
    drawn.arch_width_mm = drawn.person.scale() * arch_width_mm(vessels);
    if (wish.has_coronaries)
        // A woman's coronary arteries are 9 % narrower (Dodge 1992); those of a small man are not.
        drawn.coronaries = drawn_coronaries(
            seed, drawn.aorta.draft, (drawn.person.sex == Sex::woman ? 0.91 : 1.0) / drawn.person.scale());
    return drawn;
}

VesselTree DrawnPerson::tree() const
{
    VesselTree made =
        coronaries ? tree_of(coronaries->draft, "heart.toml") : tree_of(aorta.draft, "aorta.toml");
    made.skeleton = skeleton_shape(person);
    made.seed = seed;
    made.title =
        crn::formatted("Person %llu: %s, %.0f years, %.0f cm, %.0f kg", static_cast<unsigned long long>(seed),
                       person.sex == Sex::woman ? "woman" : "man", person.age_years, 100 * person.height_m,
                       person.weight_kg);
    return made;
}

} // namespace anatomy
