// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/import/mjcf_attributes.h"

namespace poise::io {
namespace {

using MjcfNode = MjcfDocument::Element;

struct MjcfPose {
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
};

MjcfPose operator*(const MjcfPose& a, const MjcfPose& b) {
  return {a.position_m + a.orientation * b.position_m, (a.orientation * b.orientation).normalized()};
}

/// Which geoms touch which, by bits: MuJoCo's contype and conaffinity.
using MjcfContactBits = std::pair<std::uint64_t, std::uint64_t>;

/// A body with a free joint while it is read.
struct MjcfFreeBody {
  std::size_t body = 0;  ///< index into SceneDraft::bodies
  std::optional<MjcfGeom> first;
  std::optional<double> density_kgpm3;  ///< of the geoms so far; NaN where it is not known
  double mass_kg = 0;
  bool mass_known = true;
};

/// Where the elements of a body are.
struct MjcfFrame {
  MjcfPose pose;                        ///< in the world, or in the body that moves
  const MjcfClass* defaults = nullptr;  ///< childclass; may be null
  MjcfFreeBody* moving = nullptr;       ///< null: the world and what is fixed to it
  bool in_world = true;                 ///< directly, where a free joint may be
  bool geoms_weigh = true;              ///< no <inertial> says what the body weighs
  std::string name;
};

/// Walks the bodies. Invariant: of the bodies of the draft, `bits_` has those of the geoms.
class MjcfBodies {
 public:
  MjcfBodies(const MjcfDocument& document, const MjcfClasses& classes, const MjcfSettings& settings,
             UnmodelledKinds& unmodelled, SceneDraft& draft)
      : document_(document), classes_(classes), settings_(settings), unmodelled_(unmodelled), draft_(draft) {}

  Status walk(const MjcfNode& element, const MjcfFrame& frame) {
    for (const MjcfNode* child : document_.children(element)) {
      const std::string_view name = child->Name();
      Status read = Done{};
      if (name == "body") {
        read = read_body(*child, frame);
      } else if (name == "frame") {
        read = read_frame(*child, frame);
      } else if (name == "geom") {
        read = read_geom(*child, frame);
      } else if (name != "site" && name != "camera" && name != "light" && name != "joint" && name != "freejoint" &&
                 name != "inertial") {
        unmodelled_.add(fmt::format("{} in a body", mjcf_shown(name)), document_.line(*child));
      }
      if (!read) return read;
    }
    return Done{};
  }

  /// Gives each kind of contact bits a group of its own, so that the same pairs collide.
  void set_groups() {
    std::map<MjcfContactBits, std::uint32_t> groups;
    for (const MjcfContactBits& bits : bits_) groups.try_emplace(bits, 0U);
    if (groups.size() > 32) {
      unmodelled_.add("more than 32 kinds of contype and conaffinity", "the end");
      return;
    }
    std::uint32_t next = 1;
    for (auto& [bits, group] : groups) group = std::exchange(next, next << 1U);
    for (std::size_t i = 0; i < bits_.size(); ++i) {
      const auto& [contype, conaffinity] = bits_[i];
      std::uint32_t touched = 0;
      for (const auto& [other, group] : groups)
        if ((contype & other.second) != 0 || (other.first & conaffinity) != 0) touched |= group;
      const bool all = touched == next - 1;
      draft_.bodies[i].group = groups.size() > 1 ? groups.at(bits_[i]) : 1;
      draft_.bodies[i].collides_with = all ? 0xffffffffU : touched;
    }
  }

 private:
  Result<MjcfFrame> inside(const MjcfNode& element, const MjcfFrame& frame) {
    const MjcfView view{&document_, &element, nullptr};
    note_mjcf_attributes(view, unmodelled_);
    MjcfPose pose;
    Status read = view.numbers("pos", {pose.position_m.data(), 3});
    if (read) read = mjcf_orientation(view, settings_.angles, pose.orientation);
    if (!read) return read.error();
    MjcfFrame inner = frame;
    inner.pose = frame.pose * pose;
    if (const char* name = element.Attribute("childclass")) {
      const auto found = classes_.find(std::string_view(name));
      if (found == classes_.end()) return view.refused("childclass", "must be the class of a <default>");
      inner.defaults = &found->second;
    }
    return inner;
  }

  Status read_frame(const MjcfNode& element, const MjcfFrame& frame) {
    const Result<MjcfFrame> inner = inside(element, frame);
    if (!inner) return inner.error();
    for (const MjcfNode* child : document_.children(element)) {
      const std::string_view name = child->Name();
      if (name == "joint" || name == "freejoint" || name == "inertial")
        unmodelled_.add(fmt::format("{} in a frame", name), document_.line(*child));
    }
    return walk(element, inner.value());
  }

  Status read_body(const MjcfNode& element, const MjcfFrame& frame) {
    Result<MjcfFrame> inner = inside(element, frame);
    if (!inner) return inner.error();
    const char* name = element.Attribute("name");
    if (name != nullptr) inner.value().name = name;
    inner.value().geoms_weigh = true;
    inner.value().in_world = false;
    const Result<bool> free = has_free_joint(element, inner.value());
    if (!free) return free.error();
    if (free.value() && !frame.in_world)
      return bad_input(document_.place(element) + ": has a free joint, must be directly in <worldbody>");
    double gravcomp = 0;
    const Status floats = MjcfView{&document_, &element, nullptr}.numbers("gravcomp", {&gravcomp, 1});
    if (!floats) return floats;
    if (gravcomp != 0) unmodelled_.add("gravcomp", document_.line(element));
    if (!free.value()) {
      const Status weighed = read_inertial(element, inner.value());
      return weighed ? walk(element, inner.value()) : weighed;
    }
    MjcfFreeBody moving;
    moving.body = draft_.bodies.size();
    DraftBody& body = draft_.bodies.emplace_back();
    bits_.emplace_back();
    body.name = inner.value().name;
    body.dynamic = true;
    body.position_m = inner.value().pose.position_m;
    body.orientation = inner.value().pose.orientation;
    inner.value().pose = {};
    inner.value().moving = &moving;
    Status read = read_inertial(element, inner.value());
    if (read) read = walk(element, inner.value());
    return read ? finish(element, moving) : read;
  }

  /// Other joints are not modelled: what they hold is taken as if it were fixed.
  Result<bool> has_free_joint(const MjcfNode& element, const MjcfFrame& frame) {
    bool free = false;
    for (const MjcfNode* child : document_.children(element)) {
      const std::string_view name = child->Name();
      if (name != "joint" && name != "freejoint") continue;
      std::string_view type = "free";
      if (name == "joint") {
        const Result<const MjcfClass*> own = mjcf_class_of(document_, *child, classes_, frame.defaults);
        if (!own) return own.error();
        const MjcfView view{&document_, child, own.value()};
        const char* given = view.find("type");
        type = given != nullptr ? given : "hinge";
        const Status read = type == "free" ? note_free_joint(view) : Status(Done{});
        if (!read) return read.error();
      }
      note_mjcf_attributes({&document_, child, nullptr}, unmodelled_);
      if (type == "free") {
        free = true;
      } else {
        unmodelled_.add(fmt::format("{} joint", mjcf_shown(type)), document_.line(*child));
      }
    }
    return free;
  }

  /// What a free joint may do besides letting go.
  Status note_free_joint(const MjcfView& view) {
    for (const char* name : {"stiffness", "damping", "armature", "frictionloss"}) {
      std::array<double, 3> values{};
      std::size_t count = 0;
      const Status read = view.numbers(name, 1, values, count);
      if (!read) return read;
      if (std::ranges::any_of(values, [](double value) { return value != 0; }))
        unmodelled_.add(fmt::format("{} of a free joint", name), document_.line(*view.element));
    }
    return Done{};
  }

  Status read_inertial(const MjcfNode& element, MjcfFrame& frame) {
    if (frame.moving == nullptr || settings_.ignore_inertial) return Done{};
    for (const MjcfNode* child : document_.children(element)) {
      if (std::string_view(child->Name()) != "inertial") continue;
      const MjcfView view{&document_, child, nullptr};
      note_mjcf_attributes(view, unmodelled_);
      double mass_kg = 0;
      const Status read = view.numbers("mass", {&mass_kg, 1});
      if (!read) return read;
      if (!(mass_kg >= 0) || view.find("mass") == nullptr) return view.refused("mass", "must be at least 0");
      frame.moving->mass_kg += mass_kg;
      frame.geoms_weigh = false;
      unmodelled_.add("inertial of a free body, but for its mass", document_.line(*child));
    }
    return Done{};
  }

  Status read_geom(const MjcfNode& element, const MjcfFrame& frame) {
    const Result<const MjcfClass*> own = mjcf_class_of(document_, element, classes_, frame.defaults);
    if (!own) return own.error();
    const MjcfView view{&document_, &element, own.value()};
    MjcfGeom geom;
    const Result<bool> modelled = read_mjcf_geom(view, settings_, unmodelled_, geom);
    if (!modelled) return modelled.error();
    if (!modelled.value()) return Done{};
    const MjcfPose pose = frame.pose * MjcfPose{geom.solid.position_m, geom.solid.orientation};
    if (frame.moving != nullptr) {
      if (geom.plane) return view.refused("type", "must be in a body that does not move");
      geom.solid.position_m = pose.position_m;
      geom.solid.orientation = pose.orientation;
      add_to(*frame.moving, geom, frame.geoms_weigh, document_.line(element));
      return Done{};
    }
    if (!geom.collides()) return Done{};
    DraftBody& body = draft_.bodies.emplace_back();
    bits_.emplace_back(geom.contype, geom.conaffinity);
    body.name = geom.name.empty() ? frame.name : geom.name;
    body.position_m = pose.position_m;
    body.orientation = pose.orientation;
    body.friction = geom.friction;
    geom.solid.position_m.setZero();
    geom.solid.orientation.setIdentity();
    if (!geom.plane) body.solids.push_back(geom.solid);
    return Done{};
  }

  void add_to(MjcfFreeBody& moving, const MjcfGeom& geom, bool weighs, const std::string& line) {
    const double mass_kg = geom.known_mass_kg();
    if (!geom.collides()) {
      if (weighs && (mass_kg > 0 || (mass_kg < 0 && geom.density_kgpm3 > 0)))
        unmodelled_.add("mass of a geom that collides with nothing", line);
      return;
    }
    DraftBody& body = draft_.bodies[moving.body];
    body.solids.push_back(geom.solid);
    if (weighs) weigh(moving, geom, mass_kg, line);
    if (!moving.first) {
      moving.first = geom;
      body.friction = geom.friction;
      bits_[moving.body] = {geom.contype, geom.conaffinity};
      return;
    }
    if (geom.friction != moving.first->friction) unmodelled_.add("other friction in the same free body", line);
    if (geom.contype != moving.first->contype || geom.conaffinity != moving.first->conaffinity)
      unmodelled_.add("other contype or conaffinity in the same free body", line);
  }

  void weigh(MjcfFreeBody& moving, const MjcfGeom& geom, double mass_kg, const std::string& line) {
    const bool mesh = geom.solid.kind == SolidKind::Mesh;
    const double density = !mesh         ? mass_kg / volume_of(geom.solid)
                           : mass_kg < 0 ? geom.density_kgpm3
                                         : std::numeric_limits<double>::quiet_NaN();
    // Of those of a body the first that says something counts, if any does.
    const bool first = !moving.density_kgpm3;
    const bool told = moving.density_kgpm3 && *moving.density_kgpm3 > 0;
    if (!first && !(std::abs(density - *moving.density_kgpm3) <= 1e-6 * *moving.density_kgpm3))
      unmodelled_.add("other density in the same free body", line);
    if (first || !told) moving.density_kgpm3 = density;
    if (mass_kg < 0) moving.mass_known = false;
    if (mass_kg > 0) moving.mass_kg += mass_kg;
  }

  Status finish(const MjcfNode& element, const MjcfFreeBody& moving) {
    DraftBody& body = draft_.bodies[moving.body];
    if (body.solids.empty()) {
      unmodelled_.add("free body without a shape", document_.line(element));
      draft_.bodies.pop_back();
      bits_.pop_back();
      return Done{};
    }
    if (moving.mass_known) body.mass_kg = moving.mass_kg;
    if (!moving.mass_known) body.density_kgpm3 = moving.density_kgpm3.value_or(1000);
    if (std::isnan(body.density_kgpm3)) body.density_kgpm3 = 1000;
    if ((moving.mass_known && !(body.mass_kg > 0)) || !(body.density_kgpm3 > 0))
      return bad_input(document_.place(element) + ": moves, must have a mass above 0");
    return Done{};
  }

  const MjcfDocument& document_;
  const MjcfClasses& classes_;
  const MjcfSettings& settings_;
  UnmodelledKinds& unmodelled_;
  SceneDraft& draft_;
  std::vector<MjcfContactBits> bits_;  ///< beside draft_.bodies
};

}  // namespace

Result<const MjcfClass*> mjcf_class_of(const MjcfDocument& document, const MjcfDocument::Element& element,
                                       const MjcfClasses& classes, const MjcfClass* otherwise) {
  const char* name = element.Attribute("class");
  if (name == nullptr) return otherwise != nullptr ? otherwise : &classes.at("main");
  const auto found = classes.find(std::string_view(name));
  if (found != classes.end()) return &found->second;
  return MjcfView{&document, &element, nullptr}.refused("class", "must be the class of a <default>");
}

Status read_mjcf_bodies(const MjcfDocument& document, const MjcfClasses& classes, const MjcfSettings& settings,
                        UnmodelledKinds& unmodelled, SceneDraft& draft) {
  MjcfBodies bodies(document, classes, settings, unmodelled, draft);
  for (const MjcfNode* section : document.children(document.root())) {
    if (std::string_view(section->Name()) != "worldbody") continue;
    const Status read = bodies.walk(*section, {});
    if (!read) return read;
  }
  bodies.set_groups();
  return Done{};
}

}  // namespace poise::io
