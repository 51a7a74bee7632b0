#include "host/suite/case_card.hpp"
#include "host/base/examples.hpp"
#include "host/base/format.hpp"
#include "host/command/names.hpp"
#include "host/suite/session_host.hpp"
#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>

namespace crn
{
namespace
{

namespace fs = std::filesystem;

CaseCard practice_card(const WindowOptions &options, const std::string &name, const std::string &story,
                       const std::string &goal, const std::vector<std::string> &tools)
{
    CaseCard made{name, story, goal, "", "", options, {}};
    try {
        made.options.instrument.clear();
        made.options.tools.clear();
        for (const std::string &tool : tools)
            made.options.tools.push_back(example_path(instrument_files, tool));
    } catch (const std::exception &error) {
        made.trouble = error.what();
    }
    return made;
}

std::string local_time(const fs::file_time_type &time)
{
    const auto system = std::chrono::file_clock::to_sys(time);
    const std::time_t seconds = std::chrono::system_clock::to_time_t(
        std::chrono::time_point_cast<std::chrono::system_clock::duration>(system));
    std::tm local{};
    localtime_r(&seconds, &local);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local);
    return text;
}

} // namespace

CaseCard case_card(const WindowOptions &options, const Case &lesson)
{
    CaseCard card{lesson.title, lesson.story, lesson.aim, "", "", options, {}};
    card.options.scene.clear();
    card.options.pictures.bodies_path.clear();
    card.options.instrument.clear();
    card.options.tools = lesson.start.tools;
    card.options.stents = lesson.stents;
    card.options.inserted_mm.clear();
    for (const std::uint32_t um : lesson.start.inserted_um) card.options.inserted_mm.push_back(um * 1e-3);
    card.options.lesson = std::make_shared<const Case>(lesson);
    try {
        if (!lesson.picture.empty()) card.picture = read_grey_png(lesson.picture);
    } catch (const std::runtime_error &) {
        // A case card without a picture can still be used; `cournand case check` reports a bad picture.
    }
    if (card.picture.width != card.picture.height) card.picture = {};
    return card;
}

std::vector<CaseCard> case_cards(const WindowOptions &options, const std::map<std::string, double> &best)
{
    struct Listed {
        int order = 0;
        CaseCard card;
    };
    std::vector<Listed> listed;
    for (const std::string &path : case_paths()) {
        try {
            const Case lesson = read_case(path);
            listed.push_back({lesson.order, case_card(options, lesson)});
            if (const auto found = best.find(lesson.name); found != best.end())
                listed.back().card.best = formatted("%.0f of 100", found->second);
        } catch (const std::runtime_error &error) {
            CaseCard card{fs::path(path).stem().string(), "", "", "", error.what(), options, {}};
            listed.push_back({1000, card});
        }
    }
    std::stable_sort(listed.begin(), listed.end(),
                     [](const Listed &a, const Listed &b) { return a.order < b.order; });
    std::vector<CaseCard> cards;
    for (Listed &each : listed) cards.push_back(std::move(each.card));
    return cards;
}

std::vector<CaseCard> practice_cards(const WindowOptions &options)
{
    WindowOptions aorta = options;
    std::string none;
    try {
        if (aorta.scene.empty()) aorta.scene = scene_path("aorta");
    } catch (const std::exception &error) {
        none = error.what();
    }
    std::vector<CaseCard> cards = {
        practice_card(aorta, "Wire in the aorta",
                      "Free practice in the shipped aorta, from the right groin, with a J wire of 0.035 in.",
                      "Bring the tip into the ascending aorta. Nothing is scored.", {"j_wire"}),
        practice_card(aorta, "Catheter over a wire",
                      "Free practice in the shipped aorta with a Bentson wire in a 5F Kumpe catheter.",
                      "Let the wire lead, and bring the catheter after it.", {"bentson", "beacon_5f"}),
    };
    for (CaseCard &made : cards)
        if (!none.empty()) made.trouble = none;
    WindowOptions space = options;
    space.scene.clear();
    cards.push_back(practice_card(space, "Free space", "A catheter and a wire without a patient.",
                                  "Watch how force, torque and shape follow the hands.",
                                  {"rosen", "pigtail_5f"}));
    return cards;
}

std::vector<KeptRecording> kept_recordings(std::size_t count_max)
{
    std::vector<KeptRecording> found;
    const std::vector<fs::path> files = kept_recording_files();
    for (auto file = files.rbegin(); file != files.rend() && found.size() < count_max; ++file) {
        std::error_code ignored;
        found.push_back({file->string(), file->stem().string(),
                         local_time(fs::last_write_time(*file, ignored)), fs::file_size(*file, ignored)});
    }
    return found;
}

} // namespace crn
