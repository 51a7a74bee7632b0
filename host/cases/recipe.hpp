// A recipe is the part of a case that states how its anatomy is made: the command of the program `anatomy`,
// the file of vessels, and the lesions. When a case is played for the first time, the programs `anatomy` and
// `bake` make the scene from the recipe; the scene is kept in the user's cache.
//
//   const PreparedScene scene = prepare_scene(recipe, [](const SceneProgress &) { return true; });
#pragma once
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

struct Recipe {
    int line = 0;
    std::string kind;                 // aorta, heart, phantom or access; empty: `scene`
    std::string vessels;              // path of a file of vessels; empty: that of the kind
    std::vector<std::string> lesions; // paths of texts with [[lesion]] tables
    std::string scene;                // path of a baked scene, or of a scene text for `bake` (.toml)
};

// Returns the kinds of anatomy that a recipe may name.
const std::vector<std::string> &recipe_kinds();

// Describes the progress of a scene that is being made.
struct SceneProgress {
    std::string stage; // "the anatomy is made"
    int step = 0, steps = 0;
    double seconds = 0.0; // since the begin
};
// The following function is called several times per second; if it returns false, the making of the scene
// ends.
using SceneWatch = std::function<bool(const SceneProgress &)>;

struct PreparedScene {
    std::string scene, bodies; // paths
    bool was_ready = false;    // it was in the cache
};

// SceneStopped means that the making of a scene was interrupted, either by Ctrl-C or by the caller's
// function.
struct SceneStopped : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Returns the key of a recipe: a hash of everything that influences the scene, including the release of the
// programs that make it. Throws std::runtime_error if a file or a program is missing.
std::string recipe_key(const Recipe &recipe);
// Returns true if prepare_scene() would find the scene in the cache.
bool is_scene_ready(const Recipe &recipe);
// Returns the scene from the cache ($XDG_CACHE_HOME/cournand/scenes or ~/.cache/cournand/scenes), and makes
// the scene first if the cache does not contain it. A scene gets its final name only when it is complete, so
// no program finds an incomplete scene. If another process makes the same scene, this function waits for it.
// Throws SceneStopped if the work was interrupted, OutputError if the cache cannot be written, and
// std::runtime_error with the message of the program that failed.
PreparedScene prepare_scene(const Recipe &recipe, const SceneWatch &watch);

// Describes a vessel of the scene that a recipe will give, as far as it is known before the scene is made.
struct RecipeVessel {
    std::string name;
    double length_mm = 0.0;
};
// Returns the vessels that `anatomy list` prints for a recipe that names a kind of anatomy. Throws a
// std::runtime_error with the program's message, which names file and line if a file of vessels has a
// mistake.
std::vector<RecipeVessel> recipe_vessels(const Recipe &recipe);

} // namespace crn
