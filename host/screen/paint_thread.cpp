#include "host/screen/paint_thread.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <utility>

namespace crn
{

PaintThread::PaintThread(GLFWwindow *window) : window_(window), thread_([this] { serve(); }) {}

PaintThread::~PaintThread()
{
    {
        const std::lock_guard lock(mutex_);
        must_end_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void PaintThread::start(std::function<void()> work)
{
    finish();
    {
        const std::lock_guard lock(mutex_);
        work_ = std::move(work);
    }
    changed_.notify_all();
}

bool PaintThread::is_idle() const
{
    const std::lock_guard lock(mutex_);
    return !work_;
}

void PaintThread::finish()
{
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !work_; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void PaintThread::run(std::function<void()> work)
{
    start(std::move(work));
    finish();
}

void PaintThread::serve()
{
    glfwMakeContextCurrent(window_);
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return work_ || must_end_; });
        if (!work_) break;
        lock.unlock();
        std::exception_ptr failure;
        try {
            work_();
        } catch (...) {
            failure = std::current_exception();
        }
        lock.lock();
        failure_ = failure;
        work_ = nullptr;
        changed_.notify_all();
        glfwPostEmptyEvent();
    }
    glfwMakeContextCurrent(nullptr);
}

} // namespace crn
