#include "tools/anatomy/program/person.hpp"
#include "host/base/command_values.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/progress_line.hpp"
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/varied/plausible.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>

namespace anatomy
{

namespace
{

CLI::Option *add_number(CLI::App &command, const char *name, std::optional<double> &value, const char *what,
                        double least, double most)
{
    return command.add_option(name, value, what)->check(CLI::Range(least, most));
}

CLI::Option *add_seed_number(CLI::App &command, const char *name, std::uint64_t &value, const char *what)
{
    return command.add_option(name, value, what)
        ->type_name("N")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{UINT32_MAX}));
}

/* What `anatomy seeds` counts. */
struct Tally {
    std::uint64_t accepted = 0, refused = 0, women = 0, attempts = 0;
    std::array<std::uint64_t, 3> arches = {};
};

/* Returns the options that change what is made, as on the command line. */
std::string making_text(const Options &options)
{
    const Fineness usual;
    std::string text;
    if (options.fineness.lumen_voxel_mm != usual.lumen_voxel_mm)
        text += " --lumen-mm " + crn::trimmed_text(options.fineness.lumen_voxel_mm, 4);
    if (options.lumen_from_mm > 0.0) text += " --lumen-from " + crn::trimmed_text(options.lumen_from_mm, 4);
    if (options.fineness.body_scale != usual.body_scale)
        text += " --body-scale " + crn::trimmed_text(options.fineness.body_scale, 4);
    if (!options.bodies) text += " --no-bodies";
    for (const std::string &lesion : options.lesions) text += " --lesion " + lesion;
    return text;
}

void print_tally(const Tally &tally, std::uint64_t from, std::uint64_t next)
{
    if (next == from) {
        std::printf("no seed checked\n");
        return;
    }
    std::printf(
        "seeds %llu to %llu: %llu accepted, %llu refused; %llu women; arch I %llu, II %llu, III %llu; %.1f "
        "trees drawn per person\n",
        static_cast<unsigned long long>(from), static_cast<unsigned long long>(next - 1),
        static_cast<unsigned long long>(tally.accepted), static_cast<unsigned long long>(tally.refused),
        static_cast<unsigned long long>(tally.women), static_cast<unsigned long long>(tally.arches[0]),
        static_cast<unsigned long long>(tally.arches[1]), static_cast<unsigned long long>(tally.arches[2]),
        static_cast<double>(tally.attempts) /
            static_cast<double>(std::max<std::uint64_t>(1, tally.accepted)));
}

} // namespace

PersonCommand::PersonCommand(CLI::App &app, void (*add_making)(CLI::App &, Options &))
{
    person_ = app.add_subcommand("person",
                                 "A whole person drawn from a seed: sex, age, size, weight, bones, arteries");
    seeds_ = app.add_subcommand("seeds", "Whether the persons of many seeds are plausible, without meshes");
    CLI::App &command = *person_;
    add_making(command, options_);
    add_seed_number(command, "--seed", seed_, "Draws all that the other options leave open")->required();
    command.add_option("--sex", sex_, "m or f")->check(crn::one_of({"m", "f"}));
    add_number(command, "--age", wish_.age_years, "Years", AGE_LEAST, AGE_MOST);
    add_number(command, "--height", wish_.height_cm, "cm", HEIGHT_LEAST_CM, HEIGHT_MOST_CM);
    add_number(command, "--weight", wish_.weight_kg, "kg", WEIGHT_LEAST_KG, WEIGHT_MOST_KG);
    command.add_option("--arch", arch_, "Type of the aortic arch, or bovine: with a common trunk")
        ->check(crn::one_of({"I", "II", "III", "bovine"}));
    add_number(command, "--tortuosity", wish_.tortuosity, "Length over distance of the iliac arteries",
               TORTUOSITY_LEAST, TORTUOSITY_MOST);
    add_number(command, "--calcium", wish_.calcium,
               "Plaques of the aorta and the iliac arteries: 0 none, 1 many", 0, 1);
    command.add_option("--arms", arms_, "Where the arms lie: raised over the head, or beside the body")
        ->check(crn::one_of({"raised", "beside"}))
        ->capture_default_str();
    command
        .add_option(
            "--clutter", clutter_,
            "What lies on or in the patient, with commas: leads (ECG), table, wires (sternal), pacemaker")
        ->delimiter(',')
        ->check(crn::one_of({"leads", "table", "wires", "pacemaker"}));
    command.add_flag("--coronary", wish_.has_coronaries,
                     "With coronary arteries and a heart that beats, in 24 frames");
    add_seed_number(*seeds_, "--from", from_, "The first seed")->capture_default_str();
    seeds_->add_option("--count", count_, "How many seeds")
        ->type_name("N")
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000}))
        ->capture_default_str();
    seeds_->add_flag("--coronary", wish_.has_coronaries, "With coronary arteries");
}

std::optional<int> PersonCommand::run()
{
    if (*seeds_) return check_seeds();
    if (*person_) return make();
    return std::nullopt;
}

int PersonCommand::make()
{
    if (!sex_.empty()) wish_.sex = sex_ == "f" ? Sex::woman : Sex::man;
    wish_.arms = arms_ == "beside" ? Arms::beside : Arms::raised;
    for (const std::string &kind : clutter_) {
        wish_.clutter.leads |= kind == "leads";
        wish_.clutter.table |= kind == "table";
        wish_.clutter.wires |= kind == "wires";
        wish_.clutter.pacemaker |= kind == "pacemaker";
    }
    if (arch_ == "bovine")
        wish_.has_common_trunk = true;
    else if (!arch_.empty())
        wish_.arch = arch_ == "I" ? ArchType::I : arch_ == "II" ? ArchType::II : ArchType::III;
    const DrawnPerson drawn = drawn_person(seed_, wish_);
    VesselTree tree = drawn.tree();
    tree.made_by = "person --seed " + std::to_string(seed_);
    options_.scale = drawn.person.scale();
    std::vector<Body> bodies;
    if (options_.bodies || wish_.has_coronaries)
        bodies = patient_bodies(tree, options_.fineness, drawn.person);
    if (wish_.has_coronaries)
        make_heart_scene(options_, tree, bodies);
    else if (options_.bodies)
        make_breathing_scene(options_, tree, bodies, drawn.person);
    else
        make_scene(options_, tree, bodies, [](const std::string &, const Mesh &) {});
    crn::write_whole_file((options_.folder / "person.toml").string(),
                          person_text(drawn, wish_, making_text(options_)));
    crn::write_whole_file((options_.folder / "vessels.toml").string(), person_vessels_text(drawn));
    std::printf("%s: %s\n", (options_.folder / "person.toml").string().c_str(), person_line(drawn).c_str());
    return 0;
}

int PersonCommand::check_seeds() const
{
    crn::watch_for_interrupt();
    Tally tally;
    std::uint64_t seed = from_;
    {
        crn::ProgressLine progress(crn::shows_progress());
        for (; seed < from_ + count_ && !crn::is_interrupted(); ++seed) {
            progress.show(crn::formatted("seed %llu", static_cast<unsigned long long>(seed)), seed - from_,
                          count_);
            try {
                const DrawnPerson drawn = drawn_person(seed, wish_);
                ++tally.accepted;
                tally.women += drawn.person.sex == Sex::woman;
                tally.attempts += drawn.aorta.refused + 1;
                ++tally.arches[static_cast<size_t>(drawn.aorta.arch.type)];
            } catch (const std::exception &error) {
                ++tally.refused;
                std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), error.what());
            }
        }
    }
    print_tally(tally, from_, seed);
    const std::uint64_t left = from_ + count_ - seed;
    if (left > 0)
        std::printf("interrupted; go on with: anatomy seeds --from %llu --count %llu%s\n",
                    static_cast<unsigned long long>(seed), static_cast<unsigned long long>(left),
                    wish_.has_coronaries ? " --coronary" : "");
    return tally.refused > 0 || left > 0 ? 1 : 0;
}

} // namespace anatomy
