// SPDX-License-Identifier: MIT
#include "architecture/old_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

namespace poise::tests {
namespace {

/// How a word is compared with an old word.
enum class Match : unsigned char {
  Word,   ///< equal
  Begin,  ///< begins with it
  Any,    ///< contains it
};

struct OldWord {
  std::string_view word;
  Match match;
  std::string_view instead;
};

/// Only words without another meaning in this project: "place", "patch" and "visit" have others.
constexpr std::array kOldWords{
    OldWord{"RestPlace", Match::Any, "ContactPoint"},
    OldWord{"RestLoad", Match::Any, "ContactForce"},
    OldWord{"RestPair", Match::Any, "Manifold"},
    OldWord{"RestSystem", Match::Any, "ContactSystem"},
    OldWord{"RestSolver", Match::Any, "ContactSolver"},
    OldWord{"RestBlock", Match::Any, "ContactBlock"},
    OldWord{"PatchSet", Match::Any, "ManifoldPoints"},
    OldWord{"PatchClusters", Match::Any, "ManifoldClusters"},
    OldWord{"PolygonPatches", Match::Any, "PolygonPoints"},
    OldWord{"PlaceStore", Match::Any, "ContactCache"},
    OldWord{"PlaceList", Match::Any, "PointList"},
    OldWord{"PairMemory", Match::Any, "CachedPair"},
    OldWord{"KeptPlace", Match::Any, "CachedPoint"},
    OldWord{"KeptCandidates", Match::Any, "CandidateCache"},
    OldWord{"Glance", Match::Begin, "BodyBounds"},
    OldWord{"glance", Match::Begin, "body_bounds"},
    OldWord{"Outline", Match::Begin, "ActivePair"},
    OldWord{"Mover", Match::Word, "MovingBody"},
    OldWord{"mover", Match::Begin, "moving body"},
    OldWord{"Meeting", Match::Begin, "TimeOfImpact"},
    OldWord{"Sight", Match::Word, "ViewQuery"},
    OldWord{"PairSighting", Match::Any, "PairView"},
    OldWord{"rouse", Match::Any, "wake"},
    OldWord{"stir", Match::Word, "wake"},
    OldWord{"stirred", Match::Word, "woken"},
    OldWord{"bore", Match::Word, "accumulated impulse"},
    OldWord{"rub", Match::Word, "friction"},
    OldWord{"rubs", Match::Word, "friction"},
    OldWord{"surely_m", Match::Any, "certain_separation_m"},
    OldWord{"likely_m", Match::Any, "estimated_separation_m"},
    OldWord{"given_ns", Match::Any, "applied_impulse_ns"},
    OldWord{"kept_", Match::Begin, "cached_"},
    OldWord{"lone_", Match::Begin, "single_ or impact_"},
    OldWord{"yields_", Match::Begin, "dynamic_"},
    OldWord{"newton_s", Match::Any, "reduced_mass"},
    OldWord{"gyration", Match::Any, "inverse inertia"},
    OldWord{"Gyration", Match::Any, "ScaledInverseInertia"},
    OldWord{"RowGate", Match::Any, "RowActivation"},
    OldWord{"astray", Match::Word, "diverged"},
    OldWord{"verdict", Match::Any, "report"},
    OldWord{"Verdict", Match::Any, "MeshReport"},
    OldWord{"judge", Match::Begin, "measure, oracle"},
    OldWord{"judging", Match::Begin, "measuring"},
    OldWord{"Judge", Match::Begin, "Oracle"},
    OldWord{"patch_visits", Match::Any, "point_iterations"},
    OldWord{"jobs_dropped", Match::Any, "jobs_discarded"},
    OldWord{"pairs_dropped", Match::Any, "pairs_discarded"},
    OldWord{"given_up", Match::Any, "abandoned"},
    OldWord{"GivenUp", Match::Any, "Abandoned"},
    OldWord{"max_sweeps", Match::Any, "max_iterations"},
    OldWord{"lay_out", Match::Any, "find, list or reserve"},
    OldWord{"given up", Match::Word, "abandoned"},
    OldWord{"gave up", Match::Word, "abandoned"},
    OldWord{"lay out", Match::Word, "arrange"},
    OldWord{"lays out", Match::Word, "arrange"},
    OldWord{"laid out", Match::Word, "arranged"},
    OldWord{"beyond doubt", Match::Word, "certain"},
};

/// The table old -> new and this test itself.
constexpr std::array<std::string_view, 2> kExempt{"CHANGELOG.md", "tests/architecture/"};

/// Scene data and pictures are not searched.
constexpr std::array<std::string_view, 10> kEndings{".h",     ".cpp", ".md", ".json", ".txt",
                                                    ".cmake", ".sh",  ".py", ".js",   ".html"};

bool is_part_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool is_at(std::string_view line, std::size_t at, const OldWord& old) {
  const std::size_t end = at + old.word.size();
  const bool begins = at == 0 || !is_part_of_word(line[at - 1]);
  const bool ends = end == line.size() || !is_part_of_word(line[end]);
  return old.match == Match::Any || (begins && (old.match == Match::Begin || ends));
}

bool uses(std::string_view line, const OldWord& old) {
  for (std::size_t at = line.find(old.word); at != std::string_view::npos; at = line.find(old.word, at + 1)) {
    if (is_at(line, at, old)) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> old_words(std::string_view path, std::string_view text) {
  const auto begins = [path](std::string_view folder) { return path.starts_with(folder); };
  const auto ends = [path](std::string_view ending) { return path.ends_with(ending); };
  std::vector<std::string> found;
  if (std::ranges::any_of(kExempt, begins)) return found;
  if (std::ranges::none_of(kEndings, ends)) return found;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    for (const OldWord& old : kOldWords) {
      if (!uses(line, old)) continue;
      found.push_back(std::string(path) + ":" + std::to_string(number) + ": \"" + std::string(old.word) +
                      "\" is an old word for " + std::string(old.instead));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return found;
}

}  // namespace poise::tests
