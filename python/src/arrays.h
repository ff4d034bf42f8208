// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arguments.h"

namespace poise::python {

/// An array that cannot be written through and shows `data` without a copy, as long as it keeps `base` alive.
template <class T>
py::array shown(const T* data, const std::vector<py::ssize_t>& shape, const py::object& base) {
  py::array_t<T> array(shape, data, base);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// An array that owns `values`.
template <class T>
py::array owned(std::vector<T> values, const std::vector<py::ssize_t>& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const T* const data = kept->data();
  const py::capsule base(kept.get(), [](void* held) { delete static_cast<std::vector<T>*>(held); });
  static_cast<void>(kept.release());
  return py::array_t<T>(shape, data, base);
}

/// Whether all of it are whole numbers, which a conversion to whole numbers would otherwise round in silence.
inline bool is_whole(const py::object& given) {
  const py::array any = py::array::ensure(given);
  PyErr_Clear();
  return any &&
         (any.size() == 0 || any.dtype().kind() == 'i' || any.dtype().kind() == 'u' || any.dtype().kind() == 'b');
}

/// `given` as contiguous numbers with rows of `columns`; raises poise.Error with the name for anything else. An array
/// of the right type is not copied.
template <class T>
py::array_t<T, py::array::c_style | py::array::forcecast> rows_of(const char* name, const py::object& given,
                                                                  py::ssize_t columns) {
  if (std::is_integral_v<T> && !is_whole(given)) raise(bad_input(std::string(name) + ", must be whole numbers"));
  auto array = py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(given);
  const bool right = array && (columns == 1 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == columns);
  if (right) return array;
  // An empty list is as good as no rows.
  if (array && array.size() == 0 && array.ndim() == 1) return decltype(array)(std::vector<py::ssize_t>{0, columns});
  PyErr_Clear();
  raise(bad_input(std::string(name) + (columns == 1
                                           ? ", must be a row of numbers"
                                           : ", must be an array of shape (n, " + std::to_string(columns) + ")")));
}

}  // namespace poise::python
