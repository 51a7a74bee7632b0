// Begins and ends the live sessions of the window: reads the files that the options name, numbers the files
// of later sessions, and writes the report of each session.
#pragma once
#include "host/command/cli.hpp"
#include "host/igtl/feed.hpp"
#include "host/live/live_goals.hpp"
#include "host/live/physics_thread.hpp"
#include "host/suite/pages.hpp"
#include <memory>
#include <string>

namespace crn
{

class WindowFeed;

class SessionHost
{
  public:
    // The function `window_context` opens an OpenGL context for the X-ray (--xray opengl). Throws the
    // exceptions of the functions that read the files.
    SessionHost(WindowOptions options, GlOpener window_context);

    // Begins a session; the previous session must have ended. `number` counts the window's sessions from 1:
    // the file names of later sessions contain this number. Throws what LiveSession throws.
    void begin(int number);
    // Ends the session, prints its figures and writes its files. Returns the program's exit code for the
    // ended session: 0, 1 or 3 (physics out of range).
    int end();
    PhysicsThread &physics() const { return *physics_; }
    bool is_running() const { return physics_ != nullptr; }
    // Prints the fault of the session once, if the session has one.
    void tell_fault();

    const std::vector<Instrument> &table() const { return table_; } // all tools of the session
    const LineNumbers &line() const { return line_; }               // at the start
    // Returns the tools of the table at these positions. The returned list of tools is valid until the next
    // call.
    const std::vector<Instrument> &tools_on(const LineNumbers &line);
    const SceneFile &scene() const { return scene_; }
    const WindowOptions &options() const { return options_; }
    // Returns the report and the files of the session that ended last.
    const Debrief &debrief() const { return debrief_; }
    // Begins to score the recording of the ended session in the background; the result of a case is stored
    // for the trainee (trainee_records.hpp).
    void assess(const std::string &trainee);
    // Returns the case's goals and which of them are reached now, or null if the session has no case or the
    // goals have not been checked yet.
    std::shared_ptr<const std::vector<GoalResult>> goals() const
    {
        return goals_ ? goals_->latest() : nullptr;
    }
    // Returns, for each position, where the tool's tip is, or null if the session has no case or the tips
    // have not been located yet.
    std::shared_ptr<const std::vector<std::string>> tips() const { return goals_ ? goals_->tips() : nullptr; }
    const std::string &recording() const { return recording_; } // of the last session; empty: none
    bool was_interrupted() const { return was_interrupted_; }

  private:
    WindowOptions options_;
    GlOpener window_context_;
    SceneFile scene_;
    std::vector<Instrument> table_, shown_tools_;
    LineNumbers line_, shown_line_;
    crn_wire_entry entry_;
    DeviceChoice choice_;
    std::shared_ptr<LiveGoals> goals_;
    std::shared_ptr<WindowFeed> feed_;
    std::unique_ptr<PhysicsThread> physics_; // uses goals_
    std::string started_at_;
    std::string recording_;
    int number_ = 0, begun_ = 0; // the session's number in the window, and in this object
    bool is_fault_told_ = false, was_interrupted_ = false;
    Debrief debrief_;
};

} // namespace crn
