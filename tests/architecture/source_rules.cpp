// SPDX-License-Identifier: MIT
#include "architecture/source_rules.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <optional>
#include <regex>

#include "architecture/libm_rule.h"

namespace poise::tests {
namespace {

constexpr std::size_t kMaxLines = 500;
constexpr std::size_t kMaxFunctionLines = 80;

struct Room {
  std::string_view place;  // a file, or a folder with its last slash
  int rank;                // a file may include its own room, and lower ranks
  std::string_view name;
};

// The first match counts.
constexpr std::array kRooms{
    Room{"scheduler/", 1, "scheduler"},
    Room{"include/poise/scheduler/", 1, "scheduler"},
    Room{"include/poise/result.h", 0, "values"},
    Room{"include/poise/types.h", 0, "values"},
    Room{"include/poise/reference.h", 0, "values"},
    Room{"include/poise/trace.h", 0, "values"},
    Room{"include/poise/executor.h", 0, "values"},
    Room{"include/poise/time_arithmetic.h", 0, "values"},
    Room{"include/poise/queries.h", 0, "values"},
    Room{"src/math/", 0, "math"},
    Room{"src/parallel/", 1, "parallel"},
    Room{"include/poise/mesh.h", 2, "geometry"},
    Room{"include/poise/shape.h", 2, "geometry"},
    Room{"include/poise/sphere_tree.h", 2, "geometry"},
    Room{"src/geometry/", 2, "geometry"},
    Room{"include/poise/assets/", 11, "assets"},
    Room{"src/assets/", 11, "assets"},
    Room{"include/poise/scene/", 13, "scene"},
    Room{"src/scene/", 13, "scene"},
    Room{"src/record/", 14, "record"},
    Room{"include/poise/", 3, "interface"},
    Room{"src/dynamics/", 3, "dynamics"},
    Room{"src/collision/", 4, "collision"},
    Room{"src/solver/", 5, "solver"},
    Room{"src/query/", 5, "query"},
    Room{"src/world/", 6, "world"},
    Room{"src/frame/", 7, "frame"},
    Room{"src/verify/", 8, "verify"},
    Room{"src/api/", 9, "api"},
    Room{"src/sweep/", 14, "sweep"},
    Room{"src/capture/", 15, "capture"},
    Room{"src/app/", 16, "app"},
    Room{"bench/", 17, "bench"},
    Room{"examples/", 17, "examples"},
    Room{"python/", 17, "python"},
};

// <stop_token> is not in the list: a std::stop_token is a handle that public options hold and long work polls.
// Requesting a stop concerns threads, so stop sources and callbacks belong to src/parallel.
constexpr std::array<std::string_view, 15> kThreadHeaders{
    "atomic", "barrier",   "condition_variable", "execution",   "future",
    "latch",  "mutex",     "semaphore",          "semaphore.h", "shared_mutex",
    "thread", "pthread.h", "stdatomic.h",        "threads.h",   "omp.h"};

const Room* room_of(std::string_view path) {
  const auto* room = std::ranges::find_if(kRooms, [&](const Room& r) { return path.starts_with(r.place); });
  return room == kRooms.end() ? nullptr : room;
}

/// The path in the repository of an include in quotes; includes are relative to src/, include/ and bench/.
std::string included_path(std::string_view include) {
  constexpr std::array<std::string_view, 4> kBenchFolders{"studies/", "oracle/", "accuracy/", "peers/"};
  const bool is_bench =
      std::ranges::any_of(kBenchFolders, [&](std::string_view folder) { return include.starts_with(folder); });
  const std::string_view folder = is_bench ? "bench/" : include.starts_with("poise/") ? "include/" : "src/";
  return std::string(folder).append(include);
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

bool found(const std::regex& pattern, std::string_view line) {
  return std::regex_search(line.begin(), line.end(), pattern);
}

bool is_thread_header(std::string_view name) {
  return name.starts_with("tbb/") || name.starts_with("oneapi/") ||
         std::ranges::find(kThreadHeaders, name) != kThreadHeaders.end();
}

/// Benchmarks and examples are separate programs.
bool may_use_threads(const Room& room) {
  return room.name == "parallel" || room.name == "bench" || room.name == "examples";
}

std::optional<std::string> wrong_include(const Room& room, bool is_public, char quote, std::string_view name) {
  const bool stops = name == "stop_token" && room.name == "scheduler";
  // The host's threads share the scheduler's queue, so this room may use <atomic>, but nothing that waits.
  const bool atomics = name == "atomic" && room.name == "scheduler";
  if ((is_thread_header(name) && !may_use_threads(room) && !atomics) || stops)
    return "threads, locks and atomics belong to src/parallel";
  if (quote == '<') {
    if (room.name == "scheduler" && name.find_first_of("./") != std::string_view::npos) {
      return "the scheduler may use the standard library alone";
    }
    return std::nullopt;
  }
  if (room.name == "scheduler" && !name.starts_with("poise/scheduler/") && !(name.starts_with("math/") && !is_public)) {
    return "the scheduler may include its own headers and src/math alone";
  }
  const std::string path = included_path(name);
  if (is_public && !name.starts_with("poise/")) return "a public header may include public ones alone";
  const Room* other = room_of(path);
  if (other == nullptr) return std::nullopt;  // generated, or in the same folder as the file
  const bool sibling = other->rank == room.rank && other->name != room.name && room.rank == 1;
  if (other->rank > room.rank || sibling) {
    return "room " + std::string(room.name) + " may not include " + std::string(other->name);
  }
  return std::nullopt;
}

/// Rules on the code of a room, except includes.
std::optional<std::string> wrong_code(const Room& room, std::string_view path, std::string_view code) {
  static const std::regex threads(
      R"(\bstd::(atomic|jthread|thread|mutex|shared_mutex|condition_variable|async|stop_source|stop_callback)\b)");
  static const std::regex clocks(R"(\w*[cC]lock::now\b|\b(clock_gettime|gettimeofday|__rdtscp?)\s*\()");
  static const std::regex prints(
      R"(\bstd::(cout|cerr|clog|terminate|abort|exit|quick_exit)\b|\b(printf|fprintf|puts|abort|exit)\s*\(|\bfmt::print\b)");
  const bool stops = room.name == "scheduler" && code.find("std::stop_token") != std::string_view::npos;
  static const std::regex waits(
      R"(\bstd::(jthread|thread|this_thread|mutex|shared_mutex|condition_variable|async|stop_source|stop_callback)\b|\.(wait|notify_one|notify_all)\()");
  const bool wrong = room.name == "scheduler" ? found(waits, code) : !may_use_threads(room) && found(threads, code);
  if (wrong || stops) return "threads, locks and atomics belong to src/parallel";
  const bool is_program = room.name == "app" || room.name == "bench" || room.name == "examples";
  const bool may_read_clock = room.name == "parallel" || room.name == "frame" || room.name == "verify" ||
                              room.name == "api" || room.name == "scene" || is_program ||
                              path == "include/poise/step.h";
  if (!may_read_clock && found(clocks, code))
    return "time is an argument; only parallel, frame, verify and programs read a clock";
  if (!is_program && found(prints, code)) return "the library neither prints nor ends the program";
  static const std::regex throws(R"(\bfmt::print\(\s*stderr\b)");
  if (room.name == "app" && found(throws, code))
    return "print_error prints: fmt::print throws where the standard error takes nothing";
  static const std::regex opens(R"(\b(O_RDONLY|O_RDWR)\b|\bfopen\s*\()");
  // part_file.cpp opens to lock, and reads nothing.
  const bool may_open = path == "src/assets/files/open_file.cpp" || path == "src/assets/files/part_file.cpp";
  if (!is_program && !may_open && found(opens, code))
    return "src/assets/files/open_file.cpp opens what is read, so that no pipe is waited for";
  static const std::regex prefetches(R"(^\s*(template\s*<.*>\s*)?(inline\s+|static\s+)*void prefetch\w*\()");
  if (found(prefetches, code)) return "what only prefetches is HWY_INLINE: GCC leaves out calls of it";
  return std::nullopt;
}

/// Rules on any text: it must not name paths of the machine it was written on, or mirrors of package registries.
std::optional<std::string> wrong_text(std::string_view raw) {
  // Composed of parts, so that this file obeys its own rule.
  static const std::regex machine_path(
      "(^|[^A-Za-z0-9_.}/*-])/(home|wo"
      "rk|root|Us"
      "ers|tm"
      "p)/[A-Za-z0-9_.]");
  static const std::regex registry(
      "registry\\.npm"
      "js|py"
      "pi\\.org|crat"
      "es\\.io|deb\\.deb"
      "ian\\.org|pythonhos"
      "ted|conan\\."
      "io|ghcr\\."
      "io");
  if (found(machine_path, raw)) return "no path of one machine";
  if (found(registry, raw)) return "no host of a package registry";
  return std::nullopt;
}

bool is_code(std::string_view path) { return path.ends_with(".h") || path.ends_with(".cpp"); }

bool has_line_limit(std::string_view path) {
  constexpr std::array<std::string_view, 9> kEndings{".h",  ".cpp", ".cmake", "CMakeLists.txt", ".sh", ".py",
                                                     ".js", ".mjs", ".ts"};
  return std::ranges::any_of(kEndings, [&](std::string_view ending) { return path.ends_with(ending); });
}

}  // namespace

std::optional<RoomInOrder> room_in_order(std::string_view path) {
  const Room* room = room_of(path);
  if (room == nullptr) return std::nullopt;
  return RoomInOrder{room->name, room->rank};
}

std::string code_only(std::string_view text) {
  std::string code(text);
  std::size_t at = 0;
  const auto blank_up_to = [&](std::size_t end) {
    for (end = std::min(end, code.size()); at < end; ++at) {
      if (code[at] != '\n') code[at] = ' ';
    }
  };
  const auto after = [&](std::string_view closing, std::size_t from) {
    const std::size_t found_at = text.find(closing, from);
    return found_at == std::string_view::npos ? text.size() : found_at + closing.size();
  };
  while (at < text.size()) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("//")) {
      blank_up_to(std::min(text.find('\n', at), text.size()));
    } else if (rest.starts_with("/*")) {
      blank_up_to(after("*/", at + 2));
    } else if (rest.starts_with("R\"")) {
      const std::size_t open = text.find('(', at);
      const std::string closing = ")" + std::string(text.substr(at + 2, open - at - 2)) + "\"";
      blank_up_to(after(closing, at));
    } else if (rest[0] == '"' ||
               (rest[0] == '\'' && !(at > 0 && std::isxdigit(static_cast<unsigned char>(text[at - 1])) != 0))) {
      std::size_t end = at + 1;
      while (end < text.size() && text[end] != rest[0] && text[end] != '\n') end += text[end] == '\\' ? 2U : 1U;
      blank_up_to(end + 1);
    } else {
      ++at;
    }
  }
  return code;
}

std::vector<LongFunction> long_functions(std::string_view code) {
  static const std::regex type(R"(^\s*(template\b[^;]*>\s*)?(namespace|struct|class|enum|union|extern)\b)");
  struct Open {
    std::size_t line = 0;
    bool is_function = false;
  };
  std::vector<Open> open;
  std::vector<LongFunction> found_long;
  std::string head;  // the text between the last `;`, `{` or `}` and here
  std::size_t line = 1;
  for (const char c : code) {
    if (c == '\n') ++line;
    if (c == '{') {
      open.push_back({line, head.find(')') != std::string::npos && !std::regex_search(head, type)});
    } else if (c == '}' && !open.empty()) {
      const std::size_t lines = line - open.back().line + 1;
      if (open.back().is_function && lines > kMaxFunctionLines) found_long.push_back({open.back().line, lines});
      open.pop_back();
    }
    if (c == '{' || c == '}' || c == ';') {
      head.clear();
    } else {
      head += c;
    }
  }
  return found_long;
}

std::vector<std::string> broken_rules(std::string_view path, std::string_view text) {
  static const std::regex include(R"(^\s*#\s*include\s*([<"])([^">]+)[">])");
  std::vector<std::string> broken;
  const auto report = [&](std::size_t line, std::string_view raw, const std::string& rule) {
    broken.push_back(std::string(path) + ":" + std::to_string(line) + ": " + std::string(raw) + " (" + rule + ")");
  };
  const std::vector<std::string_view> raw = lines_of(text);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (const auto rule = wrong_text(raw[i])) report(i + 1, raw[i], *rule);
  }
  if (has_line_limit(path) && raw.size() > kMaxLines) {
    report(raw.size(), "too long", "at most " + std::to_string(kMaxLines) + " lines a file");
  }
  if (!is_code(path)) return broken;
  if (raw.empty() || raw[0] != "// SPDX-License-Identifier: MIT") {
    report(1, raw.empty() ? "" : raw[0], "the first line names the licence");
  }
  const Room* room = room_of(path);
  if (room == nullptr) return broken;
  const bool is_public = path.starts_with("include/");
  const std::string stripped = code_only(text);
  const std::vector<std::string_view> code = lines_of(stripped);
  for (const LongFunction& function : long_functions(stripped)) {
    report(function.line, std::to_string(function.lines) + " lines",
           "at most " + std::to_string(kMaxFunctionLines) + " lines a function");
  }
  for (std::size_t i = 0; i < raw.size(); ++i) {
    std::match_results<std::string_view::const_iterator> match;
    if (std::regex_search(raw[i].begin(), raw[i].end(), match, include)) {
      if (const auto rule = wrong_include(*room, is_public, *match[1].first, match[2].str()))
        report(i + 1, raw[i], *rule);
    } else if (const auto rule_of_code = wrong_code(*room, path, code[i])) {
      report(i + 1, raw[i], *rule_of_code);
    } else if (const auto rule_of_state = depends_on_libm(room->name, path, code[i])) {
      report(i + 1, raw[i], *rule_of_state);
    }
  }
  return broken;
}

}  // namespace poise::tests
