// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "poise/result.h"
#include "poise/types.h"

/// From Python's values to those of the library, and its refusals back as poise.Error. All of it needs the global lock.
namespace poise::python {

namespace py = pybind11;

/// Raises poise.Error with the library's message.
[[noreturn]] void raise(const Error& error);

/// The value of a result; an error is raised.
template <class T>
T taken(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(result).value();
}
inline void check(const Status& status) {
  if (!status) raise(status.error());
}

/// Work without the global lock, as long as it lives: other Python threads run meanwhile. When the interpreter ends it
/// takes the lock from the threads that are left, which no C++ function survives; so it waits for what is at work
/// (poise/_at_exit.py), and from then on this raises poise.Error.
class WithoutLock {
 public:
  WithoutLock();
  ~WithoutLock();
  WithoutLock(const WithoutLock&) = delete;
  WithoutLock& operator=(const WithoutLock&) = delete;

  /// From now on nothing begins.
  static void close();
  /// How many are at work.
  static int running();

 private:
  std::optional<py::gil_scoped_release> released_;
};

/// A vector as an argument: any sequence or array of three numbers. Converted by vec3_of, which names the argument.
struct VectorArgument {
  py::object given;
};
/// A quaternion as an argument: w, x, y, z.
struct QuaternionArgument {
  py::object given;
};

/// Raises poise.Error with the argument's name unless it is three numbers. Whether they are finite and in range is for
/// the library to say.
Vec3 vec3_of(const char* name, const VectorArgument& argument);
/// The same of four numbers, w first.
Quat quat_of(const char* name, const QuaternionArgument& argument);

/// The index of `given` among `names`; otherwise raises poise.Error that lists them.
std::size_t index_of(const char* name, std::string_view given, std::span<const std::string_view> names);

/// Seconds as nanoseconds; NaN raises poise.Error, what is beyond a year counts as a year.
std::chrono::nanoseconds nanoseconds_of(const char* name, double seconds);
inline double seconds_of(std::chrono::nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }

/// A whole number >= 0 of at most `most`; otherwise raises poise.Error with its name.
std::uint64_t whole_of(const char* name, const py::handle& given, std::uint64_t most);

/// `given` as a T; TypeError with the argument's name, and `type` as what it must be, for anything else.
template <class T>
T typed(const char* name, const py::handle& given, const char* type) {
  py::detail::make_caster<T> caster;
  if (!given.is_none() && caster.load(given, true)) return py::detail::cast_op<T>(caster);
  throw py::type_error(std::string(name) + " must be " + type + ", not " + py::repr(given).cast<std::string>());
}

/// Sets attributes by keyword arguments; raises TypeError for a name that `object` does not have. `what` is what the
/// message calls it.
void set_fields(const py::object& object, const py::kwargs& fields, const char* what);

inline py::tuple tuple_of(const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); }
inline py::tuple tuple_of(const Quat& q) { return py::make_tuple(q.w(), q.x(), q.y(), q.z()); }

}  // namespace poise::python

namespace pybind11::detail {

// Taken as they come, so that the function can name the argument that is wrong.
template <>
struct type_caster<poise::python::VectorArgument> {
  PYBIND11_TYPE_CASTER(poise::python::VectorArgument, const_name("Vector"));
  bool load(handle source, bool /*convert*/) {
    value.given = reinterpret_borrow<object>(source);
    return true;
  }
  static handle cast(const poise::python::VectorArgument& source, return_value_policy /*policy*/, handle /*parent*/) {
    return source.given.inc_ref();
  }
};
template <>
struct type_caster<poise::python::QuaternionArgument> {
  PYBIND11_TYPE_CASTER(poise::python::QuaternionArgument, const_name("Quaternion"));
  bool load(handle source, bool /*convert*/) {
    value.given = reinterpret_borrow<object>(source);
    return true;
  }
  static handle cast(const poise::python::QuaternionArgument& source, return_value_policy /*policy*/,
                     handle /*parent*/) {
    return source.given.inc_ref();
  }
};

}  // namespace pybind11::detail
