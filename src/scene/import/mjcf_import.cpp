// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/import/mjcf_attributes.h"
#include "scene/import/mjcf_bodies.h"
#include "scene/import/mjcf_document.h"
#include "scene/import/mjcf_geom.h"
#include "scene/import/mjcf_values.h"

namespace poise::io {
namespace {

using MjcfNode = MjcfDocument::Element;

constexpr std::size_t kMostNamedKinds = 20;

bool says(const MjcfNode& element, const char* attribute, std::string_view value) {
  const char* text = element.Attribute(attribute);
  return text != nullptr && value == text;
}

Status read_compiler(const MjcfDocument& document, const MjcfNode& element, MjcfSettings& settings,
                     UnmodelledKinds& unmodelled) {
  const MjcfView view{&document, &element, nullptr};
  note_mjcf_attributes(view, unmodelled);
  if (const char* angle = element.Attribute("angle")) {
    settings.angles.degrees = std::string_view(angle) == "degree";
    if (!settings.angles.degrees && std::string_view(angle) != "radian")
      return view.refused("angle", "must be degree or radian");
  }
  if (const char* sequence = element.Attribute("eulerseq")) {
    settings.angles.sequence = sequence;
    if (settings.angles.sequence.size() != 3 ||
        settings.angles.sequence.find_first_not_of("xyzXYZ") != std::string::npos)
      return view.refused("eulerseq", "must be three letters of x, y, z, X, Y and Z");
  }
  // meshdir goes before assetdir, which is for pictures too.
  for (const char* folder : {"assetdir", "meshdir"})
    if (const char* named = element.Attribute(folder)) settings.mesh_folder = settings.folder / named;
  // What is said last counts.
  if (element.Attribute("strippath") != nullptr) settings.file_names_only = says(element, "strippath", "true");
  if (element.Attribute("inertiafromgeom") != nullptr)
    settings.ignore_inertial = says(element, "inertiafromgeom", "true");
  double total = -1;
  const Status read = view.numbers("settotalmass", {&total, 1});
  if (read && total > 0) unmodelled.add("settotalmass", document.line(element));
  return read;
}

Status read_option(const MjcfDocument& document, const MjcfNode& element, SceneDraft& draft, bool& weightless,
                   UnmodelledKinds& unmodelled) {
  const MjcfView view{&document, &element, nullptr};
  note_mjcf_attributes(view, unmodelled);
  Status read = view.numbers("timestep", {&draft.dt_s, 1});
  if (read && !(draft.dt_s > 0 && draft.dt_s <= 1)) read = view.refused("timestep", "must be above 0 and at most 1");
  if (read) read = view.numbers("gravity", {draft.gravity_mps2.data(), 3});
  Vec3 wind = Vec3::Zero();
  double density = 0;
  double viscosity = 0;
  if (read) read = view.numbers("wind", {wind.data(), 3});
  if (read) read = view.numbers("density", {&density, 1});
  if (read) read = view.numbers("viscosity", {&viscosity, 1});
  if (!read) return read;
  if (!wind.isZero(0) || density != 0 || viscosity != 0) unmodelled.add("air or liquid", document.line(element));
  for (const MjcfNode* flag : document.children(element)) {
    if (flag->Attribute("gravity") != nullptr) weightless = says(*flag, "gravity", "disable");
    if (says(*flag, "override", "enable")) unmodelled.add("overridden contacts", document.line(*flag));
    if (says(*flag, "contact", "disable") || says(*flag, "constraint", "disable"))
      unmodelled.add("contacts switched off", document.line(*flag));
  }
  return Done{};
}

/// What a section of the model is for.
enum class MjcfSection { Read, Unneeded, Unmodelled };

MjcfSection section_of(std::string_view name) {
  constexpr std::array<std::string_view, 5> kRead{"compiler", "option", "default", "asset", "worldbody"};
  constexpr std::array<std::string_view, 6> kUnneeded{"size", "visual", "statistic", "custom", "sensor", "keyframe"};
  if (std::ranges::find(kRead, name) != kRead.end()) return MjcfSection::Read;
  return std::ranges::find(kUnneeded, name) != kUnneeded.end() ? MjcfSection::Unneeded : MjcfSection::Unmodelled;
}

Status read_asset(const MjcfView& view, MjcfSettings& settings, UnmodelledKinds& unmodelled, SceneDraft& draft) {
  const std::string_view name = view.element->Name();
  if (name == "mesh") return read_mjcf_mesh(view, settings, unmodelled, draft);
  // Pictures and skins are not felt, and a height field only where a geom uses it.
  const bool seen_only = name == "texture" || name == "material" || name == "skin" || name == "hfield";
  if (!seen_only) unmodelled.add("asset/" + mjcf_shown(name), view.document->line(*view.element));
  return Done{};
}

/// What must be known before the first body is read, and what there is besides bodies.
Status read_sections(const MjcfDocument& document, const MjcfClasses& classes, MjcfSettings& settings,
                     UnmodelledKinds& unmodelled, SceneDraft& draft) {
  const auto sections = document.children(document.root());
  bool weightless = false;
  for (const MjcfNode* section : sections) {
    const std::string_view name = section->Name();
    Status read = Done{};
    if (name == "compiler") read = read_compiler(document, *section, settings, unmodelled);
    if (name == "option") read = read_option(document, *section, draft, weightless, unmodelled);
    if (!read) return read;
    if (section_of(name) != MjcfSection::Unmodelled) continue;
    const auto parts = document.children(*section);
    for (const MjcfNode* part : parts)
      unmodelled.add(fmt::format("{}/{}", mjcf_shown(name), mjcf_shown(part->Name())), document.line(*part));
    if (parts.empty() && section->FirstAttribute() != nullptr)
      unmodelled.add(mjcf_shown(name), document.line(*section));
  }
  if (weightless) draft.gravity_mps2 = Vec3::Zero();
  for (const MjcfNode* section : sections) {
    if (std::string_view(section->Name()) != "asset") continue;
    for (const MjcfNode* asset : document.children(*section)) {
      const Result<const MjcfClass*> own = mjcf_class_of(document, *asset, classes, nullptr);
      if (!own) return own.error();
      const Status read = read_asset({&document, asset, own.value()}, settings, unmodelled, draft);
      if (!read) return read;
    }
  }
  return Done{};
}

}  // namespace

void UnmodelledKinds::add(const std::string& kind, const std::string& line) {
  const auto [entry, added] = kinds_.try_emplace(kind, Seen{0, kinds_.size(), line});
  ++entry->second.count;
}

std::string UnmodelledKinds::text() const {
  std::vector<const std::pair<const std::string, Seen>*> ordered(kinds_.size());
  for (const auto& kind : kinds_) ordered[kind.second.order] = &kind;
  std::string text;
  for (std::size_t i = 0; i < ordered.size() && i < kMostNamedKinds; ++i) {
    const auto& [kind, seen] = *ordered[i];
    text += fmt::format("{}{} ({})", i > 0 ? ", " : "", kind,
                        seen.count > 1 ? fmt::format("{}, first at {}", seen.count, seen.line) : "at " + seen.line);
  }
  if (ordered.size() > kMostNamedKinds) text += fmt::format(" and {} kinds more", ordered.size() - kMostNamedKinds);
  return text;
}

Result<SceneDraft> import_mjcf(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                               bool skip_unmodelled) {
  const Result<MjcfDocument> opened = MjcfDocument::open(text, name, folder);
  if (!opened) return opened.error();
  const MjcfDocument& document = opened.value();
  const Result<MjcfClasses> classes = mjcf_classes(document);
  if (!classes) return classes.error();
  SceneDraft draft;
  draft.dt_s = 0.002;  // of MuJoCo, where the model says nothing
  const char* model = document.root().Attribute("model");
  draft.name = model != nullptr && *model != '\0' ? model : "MuJoCo model";
  MjcfSettings settings;
  settings.folder = settings.mesh_folder = folder;
  UnmodelledKinds unmodelled;
  Status read = read_sections(document, classes.value(), settings, unmodelled, draft);
  if (read) read = read_mjcf_bodies(document, classes.value(), settings, unmodelled, draft);
  if (!read) return read.error();
  if (unmodelled.empty()) return draft;
  const std::string what = fmt::format("{}: not modelled: {}", name, unmodelled.text());
  if (!skip_unmodelled) return bad_input(what + "; --skip-unmodelled leaves this out");
  draft.warnings.push_back(what);
  return draft;
}

}  // namespace poise::io
