#include "host/cases/recipe.hpp"
#include "host/base/digest.hpp"
#include "host/base/examples.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/base/toml_reader.hpp"
#include "host/base/user_folders.hpp"
#include "host/base/version.hpp"
#include "host/cases/programs.hpp"
#include "host/cases/unpack.hpp"
#include "shared/scene/scene.h"
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <thread>
#include <unistd.h>

namespace crn
{

namespace
{

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int vessel_files_max = 8; // that extend each other
constexpr TomlKind vessels_kind{"a file of vessels", "a file of vessels (docs/vessels.md)"};

bool is_shipped_aorta(const Recipe &recipe)
{
    return recipe.kind == "aorta" && recipe.vessels.empty() && recipe.lesions.empty();
}

// Returns the path of the archive with the scene of the shipped aorta, or an empty path if there is no
// archive.
std::string shipped_archive()
{
    return search_file(shipped_folders(scene_archives), "aorta.tar.xz").path;
}

std::string vessels_of(const Recipe &recipe)
{
    if (!recipe.vessels.empty()) return recipe.vessels;
    return search_file(shipped_folders(anatomy_files), recipe.kind + ".toml").path;
}

// Adds a file of vessels, and all files that this file extends, to the digest.
void add_vessels(Digest &digest, std::string path)
{
    const std::string shipped = "shipped:";
    for (int i = 0; i < vessel_files_max && !path.empty(); ++i) {
        digest.add(read_text_file(path));
        const TomlTable root = read_toml(path, vessels_kind);
        if (!root.has("extends")) return;
        const std::string other = root.words("extends");
        path = other.starts_with(shipped)
                   ? search_file(shipped_folders(anatomy_files), other.substr(shipped.size())).path
                   : (fs::path(path).parent_path() / other).string();
    }
}

// Adds to the digest the release of the programs that make scenes, and the version of the scene format. The
// tests of `bake` compare whole scenes, so every change of the scenes needs a new release or a new version of
// the scene format. Two releases that make equal scenes may still give them different keys.
void add_bakers(Digest &digest)
{
    for (const char *name : {"anatomy", "bake"}) sibling_program(name); // throws if it is missing
    digest.add(version_of("bake"));
    digest.add(std::to_string(int{CRN_SCENE_MAJOR}) + "." + std::to_string(int{CRN_SCENE_MINOR}));
}

fs::path scenes_folder()
{
    const fs::path cache = cache_folder();
    if (cache.empty()) throw std::runtime_error("there is no folder for scenes: set HOME or XDG_CACHE_HOME");
    return cache / "scenes";
}

PreparedScene scene_in(const fs::path &folder)
{
    const fs::path scene = folder / "case.scene", bodies = folder / "case.bodies";
    std::error_code failure;
    return {scene.string(), fs::exists(bodies, failure) ? bodies.string() : std::string(), true};
}

void make_folder(const fs::path &folder)
{
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure)
        throw OutputError(folder.string() + ": the folder for scenes cannot be made: " + failure.message() +
                          "; set XDG_CACHE_HOME to a folder that you may write");
}

// While an object of this class exists, no other process makes the scene with the same key.
class SceneLock
{
  public:
    SceneLock(const fs::path &path, const std::function<bool(const char *)> &goes_on)
    {
        file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (file_ < 0) throw OutputError(path.string(), errno);
        while (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
            if (errno != EWOULDBLOCK && errno != EINTR) throw OutputError(path.string(), errno);
            if (!goes_on("another program makes this scene")) throw SceneStopped("interrupted");
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
    }
    ~SceneLock() { ::close(file_); }
    SceneLock(const SceneLock &) = delete;
    SceneLock &operator=(const SceneLock &) = delete;

  private:
    int file_ = -1;
};

// Holds a folder that is removed at the end, with everything in it.
class WorkFolder
{
  public:
    explicit WorkFolder(fs::path path) : path_(std::move(path))
    {
        std::error_code ignored;
        fs::remove_all(path_, ignored); // of a process that was killed
        make_folder(path_);
    }
    ~WorkFolder()
    {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    WorkFolder(const WorkFolder &) = delete;
    WorkFolder &operator=(const WorkFolder &) = delete;
    const fs::path &path() const { return path_; }

  private:
    fs::path path_;
};

// Makes one scene, and reports the progress to the caller's function.
class SceneMaker
{
  public:
    SceneMaker(const Recipe &recipe, const SceneWatch &watch) : recipe_(recipe), watch_(watch) {}

    bool tell(const char *stage) const
    {
        const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
        return watch_({stage, step_, steps_, seconds});
    }

    // Makes the scene in the folder `out`; `work` is a folder for temporary files.
    void make(const fs::path &work, const fs::path &out)
    {
        make_folder(out);
        if (is_shipped_aorta(recipe_) && unpack(work, out)) return;
        fs::path text = recipe_.scene;
        steps_ = recipe_.kind.empty() ? 1 : 2;
        step_ = 1;
        if (!recipe_.kind.empty()) {
            text = anatomy(work / "anatomy");
            step_ = 2;
        }
        call({sibling_program("bake"), text.string(), "-o", (out / "case.scene").string()},
             "the scene is baked");
    }

  private:
    // Returns false if the archive is absent or damaged; the scene is then made from its recipe.
    bool unpack(const fs::path &work, const fs::path &out)
    {
        const std::string archive = shipped_archive();
        if (archive.empty()) return false;
        steps_ = step_ = 1;
        const fs::path unpacked = work / "unpacked";
        bool was_stopped = false;
        try {
            unpack_scene(archive, unpacked, [&](std::size_t, std::size_t) {
                was_stopped = !tell("the shipped scene is unpacked");
                return !was_stopped;
            });
        } catch (const std::runtime_error &) {
            if (was_stopped) throw SceneStopped("interrupted");
            return false;
        }
        fs::rename(unpacked / "aorta.scene", out / "case.scene");
        fs::rename(unpacked / "aorta.bodies", out / "case.bodies");
        return true;
    }

    fs::path anatomy(const fs::path &folder) const
    {
        std::vector<std::string> words = {sibling_program("anatomy"), recipe_.kind, "--quiet", "-o",
                                          folder.string()};
        if (!recipe_.vessels.empty()) words.insert(words.end(), {"--vessels", recipe_.vessels});
        call(words, "the anatomy is made");
        const std::string text = (folder / "scene.toml").string();
        std::string with_lesions = read_text_file(text);
        for (const std::string &lesion : recipe_.lesions) with_lesions += "\n" + read_text_file(lesion);
        write_whole_file(text, with_lesions);
        return text;
    }

    void call(const std::vector<std::string> &words, const char *stage) const
    {
        const ProgramResult done = run_program(words, [&] { return tell(stage); });
        if (done.was_stopped) throw SceneStopped("interrupted");
        if (done.code == 0) return;
        std::string why = done.refused.substr(0, done.refused.find_last_not_of("\n ") + 1);
        if (why.empty()) why = words[0] + " ended with " + std::to_string(done.code);
        throw std::runtime_error("the scene of this case cannot be made: " + why);
    }

    const Recipe &recipe_;
    const SceneWatch &watch_;
    Clock::time_point begin_ = Clock::now();
    int step_ = 0, steps_ = 0;
};

bool is_baked(const Recipe &recipe)
{
    return !recipe.scene.empty() && fs::path(recipe.scene).extension() != ".toml";
}

PreparedScene baked_scene(const Recipe &recipe)
{
    std::error_code failure;
    const fs::path bodies = fs::path(recipe.scene).replace_extension(".bodies");
    return {recipe.scene, fs::exists(bodies, failure) ? bodies.string() : std::string(), true};
}

double length_of(const std::string &text)
{
    double length_mm = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), length_mm);
    return length_mm;
}

// Splits a line at tabs.
std::vector<std::string> cells_of(const std::string &line)
{
    std::vector<std::string> cells(1);
    for (char c : line) {
        if (c == '\t')
            cells.emplace_back();
        else
            cells.back() += c;
    }
    return cells;
}

// Adds a scene text and the contents of all files that the text names to the digest. Any text in quotes may
// be the path of a mesh or of a centreline, relative to the folder of the scene text.
void add_scene_text(Digest &digest, const fs::path &scene)
{
    const std::string text = read_text_file(scene.string());
    digest.add(text);
    for (std::size_t from = text.find('"'); from != std::string::npos; from = text.find('"', from)) {
        const std::size_t end = text.find_first_of("\"\n", from + 1);
        if (end == std::string::npos) break;
        const fs::path named = scene.parent_path() / text.substr(from + 1, end - from - 1);
        std::error_code failure;
        if (fs::is_regular_file(named, failure)) digest.add(read_text_file(named.string()));
        from = end + 1;
    }
}

} // namespace

const std::vector<std::string> &recipe_kinds()
{
    static const std::vector<std::string> kinds = {"aorta", "heart", "phantom", "access"};
    return kinds;
}

std::string recipe_key(const Recipe &recipe)
{
    Digest digest;
    digest.add(recipe.kind);
    if (is_shipped_aorta(recipe) && !shipped_archive().empty()) {
        digest.add(read_text_file(shipped_archive()));
        return digest.hex();
    }
    if (recipe.kind.empty()) add_scene_text(digest, recipe.scene);
    if (!recipe.kind.empty()) {
        add_vessels(digest, vessels_of(recipe));
    }
    for (const std::string &lesion : recipe.lesions) digest.add(read_text_file(lesion));
    add_bakers(digest);
    return digest.hex();
}

bool is_scene_ready(const Recipe &recipe)
{
    std::error_code failure;
    if (is_baked(recipe)) return fs::exists(recipe.scene, failure);
    return fs::exists(scenes_folder() / recipe_key(recipe), failure);
}

PreparedScene prepare_scene(const Recipe &recipe, const SceneWatch &watch)
{
    if (is_baked(recipe)) return baked_scene(recipe);
    const fs::path folder = scenes_folder();
    const std::string key = recipe_key(recipe);
    std::error_code failure;
    if (fs::exists(folder / key, failure)) return scene_in(folder / key);
    make_folder(folder);
    SceneMaker maker(recipe, watch);
    const SceneLock lock(folder / (key + ".lock"), [&](const char *stage) { return maker.tell(stage); });
    if (fs::exists(folder / key, failure)) return scene_in(folder / key); // another process made it meanwhile
    const WorkFolder work(folder / (key + ".part"));
    maker.make(work.path(), work.path() / "out");
    fs::rename(work.path() / "out", folder / key, failure);
    if (failure) throw OutputError((folder / key).string(), failure.value());
    PreparedScene made = scene_in(folder / key);
    made.was_ready = false;
    return made;
}

std::vector<RecipeVessel> recipe_vessels(const Recipe &recipe)
{
    const std::string file = vessels_of(recipe);
    const ProgramResult done = run_program({sibling_program("anatomy"), "list", file}, [] { return true; });
    if (done.code != 0) {
        const std::string before = "anatomy: ";
        std::string why = done.refused.substr(0, done.refused.find_last_not_of("\n ") + 1);
        throw std::runtime_error(why.starts_with(before) ? why.substr(before.size()) : why);
    }
    std::vector<RecipeVessel> vessels;
    for (std::size_t at = 0; at < done.said.size();) {
        const std::size_t end = std::min(done.said.find('\n', at), done.said.size());
        const std::vector<std::string> cells = cells_of(done.said.substr(at, end - at));
        if (cells.size() > 2 && cells[1] == "length") vessels.push_back({cells[0], length_of(cells[2])});
        at = end + 1;
    }
    return vessels;
}

} // namespace crn
