// The state of the review window without its drawing: the folder, the clicks, the place of the cross, and the
// command that runs in the background.
#pragma once
#include "host/cases/programs.hpp"
#include "host/live/background_task.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"
#include "tools/lab/ct/review/patient_folder.hpp"
#include "tools/lab/ct/review/section.hpp"
#include <chrono>
#include <memory>

namespace crn::ct
{

// A grey range by name, in Hounsfield units.
struct GreyPreset {
    const char *name;
    GreyHU grey;
};
inline constexpr GreyPreset grey_presets[] = {
    {"vessels", {-100, 500}}, {"soft tissue", {-110, 190}}, {"bone", {-200, 1300}}, {"lung", {-1200, 200}}};

class ReviewState
{
  public:
    ReviewState(std::filesystem::path folder, std::vector<std::string> command);

    // Reads what has changed in the folder, and takes the result of a command that has ended. Returns true if
    // anything has changed.
    bool look();

    // Runs the command, or another one for this run, unless one runs already.
    void run(const std::vector<std::string> &other = {});
    void stop();
    bool is_running() const { return task_ && !task_->is_done(); }
    double running_s() const; // since the command began
    // Whether the clicks differ from those of the last run.
    bool needs_run() const { return clicks_changed_; }
    const std::string &trouble() const { return trouble_; } // empty: none

    // The cross lies within the scan.
    const Eigen::Vector3d &cross_mm() const { return cross_mm_; }
    void set_cross(const Eigen::Vector3d &place_mm);
    void step(Section section, int steps); // moves the cross along the normal, by slices or half slabs
    double cross_HU() const;
    void set_slab(double slab_mm);
    double slab_mm() const { return slab_mm_; }
    void set_grey(std::size_t preset);
    std::size_t grey() const { return grey_; }

    const std::vector<Click> &clicks() const { return clicks_; }
    // Adds a click at the cross and saves the file of clicks. `branch` is for names only. Returns false, with
    // trouble(), if the click is refused.
    bool add_click(ClickKind kind, const std::string &branch = "");
    void remove_click(std::size_t number);

    const PatientFolder &folder() const { return folder_; }
    bool has_scan() const { return folder_.scan.count() > 0; }
    // The picture of a section through the cross, and the lumen's outline in it. `version` changes with it.
    const SectionPicture &picture(Section section);
    const Outline &outline(Section section);
    std::uint64_t version(Section section) const;

  private:
    struct View {
        SectionPicture picture;
        Outline outline;
        std::uint64_t version = 0;
        bool is_old = true;
    };
    View &view(Section section);
    void renew();
    void save_clicks();
    void read_clicks_file();

    PatientFolder folder_;
    std::vector<std::string> command_;
    std::vector<Click> clicks_;
    bool clicks_changed_ = false, had_scan_ = false;
    Eigen::Vector3d cross_mm_ = Eigen::Vector3d::Zero();
    double slab_mm_ = 20;
    std::size_t grey_ = 0;
    View views_[3];
    std::string trouble_;
    std::chrono::steady_clock::time_point began_{};
    std::unique_ptr<BackgroundTask<ProgramResult>> task_; // the last member: it ends first
};

} // namespace crn::ct
