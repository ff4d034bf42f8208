// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "assets/files/text_words.h"
#include "assets/tree/tree_files.h"
#include "math/functions.h"

namespace poise::io {
namespace {

constexpr double kMostMjcfNumber = 1e9;
constexpr std::array<std::string_view, 5> kOrientations{"quat", "axisangle", "xyaxes", "zaxis", "euler"};

Quat turn_about(const Vec3& axis, double angle_rad) {
  const math::SinCos half = math::sin_cos(0.5 * angle_rad);
  const Vec3 v = half.sin * axis;
  return {half.cos, v.x(), v.y(), v.z()};
}

Quat quat_of_euler(const double* angles, double unit, const std::string& sequence) {
  Quat turn = Quat::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const char axis = sequence[i];
    const bool fixed = axis < 'a';
    const Quat one = turn_about(Vec3::Unit((fixed ? axis - 'X' : axis - 'x')), unit * angles[i]);
    turn = fixed ? one * turn : turn * one;
  }
  return turn;
}

/// One orientation of the words that were read.
Status orientation_of(const MjcfView& view, std::string_view kind, const MjcfAngles& angles, Quat& orientation) {
  std::array<double, 6> n{};
  const std::size_t count = kind == "xyaxes" ? 6 : kind == "quat" || kind == "axisangle" ? 4 : 3;
  const Status read = view.numbers(kind, {n.data(), count});
  if (!read) return read;
  const double unit = angles.degrees ? std::numbers::pi / 180 : 1;
  const Vec3 first(n[0], n[1], n[2]);
  if (kind == "euler") {
    orientation = quat_of_euler(n.data(), unit, angles.sequence);
    return Done{};
  }
  if (kind == "quat") {
    const Quat given(n[0], n[1], n[2], n[3]);
    if (!(given.norm() > 1e-100)) return view.refused(kind, "must not be zero");
    orientation = given.normalized();
    return Done{};
  }
  if (!(first.norm() > 1e-100)) return view.refused(kind, "must have a length");
  if (kind == "axisangle") orientation = turn_about(first.normalized(), unit * n[3]);
  if (kind == "zaxis") orientation = mjcf_turn_of_z(first);
  if (kind == "xyaxes") {
    const Vec3 x = first.normalized();
    const Vec3 second(n[3], n[4], n[5]);
    const Vec3 y = second - x * x.dot(second);
    if (!(y.norm() > 1e-12 * second.norm())) return view.refused(kind, "must be two directions");
    Mat3 axes;
    axes << x, y.normalized(), x.cross(y.normalized());
    orientation = Quat(axes).normalized();
  }
  return Done{};
}

/// Sets what a <default> gives and goes on with those in it.
Status read_class(const MjcfDocument& document, const MjcfDocument::Element& element, const std::string& name,
                  const MjcfClass& parent, MjcfClasses& classes) {
  const auto [entry, added] = classes.try_emplace(name, parent);
  if (!added && name != "main")
    return bad_input(
        fmt::format("{}: class = '{}', is that of another <default>", document.place(element), mjcf_shown(name)));
  const auto children = document.children(element);
  for (const auto* child : children) {
    const auto kind = std::ranges::find(kMjcfKinds, std::string_view(child->Name()));
    if (kind == kMjcfKinds.end()) continue;
    auto& values = entry->second.values[static_cast<std::size_t>(kind - kMjcfKinds.begin())];
    for (std::size_t i = 0; i < kMjcfAttributes.size(); ++i) {
      if (const char* text = child->Attribute(kMjcfAttributes[i].data())) values[i] = text;
    }
  }
  for (const auto* child : children) {
    if (std::string_view(child->Name()) != "default") continue;
    const char* own = child->Attribute("class");
    if (own == nullptr || *own == '\0') return bad_input(document.place(*child) + ": must have a class");
    const Status read = read_class(document, *child, own, entry->second, classes);
    if (!read) return read;
  }
  return Done{};
}

}  // namespace

const char* MjcfView::find(std::string_view name) const {
  if (const char* own = element->Attribute(name.data())) return own;
  if (defaults == nullptr) return nullptr;
  const auto attribute = std::ranges::find(kMjcfAttributes, name);
  const auto kind = std::ranges::find(kMjcfKinds, std::string_view(element->Name()));
  if (attribute == kMjcfAttributes.end() || kind == kMjcfKinds.end()) return nullptr;
  return defaults->values[static_cast<std::size_t>(kind - kMjcfKinds.begin())]
                         [static_cast<std::size_t>(attribute - kMjcfAttributes.begin())];
}

Error MjcfView::refused(std::string_view name, std::string_view rule) const {
  const char* text = find(name);
  return bad_input(fmt::format("{}: {} = '{}', {}", place(), name, mjcf_shown(text != nullptr ? text : ""), rule));
}

Status MjcfView::numbers(std::string_view name, std::size_t least, std::span<double> numbers,
                         std::size_t& count) const {
  count = 0;
  const char* text = find(name);
  if (text == nullptr) return Done{};
  // A line end is a blank in XML.
  std::string line(text);
  std::ranges::replace(line, '\n', ' ');
  const std::vector<std::string_view> words = geometry::words_of(line);
  bool sound = words.size() >= least && words.size() <= numbers.size();
  for (std::size_t i = 0; i < words.size() && sound; ++i)
    sound = geometry::read_number(words[i], numbers[i]) && std::abs(numbers[i]) <= kMostMjcfNumber;
  count = words.size();
  if (sound) return Done{};
  const std::string wanted =
      least == numbers.size() ? fmt::format("{}", least) : fmt::format("{} to {}", least, numbers.size());
  return refused(name,
                 fmt::format("must be {} number{} within {}", wanted, numbers.size() == 1 ? "" : "s", kMostMjcfNumber));
}

Status MjcfView::numbers(std::string_view name, std::span<double> into) const {
  std::size_t count = 0;
  return numbers(name, into.size(), into, count);
}

Status MjcfView::whole(std::string_view name, std::uint64_t most, std::uint64_t& number) const {
  double value = static_cast<double>(number);
  const char* text = find(name);
  if (text == nullptr) return Done{};
  if (!geometry::read_number(text, value) || value < 0 || value > static_cast<double>(most) ||
      value != std::floor(value))
    return refused(name, fmt::format("must be a whole number from 0 to {}", most));
  number = static_cast<std::uint64_t>(value);
  return Done{};
}

Status mjcf_orientation(const MjcfView& view, const MjcfAngles& angles, Quat& orientation) {
  // What the element says goes before what its class says.
  MjcfView own = view;
  own.defaults = nullptr;
  for (const MjcfView& looked_at : {own, view}) {
    std::string_view found;
    for (const std::string_view kind : kOrientations) {
      if (looked_at.find(kind) == nullptr) continue;
      if (!found.empty())
        return bad_input(fmt::format("{}: has {} and {}, must have one of them", view.place(), found, kind));
      found = kind;
    }
    if (!found.empty()) return orientation_of(looked_at, found, angles, orientation);
  }
  return Done{};
}

Quat mjcf_turn_of_z(const Vec3& direction) {
  const Vec3 unit = direction.normalized();
  const Vec3 axis = Vec3::UnitZ().cross(unit);
  const double sine = axis.norm();
  if (sine < 1e-10) return turn_about(Vec3::UnitX(), unit.z() > 0 ? 0 : std::numbers::pi);
  return turn_about(axis / sine, math::atan2(sine, unit.z()));
}

Result<MjcfClasses> mjcf_classes(const MjcfDocument& document) {
  MjcfClasses classes;
  classes.try_emplace("main");
  for (const auto* element : document.children(document.root())) {
    if (std::string_view(element->Name()) != "default") continue;
    // The first level is "main", whatever it is called.
    const Status read = read_class(document, *element, "main", {}, classes);
    if (!read) return read.error();
    const char* called = element->Attribute("class");
    if (called != nullptr && std::string_view(called) != "main") classes.try_emplace(called, classes.at("main"));
  }
  return classes;
}

}  // namespace poise::io
