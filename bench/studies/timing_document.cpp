// SPDX-License-Identifier: MIT
#include "studies/timing_document.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

Json by_json(const MeasuredBy& by) {
  return {{"threads", by.threads}, {"executor", by.executor}, {"machine", by.machine}, {"build", by.build}};
}

std::string by_text(const MeasuredBy& by) {
  return fmt::format("{}, {} cores, {}; {} threads ({}); poise {} commit {}, {}, {}\n", by.machine.processor,
                     by.machine.cores, by.machine.system, by.threads, by.executor, by.build.version, by.build.commit,
                     by.build.compiler, by.build.flags);
}

std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string cost_json(const CostDocument& document) {
  Json json = {{"schema", "poise.cost/1"},
               {"scene", document.scene},
               {"period_ms", document.period_ms},
               {"rows", Json::array()}};
  for (const CostRow& row : document.rows) {
    json["rows"].push_back({{"bodies", row.bodies},
                            {"state", row.settled ? "settled" : "falling"},
                            {"stage", row.stage},
                            {"ms_p50", row.stage_ms},
                            {"ns_per_body", row.ns_per_body()},
                            {"ns_per_candidate_pair", row.ns_per_pair()},
                            {"candidate_pairs", row.candidate_pairs},
                            {"contacts", row.contacts},
                            {"frames", row.frames}});
  }
  json.update(by_json(document.by));
  return text_of(json);
}

std::string cost_markdown(const CostDocument& document) {
  std::string text = fmt::format(
      "{}: medians of frames; a period is {:.4g} ms\n\n| bodies | state | candidate pairs | contacts | stage | ms | ns "
      "a pair | ns a body | of a period |\n",
      document.scene, document.period_ms);
  text += "|---:|---|---:|---:|---|---:|---:|---:|---:|\n";
  std::uint64_t before = 0;
  bool settled = false;
  for (const CostRow& row : document.rows) {
    const bool same = row.bodies == before && row.settled == settled;
    before = row.bodies;
    settled = row.settled;
    const std::string head = same ? "| | | | "
                                  : fmt::format("| {} | {} | {:.0f} | {:.0f} ", row.bodies,
                                                row.settled ? "settled" : "falling", row.candidate_pairs, row.contacts);
    text += fmt::format("{}| {} | {:.3f} | {:.1f} | {:.0f} | {:.1f} % |\n", head, row.stage, row.stage_ms,
                        row.ns_per_pair(), row.ns_per_body(),
                        document.period_ms > 0 ? 100 * row.stage_ms / document.period_ms : 0);
  }
  return text + "\n" + by_text(document.by);
}

std::string cache_json(const CacheDocument& document) {
  Json json = {{"schema", "poise.cache/1"},
               {"scene", document.scene},
               {"bodies", document.bodies},
               {"frames_cached", document.frames_retained},
               {"frames_anew", document.frames_anew},
               {"cached_pairs", document.cached_pairs},
               {"levels_cached", document.levels_retained},
               {"levels_anew", document.levels_anew},
               {"saved_ns_per_pair", document.saved_ns_per_pair()},
               {"rows", Json::array()}};
  for (const CacheRow& row : document.rows) {
    json["rows"].push_back({{"stage", row.stage},
                            {"cached_ms_p50", row.cached_ms},
                            {"anew_ms_p50", row.anew_ms},
                            {"cached_over_anew", row.share()}});
  }
  json.update(by_json(document.by));
  return text_of(json);
}

std::string cache_markdown(const CacheDocument& document) {
  std::string text = fmt::format(
      "{}, {} bodies, every pair at its deepest level: medians of {} frames with the contact cache and {} "
      "without\n\n| stage | cached, ms | anew, ms | cached / anew |\n|---|---:|---:|---:|\n",
      document.scene, document.bodies, document.frames_retained, document.frames_anew);
  for (const CacheRow& row : document.rows)
    text += fmt::format("| {} | {:.3f} | {:.3f} | {:.2f} |\n", row.stage, row.cached_ms, row.anew_ms, row.share());
  text += fmt::format(
      "\n{:.0f} pairs a frame need no refinement; each saves {:.0f} ns of finding and refining. Levels completed a "
      "frame: {:.0f} with the cache, {:.0f} without.\n\n",
      document.cached_pairs, document.saved_ns_per_pair(), document.levels_retained, document.levels_anew);
  return text + by_text(document.by);
}

std::string scaling_json(const ScalingDocument& document) {
  Json json = {{"schema", "poise.scaling/1"},
               {"scene", document.scene},
               {"bodies", document.bodies},
               {"units_a_frame", document.units_a_frame},
               {"rows", Json::array()}};
  for (const ScalingRow& row : document.rows) {
    json["rows"].push_back({{"threads", row.threads},
                            {"units_per_us_p50", row.units_per_us},
                            {"p10", row.p10},
                            {"p90", row.p90},
                            {"times_first", row.times_one},
                            {"frames", row.frames}});
  }
  json.update(by_json(document.by));
  return text_of(json);
}

std::string scaling_markdown(const ScalingDocument& document) {
  std::string text = fmt::format(
      "{}, {} bodies, every pair anew to its deepest level ({:.0f} expansions a frame): node-pair expansions a "
      "microsecond of refinement, frames of all rows in turn\n\n",
      document.scene, document.bodies, document.units_a_frame);
  text += "| threads | p10 | p50 | p90 | times the first | frames |\n|---:|---:|---:|---:|---:|---:|\n";
  for (const ScalingRow& row : document.rows) {
    text += fmt::format("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n", row.threads, row.p10, row.units_per_us,
                        row.p90, row.times_one, row.frames);
  }
  return text + "\n" + by_text(document.by);
}

std::string span_json(const SpanDocument& document) {
  Json json = {{"schema", "poise.span/1"},
               {"scene", document.scene},
               {"bodies", document.bodies},
               {"cores", document.cores},
               {"rows", Json::array()}};
  for (const SpanRow& row : document.rows) {
    json["rows"].push_back({{"state", row.settled ? "settled" : "falling"},
                            {"stage", row.stage},
                            {"work_ms_p50", row.work_ms},
                            {"serial_ms_p50", row.serial_ms},
                            {"span_ms_p50", row.span_ms},
                            {"on_cores_ms_p50", row.on_cores_ms},
                            {"work_over_span", row.parallelism()},
                            {"work_over_on_cores", row.times_faster()},
                            {"loops_p50", row.loops},
                            {"frames", row.frames}});
  }
  json.update(by_json(document.by));
  return text_of(json);
}

std::string span_markdown(const SpanDocument& document) {
  std::string text = fmt::format(
      "{}, {} bodies, every pair to its deepest level: work of one thread, and its critical path; medians of frames, "
      "CPU time\n\n| state | stage | work, ms | serial, ms | span, ms | on {} cores, ms | work / span | work / on {} "
      "cores | loops |\n|---|---|---:|---:|---:|---:|---:|---:|---:|\n",
      document.scene, document.bodies, document.cores, document.cores);
  for (const SpanRow& row : document.rows) {
    text += fmt::format("| {} | {} | {:.2f} | {:.3f} | {:.3f} | {:.2f} | {:.1f} | {:.1f} | {:.0f} |\n",
                        row.settled ? "settled" : "falling", row.stage, row.work_ms, row.serial_ms, row.span_ms,
                        row.on_cores_ms, row.parallelism(), row.times_faster(), row.loops);
  }
  return text + "\n" + by_text(document.by);
}

std::string free_json(const FreeDocument& document) {
  Json json = {{"schema", "poise.free/1"},
               {"counted_by", document.counted_by},
               {"frames", document.frames},
               {"rows", Json::array()}};
  for (const FreeRow& row : document.rows) {
    json["rows"].push_back({{"feature", row.feature},
                            {"absent", row.absent},
                            {"off_options", row.off_options},
                            {"on_options", row.on_options},
                            {"off_instructions_a_step", row.off_instructions},
                            {"on_instructions_a_step", row.on_instructions},
                            {"called_off", row.called_off},
                            {"functions_on", row.functions_on},
                            {"inside_kernels", row.inside_kernels},
                            {"ok", row.ok()}});
  }
  json.update(by_json(document.by));
  return text_of(json);
}

std::string free_markdown(const FreeDocument& document) {
  std::string text = fmt::format(
      "Instructions of a step, the mean of {}; counted by {}\n\n| feature | off | on | on / off | its functions called "
      "when off | when on |\n|---|---:|---:|---:|---:|---:|\n",
      document.frames, document.counted_by);
  for (const FreeRow& row : document.rows) {
    if (row.absent) {
      text += fmt::format("| {} | | | | not in this program | |\n", row.feature);
      continue;
    }
    const std::string off =
        row.inside_kernels ? std::string("none of its own") : fmt::format("{}", row.called_off.size());
    const std::string on = row.inside_kernels ? std::string() : fmt::format("{}", row.functions_on);
    text += fmt::format("| {} | {:.0f} | {:.0f} | {:.3f} | {} | {} |\n", row.feature, row.off_instructions,
                        row.on_instructions, row.off_instructions > 0 ? row.on_instructions / row.off_instructions : 0,
                        off, on);
  }
  return text + "\n" + by_text(document.by);
}

}  // namespace poise::io
