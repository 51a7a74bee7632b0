// Computes the pictures of a live session in a separate thread. The physics passes packages of data to the
// pictures' thread. A package has the events of the X-ray room, a copy of the data for each pulse's picture,
// and a copy of the room's state. The GUI window takes the finished pictures from mailboxes. The pictures'
// thread shares nothing else with the physics, so the pictures cannot influence the physics.
//
// If the machine is too slow, fluoroscopy pulses that wait for their pictures are left out, and only the
// newest pulse is drawn. All frames of cine and DSA runs are drawn. While many frames of cine and DSA runs
// wait to be drawn, give() waits too, and the session becomes slower than real time. With `keeps_all`, all
// pulses of fluoroscopy are drawn as well.
#pragma once
#include "host/live/mailbox.hpp"
#include "host/picture/room_pictures.hpp"
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <optional>
#include <thread>

namespace crn
{

using SuiteClock = std::chrono::steady_clock;

struct RoomItem {
    RoomEvent event;
    std::optional<PulseShot> shot; // of a pulse; it owns its bodies
};

struct RoomPackage {
    Room room; // after the events
    std::vector<RoomItem> items;
    SuiteClock::time_point asked{}; // when the user last moved a hand before this package; 0: never
};

// States what the reference monitor shows.
struct ReferenceChoice {
    enum class Kind { nothing, copy, loop, frame } kind = Kind::nothing;
    int run = 0, frame = 0;
    bool operator==(const ReferenceChoice &) const = default;
};

// Holds one finished picture of a monitor, without text.
struct MonitorPicture {
    int size = 0;
    std::vector<std::uint8_t> grey; // size * size pixels; empty before the first pulse
    RoomStatus status;
    std::uint64_t number = 0; // counts the pictures of this monitor
    std::uint64_t pulses = 0, pulses_left_out = 0;
    double render_ms = 0.0;         // of the last pulse
    SuiteClock::time_point asked{}; // of the package with the last pulse
};

class PictureThread
{
  public:
    // `scene` must live longer than this object. The constructor starts the thread, and throws the exceptions
    // that RoomPictures throws. If `threads` in the settings is 0, the pictures use all processors except
    // one, which remains for the physics.
    PictureThread(const PictureSettings &settings, const std::vector<Instrument> &tools,
                  const XrayScene &scene, const SceneAnatomy &anatomy, bool keeps_all);
    ~PictureThread();
    PictureThread(const PictureThread &) = delete;
    PictureThread &operator=(const PictureThread &) = delete;

    // Throws the exception with which the thread has failed, for example because the memory is full.
    void give(RoomPackage package);
    std::shared_ptr<const MonitorPicture> live() const { return live_.latest(); }
    std::shared_ptr<const MonitorPicture> reference() const { return reference_.latest(); }
    void show_reference(const ReferenceChoice &choice);
    // The function is called in the pictures' thread after each picture of the live monitor.
    void on_picture(std::function<void()> told);
    void wait_until_idle();
    // Draws the pictures that still wait, and ends the thread. Afterwards pictures() may be used.
    void stop();
    RoomPictures &pictures() { return *pictures_; }

  private:
    using Lock = std::unique_lock<std::mutex>;
    void run(const PictureSettings &settings, const std::vector<Instrument> &tools, const XrayScene &scene,
             const SceneAnatomy &anatomy);
    void serve();
    void draw(RoomPackage package);
    void draw_reference();
    void throw_failure();
    std::size_t waiting_pulses() const;
    void leave_out_fluoroscopy();

    const bool keeps_all_;
    Room room_; // copy of the last package
    std::unique_ptr<RoomPictures> pictures_;
    Mailbox<MonitorPicture> live_, reference_;
    MonitorPicture present_, second_; // drawn by the thread
    ReferenceChoice shown_;           // by the thread
    std::optional<MonitorPicture> copied_;
    bool is_chosen_ = false; // the reference monitor must show something else

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<RoomPackage> waiting_;
    std::optional<ReferenceChoice> wanted_;
    std::function<void()> told_;
    std::uint64_t left_out_ = 0;
    bool is_ready_ = false, is_busy_ = false, must_end_ = false;
    std::exception_ptr failure_;
    std::thread thread_; // the last member, because it uses the others
};

} // namespace crn
