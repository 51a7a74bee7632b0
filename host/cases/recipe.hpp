// A case states how its anatomy is made: which command of the program `anatomy`, which file of vessels and
// which lesions. The programs `anatomy` and `bake` make the scene from this recipe when the case is first
// played, and the scene is kept in the user's cache.
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

// The kinds of anatomy that a recipe may name.
const std::vector<std::string> &recipe_kinds();

// Reports the progress of a scene that is being made.
struct SceneProgress {
    std::string stage; // "the anatomy is made"
    int step = 0, steps = 0;
    double seconds = 0.0; // since the begin
};
// Is called several times per second; if it returns false, the making ends.
using SceneWatch = std::function<bool(const SceneProgress &)>;

struct PreparedScene {
    std::string scene, bodies; // paths
    bool was_ready = false;    // it was in the cache
};

// The making of a scene was interrupted, by Ctrl-C or by its watch.
struct SceneStopped : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Returns the key of a recipe: a hash of everything that decides how the scene becomes, including the
// contents of the programs that make it. Throws std::runtime_error if a file or a program is missing.
std::string recipe_key(const Recipe &recipe);
// Returns true if prepare_scene() would return without making anything.
bool is_scene_ready(const Recipe &recipe);
// Returns the scene from the cache, $XDG_CACHE_HOME/cournand/scenes or ~/.cache/cournand/scenes, and makes it
// first if it is not there. A scene gets its name when it is complete, so no half scene is ever found. If
// another process makes the same scene, this function waits for it. Throws SceneStopped, OutputError if the
// cache cannot be written, and std::runtime_error with the message of the program that failed.
PreparedScene prepare_scene(const Recipe &recipe, const SceneWatch &watch);

// Holds the vessels that a recipe will give, as far as they are known before the scene is made.
struct RecipeVessel {
    std::string name;
    double length_mm = 0.0;
};
// Returns the vessels that `anatomy list` names for a recipe with a kind. Throws std::runtime_error with the
// program's message, which names file and line for a mistake in a file of vessels.
std::vector<RecipeVessel> recipe_vessels(const Recipe &recipe);

} // namespace crn
