// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "poise/world.h"

namespace poise::simulation {

/// A contact model and the word for it on the command line and in documents.
struct NamedContactModel {
  std::string_view name;
  ContactModel model;
};

/// All of them, in the order of tables.
inline constexpr std::array kContactModels = {NamedContactModel{"paper", ContactModel::Paper},
                                              NamedContactModel{"wrench", ContactModel::Wrench},
                                              NamedContactModel{"fitted", ContactModel::Fitted}};

}  // namespace poise::simulation
