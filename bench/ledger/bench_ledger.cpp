// SPDX-License-Identifier: MIT
// The cost ledger: instructions of a frame and of a unit of work, compared with bench/ledger.json.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "build_info.h"
#include "ledger/callgrind_switch.h"
#include "ledger/ledger_file.h"
#include "ledger/unit_costs.h"
#include "ledger/workload.h"

extern char** environ;

namespace poise::ledger {
namespace {

constexpr int kExitOutside = 1;
constexpr int kExitBadUsage = 2;
constexpr int kExitBadInput = 3;
constexpr int kExitSkipped = 77;

struct Options {
  std::string ledger = std::string(POISE_SOURCE_DIR) + "/bench/ledger.json";
  std::string update;  // the reason; empty: compare
  std::vector<std::string> only;
  std::string profiles;  // a folder for callgrind's files
  std::string count;     // the workload to run here
  std::string into;      // where its units are written
};

int fail(const std::string& message, int exit_code) {
  fmt::print(stderr, "bench_ledger: {}\n", message);
  return exit_code;
}

/// Runs a program and waits for it. Returns its exit status, or nothing if it cannot be started.
std::optional<int> run_program(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = -1;
  if (::posix_spawnp(&child, argv[0], nullptr, nullptr, argv.data(), environ) != 0) return std::nullopt;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return std::nullopt;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Valgrind's version, or nothing if it cannot be run.
std::string valgrind_version(const std::filesystem::path& folder) {
  const std::string file = (folder / "version").string();
  if (run_program({"sh", "-c", "valgrind --version >\"$0\" 2>&1", file}) != 0) return {};
  const std::string text = read_text(file);
  return text.substr(0, text.find('\n'));
}

/// The work of a child process: runs one workload and writes its units as JSON.
int count_here(const Options& o) {
  const auto workload = std::ranges::find(workloads(), o.count, &Workload::name);
  if (workload == workloads().end()) return fail(o.count + ": no such entry", kExitBadUsage);
  const Result<CountedUnits> units = run_workload(*workload);
  if (!units) return fail(units.error().message, kExitBadInput);
  const CountedUnits& u = units.value();
  std::ofstream(o.into) << nlohmann::json(
      {u.frames, u.bodies, u.candidate_pairs, u.expansions, u.levels, u.contact_pairs, u.point_iterations});
  return EXIT_SUCCESS;
}

Result<CountedUnits> read_units(const std::filesystem::path& file) {
  const nlohmann::json json = nlohmann::json::parse(read_text(file), nullptr, false);
  if (!json.is_array() || json.size() != 7) return bad_input(file.string() + ": holds no units");
  return CountedUnits{json[0], json[1], json[2], json[3], json[4], json[5], json[6]};
}

Result<EntryCosts> count_under_valgrind(const std::string& entry, const std::filesystem::path& folder) {
  const std::filesystem::path profile = folder / (entry + ".callgrind");
  const std::filesystem::path units = folder / (entry + ".json");
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::optional<int> code =
      run_program({"valgrind", "--tool=callgrind", "--quiet", "--instr-atstart=no", "--collect-atstart=no",
                   "--compress-strings=no", "--compress-pos=no", "--callgrind-out-file=" + profile.string(), program,
                   "--count=" + entry, "--into=" + units.string()});
  if (code != 0) return bad_input(fmt::format("{}: ended with {} under valgrind", entry, code.value_or(127)));
  const Result<CountedUnits> counted = read_units(units);
  if (!counted) return counted.error();
  const Result<CallgrindProfile> parsed = parse_callgrind_profile(read_text(profile));
  if (!parsed) return parsed.error();
  return unit_costs(entry, parsed.value(), counted.value());
}

/// A temporary folder that the destructor removes with its contents.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& wanted) : keep_(!wanted.empty()), path_(wanted) {
    if (keep_) {
      std::filesystem::create_directories(path_);
      return;
    }
    std::string name = (std::filesystem::temp_directory_path() / "poise-ledger-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!keep_ && !path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  bool keep_;
  std::filesystem::path path_;
};

/// Prints the table of all numbers; returns how many are out of range.
std::size_t print_table(const std::vector<Compared>& rows) {
  fmt::print("{:<20} {:<24} {:>14} {:>14} {:>7}\n", "entry", "instructions per", "ledger", "now", "ratio");
  std::size_t outside = 0;
  for (const Compared& row : rows) {
    const std::string ratio = row.before > 0 ? fmt::format("{:.3f}", row.now / row.before) : "new";
    fmt::print("{:<20} {:<24} {:>14.1f} {:>14.1f} {:>7}{}\n", row.entry, row.cost, row.before, row.now, ratio,
               row.within ? "" : "  OUTSIDE");
    if (!row.within) ++outside;
  }
  return outside;
}

/// Replaces only the entries that were counted again.
int write_update(const Options& o, Ledger ledger, const std::vector<EntryCosts>& now) {
  for (const EntryCosts& entry : now) {
    const auto at = std::ranges::find(ledger.entries, entry.entry, &EntryCosts::entry);
    if (at == ledger.entries.end())
      ledger.entries.push_back(entry);
    else
      *at = entry;
  }
  if (o.only.empty()) {
    std::erase_if(ledger.entries, [&](const EntryCosts& entry) {
      return std::ranges::find(now, entry.entry, &EntryCosts::entry) == now.end();
    });
  }
  ledger.changes.push_back({POISE_BUILD_COMMIT, o.update});
  const Status written = write_ledger(ledger, o.ledger);
  return written ? EXIT_SUCCESS : fail(written.error().message, 4);
}

int run(const Options& o) {
  if (!o.count.empty()) return count_here(o);
  if (!can_switch_callgrind()) return fail("skipped: built without valgrind's headers", kExitSkipped);
  const ScratchFolder folder(o.profiles);
  Ledger here{valgrind_version(folder.path()), POISE_BUILD_COMPILER, POISE_LEDGER_BUILD, 0.03, {}, {}};
  if (here.counted_by.empty()) return fail("skipped: valgrind is not installed", kExitSkipped);
  Ledger ledger = here;
  if (o.update.empty() || std::filesystem::exists(o.ledger)) {
    const Result<Ledger> read = read_ledger(o.ledger);
    if (!read) return fail(read.error().message, kExitBadInput);
    ledger = read.value();
  }
  const auto identity = [](const Ledger& l) { return l.compiler + ", " + l.build + ", " + l.counted_by; };
  if (identity(ledger) != identity(here)) {
    if (o.update.empty())
      return fail(fmt::format("skipped: the ledger is for {}; this is {}", identity(ledger), identity(here)),
                  kExitSkipped);
    here.changes = ledger.changes;
    ledger = here;
  }
  const Status trees = prepare_trees();
  if (!trees) return fail(trees.error().message, kExitBadInput);
  std::vector<EntryCosts> now;
  for (const Workload& workload : workloads()) {
    const std::string name(workload.name);
    if (!o.only.empty() && std::ranges::find(o.only, name) == o.only.end()) continue;
    const Result<EntryCosts> costs = count_under_valgrind(name, folder.path());
    if (!costs) return fail(costs.error().message, kExitBadInput);
    now.push_back(costs.value());
  }
  if (now.empty()) return fail("--only names no entry", kExitBadUsage);
  Ledger compared = ledger;
  if (!o.only.empty()) {
    std::erase_if(compared.entries, [&](const EntryCosts& entry) {
      return std::ranges::find(now, entry.entry, &EntryCosts::entry) == now.end();
    });
  }
  const std::size_t outside = print_table(compare(compared, now));
  if (!o.update.empty()) return write_update(o, ledger, now);
  if (outside == 0) return EXIT_SUCCESS;
  return fail(fmt::format("{} numbers are outside +-{:.0f} % of {}; if that is meant, run `bench_ledger --update "
                          "REASON` and commit the file with the change",
                          outside, 100 * ledger.tolerance, o.ledger),
              kExitOutside);
}

}  // namespace
}  // namespace poise::ledger

int main(int argc, char** argv) {
  poise::ledger::Options options;
  CLI::App app(
      "Counts instructions a frame and a unit of work under valgrind's callgrind, and compares them with the "
      "ledger");
  app.add_option("--ledger", options.ledger, "the file to compare with or to write")->capture_default_str();
  app.add_option("--update", options.update, "write the numbers to the ledger, with this reason");
  app.add_option("--only", options.only, "these entries alone");
  app.add_option("--profiles", options.profiles, "keep callgrind's files in this folder");
  app.add_option("--count", options.count, "run this entry here, for callgrind")->group("");
  app.add_option("--into", options.into, "where --count leaves its units")->group("");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : poise::ledger::kExitBadUsage;
  }
  return poise::ledger::run(options);
}
