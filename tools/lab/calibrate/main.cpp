// Command line of `calibrate` (docs/calibrate.md).
#include "host/base/command_values.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "tools/lab/calibrate/checkpoint.hpp"
#include "tools/lab/calibrate/corde_evaluator.hpp"
#include "tools/lab/calibrate/result.hpp"
#include "tools/lab/calibrate/rod_evaluator.hpp"

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

namespace
{

using namespace crn::calibrate;
namespace fs = std::filesystem;
namespace insertion = crn::insertion;

constexpr const char *examples =
    "Examples:\n"
    "  calibrate out/case -o out/fit                                   CMA-ES over all cores\n"
    "  calibrate out/case -o out/fit --method genetic cmaes differential   the thesis' search and two "
    "others, with curves\n"
    "  calibrate out/case -o out/fit --resume                          go on after Ctrl-C, a crash, or on "
    "another machine\n"
    "  mpirun -n 16 build/bin/calibrate out/case -o out/fit --resume    over the ranks of an MPI job\n"
    "  calibrate out/case -o out/fit --bounds alpha=0.01..0.5 --bounds density=7000..9000\n"
    "  calibrate out/case --evaluate alpha=0.1                         one insertion, its errors\n"
    "  calibrate out/case -o out/corde --rod corde                     the thesis' own rod instead of ours\n"
    "Exit codes: 0 done, 1 failed or stopped, 2 usage.\n";

struct Options {
    std::string folder, output, rod = "core";
    std::vector<std::string> methods = {"cmaes"}, bounds, trial;
    bool is_trial = false, resume = false, quiet = false, with_page = true;
    unsigned threads = 0;
    SearchSettings search; // except its method and the optional values below
    std::optional<unsigned> population,
        generations; // empty: the method's population, and as many generations as the budget allows
    std::optional<double> speed_mm_per_s, approach_mm, element_factor; // empty: the rod's own
    JudgeSettings judge;
    IdentifySettings identify;
};

class UsageError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

double number_of(const std::string &text, const std::string &whole)
{
    std::size_t used = 0;
    double value = 0.0;
    try {
        value = std::stod(text, &used);
    } catch (const std::exception &) {
        used = 0;
    }
    if (used == 0 || used != text.size()) throw UsageError("'" + whole + "': '" + text + "' is no number");
    return value;
}

// Splits "NAME=REST" into the parameter of that name and REST.
std::pair<std::size_t, std::string> named(const std::string &text, const std::vector<Parameter> &parameters)
{
    const std::size_t at = text.find('=');
    std::string known;
    for (std::size_t i = 0; i < parameters.size(); i++) {
        if (at != std::string::npos && text.substr(0, at) == parameters[i].name)
            return {i, text.substr(at + 1)};
        known += (known.empty() ? "" : ", ") + parameters[i].name;
    }
    throw UsageError("'" + text + "': give NAME=... with one of this instrument's parameters: " + known);
}

// Holds all data that one trial needs; these data are equal on every rank (MPI process).
struct Setup {
    insertion::Case c;
    std::unique_ptr<vcsim3::Vessel> vessel;
    std::unique_ptr<Evaluator> evaluator, careful;
    std::unique_ptr<Judge> judge;

    explicit Setup(const Options &options) : c(insertion::read_case(options.folder))
    {
        std::error_code ignored;
        const fs::path scene = c.path_in(c.scene);
        if (!fs::is_regular_file(scene, ignored))
            throw crn::Fault(scene.string() + ": no such scene: `bake` makes it from the phantom's mesh");
        vessel = std::make_unique<vcsim3::Vessel>(scene.string());
        if (options.rod == "corde") {
            make_evaluators<CordeEvaluator>(options, corde_settings(), careful_corde_settings());
        } else {
            make_evaluators<RodEvaluator>(options, {}, careful_settings());
        }
        judge = std::make_unique<Judge>(c, options.judge);
        for (const std::string &bound : options.bounds) {
            const auto [index, range] = named(bound, evaluator->parameters());
            const std::size_t dots = range.find("..");
            if (dots == std::string::npos) throw UsageError("'" + bound + "': give NAME=LOW..HIGH");
            evaluator->set_bounds(index, number_of(range.substr(0, dots), bound),
                                  number_of(range.substr(dots + 2), bound));
        }
    }

    template <class Kind, class Settings>
    void make_evaluators(const Options &options, Settings settings, const Settings &careful_ones)
    {
        settings.speed_mm_per_s = options.speed_mm_per_s.value_or(settings.speed_mm_per_s);
        settings.approach_mm = options.approach_mm.value_or(settings.approach_mm);
        settings.element_factor = options.element_factor.value_or(settings.element_factor);
        evaluator = std::make_unique<Kind>(c, *vessel, settings);
        careful = std::make_unique<Kind>(c, *vessel, careful_ones);
    }

    Verdict evaluate(const std::vector<double> &shares) const
    {
        return judge->evaluate(*evaluator, values_of(shares));
    }

    std::vector<double> values_of(const std::vector<double> &shares) const
    {
        std::vector<double> values;
        for (std::size_t i = 0; i < shares.size(); i++)
            values.push_back(evaluator->parameters()[i].value_at(shares[i]));
        return values;
    }
};

// Writes the file depth_N.csv of a case. `nodes_mm` begins at the tip, but the file lists the nodes from the
// introducer to the tip.
void write_shape(const Options &options, const insertion::Case &c, std::size_t depth,
                 const std::vector<Vector3d> &nodes_mm)
{
    std::vector<Vector3d> line = {c.mouth_mm};
    line.insert(line.end(), nodes_mm.rbegin(), nodes_mm.rend());
    insertion::write_centreline(fs::path(options.output) / ("depth_" + std::to_string(depth + 1) + ".csv"),
                                line);
}

int evaluate_once(const Options &options, const Setup &setup)
{
    std::vector<double> values;
    for (const Parameter &parameter : setup.evaluator->parameters()) values.push_back(parameter.nominal);
    for (const std::string &text : options.trial) {
        if (text.empty()) continue;
        const auto [index, value] = named(text, setup.evaluator->parameters());
        values[index] = number_of(value, text);
    }
    const Insertion made = setup.evaluator->insert(values, setup.c.depths.size());
    for (std::size_t i = 0; i < values.size(); i++)
        std::printf("%s\t%.6g\t%s\n", setup.evaluator->parameters()[i].name.c_str(), values[i],
                    setup.evaluator->parameters()[i].unit.c_str());
    std::printf("depth\tRMS mm\tmean mm\tdeviation mm\tmax mm\tforce, relative\trest ms\n");
    for (std::size_t i = 0; i < setup.c.depths.size(); i++) {
        const Distances d = distances_of(made.nodes_mm[i], setup.judge->references_mm()[i]);
        const std::optional<double> force =
            setup.judge->has_force() ? setup.judge->force_error_to(made, i) : std::nullopt;
        std::printf("%s\t%.4f\t%.4f\t%.4f\t%.4f\t%s\t%d\n", setup.c.depths[i].name.c_str(), d.rms_mm,
                    d.mean_mm, d.deviation_mm, d.max_mm, force ? std::to_string(*force).c_str() : "-",
                    made.settle_ticks[i]);
    }
    if (options.output.empty()) return 0;
    fs::create_directories(options.output);
    for (std::size_t i = 0; i < made.nodes_mm.size(); i++) write_shape(options, setup.c, i, made.nodes_mm[i]);
    insertion::write_force(fs::path(options.output) / "force.csv", made.force);
    return 0;
}

// Runs one search method until its budget of trials is used up, and writes a checkpoint after every
// generation.
Finished search(const Options &options, Method method, const Setup &setup, const EvaluateShares &evaluate,
                std::string &doing)
{
    Finished finished{sized(options.search, method, options.population, options.generations), {}};
    SearchState &state = finished.state;
    const std::string file =
        (fs::path(options.output) / ("checkpoint_" + std::string(method_token(method)) + ".txt")).string();
    const std::uint64_t hash = hash_of(setup.c, *setup.evaluator, *setup.judge, finished.settings);
    const std::size_t count = setup.evaluator->parameters().size();
    std::error_code ignored;
    if (options.resume && fs::exists(file, ignored)) state = read_checkpoint(file, hash, count);
    while (state.generation < finished.settings.generations && !has_converged(finished.settings, state)) {
        const std::string text = crn::formatted("%s, generation %u of %u", method_token(method),
                                                state.generation + 1, finished.settings.generations);
        doing = text;
        advance(finished.settings, count, evaluate, state);
        write_checkpoint(file, hash, finished.settings, state);
    }
    return finished;
}

void write_outputs(const Options &options, const Setup &setup, const Result &result)
{
    const fs::path folder = options.output;
    if (!result.instrument_file.empty()) {
        const std::string file = (folder / "instrument.toml").string();
        crn::write_whole_file(file, result.instrument_file);
        crn::read_instrument(file); // checks that the file can be loaded before we deliver it
    }
    for (std::size_t i = 0; i < result.depths.size(); i++)
        write_shape(options, setup.c, i, result.depths[i].simulated_mm);
    crn::write_whole_file((folder / "result.json").string(), to_json(result));
    if (!options.with_page) return;
    draw_shapes(result, *setup.vessel, (folder / "shapes.png").string());
    draw_curves(result, (folder / "curves.png").string());
    crn::write_whole_file((folder / "index.html").string(), page_html(result));
}

void say(const Result &result, const Options &options)
{
    for (const ParameterResult &p : result.parameters)
        std::printf("%-11s %.5g %s (nominal %.5g, as good from %.3g to %.3g)%s%s\n", p.parameter.name.c_str(),
                    p.fitted, p.parameter.unit.c_str(), p.parameter.nominal, p.identified.low,
                    p.identified.high, p.is_determined ? "" : ": undetermined, ", p.why.c_str());
    for (const DepthResult &depth : result.depths)
        std::printf("%s: RMS %.3f mm, max %.3f mm%s\n", depth.name.c_str(), depth.distances.rms_mm,
                    depth.distances.max_mm, depth.is_fitted ? "" : " (validation)");
    std::printf("average: RMS %.3f mm, mean %.3f mm, deviation %.3f mm, max %.3f mm\n", result.average.rms_mm,
                result.average.mean_mm, result.average.deviation_mm, result.average.max_mm);
    std::printf("Written: %s/%sresult.json%s\n", options.output.c_str(),
                options.with_page ? "index.html, " : "",
                result.instrument_file.empty() ? "; no instrument file, as our simulator has no such rod"
                                               : ", instrument.toml");
}

int calibrate(const Options &options, MpiJob *job)
{
    if (!job || job->rank() == 0) crn::check_output_folder({"--output", options.output});
    const Setup setup(options);
    const Evaluate one = [&](const std::vector<double> &shares) { return setup.evaluate(shares); };
    if (job && job->rank() > 0) {
        std::signal(SIGINT, SIG_IGN); // rank 0 stops the job
        job->serve(options.threads, one);
        return 0;
    }
    if (options.is_trial) return evaluate_once(options, setup);
    fs::create_directories(options.output);
    crn::watch_for_interrupt();
    crn::ProgressLine line(!options.quiet);
    std::string doing;
    std::size_t total = 1, made = 0; // number of trials: in the current batch; in total
    const Progress progress = [&](std::size_t done) { line.show(doing, done, total); };
    const std::unique_ptr<Workers> workers =
        job ? job->workers(options.threads, one, crn::is_interrupted, progress)
            : thread_workers(options.threads, one, crn::is_interrupted, progress);
    const EvaluateShares evaluate = [&](const std::vector<std::vector<double>> &trials) {
        total = trials.size();
        made += total;
        return workers->evaluate(trials);
    };
    if (!options.quiet) crn::say(stderr, "calibrate: %s\n", workers->description().c_str());
    std::vector<Finished> searches;
    const auto begun = std::chrono::steady_clock::now();
    for (const std::string &method : options.methods)
        searches.push_back(search(options, *method_of(method), setup, evaluate, doing));
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (!options.quiet && made > 0)
        std::fprintf(stderr, "\rcalibrate: %zu insertions in %.1f s, %.2f per s\n", made, took_s,
                     static_cast<double>(made) / took_s);
    doing = "how well each number is determined";
    const Result result = make_result(setup.c, *setup.evaluator, *setup.careful, *setup.judge, searches,
                                      evaluate, options.identify);
    if (job) job->dismiss();
    write_outputs(options, setup, result);
    say(result, options);
    return 0;
}

std::string check_method(const std::string &token)
{
    return method_of(token) ? "" : "'" + token + "' is no method: cmaes, genetic or differential";
}

std::string check_even(const std::string &token)
{
    return !token.empty() && (token.back() - '0') % 2 == 0 ? ""
                                                           : "'" + token + "' is odd: parents come in pairs";
}

void add_options(CLI::App &app, Options &options, CLI::Option *&trial)
{
    app.add_option("CASE", options.folder, "folder of a case: docs/ct.md")->required();
    app.add_option("-o,--output", options.output, "folder for instrument, page, figures and checkpoints");
    app.add_option("--rod", options.rod, "core: our rod; corde: the thesis' (no instrument file is written)")
        ->check(CLI::IsMember({"core", "corde"}))
        ->capture_default_str();
    app.add_option("--method", options.methods, "cmaes, genetic, differential; several are compared")
        ->check(CLI::Validator(check_method, "METHOD"))
        ->capture_default_str();
    app.add_option("--population", options.population,
                   "trials per generation, an even number; else 16 for cmaes, 50 for the others")
        ->check(CLI::Range(8u, 10000u))
        ->check(CLI::Validator(check_even, "EVEN"));
    app.add_option(
           "--generations", options.generations,
           "of each method, the first one included; else as many as make 2500 trials, but 50 at least")
        ->check(CLI::Range(1u, 100000u));
    app.add_option("--stop-spread-mm", options.search.stop_spread_mm,
                   "a search also ends when the objectives of its population differ by less; 0: never")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    app.add_option("--seed", options.search.seed, "of all that is random")->capture_default_str();
    app.add_option(
           "--threads", options.threads,
           "trials at the same time; changes no result. 0: one per core, or one per rank under mpirun")
        ->check(CLI::Range(0u, 1024u))
        ->capture_default_str();
    app.add_flag("--resume", options.resume,
                 "go on from the checkpoints in the output folder, where there are any");
    app.add_option("--bounds", options.bounds, "NAME=LOW..HIGH of a parameter, in its unit");
    app.add_option("--noise-mm", options.identify.noise_mm,
                   "rise of the objective that says nothing about a parameter")
        ->check(CLI::Range(1e-4, 10.0))
        ->capture_default_str();
    app.add_option("--force-weight-mm", options.judge.force_weight_mm,
                   "objective per relative RMS of the force; 0: by shape alone")
        ->check(CLI::Range(0.0, 100.0))
        ->capture_default_str();
    app.add_option("--fit-depths", options.judge.fit_depths,
                   "first depths that are fitted; the others validate")
        ->check(CLI::Range(1, 16))
        ->capture_default_str();
    app.add_option("--speed-mm-s", options.speed_mm_per_s,
                   "of the hand, or the case's where that is faster; else the rod's own: docs/calibrate.md")
        ->check(CLI::Range(0.0, 200.0));
    app.add_option("--approach-mm", options.approach_mm,
                   "last way to each depth, gone at 10 mm/s or the case's speed where that is faster; else "
                   "the rod's own")
        ->check(CLI::Range(0.0, 100.0));
    app.add_option(
           "--element-factor", options.element_factor,
           "elements as multiples of the instrument file's (core) or of 3 mm (corde); else the rod's own")
        ->check(CLI::Range(0.2, 4.0));
    app.add_flag("!--no-ranges", options.identify.is_wanted,
                 "leave out how well each parameter is determined");
    app.add_flag("!--no-page", options.with_page, "leave out page and pictures");
    app.add_flag("--quiet", options.quiet, "no progress");
    trial = app.add_option("--evaluate", options.trial,
                           "no search: one insertion with these NAME=VALUE, the others nominal; with -o its "
                           "shapes and force")
                ->expected(0, 16);
}

int run(Options &options, std::unique_ptr<MpiJob> &job)
{
    if (is_mpi_job()) job = std::make_unique<MpiJob>();
    if (options.threads == 0) options.threads = job ? 1 : std::max(1u, std::thread::hardware_concurrency());
    try {
        return calibrate(options, job.get());
    } catch (const Interrupted &) {
        std::fprintf(stderr,
                     "calibrate: stopped; every finished generation is kept, --resume goes on from there\n");
    } catch (const UsageError &error) {
        crn::say(stderr, "calibrate: %s\n", error.what());
        if (job && job->size() > 1) job->abort(2);
        return 2;
    } catch (const std::exception &error) {
        crn::say(stderr, "calibrate: %s\n", error.what());
    }
    if (job && job->size() > 1) job->abort(1);
    return 1;
}

} // namespace

int main(int argc, char **argv)
{
    CLI::App app{"calibrate: fits an instrument's stiffness, radius and mass to scans of it in a phantom"};
    app.footer(examples);
    Options options;
    CLI::Option *trial = nullptr;
    add_options(app, options, trial);
    crn::refuse_empty_values(app);
    app.set_version_flag("--version", crn::version_of("calibrate"));
    try {
        app.parse(argc, argv);
        options.is_trial = trial->count() > 0;
        if (!options.is_trial && options.output.empty())
            throw CLI::RequiredError("--output, a folder for what is found,");
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    std::unique_ptr<MpiJob> job;
    return run(options, job);
}
