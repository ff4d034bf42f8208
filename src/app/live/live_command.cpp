// SPDX-License-Identifier: MIT
#include "app/live/live_command.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/capture/run_capture.h"
#include "app/files/scene_input.h"
#include "app/live/live_loop.h"
#include "app/live/live_network.h"
#include "app/live/live_page.h"
#include "app/live/live_run.h"
#include "app/live/request_check.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/process_memory.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/run/run_options.h"
#include "capture/observe.h"
#include "parallel/interrupt.h"
#include "poise/scene/scene.h"
#include "scene/policy_file.h"
#include "scene/result_file.h"
#include "scene/run/policy_name.h"

namespace poise::app {
namespace {

struct LiveOptions {
  RunOptions run;  ///< those that both commands have
  std::optional<std::uint64_t> port;
  std::string address = "127.0.0.1";
};

int refuse_live(int code, const std::string& message) { return refuse("live", code, message); }

/// The address of the page, as a browser of this machine finds it.
std::string page_url(const std::string& address, std::uint16_t port, const std::string& token) {
  const std::string here = address == "0.0.0.0" ? "127.0.0.1" : address == "::" ? "::1" : address;
  const bool is_wide = here.find(':') != std::string::npos;
  return fmt::format("http://{}{}{}:{}/{}/", is_wide ? "[" : "", here, is_wide ? "]" : "", port, token);
}

capture::CaptureHeader header_of(const LiveOptions& options, const Scene& scene, const SceneRun& run,
                                 double deadline_ms) {
  capture::CaptureHeader header = capture::header_of(scene, run);
  header.command = command_line();
  header.deadline_ms = deadline_ms;
  header.paced = true;
  header.frames_asked = options.run.frames;
  header.policy = io::policy_name(run.world().settings().policy.kind);
  header.contact = options.run.contact;
  return header;
}

/// From a scene that stands to its end.
int serve(const LiveOptions& options, const Scene& scene, const SceneRunOptions& start, SceneRun run,
          const std::string& page, const parallel::Interrupt& interrupt) {
  Result<std::string> token = random_token();
  if (!token) return refuse("live", token.error());
  LiveLink link;
  WebSettings settings;
  settings.address = options.address;
  settings.port = static_cast<std::uint16_t>(options.port.value_or(0));
  settings.token = token.value();
  settings.page = page;
  Result<LiveNetwork> network = LiveNetwork::open(settings, link);
  if (!network) return refuse("live", network.error());
  const double deadline_ms = options.run.deadline_ms.value_or(scene.deadline_ms.value_or(1000 * scene.dt_s));
  network.value().begin(header_of(options, scene, run, deadline_ms));
  LiveRun live(scene, start, std::move(run), Nanoseconds(static_cast<std::int64_t>(deadline_ms * 1e6)));
  if (!is_loopback(options.address)) {
    print_error(
        "poise live: warning: --address {}: whoever learns the address of the page can see and change the run "
        "from other machines, and what is sent is not encrypted\n",
        options.address);
  }
  const Status told = io::write_stdout(page_url(options.address, network.value().port(), token.value()) + "\n");
  if (!told) return refuse("live", told.error());
  LiveLoopSettings loop;
  loop.frames = options.run.frames;
  loop.stops = [&interrupt] { return interrupt.asked(); };
  loop.told = [&network] { network.value().wake(); };
  const Result<std::uint64_t> ended = live_loop(live, link, loop);
  return ended ? kExitDone : refuse("live", ended.error());
}

int live(LiveOptions options) {
  const std::optional<std::string> address = plain_address(options.address);
  if (!address) {
    return refuse_live(kExitBadUsage,
                       fmt::format("--address = {}, must be an IPv4 or IPv6 address as a number, such as "
                                   "127.0.0.1",
                                   options.address));
  }
  options.address = *address;
  const Status sound = check_run_options(options.run);
  if (!sound) return refuse_live(kExitBadUsage, sound.error().message);
  const Result<std::string> page = read_live_page();
  if (!page) return refuse("live", page.error());
  const Result<SceneText> text = read_scene_argument(options.run.scene, "live", options.run.quiet);
  if (!text) return refuse("live", text.error());
  std::vector<std::string> errors;
  Result<Scene> scene = parse_scene_text(text.value(), errors);
  for (const std::string& error : errors) refuse_live(kExitBadInput, error);
  if (!scene) return exit_code_of(scene.error());
  const Status policy = apply_to_scene(options.run, scene.value(), errors);
  for (const std::string& error : errors) refuse_live(kExitBadInput, error);
  if (!policy) return exit_code_of(policy.error());
  if (options.run.bodies && scene.value().generators.empty())
    return refuse_live(kExitBadUsage, "--bodies: the scene " + scene.value().name + " has no generators");
  const parallel::Interrupt interrupt;
  Progress progress(!options.run.quiet);
  const char* const loading = "loading shapes and building sphere trees";
  progress.say(loading);
  SceneRunOptions start;
  start.world = world_settings(options.run, scene.value());
  start.bodies = options.run.bodies;
  start.seed = options.run.seed;
  start.max_memory_bytes = max_memory_bytes(options.run.max_memory_mib);
  start.stop = interrupt.token();
  start.tree_progress = [&](double share) { progress.share(loading, share); };
  if (!options.run.quiet) warn_of_threads("live", start.world.threads);
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.run.tree_cache);
  if (!cache) return refuse_live(kExitBadUsage, cache.error().message);
  start.tree_cache = cache.value();
  Result<SceneRun> run = SceneRun::create(scene.value(), start);
  progress.end();
  if (!run) return refuse("live", interrupt.asked() ? stopped_error(kStoppedLoading) : run.error());
  start.tree_progress = {};
  for (const std::string& warning : run.value().warnings()) print_error("poise live: warning: {}\n", warning);
  return serve(options, scene.value(), start, std::move(run).value(), page.value(), interrupt);
}

}  // namespace

void add_live_command(CLI::App& app, int& exit_code) {
  constexpr std::uint64_t kMany = std::numeric_limits<std::uint64_t>::max();
  auto options = std::make_shared<LiveOptions>();
  RunOptions& run = options->run;
  CLI::App* command =
      app.add_subcommand("live", "Run a scene in real time, and serve a page in which it is seen and changed");
  add_scene(*command, run.scene);
  add_whole(*command, "--frames", run.frames, 1, kMaxSceneFrames, "End after so many frames (default: at Ctrl-C)");
  add_whole(*command, "--bodies", run.bodies, 1, kMaxSceneBodies,
            "How many bodies the generators make together at the start");
  add_number(*command, "--deadline", run.deadline_ms, 0, true, kLongestDeadlineMs,
             "Deadline of a frame in ms, which the page can change (default: the scene's deadline_ms, else its time "
             "step)");
  add_whole(*command, "--threads", run.threads, 0, 256, "Threads, 0 = as many as the machine has (default 0)");
  add_policy_options(*command, run);
  add_whole(*command, "--seed", run.seed, 0, kMany, "Instead of the scene's seed; moves generated bodies too");
  add_whole(*command, "--port", options->port, 0, std::numeric_limits<std::uint16_t>::max(),
            "Port of the page, 0 = any that is free (default 0)");
  command
      ->add_option(
          "--address", options->address,
          "Address to serve at (default 127.0.0.1). With another one other machines can see and change the run")
      ->type_name("A");
  add_tree_cache_options(*command, run.tree_cache);
  add_max_memory(*command, run.max_memory_mib);
  command->add_flag("--quiet", run.quiet, "No progress");
  command->footer(
      "Example:\n"
      "  poise live jacks --bodies 500 --deadline 8\n\n"
      "It prints the address of the page; who knows it can change the run (docs/live.md). Ctrl-C or SIGTERM ends it. "
      "Exit "
      "codes: 0 done, 2 bad usage, 3 bad input or a page that is not built, 4 the address cannot be served.");
  command->callback([options, &exit_code] { exit_code = live(*options); });
}

}  // namespace poise::app
