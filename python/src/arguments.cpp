// SPDX-License-Identifier: MIT
#include "arguments.h"

#include <cmath>
#include <cstddef>

#include "poise/time_arithmetic.h"

namespace poise::python {
namespace {

const char* kind_name(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::BadInput:
      return "bad_input";
    case ErrorKind::StaleHandle:
      return "stale_handle";
    case ErrorKind::OutputFailed:
      return "output_failed";
    case ErrorKind::CapacityFull:
      return "capacity_full";
    case ErrorKind::Cancelled:
      return "cancelled";
  }
  return "bad_input";
}

/// `count` numbers of a sequence or an array.
template <std::size_t count>
std::array<double, count> numbers_of(const char* name, const py::object& given, const char* rule) {
  std::array<double, count> numbers{};
  const auto refuse = [&] {
    PyErr_Clear();
    raise(bad_input(std::string(name) + " = " + py::repr(given).cast<std::string>() + ", " + rule));
  };
  if (PySequence_Check(given.ptr()) == 0 || PyUnicode_Check(given.ptr()) != 0) refuse();
  if (PySequence_Size(given.ptr()) != static_cast<Py_ssize_t>(count)) refuse();
  for (std::size_t i = 0; i < count; ++i) {
    const auto item = py::reinterpret_steal<py::object>(PySequence_GetItem(given.ptr(), static_cast<Py_ssize_t>(i)));
    if (!item) refuse();
    numbers[i] = PyFloat_AsDouble(item.ptr());
    if (numbers[i] == -1.0 && PyErr_Occurred() != nullptr) refuse();
  }
  return numbers;
}

/// Read and written under the global lock.
struct WorkInProgress {
  int running = 0;
  bool closed = false;
};

WorkInProgress& work_in_progress() {
  static WorkInProgress work;
  return work;
}

}  // namespace

WithoutLock::WithoutLock() {
  if (work_in_progress().closed) raise({ErrorKind::Cancelled, "the interpreter is ending: no step begins any more"});
  ++work_in_progress().running;
  released_.emplace();
}

WithoutLock::~WithoutLock() {
  released_.reset();
  --work_in_progress().running;
}

void WithoutLock::close() { work_in_progress().closed = true; }
int WithoutLock::running() { return work_in_progress().running; }

void raise(const Error& error) {
  const py::object type = py::module_::import("poise._errors").attr("Error");
  // The text of the system may be of another encoding.
  const auto message = py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(error.message.data(), static_cast<Py_ssize_t>(error.message.size()), "replace"));
  PyErr_SetObject(type.ptr(), type(message, kind_name(error.kind)).ptr());
  throw py::error_already_set();
}

Vec3 vec3_of(const char* name, const VectorArgument& argument) {
  const std::array<double, 3> v = numbers_of<3>(name, argument.given, "must be three numbers");
  return {v[0], v[1], v[2]};
}

Quat quat_of(const char* name, const QuaternionArgument& argument) {
  const std::array<double, 4> q = numbers_of<4>(name, argument.given, "must be four numbers, w x y z");
  return {q[0], q[1], q[2], q[3]};
}

std::size_t index_of(const char* name, std::string_view given, std::span<const std::string_view> names) {
  std::string listed;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (given == names[i]) return i;
    listed.append(i == 0 ? "" : ", ").append(names[i]);
  }
  raise(bad_input(std::string(name) + " = " + std::string(given) + ", must be one of " + listed));
}

std::chrono::nanoseconds nanoseconds_of(const char* name, double seconds) {
  if (std::isnan(seconds)) raise(bad_input(std::string(name) + " = nan, must be a number of seconds"));
  const double most = seconds_of(kFarthestTime);
  if (seconds >= most) return kFarthestTime;
  if (seconds <= -most) return -kFarthestTime;
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::floor(seconds * 1e9 + 0.5)));
}

std::uint64_t whole_of(const char* name, const py::handle& given, std::uint64_t most) {
  const auto refuse = [&] {
    PyErr_Clear();
    raise(bad_input(std::string(name) + " = " + py::repr(given).cast<std::string>() +
                    ", must be a whole number in [0, " + std::to_string(most) + "]"));
  };
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(given.ptr()));
  if (!number) refuse();
  const std::uint64_t value = PyLong_AsUnsignedLongLong(number.ptr());
  if (PyErr_Occurred() != nullptr || value > most) refuse();
  return value;
}

void set_fields(const py::object& object, const py::kwargs& fields, const char* what) {
  for (const auto& [key, value] : fields) {
    const auto name = key.cast<std::string>();
    if (name.starts_with("_") || !py::hasattr(object, name.c_str())) {
      std::string listed;
      for (const py::handle& has : py::reinterpret_steal<py::list>(PyObject_Dir(object.ptr()))) {
        const auto known = has.cast<std::string>();
        if (!known.starts_with("_")) listed += (listed.empty() ? "" : ", ") + known;
      }
      throw py::type_error(std::string(what) + " has no '" + name + "'; it has " + listed);
    }
    if (PyObject_SetAttrString(object.ptr(), name.c_str(), value.ptr()) == 0) continue;
    // What pybind11 says of a wrong type does not name the attribute.
    py::error_already_set failure;
    const bool unnamed = failure.matches(PyExc_TypeError) &&
                         std::string_view(failure.what()).find("incompatible function arguments") != std::string::npos;
    if (!unnamed) throw failure;
    throw py::type_error(std::string(what) + ": " + name + " = " + py::repr(value).cast<std::string>() +
                         " is of a wrong type");
  }
}

}  // namespace poise::python
