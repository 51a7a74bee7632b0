#include "host/command/names.hpp"
#include "host/base/command_values.hpp"
#include "host/base/examples.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/base/user_folders.hpp"
#include "host/cases/unpack.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <set>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr char archive_ending[] = ".tar.xz";
constexpr char last_word[] = "last";
const ExampleKind archive_files{scene_files.folder, scene_files.singular, archive_ending};

// Lists the scenes that are made from a recipe when they are first needed, as the scenes of cases are.
struct RecipeScene {
    const char *name, *kind, *lesion; // an empty lesion: none
};
constexpr RecipeScene recipe_scenes[] = {
    {"heart", "heart", ""}, {"lad_pci", "heart", "lad_middle"}, {"renal_pci", "aorta", "renal_ostium"}};

// Lists the scenes that need data from other sources; these scenes are made only if the user asks for them.
struct MadeScene {
    const char *name, *target, *minutes;
};
constexpr MadeScene made_scenes[] = {{"real_coronaries", "coronary-real", "10"}};

// Returns the folders with scenes that are not compressed.
std::vector<fs::path> scene_folders()
{
    std::vector<fs::path> folders;
    std::error_code failure;
    const fs::path own = data_folder() / scene_files.folder;
    if (fs::is_directory(own, failure)) folders.push_back(own);
    if (fs::is_directory("out", failure)) folders.emplace_back("out");
    for (const fs::path &shipped : shipped_folders(scene_files)) { // shared/examples/scenes
        const fs::path made = shipped.parent_path().parent_path().parent_path() / "out";
        if (shipped.parent_path().parent_path().filename() == "shared" && fs::is_directory(made, failure))
            folders.push_back(made);
    }
    return folders;
}

fs::path shipped_archive(const std::string &name)
{
    return search_file(shipped_folders(scene_files), name + archive_ending).path;
}

std::vector<std::string> scene_names()
{
    std::set<std::string> names;
    for (const fs::path other : search_file(scene_folders(), "").others)
        if (other.extension() == scene_files.ending) names.insert(other.stem().string());
    for (const std::string &other : search_file(shipped_folders(scene_files), "").others)
        if (other.ends_with(archive_ending))
            names.insert(other.substr(0, other.size() - (sizeof archive_ending - 1)));
    for (const RecipeScene &each : recipe_scenes) names.insert(each.name);
    return {names.begin(), names.end()};
}

// Returns the scene of a recipe from the cache, and makes it first if it is not there. Returns an empty path
// if the name is not that of a recipe.
std::string scene_of_recipe(const std::string &name)
{
    const auto *found = std::find_if(std::begin(recipe_scenes), std::end(recipe_scenes),
                                     [&](const RecipeScene &each) { return name == each.name; });
    if (found == std::end(recipe_scenes)) return "";
    Recipe recipe;
    recipe.kind = found->kind;
    if (*found->lesion) recipe.lesions.push_back(example_path(lesion_files, found->lesion));
    return prepare_told_scene(recipe, "scene " + name, false).scene;
}

// The folder's name contains the checksum of the archive, so a new version of the program does not use the
// scene that an old version unpacked.
std::string unpacked(const fs::path &archive, const std::string &name)
{
    const std::vector<unsigned char> bytes = read_binary_file(archive.string());
    const fs::path cache = cache_folder();
    if (cache.empty())
        throw std::runtime_error("the scene '" + name +
                                 "' is unpacked into the user's cache, but neither HOME nor XDG_CACHE_HOME "
                                 "names a folder: set XDG_CACHE_HOME");
    const std::string sum = formatted("%08x", unsigned{crn_wire_crc32(0, bytes.data(), bytes.size())});
    const fs::path folder = cache / scene_files.folder / sum, file = folder / (name + scene_files.ending);
    std::error_code failure;
    if (!fs::is_regular_file(file, failure)) {
        fs::remove_all(folder, failure); // somebody has removed a part of it
        ProgressLine line(true);
        unpack_scene(archive, folder, [&](std::size_t done, std::size_t total) {
            line.show("unpacking " + archive.filename().string(), done, total);
            return !is_interrupted();
        });
    }
    return file.string();
}

[[noreturn]] void refuse_scene(const std::string &name)
{
    for (const MadeScene &made : made_scenes)
        if (name == made.name)
            throw std::runtime_error("the scene '" + name + "' is not made yet: `make " + made.target +
                                     "` in the repository makes out/" + name + ".scene in about " +
                                     made.minutes + " minutes");
    std::vector<std::string> known = scene_names();
    for (const MadeScene &made : made_scenes) known.emplace_back(made.name);
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    throw std::runtime_error("there is no scene '" + name + "'" + suggestion(name, known));
}

std::vector<std::string> recording_names()
{
    std::vector<std::string> names;
    for (const fs::path &file : kept_recording_files()) names.push_back(file.stem().string());
    if (!names.empty()) names.emplace_back(last_word);
    return names;
}

const ExampleKind *kind_of(const std::string &type)
{
    return type == "INSTRUMENT" ? &instrument_files
           : type == "STENT"    ? &stent_files
           : type == "SESSION"  ? &session_files
                                : nullptr;
}

} // namespace

PreparedScene prepare_told_scene(const Recipe &recipe, const std::string &who, bool is_quiet)
{
    watch_for_interrupt();
    std::string shown;
    const bool is_drawn = !is_quiet && shows_progress();
    PreparedScene scene = prepare_scene(recipe, [&](const SceneProgress &progress) {
        const std::string text = who + ": " + progress.stage;
        if (is_drawn)
            std::fprintf(stderr, "\r%s (step %d of %d, %.0f s) ", printable(text).c_str(), progress.step,
                         progress.steps, progress.seconds);
        else if (!is_quiet && text != shown)
            std::fprintf(stderr, "%s\n", printable(text).c_str());
        shown = text;
        return !is_interrupted();
    });
    if (is_drawn) std::fprintf(stderr, "\r%78s\r", "");
    return scene;
}

std::string scene_path(const std::string &word)
{
    if (word.empty() || is_path(word)) return word;
    const FileSearch search = search_file(scene_folders(), word + scene_files.ending);
    if (!search.path.empty()) return search.path;
    const fs::path archive = shipped_archive(word);
    if (!archive.empty()) return unpacked(archive, word);
    const std::string made = scene_of_recipe(word);
    if (made.empty()) refuse_scene(word);
    return made;
}

std::string recording_path(const std::string &word)
{
    std::error_code failure;
    if (word.empty() || fs::exists(word, failure)) return word;
    const std::vector<fs::path> kept = kept_recording_files();
    for (const fs::path &file : kept)
        if (file.stem() == word) return file.string(); // its name may have a dot
    if (is_path(word)) return word;
    const std::string folder = state_folder().string();
    if (kept.empty())
        throw std::runtime_error("there is no recording '" + word + "': no recording is kept in '" + folder +
                                 "'; `cournand view` keeps one, or name a file");
    if (word == last_word) return kept.back().string();
    throw std::runtime_error("there is no recording '" + word + "' in '" + folder + "'" +
                             suggestion(word, recording_names()));
}

std::string any_path(const std::string &word)
{
    if (word.empty() || is_path(word)) return word;
    const std::string name = word.substr(0, word.find_last_of(':')), preset = word.substr(name.size());
    for (const ExampleKind *kind : {&instrument_files, &session_files, &stent_files}) {
        const FileSearch search = search_file(example_folders(*kind), name + kind->ending);
        if (!search.path.empty()) return search.path + preset;
    }
    const std::vector<std::string> scenes = scene_names(), kept = recording_names();
    if (std::find(scenes.begin(), scenes.end(), word) != scenes.end()) return scene_path(word);
    if (std::find(kept.begin(), kept.end(), word) != kept.end()) return recording_path(word);
    throw std::runtime_error("nothing has the name '" + word + "'" + suggestion(word, names_of_type("NAME")));
}

std::vector<std::string> names_of_type(const std::string &type)
{
    if (const ExampleKind *kind = kind_of(type)) return example_names(*kind);
    if (type == "SCENE") return scene_names();
    if (type == "RECORDING") return recording_names();
    if (type != "NAME") return {};
    std::set<std::string> all;
    for (const char *each : {"INSTRUMENT", "STENT", "SESSION", "SCENE", "RECORDING"})
        for (const std::string &name : names_of_type(each)) all.insert(name);
    return {all.begin(), all.end()};
}

std::vector<fs::path> kept_recording_files()
{
    std::vector<fs::path> files;
    std::error_code failure;
    for (const fs::directory_entry &entry : fs::directory_iterator(state_folder(), failure))
        if (entry.path().extension() == ".rec" && entry.is_regular_file(failure))
            files.push_back(entry.path());
    std::sort(files.begin(), files.end(), [](const fs::path &a, const fs::path &b) {
        std::error_code ignored;
        return std::pair(fs::last_write_time(a, ignored), a) < std::pair(fs::last_write_time(b, ignored), b);
    });
    return files;
}

// Deletes the oldest recordings of the user's folder, so that one more can be kept.
static void tidy_recordings()
{
    const std::vector<fs::path> files = kept_recording_files();
    for (std::size_t i = 0; i + kept_recordings_max - 1 < files.size(); ++i) {
        std::error_code ignored;
        fs::remove(files[i], ignored);
    }
}

std::string kept_recording()
{
    const fs::path folder = state_folder().empty() ? fs::path("cournand") : state_folder();
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw UsageError("recordings are kept in '" + folder.string() + "', which cannot be made (" +
                         error.message() + "): name a file with --record, or give --no-record");
    tidy_recordings();
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    localtime_r(&now, &local);
    char name[32];
    std::strftime(name, sizeof name, "%Y-%m-%d_%H-%M-%S", &local);
    fs::path file = folder / (std::string(name) + ".rec");
    for (int again = 2; fs::exists(file, error); ++again)
        file = folder / (std::string(name) + "." + std::to_string(again) + ".rec");
    return file.string();
}

CLI::Validator scene_name()
{
    return replaced_by([](const std::string &word) {
        const std::vector<std::string> known = scene_names();
        if (!is_path(word) && std::find(known.begin(), known.end(), word) == known.end()) refuse_scene(word);
        return word;
    });
}

CLI::Validator recording_name()
{
    return replaced_by(recording_path);
}

CLI::Validator any_name()
{
    return replaced_by(any_path);
}

} // namespace crn
