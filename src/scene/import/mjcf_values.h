// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "poise/types.h"
#include "scene/import/mjcf_document.h"

namespace poise::io {

/// The attributes that <default> may give and this project reads, of all kinds of elements.
inline constexpr std::array<std::string_view, 24> kMjcfAttributes{
    "type",  "size",   "fromto",       "pos",      "quat",      "axisangle",   "xyaxes",   "zaxis",
    "euler", "mass",   "density",      "friction", "contype",   "conaffinity", "condim",   "mesh",
    "scale", "hfield", "shellinertia", "inertia",  "stiffness", "damping",     "armature", "frictionloss"};

/// Kinds of elements that have defaults here.
inline constexpr std::array<std::string_view, 3> kMjcfKinds{"geom", "mesh", "joint"};

/// What a class of <default> gives, that of its parents included; nullptr where it gives nothing.
struct MjcfClass {
  std::array<std::array<const char*, kMjcfAttributes.size()>, kMjcfKinds.size()> values{};
};

/// An element with the class that applies to it.
struct MjcfView {
  const MjcfDocument* document = nullptr;
  const MjcfDocument::Element* element = nullptr;
  const MjcfClass* defaults = nullptr;  ///< may be null

  /// The attribute of the element, else that of its class, else nullptr.
  [[nodiscard]] const char* find(std::string_view name) const;
  [[nodiscard]] std::string place() const { return document->place(*element); }
  /// Reads up to numbers.size() numbers, at least `least`; `count` gets how many there are, 0 without the attribute.
  /// Refused: other words, other counts, beyond 1e9.
  Status numbers(std::string_view name, std::size_t least, std::span<double> numbers, std::size_t& count) const;
  /// Exactly as many as there is room for; without the attribute they stay.
  Status numbers(std::string_view name, std::span<double> numbers) const;
  /// A whole number from 0 to `most`.
  Status whole(std::string_view name, std::uint64_t most, std::uint64_t& number) const;
  /// The refusal of an attribute.
  [[nodiscard]] Error refused(std::string_view name, std::string_view rule) const;
};

/// How angles are written: <compiler angle eulerseq>.
struct MjcfAngles {
  bool degrees = true;
  std::string sequence = "xyz";  ///< small: about the turned axes, large: about the fixed ones
};

/// Reads one of quat, axisangle, xyaxes, zaxis and euler; without any the orientation stays. Refused: several of them,
/// and directions without a length.
Status mjcf_orientation(const MjcfView& view, const MjcfAngles& angles, Quat& orientation);

/// The smallest rotation that turns +z to `direction`, which is not 0.
Quat mjcf_turn_of_z(const Vec3& direction);

/// By name; "main" is what applies where no class is named.
using MjcfClasses = std::map<std::string, MjcfClass, std::less<>>;

/// The classes of all <default> sections. Refused: a class twice, one without a name below the first.
Result<MjcfClasses> mjcf_classes(const MjcfDocument& document);

}  // namespace poise::io
