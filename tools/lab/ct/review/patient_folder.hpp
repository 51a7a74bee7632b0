// Reads what `ct patient` has written into its folder so far, for the review window (docs/own_ct.md).
#pragma once
#include "host/model/ct_volume.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/centreline/tree.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace crn::ct
{

// A step of `ct patient`: its name in steps.json, and its words for the user.
struct ReviewStep {
    const char *name, *title;
    bool is_done = false;
};

class PatientFolder
{
  public:
    explicit PatientFolder(std::filesystem::path path) : path_(std::move(path)) {}

    // Reads the files that are new or have changed. Returns true if anything has changed. A file that is not
    // there, or is damaged, leaves its part empty; `trouble` names the damaged file.
    bool look();

    std::filesystem::path file(const char *name) const { return path_ / name; }
    std::vector<ReviewStep> steps() const;
    bool has_scene() const; // and it was made from what the folder holds now

    CtVolume scan;         // empty: not read yet
    bake::Mesh lumen;      // empty: not found yet
    centreline::Tree tree; // empty: not found yet
    std::vector<std::string> check, assumed, facts;
    std::string trouble;

  private:
    struct Watched {
        const char *name;
        std::filesystem::file_time_type time{}; // of the version that was read
        bool is_there = false;
        std::string trouble{}; // why it could not be read
    };
    void read(const std::string &name);

    std::filesystem::path path_;
    std::vector<std::string> done_;
    std::vector<Watched> watched_ = {
        {"scan.ct"}, {"lumen.ply"}, {"tree.csv"}, {"report.json"}, {"steps.json"}};
};

} // namespace crn::ct
