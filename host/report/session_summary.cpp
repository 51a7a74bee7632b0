#include "host/report/session_summary.hpp"
#include "host/base/format.hpp"
#include "host/base/terminal.hpp"
#include "host/patient/contrast.hpp"
#include "host/patient/stents.hpp"
#include "host/report/figures/score.hpp"
#include "host/report/score_page.hpp"
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>

namespace crn
{

void print_tools(const std::vector<Instrument> &tools, const SessionFigures &figures,
                 const std::vector<TipPlace> &tips)
{
    for (std::size_t k = 0; k < figures.tools.size() && k < tools.size(); k++) {
        const ToolFigures &tool = figures.tools[k];
        std::printf("tool %zu                %s\n", k + 1, printable(tools[k].name).c_str());
        std::printf("  inserted            %.1f mm at the end, %.1f mm at most\n", tool.inserted_m * 1e3,
                    tool.inserted_max_m * 1e3);
        std::printf("  largest hand force  %.2f N, torque %.2f mN m\n", tool.axial_max_N,
                    tool.torque_max_N_m * 1e3);
        if (k < tips.size() && tips[k].is_known)
            std::printf("  tip                 %s, %.1f mm along it (%.1f mm inside)\n",
                        printable(tips[k].vessel).c_str(), tips[k].place.along_m * 1e3,
                        tips[k].inside_m * 1e3);
    }
}

void print_files(const std::vector<std::string> &files)
{
    for (const std::string &file : files) std::printf("written               %s\n", printable(file).c_str());
}

namespace
{

constexpr std::size_t score_pictures_max = 8; // pictures on a page
constexpr double shown_share = 0.01; // of the iodine: a branch that received less is only in the report

void print_result(const RunResult &result, const std::vector<Instrument> &tools)
{
    const SessionFigures &figures = result.figures;
    std::printf("ticks                 %u (%.3f s)\n", unsigned{figures.ticks}, figures.ticks * 1e-3);
    std::printf("final hash            %016llx\n", static_cast<unsigned long long>(result.hash));
    std::printf("wall clock            %.2f s, %.1f times real time\n", result.seconds,
                result.seconds > 0.0 ? figures.ticks * 1e-3 / result.seconds : 0.0);
    std::printf("worst penetration     %.3f mm at tick %u\n", figures.penetration_max_m * 1e3,
                unsigned{figures.penetration_max_tick});
    std::printf("worst length error    %.4f %% at tick %u\n", figures.strain_max * 1e2,
                unsigned{figures.strain_max_tick});
    if (result.contacts.wall_way_max_m + result.contacts.wall_widened_max_m > 0.0)
        std::printf(
            "vessel pushed aside   %.2f mm at most, at tick %u; widened by %.2f mm at most in radius\n",
            result.contacts.wall_way_max_m * 1e3, unsigned{result.contacts.wall_way_max_tick},
            result.contacts.wall_widened_max_m * 1e3);
    print_tools(tools, figures, result.tips);
    for (const SteeringResult &steered : result.steered)
        std::printf("%-21s line %d: %s, %d tries, %.1f s\n", steered.is_reached ? "steered" : "not reached",
                    steered.line, printable(steered.vessel).c_str(), steered.tries, steered.ticks * 1e-3);
    for (const ExpectationResult &expected : result.expected)
        std::printf("%-21s line %d: %s: %s\n", expected.is_held ? "held" : "NOT HELD", expected.line,
                    printable(expected.text).c_str(), printable(expected.found).c_str());
    for (std::uint16_t i = 0; i < result.faults.entries_count; i++) {
        const crn_wire_fault_entry &fault = result.faults.entries[i];
        if (fault.code == CRN_FAULT_CODE_CORE_INSERT_END) {
            std::printf(
                "notice                a tool was pushed or pulled to the end of its length, first at "
                "tick %u, %u in all: its hand slipped, and nothing is wrong\n",
                unsigned{fault.tick_first}, unsigned{fault.count});
            continue;
        }
        std::printf("fault                 %s at tick %u, %u in all: %s; remedy: %s\n",
                    crn_wire_fault_name(fault.code), unsigned{fault.tick_first}, unsigned{fault.count},
                    crn_wire_fault_text(fault.code), crn_wire_fault_remedy(fault.code));
    }
    if (result.resumes > 0) {
        std::printf("device                went and came back %u times; the session went on bit for bit\n",
                    unsigned{result.resumes});
    }
    if (result.pictures > 0) {
        std::printf("led by the rig        %u shapes of the line, %u ticks with power, %u late\n",
                    unsigned{result.pictures}, unsigned{result.powered_ticks}, unsigned{result.late_ticks});
    }
    for (std::size_t k = 0; k < result.grips.size(); k++) {
        const GripFigures &grip = result.grips[k];
        if (grip.first_tick)
            std::printf("slipped               tool %zu through its hand, %.1f mm and %.0f deg in all, first "
                        "at tick %u\n",
                        k + 1, grip.slipped_mm, grip.slipped_deg, unsigned{*grip.first_tick});
    }
    for (int line : result.given_up_lines) {
        std::printf("given up              line %d: the length was not reached within %u s\n", line,
                    unsigned{SessionPlayer::until_limit_ticks / 1000});
    }
}

void print_dose(const DoseMeter &dose)
{
    const Dose &total = dose.total();
    std::printf(
        "dose                  %.2f mGy reference air kerma, %.3f Gy cm2, %u pulses, fluoroscopy %.2f min\n",
        total.air_kerma_uGy * 1e-3, total.kap_Gy_cm2, unsigned{total.pulses}, dose.fluoro_ticks() / 60e3);
    int number = 0;
    for (const Irradiation &one : dose.irradiations()) {
        const char *kind = one.kind == RunKind::fluoro ? "fluoroscopy"
                           : one.kind == RunKind::cine ? "cine"
                                                       : "DSA";
        std::printf("  %2d %-12s %7.1f s  %4u pulses  %8.3f mGy  %8.4f Gy cm2\n", ++number, kind,
                    one.dose.beam_ticks * 1e-3, unsigned{one.dose.pulses}, one.dose.air_kerma_uGy * 1e-3,
                    one.dose.kap_Gy_cm2);
    }
}

void print_medium(const PatientContrast &contrast)
{
    const IodineBudget &budget = contrast.flow().budget();
    std::printf("contrast medium       %.1f ml, %.0f mg iodine: %.0f in the vessels, %.0f out, %.0f back "
                "through the inlet\n",
                contrast.injected_ml(), budget.injected_mg, contrast.flow().held_mg(), budget.out_mg,
                budget.reflux_mg);
    const std::vector<double> received_mg = contrast.flow().received_mg();
    for (std::size_t b = 0; b < received_mg.size() && budget.injected_mg > 0.0; b++)
        if (received_mg[b] >= shown_share * budget.injected_mg)
            std::printf("  received            %s: %.0f mg, %.1f %%\n",
                        printable(contrast.vessels().branches[b].name).c_str(), received_mg[b],
                        100.0 * received_mg[b] / budget.injected_mg);
}

// Returns the darkest frame of a run, in which the medium is most visible.
Image darkest_frame(const StoredRun &stored)
{
    const auto sum = [](const std::vector<std::uint8_t> &grey) {
        return std::accumulate(grey.begin(), grey.end(), std::uint64_t{0});
    };
    const auto darkest = std::min_element(stored.grey.begin(), stored.grey.end(),
                                          [&](const auto &a, const auto &b) { return sum(a) < sum(b); });
    return {stored.run.size, stored.run.size, 1, *darkest};
}

// Writes the page of the score with a picture of each cine run, and prints the score.
void give_score(const std::string &path, const nlohmann::ordered_json &report, const RoomScreen *screen)
{
    std::vector<ScorePicture> pictures;
    for (std::size_t i = 0; screen && i < screen->store().runs().size(); ++i)
        if (const auto &stored = screen->store().runs()[i]; stored->run.kind == RunKind::cine &&
                                                            !stored->grey.empty() &&
                                                            pictures.size() < score_pictures_max) {
            const std::string caption =
                formatted("Run %d, at %.0f s", stored->run.number, stored->run.frames.front().tick * 1e-3);
            pictures.push_back({caption, darkest_frame(*stored)});
        }
    write_score_page(path, report, report.at("score"), pictures);
    if (report.at("score").at("percent").is_number())
        std::printf("score                 %.0f of 100\n", report.at("score").at("percent").get<double>());
    std::printf("written               %s\n", printable(path).c_str());
}

void print_stents(PatientStents &stents)
{
    for (const StentResult &stent : stents.results()) {
        std::printf("stent                 %s, %s", printable(stent.name).c_str(),
                    stent.was_taken_out ? "taken out of the patient unopened"
                                        : std::string(stent_stage_text(stent.stage)).c_str());
        if (stent.stage == StentStage::deployed)
            std::printf(": apposed %.0f %%, inside %.2f mm at least", stent.figures.apposed_share * 100.0,
                        stent.figures.diameter_min_mm);
        std::printf("\n");
    }
    for (const std::string &refusal : stents.refusals())
        std::printf("refused               %s\n", printable(refusal).c_str());
}

void print_injuries(const Patient &patient)
{
    const PatientComplications &complications = patient.complications();
    for (const Injury &injury : complications.injuries())
        std::printf("%-11s           at %.3f s, %s %s of %s by %s: %.3g %s, the wall bears %.3g\n",
                    injury.kind == InjuryKind::perforation ? "perforation" : "dissection", injury.tick * 1e-3,
                    injury.kind == InjuryKind::perforation ? "Ellis" : "type",
                    injury_class(injury, complications.limits()).c_str(), printable(injury.vessel).c_str(),
                    printable(injury.tool).c_str(), injury.value, injury.unit(), injury.limit);
    const Wounds &wounds = patient.contrast().flow().wounds();
    if (wounds.is_bleeding())
        std::printf("blood loss            %.1f ml through the walls of vessels\n", wounds.leaked_ml());
}

void print_refusals(const std::vector<Refusal> &refusals)
{
    for (const Refusal &refusal : refusals)
        std::printf("refused               at %.3f s: %s\n", refusal.tick * 1e-3,
                    printable(refusal.why).c_str());
}

} // namespace

void print_session(const RunResult &result, const std::vector<Instrument> &tools, Patient &patient)
{
    print_result(result, tools);
    print_dose(patient.room().dose());
    if (patient.contrast().was_used()) print_medium(patient.contrast());
    if (patient.stents()) print_stents(*patient.stents());
    print_injuries(patient);
    print_refusals(patient.refusals());
}

void write_session_files(const SessionFiles &files, const RunResult &result, const std::string &scene,
                         const std::vector<Instrument> &tools, const std::string &session, Patient &patient,
                         const RoomScreen *screen)
{
    if (!files.timing.empty()) write_report(files.timing, timing_of(result, patient));
    if (files.json.empty() && files.score.empty()) return;
    nlohmann::ordered_json report = report_of(result, scene, tools, session, patient);
    if (!files.case_entry.is_null()) report["case"] = files.case_entry;
    if (!files.score.empty()) give_score(files.score, report, screen);
    if (!files.json.empty()) write_report(files.json, report);
}

Image card_picture(const RoomScreen &screen, const Image &last)
{
    for (auto one = screen.store().runs().rbegin(); one != screen.store().runs().rend(); ++one)
        if ((*one)->run.kind == RunKind::cine && !(*one)->grey.empty()) return darkest_frame(**one);
    return last;
}

} // namespace crn
