// This header has the declarations that the parts of the Python module share. The module uses only the
// functions of cournand.h and nothing else of the project. The module releases the interpreter's lock in
// every call that takes more than microseconds.
#pragma once
#include "host/library/cournand.h"
// After cournand.h:
#include "host/library/cournand_play.h"
#include <memory>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cournand_python
{

namespace nb = nanobind;

// The C++ exception of a refused call becomes the Python exception of the same status in cournand/errors.py.
class StatusError : public std::runtime_error
{
  public:
    StatusError(cournand_status status_, const std::string &text) : std::runtime_error(text), status(status_)
    {
    }
    cournand_status status;
    std::string script; // with a line and a column, both from 1: the place of a mistake in a session script
    std::uint32_t line = 0, column = 0;
};

// Call it in the thread of the refused call, because the library keeps the text of a refusal separately for
// each thread.
inline void check(cournand_status status)
{
    if (status != COURNAND_OK) throw StatusError(status, cournand_error_text());
}

// Runs a call of the library without the interpreter's lock.
template <class Call> void unlocked(Call call)
{
    const nb::gil_scoped_release release;
    check(call());
}

// Holds a handle of the library and frees it. Views refer to memory that belongs to the handle, so the Python
// object that holds the handle owns its views, and a view keeps this object alive.
template <class Handle, cournand_status (*free)(Handle *)> class Owned
{
  public:
    explicit Owned(Handle *handle) : handle_(handle) {}
    ~Owned() { free(handle_); }
    Owned(const Owned &) = delete;
    Owned &operator=(const Owned &) = delete;
    Handle *get() const { return handle_; }

  private:
    Handle *handle_;
};

using Scene = Owned<cournand_scene, cournand_scene_free>;
using Tool = Owned<cournand_tool, cournand_tool_free>;
using World = Owned<cournand_world, cournand_world_free>;
using Pool = Owned<cournand_pool, cournand_pool_free>;
using Script = Owned<cournand_script, cournand_script_free>;
using Play = Owned<cournand_play, cournand_play_free>;
using Recording = Owned<cournand_recording, cournand_recording_free>;

// Returns an empty struct of the API in which its size is set.
template <class Struct> Struct sized()
{
    Struct made{};
    made.struct_bytes = sizeof made;
    return made;
}

// Makes read-only arrays over memory of the library.
template <class Number> using View = nb::ndarray<nb::numpy, const Number, nb::c_contig>;
template <class Number> using Given = nb::ndarray<const Number, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

template <class Number>
nb::object view(const Number *data, std::initializer_list<std::size_t> shape, nb::handle owner)
{
    return nb::cast(View<Number>(data, shape, owner), nb::rv_policy::reference);
}

template <class Number> nb::tuple tuple_of(const Number *numbers, std::size_t count)
{
    nb::list list;
    for (std::size_t i = 0; i < count; i++) list.append(numbers[i]);
    return nb::tuple(list);
}

void add_worlds(nb::module_ &module);
void add_pictures(nb::module_ &module);
void add_recordings(nb::module_ &module);
void add_plays(nb::module_ &module);
void add_batches(nb::module_ &module);
void add_encoders(nb::module_ &module);

} // namespace cournand_python
