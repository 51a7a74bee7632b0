#include "host/live/picture_thread.hpp"
#include "host/live/thread_priority.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr std::size_t pulses_waiting_max = 8; // then give() waits

PictureSettings with_threads(PictureSettings settings)
{
    const int processors = static_cast<int>(std::thread::hardware_concurrency());
    if (settings.threads == 0) settings.threads = std::clamp(processors - 1, 1, 4);
    return settings;
}

std::size_t pulses_in(const RoomPackage &package)
{
    return static_cast<std::size_t>(
        std::count_if(package.items.begin(), package.items.end(),
                      [](const RoomItem &item) { return item.shot.has_value(); }));
}

} // namespace

PictureThread::PictureThread(const PictureSettings &settings, const std::vector<Instrument> &tools,
                             const XrayScene &scene, const SceneAnatomy &anatomy, bool keeps_all)
    : keeps_all_(keeps_all)
{
    thread_ = std::thread(
        [this, &settings, &tools, &scene, &anatomy] { run(with_threads(settings), tools, scene, anatomy); });
    Lock lock(mutex_);
    changed_.wait(lock, [this] { return is_ready_; });
    if (!failure_) return;
    lock.unlock();
    thread_.join();
    std::rethrow_exception(failure_);
}

PictureThread::~PictureThread()
{
    {
        const Lock lock(mutex_);
        waiting_.clear();
        must_end_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

// This thread makes the objects that draw pictures and uses them to the end, because an OpenGL context
// belongs to one thread.
void PictureThread::run(const PictureSettings &settings, const std::vector<Instrument> &tools,
                        const XrayScene &scene, const SceneAnatomy &anatomy)
{
    yield_to_physics();
    try {
        pictures_ = std::make_unique<RoomPictures>(settings, tools, scene, anatomy, room_);
        present_.size = second_.size = pictures_->size();
    } catch (...) {
        failure_ = std::current_exception();
    }
    {
        const Lock lock(mutex_);
        is_ready_ = true;
    }
    changed_.notify_all();
    if (failure_) return;
    try {
        serve();
    } catch (...) {
        const Lock lock(mutex_);
        failure_ = std::current_exception();
        is_busy_ = false;
    }
    changed_.notify_all();
}

void PictureThread::serve()
{
    Lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return !waiting_.empty() || wanted_ || must_end_; });
        if (waiting_.empty() && !wanted_) return;
        is_busy_ = true;
        const std::optional<ReferenceChoice> wanted = std::exchange(wanted_, std::nullopt);
        std::optional<RoomPackage> package;
        if (!waiting_.empty()) {
            package = std::move(waiting_.front());
            waiting_.pop_front();
        }
        present_.pulses_left_out = left_out_;
        lock.unlock();
        changed_.notify_all();
        if (wanted) {
            shown_ = *wanted;
            copied_ = present_;
            second_.grey.clear(); // another picture than before
            is_chosen_ = true;
        }
        if (package) draw(std::move(*package));
        draw_reference();
        lock.lock();
        is_busy_ = false;
        changed_.notify_all();
    }
}

void PictureThread::draw(RoomPackage package)
{
    room_ = std::move(package.room);
    for (RoomItem &item : package.items) {
        const auto begin = SuiteClock::now();
        pictures_->take(item.event, item.shot ? &*item.shot : nullptr);
        if (!item.shot) continue;
        ++present_.pulses;
        present_.asked = package.asked;
        present_.render_ms = std::chrono::duration<double, std::milli>(SuiteClock::now() - begin).count();
    }
    if (pictures_->screen().compose(present_.size, present_.grey)) ++present_.number;
    present_.status = pictures_->screen().status();
    live_.put(std::make_shared<const MonitorPicture>(present_));
    std::function<void()> told;
    {
        const Lock lock(mutex_);
        told = told_;
    }
    if (told) told();
}

void PictureThread::draw_reference()
{
    bool is_new = false;
    switch (shown_.kind) {
    case ReferenceChoice::Kind::nothing:
        is_new = is_chosen_;
        second_.status = {};
        break;
    case ReferenceChoice::Kind::copy:
        is_new = second_.grey.empty() && copied_ && !copied_->grey.empty();
        if (!is_new) return;
        second_.grey = copied_->grey;
        second_.status = copied_->status;
        break;
    default:
        is_new = pictures_->screen().compose_stored(
            shown_.run, shown_.kind == ReferenceChoice::Kind::loop ? -1 : shown_.frame, second_.grey,
            second_.status);
    }
    if (!is_new) return;
    is_chosen_ = false;
    ++second_.number;
    reference_.put(std::make_shared<const MonitorPicture>(second_));
}

std::size_t PictureThread::waiting_pulses() const
{
    std::size_t pulses = 0;
    for (const RoomPackage &package : waiting_) pulses += pulses_in(package);
    return pulses;
}

// Fluoroscopy shows the present. If an X-ray pulse is still waiting for its picture when the next pulse
// comes, the waiting pulse is left out. The events of a pulse that is left out, and all frames of stored
// runs, are kept.
void PictureThread::leave_out_fluoroscopy()
{
    for (RoomPackage &package : waiting_)
        left_out_ += std::erase_if(package.items, [](const RoomItem &item) {
            return item.shot && item.event.run_kind == RunKind::fluoro;
        });
}

void PictureThread::give(RoomPackage package)
{
    Lock lock(mutex_);
    throw_failure();
    if (!keeps_all_ && pulses_in(package) > 0) leave_out_fluoroscopy();
    changed_.wait(lock, [this] { return waiting_pulses() < pulses_waiting_max || failure_; });
    throw_failure();
    // A package from the physics without events contains only the state of the room, so the next package can
    // replace it.
    if (!waiting_.empty() && waiting_.back().items.empty()) waiting_.pop_back();
    waiting_.push_back(std::move(package));
    lock.unlock();
    changed_.notify_all();
}

void PictureThread::throw_failure()
{
    if (failure_) std::rethrow_exception(failure_);
}

void PictureThread::show_reference(const ReferenceChoice &choice)
{
    {
        const Lock lock(mutex_);
        wanted_ = choice;
    }
    changed_.notify_all();
}

void PictureThread::on_picture(std::function<void()> told)
{
    const Lock lock(mutex_);
    told_ = std::move(told);
}

void PictureThread::wait_until_idle()
{
    Lock lock(mutex_);
    changed_.wait(lock, [this] { return (waiting_.empty() && !wanted_ && !is_busy_) || failure_; });
    throw_failure();
}

void PictureThread::stop()
{
    {
        const Lock lock(mutex_);
        must_end_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
    throw_failure();
}

} // namespace crn
