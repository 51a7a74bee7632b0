// Stores the pictures for the screen: acquired runs, and the last seconds of fluoroscopy. Their memory is
// limited. When the memory for pictures is full, the pictures of the oldest run are deleted.
#pragma once
#include "host/xray/run.hpp"
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

namespace crn
{

// Holds a stored run: the raw values of its frames for files and masks, and the frames as the screen showed
// them.
struct StoredRun {
    XrayRun run;
    std::vector<std::vector<std::uint8_t>> grey; // parallel to run.frames
    bool is_dropped = false;                     // its pictures were dropped to free memory
};

struct StoredFrame {
    RunFrame frame;
    std::vector<std::uint8_t> grey;
};

class RunStore
{
  public:
    explicit RunStore(std::size_t bytes_max) : bytes_max_(bytes_max) {}

    // Begins a new run; add() adds frames to it until finish() is called. The caller must fill in the
    // remaining fields of the run's description when it adds the first frame.
    void begin(int number, RunKind kind);
    // Adds a frame to the run; returns false if the memory is full although it holds no other run.
    bool add(RunFrame frame, std::vector<std::uint8_t> grey);
    // Ends the run, and deletes it if the run has no frame. A run that the room has made stays in the list
    // without pictures if its pictures did not fit into the memory.
    void finish(bool was_made);

    // Stores a frame of fluoroscopy; the frames of the last `store_max_ms` milliseconds stay available, and
    // may take half of the memory.
    void pass(const XrayRun &header, RunFrame frame, std::vector<std::uint8_t> grey);
    // Makes a stored run from the fluoroscopy in the last `milliseconds` before `tick`.
    void keep_passed(int number, std::uint32_t tick, std::uint32_t milliseconds);

    StoredRun *open_run() { return is_open_ ? runs_.back().get() : nullptr; }
    StoredRun *find(int number) const; // nullptr: no such run; 0 the last one
    StoredRun *last_of(RunKind kind) const;
    const std::vector<std::unique_ptr<StoredRun>> &runs() const { return runs_; }
    std::size_t bytes() const { return bytes_; }

  private:
    bool make_room(std::size_t bytes);

    std::size_t bytes_max_, bytes_ = 0, passed_bytes_ = 0;
    bool is_open_ = false;
    std::vector<std::unique_ptr<StoredRun>> runs_; // addresses stay valid
    XrayRun passed_header_;
    std::deque<StoredFrame> passed_;
};

} // namespace crn
