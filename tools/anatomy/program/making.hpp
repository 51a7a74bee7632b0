/* The steps that the commands of the program `anatomy` share: they read vessels, and write the meshes, the
 * centrelines and the text of a scene. */
#pragma once
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/mesh_queue.hpp"
#include <cstdint>
#include <filesystem>
#include <optional>

namespace anatomy
{

struct Options {
    std::filesystem::path folder;
    Fineness fineness;
    bool bodies = true, quiet = false, heart_only = false;
    unsigned threads = usual_threads();
    double scale = 1.0;                // multiplies all lengths of what is written
    std::string vessels;               // the user's file; "": the one that ships
    std::optional<std::uint64_t> seed; // draws other arteries (docs/vessels.md)
    double lumen_from_mm = 0; // diameter from which small arteries are a part of the lumen; 0: none is
    std::vector<std::string> lesions; // as given on the command line
};

/* Reads the vessels for the command `anatomy KIND`. Throws std::invalid_argument when the user's file lacks
 * vessels that the command needs. */
VesselTree vessels_for(const std::string &kind, const Options &options);

/* Makes the folder for the output. */
void make_folder(const Options &options);

/* Makes the scene with the heart at the end of diastole, and writes the heart's moving bodies in 24 frames.
 */
void make_heart_scene(const Options &options, const VesselTree &tree, std::vector<Body> bodies);

using Keep = std::function<void(const std::string &name, const Mesh &mesh)>;

/* Makes the meshes of bodies with several threads, reports each on standard error, and writes it to a file.
 * The callback `keep` receives every mesh before it is scaled, in the order of the bodies. */
void make_bodies(const Options &options, const std::vector<Body> &bodies, const Keep &keep);

/* Makes and writes the meshes, the centrelines and the scene's text. The callback `keep` receives the meshes
 * of the lumen and of every body before they are scaled. */
void make_scene(const Options &options, const VesselTree &tree, const std::vector<Body> &bodies,
                const Keep &keep);

/* Does the same for a patient whose heart does not beat: breath moves the lungs and what lies below them. */
void make_breathing_scene(const Options &options, const VesselTree &tree, std::vector<Body> bodies,
                          const Person &person);

std::vector<Body> no_bodies(const VesselTree &, const Fineness &);

} // namespace anatomy
