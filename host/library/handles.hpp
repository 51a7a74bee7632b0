// Keeps the objects behind the handles of the API. A handle is a number that is never used again, so a freed
// handle is recognised. An object lives until the last call that uses it has returned.
#pragma once
#include "host/library/refusal.hpp"
#include <atomic>
#include <cstdint>
#include <memory>

namespace crn::library
{

enum class HandleKind : std::uintptr_t { scene = 1, tool, world, renderer, pool, recording, script, play };

std::uintptr_t add_handle(HandleKind kind, std::shared_ptr<void> object);
// The next two functions return null for a handle that is NULL, freed or of another kind.
std::shared_ptr<void> find_handle(HandleKind kind, std::uintptr_t handle);
std::shared_ptr<void> remove_handle(HandleKind kind, std::uintptr_t handle);

// Connects the C type of a handle to the class of its object; each class has a template specialisation.
template <class Handle> struct HandleOf;

template <class Handle> Handle *make_handle(std::shared_ptr<typename HandleOf<Handle>::Object> object)
{
    return reinterpret_cast<Handle *>(add_handle(HandleOf<Handle>::kind, std::move(object)));
}

// Throws Refused(COURNAND_BAD_HANDLE).
template <class Handle> std::shared_ptr<typename HandleOf<Handle>::Object> object_of(const Handle *handle)
{
    auto object = find_handle(HandleOf<Handle>::kind, reinterpret_cast<std::uintptr_t>(handle));
    if (!object)
        throw Refused(COURNAND_BAD_HANDLE, std::string("this is no ") + HandleOf<Handle>::name +
                                               ": the handle is NULL, freed, or of another kind");
    return std::static_pointer_cast<typename HandleOf<Handle>::Object>(object);
}

template <class Handle> cournand_status free_handle(const Handle *handle) noexcept
{
    return guarded([&] {
        object_of(handle);
        remove_handle(HandleOf<Handle>::kind, reinterpret_cast<std::uintptr_t>(handle));
    });
}

// Lets only one thread at a time use an object; a call from a second thread is refused at once.
class OneAtATime
{
  public:
    class Inside
    {
      public:
        Inside(OneAtATime &door, const char *name) : door_(door)
        {
            if (door_.busy_.test_and_set(std::memory_order_acquire))
                throw Refused(COURNAND_BUSY, std::string("another thread is inside this ") + name +
                                                 ": wait until its call has returned");
        }
        ~Inside() { door_.busy_.clear(std::memory_order_release); }
        Inside(const Inside &) = delete;
        Inside &operator=(const Inside &) = delete;

      private:
        OneAtATime &door_;
    };

  private:
    std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

} // namespace crn::library
