// Draws a window in a separate thread, so that the event thread can read keys meanwhile: without a graphics
// card, drawing takes tens of milliseconds.
//
//   PaintThread paint(window);
//   paint.run([] { load textures });              waits for the end
//   paint.start([] { draw; swap buffers });       returns at once
//   if (paint.is_idle()) ...                      begin the next picture
//
// The window's OpenGL context belongs to the drawing thread; no other thread may call OpenGL for the window.
#pragma once
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

struct GLFWwindow;

namespace crn
{

class PaintThread
{
  public:
    explicit PaintThread(GLFWwindow *window);
    ~PaintThread(); // waits for the end of the work
    PaintThread(const PaintThread &) = delete;
    PaintThread &operator=(const PaintThread &) = delete;

    // Starts `work` in the drawing thread, after the previous work has ended. When the work ends, an empty
    // event wakes the thread that waits for events.
    void start(std::function<void()> work);
    bool is_idle() const;
    // Waits for the end of the work, and rethrows an exception that the work threw.
    void finish();
    void run(std::function<void()> work);

  private:
    void serve();

    GLFWwindow *window_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::function<void()> work_; // empty: idle
    std::exception_ptr failure_;
    bool must_end_ = false;
    std::thread thread_; // the last member, because it uses the others
};

} // namespace crn
