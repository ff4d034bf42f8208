// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "assets/files/text_words.h"
#include "assets/tree/tree_files.h"

namespace poise::io {
namespace {

// The attributes of an element (MuJoCo's documentation, "XML reference"), each between blanks.
struct KnownAttributes {
  std::string_view element;
  std::string_view names;
};
constexpr std::string_view kTurns = " quat axisangle xyaxes zaxis euler ";
constexpr std::array kKnown{
    KnownAttributes{"body", " name childclass pos mocap gravcomp user sleep "},
    KnownAttributes{"frame", " name childclass pos "},
    KnownAttributes{"inertial", " pos mass diaginertia fullinertia "},
    KnownAttributes{"freejoint", " name group align "},
    KnownAttributes{"joint",
                    " name class type group pos axis springdamper limited actuatorfrclimited actuatorgravcomp "
                    "solreflimit solimplimit solreffriction solimpfriction stiffness range actuatorfrcrange margin ref "
                    "springref armature damping frictionloss user "},
    KnownAttributes{"geom",
                    " name class type contype conaffinity condim group priority size material friction mass density "
                    "shellinertia solmix solref solimp margin gap fromto pos hfield mesh fitscale rgba fluidshape "
                    "fluidcoef user "},
    KnownAttributes{"mesh",
                    " name class content_type file vertex normal texcoord face refpos refquat scale smoothnormal "
                    "maxhullvert inertia builtin params material "},
    KnownAttributes{
        "compiler",
        " autolimits boundmass boundinertia settotalmass balanceinertia strippath coordinate angle fitaabb "
        "eulerseq meshdir texturedir assetdir discardvisual convexhull usethread fusestatic inertiafromgeom "
        "exactmeshinertia inertiagrouprange alignfree saveinertial "},
    KnownAttributes{"option",
                    " timestep apirate impratio tolerance ls_tolerance noslip_tolerance mpr_tolerance ccd_tolerance "
                    "sleep_tolerance gravity wind magnetic density viscosity o_margin o_solref o_solimp o_friction "
                    "integrator collision cone jacobian solver iterations ls_iterations noslip_iterations "
                    "mpr_iterations ccd_iterations sdf_iterations sdf_initpoints actuatorgroupdisable "},
};

// What changes motion in MuJoCo and not here, unless it says what it would say by itself.
struct IdleAttribute {
  std::string_view element, name, neutral;
};
constexpr std::array kIdle{
    IdleAttribute{"geom", "shellinertia", "false"},     IdleAttribute{"mesh", "inertia", "legacy exact"},
    IdleAttribute{"compiler", "boundmass", "0"},        IdleAttribute{"compiler", "boundinertia", "0"},
    IdleAttribute{"compiler", "inertiagrouprange", ""}, IdleAttribute{"compiler", "coordinate", "local"},
};

bool has_word(std::string_view words, std::string_view word) {
  const std::vector<std::string_view> all = geometry::words_of(words);
  return std::ranges::find(all, word) != all.end();
}

bool is_zero(std::string_view text) {
  double number = 1;
  return geometry::read_number(text, number) && number == 0;
}

}  // namespace

void note_mjcf_attributes(const MjcfView& view, UnmodelledKinds& unmodelled) {
  const std::string_view element = view.element->Name();
  const auto known = std::ranges::find(kKnown, element, &KnownAttributes::element);
  if (known == kKnown.end()) return;
  const bool turns =
      element != "joint" && element != "freejoint" && element != "mesh" && element != "compiler" && element != "option";
  for (auto* given = view.element->FirstAttribute(); given != nullptr; given = given->Next()) {
    if (has_word(known->names, given->Name()) || (turns && has_word(kTurns, given->Name()))) continue;
    unmodelled.add(fmt::format("unknown attribute {} of <{}>", mjcf_shown(given->Name()), element),
                   view.document->line(*view.element));
  }
  for (const IdleAttribute& idle : kIdle) {
    if (idle.element != element) continue;
    const char* text = view.find(idle.name);
    if (text == nullptr || has_word(idle.neutral, text) || (idle.neutral == "0" && is_zero(text))) continue;
    unmodelled.add(fmt::format("{} of <{}>", idle.name, element), view.document->line(*view.element));
  }
}

}  // namespace poise::io
