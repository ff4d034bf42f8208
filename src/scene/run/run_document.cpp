// SPDX-License-Identifier: MIT
#include "scene/run/run_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "scene/islands_wait_name.h"
#include "scene/run/milliseconds.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

Json optional_number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json list(const Vec3& vector) { return Json::array({vector.x(), vector.y(), vector.z()}); }

Json of(const simulation::Percentiles& p) {
  return {{"p50", p.p50},     {"p90", p.p90}, {"p95", p.p95},  {"p99", p.p99},
          {"p99_9", p.p99_9}, {"max", p.max}, {"mean", p.mean}};
}

/// The same members, each null.
Json undefined(const Json& defined) {
  if (!defined.is_object()) return nullptr;
  Json members = Json::object();
  for (const auto& [name, value] : defined.items()) members[name] = undefined(value);
  return members;
}

Json misses_json(const simulation::RunFigures& figures) {
  const simulation::MissFigures m = figures.misses.value_or(simulation::MissFigures{});
  const Json misses = {{"count", m.count},
                       {"rate", m.rate},
                       {"release", m.release},
                       {"infeasible", m.infeasible},
                       {"machine", m.machine},
                       {"overrun", m.overrun},
                       {"forecast", m.forecast},
                       {"releases", m.releases},
                       {"skipped_releases", m.skipped_releases},
                       {"interval_95", {{"low", m.interval_95.low}, {"high", m.interval_95.high}}},
                       {"longest_run", m.longest_run},
                       {"worst_1000", m.worst_1000},
                       {"tardiness_ms", of(m.tardiness_ms)},
                       {"share_of_time_late", m.share_of_time_late}};
  return figures.misses ? misses : undefined(misses);
}

Json longest_job_json(const std::optional<simulation::LongestJob>& longest) {
  const simulation::LongestJob job = longest.value_or(simulation::LongestJob{});
  const Json members = {{"frame", job.frame}, {"body_a", job.body_a}, {"body_b", job.body_b}};
  return longest ? members : undefined(members);
}

Json out_of_range_json(const simulation::OutOfRangeFigures& out) {
  const bool any = out.bodies > 0;
  return {{"bodies", out.bodies},
          {"first_frame", any ? Json(out.first_frame) : Json(nullptr)},
          {"first_body", any ? Json(out.first_body) : Json(nullptr)}};
}

Json worst_json(const std::vector<simulation::WorstFrame>& frames) {
  Json list = Json::array();
  for (const simulation::WorstFrame& frame : frames) {
    Json row = {{"frame", frame.frame},
                {"late_ms", ms(frame.lateness)},
                {"cause", simulation::cause_name(frame.cause)},
                {"release_delay_ms", ms(frame.release_delay)},
                {"stage", frame.stage},
                {"stage_ms", ms(frame.stage_time)},
                {"piece", nullptr}};
    if (frame.piece) {
      row["piece"] = {{"ms", ms(frame.piece_time)}, {"body_a", frame.piece->body_a}, {"body_b", frame.piece->body_b}};
    }
    list.push_back(std::move(row));
  }
  return list;
}

Json tail_json(const simulation::TailFigures& tail) {
  const bool defined = tail.frames > 0;
  const auto number = [defined](double value) { return defined ? Json(value) : Json(nullptr); };
  return {{"frames", tail.frames},
          {"coverage", number(tail.coverage)},
          {"reserve_over_actual", number(tail.reserve_over_actual)},
          {"reserve_used", number(tail.reserve_used)},
          {"actual_over_forecast_p50", number(tail.actual_over_forecast.p50)},
          {"actual_over_forecast_p99", number(tail.actual_over_forecast.p99)},
          {"actual_over_forecast_max", number(tail.actual_over_forecast.max)},
          {"pinball_loss_ms", number(tail.pinball_loss_ms)},
          {"beyond_clip", tail.beyond_clip},
          {"margin_last", number(tail.margin_last)}};
}

Json work_json(const simulation::WorkFigures& work) {
  return {{"mandatory", work.mandatory},
          {"refine", work.refine},
          {"mandatory_mean", work.mandatory_mean},
          {"refine_mean", work.refine_mean},
          {"jobs_done", work.jobs_done},
          {"jobs_discarded", work.jobs_discarded},
          {"jobs_abandoned", work.jobs_abandoned},
          {"pairs_separated", work.pairs_separated},
          {"cached_separations", work.cached_separations},
          {"cached_contacts", work.cached_contacts},
          {"candidate_pairs_mean", work.candidate_pairs_mean},
          {"coarse_pairs_mean", work.coarse_pairs_mean},
          {"pairs_left_mean", work.pairs_left_mean},
          {"frames_with_pairs_left", work.frames_with_pairs_left}};
}

Json reached_json(const simulation::LevelFigures& levels) {
  return {{"frames_listed", levels.frames},
          {"by_body", levels.bodies},
          {"by_weight", levels.weight},
          {"left_for_time_mean", levels.left_for_time_mean},
          {"left_for_capacity_mean", levels.left_for_capacity_mean},
          {"longest_wait", levels.longest_wait}};
}

Json reference_json(const RunDocument& d) {
  const simulation::ReferenceRunFigures& r = d.figures.reference;
  Json json = {{"every", d.reference_every ? Json(*d.reference_every) : Json(nullptr)}, {"frames", r.frames}};
  const auto add = [&json](const std::string& name, const std::optional<simulation::Percentiles>& p) {
    json[name + "_p50"] = p ? Json(p->p50) : Json(nullptr);
    json[name + "_p90"] = p ? Json(p->p90) : Json(nullptr);
    json[name + "_max"] = p ? Json(p->max) : Json(nullptr);
    json[name + "_mean"] = p ? Json(p->mean) : Json(nullptr);
  };
  add("e_mps", r.e_mps);
  add("e_rel", r.e_rel);
  add("e_seen_mps", r.e_seen_mps);
  add("gap_mean_mm", r.gap_mean_mm);
  add("gap_max_mm", r.gap_max_mm);
  add("gap_mean_px", r.gap_mean_px);
  add("gap_max_px", r.gap_max_px);
  json["contacts_apart"] = r.contacts_apart;
  json["run_contacts"] = r.run_contacts;
  json["reference_contacts"] = r.reference_contacts;
  json["false_contacts"] = r.false_contacts;
  json["missed_contacts"] = r.missed_contacts;
  json["false_rate"] = optional_number(r.false_share);
  json["missed_rate"] = optional_number(r.missed_share);
  add("false_rate", r.false_rate);
  add("missed_rate", r.missed_rate);
  add("bodies_touched", r.bodies_touched);
  add("iterations", r.iterations);
  json["not_converged"] = r.not_converged;
  json["pairs_not_finest"] = r.pairs_not_finest;
  add("time_ms", r.time_ms);
  return json;
}

Json settings_json(const RunDocument& d) {
  Json settings = {{"dt_s", d.dt_s},
                   {"seed", d.seed},
                   {"frames_asked", d.frames_asked},
                   {"executor", d.executor},
                   {"affinity", d.affinity},
                   {"realtime_priority", d.realtime_priority},
                   {"spin_us", d.spin_us},
                   {"paced", d.paced},
                   {"period_ms", 1000 * d.dt_s},
                   {"host_work_ms", d.host_work_ms},
                   {"host_work_learned", d.host_work_learned},
                   {"render_load_ms", d.render_load_ms},
                   {"render_load_jitter_ms", d.render_load_jitter_ms},
                   {"alpha", d.alpha},
                   {"time_priors_frames", d.time_priors_frames},
                   {"budget_work", d.budget_work ? Json(*d.budget_work) : Json(nullptr)},
                   {"max_level", d.max_level},
                   {"polygons", d.polygons},
                   {"backtracking", d.backtracking},
                   {"sleeping", d.sleeping},
                   {"islands_wait", islands_wait_name(d.islands_wait)}};
  const scheduler::Policy& policy = d.policy_weights;
  for (const scheduler::PolicyField& field : scheduler::policy_weights())
    settings["policy_weights"][std::string(field.name)] = policy.*field.value;
  for (const scheduler::PolicyField& field : scheduler::policy_parameters())
    settings["policy_parameters"][std::string(field.name)] = policy.*field.value;
  for (const scheduler::PolicyCount& field : scheduler::policy_counts())
    settings["policy_parameters"][std::string(field.name)] = policy.*field.value;
  return settings;
}

Json energy_json(const RunDocument& d) {
  return {{"start", d.start.kinetic_j + d.start.potential_j},
          {"end", d.end.kinetic_j + d.end.potential_j},
          {"max", d.energy_max_j},
          {"kinetic_start", d.start.kinetic_j},
          {"kinetic_end", d.end.kinetic_j}};
}

void add_figures(const RunDocument& d, Json& json) {
  const simulation::RunFigures& f = d.figures;
  json["frame_ms"] = of(f.frame_ms);
  json["low_1_percent_fps"] = f.low_1_percent_fps;
  json["low_0_1_percent_fps"] = f.low_0_1_percent_fps;
  json["misses"] = misses_json(f);
  json["worst_frames"] = worst_json(f.worst_frames);
  json["refinement_used"] = optional_number(f.refinement_used);
  json["refinement_used_all"] = optional_number(f.refinement_used_all);
  json["levels"] = {
      {"mean", optional_number(f.level_mean)}, {"histogram", f.level_histogram}, {"polygons", f.polygon_contacts}};
  json["levels"].update(reached_json(f.levels));
  json["contacts_mean"] = f.contacts_mean;
  json["energy_j"] = energy_json(d);
  json["momentum"] = {{"start", list(d.start.momentum_ns)}, {"end", list(d.end.momentum_ns)}};
  json["angular_momentum"] = {{"start", list(d.start.angular_momentum_js)}, {"end", list(d.end.angular_momentum_js)}};
  json["state_hash"] = fmt::format("{:016x}", d.state_hash);
  for (const simulation::StageFigures& stage : f.stages) json["stage_ms"][stage.name] = of(stage.ms);
  json["tail"] = tail_json(f.tail);
  json["degraded"] = {{"frames", f.degraded.frames},
                      {"fewer_iterations", f.degraded.fewer_iterations},
                      {"fewer_partners", f.degraded.fewer_partners},
                      {"fewer_substeps", f.degraded.fewer_substeps},
                      {"pairs_reused", f.degraded.pairs_reused},
                      {"frames_held", f.degraded.frames_held},
                      {"bodies_held", f.degraded.bodies_held},
                      {"bodies_paused", f.degraded.bodies_paused},
                      {"frames_unfinished", f.degraded.frames_unfinished},
                      {"infeasible_forecast", f.degraded.infeasible_forecast}};
  json["work"] = work_json(f.work);
  json["capacity"] = {{"pairs_discarded", f.capacity.pairs_discarded},
                      {"fronts_full", f.capacity.fronts_full},
                      {"colors_full", f.capacity.colors_full},
                      {"degenerate", f.capacity.degenerate}};
  json["out_of_range"] = out_of_range_json(f.out_of_range);
  json["swept"] = {{"pairs", f.swept.pairs}, {"hits", f.swept.hits}, {"cut", f.swept.cut}};
  json["sleep"] = {{"asleep_end", f.sleep.asleep_end},
                   {"asleep_mean", f.sleep.asleep_mean},
                   {"fell_asleep", f.sleep.fell_asleep},
                   {"woken", f.sleep.woken}};
  json["reference"] = reference_json(d);
  json["warm_up"] = {{"frames", f.warm_up_frames}, {"misses", f.warm_up_misses}};
  json["release_delay_ms"] = of(f.release_delay_ms);
  json["off_cpu_ms_max"] = f.off_cpu_ms_max;
  json["longest_job_ms_max"] = f.longest_job_ms_max;
  json["longest_job"] = longest_job_json(f.longest_job);
}

Json document_json(const RunDocument& d) {
  Json json;
  json["schema"] = "poise.run/2";
  json["scene"] = d.scene;
  json["scene_file"] = d.scene_file;
  json["bodies"] = d.bodies;
  json["dynamic_bodies"] = d.dynamic_bodies;
  json["dynamic_bodies_max"] = d.dynamic_bodies_max;
  json["frames"] = d.figures.frames;
  json["stopped"] = d.stopped;
  json["threads"] = d.threads;
  json["policy"] = d.policy;
  json["contact"] = d.contact;
  json["clock"] = d.clock;
  json["deadline_ms"] = optional_number(d.deadline_ms);
  add_figures(d, json);
  json["settings"] = settings_json(d);
  json["tray_side_m"] = d.tray_side_m > 0 ? Json(d.tray_side_m) : Json(nullptr);
  json["origin_offset_m"] = Json::object();
  for (const auto& [shape, offset] : d.origin_offsets_m) json["origin_offset_m"][shape] = list(offset);
  json["warnings"] = d.warnings;
  json["tree_cache"] = {{"off", d.tree_cache_use.off},
                        {"hits", d.tree_cache_use.hits},
                        {"built", d.tree_cache_use.built},
                        {"rebuilt", d.tree_cache_use.rebuilt},
                        {"not_writable", d.tree_cache_use.not_writable},
                        {"evicted", d.tree_cache_use.evicted}};
  json["require"] = {{"expression", d.requirement ? Json(*d.requirement) : Json(nullptr)},
                     {"failed", d.requirements_failed}};
  json["capture"] = nullptr;
  if (d.capture) {
    json["capture"] = {{"file", d.capture->file},
                       {"frames", d.capture->frames},
                       {"left_out", d.capture->left_out},
                       {"bytes", d.capture->bytes}};
  }
  json["machine"] = d.machine;
  json["build"] = d.build;
  return json;
}

void flatten(const Json& json, const std::string& path, std::vector<NamedFigure>& out) {
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) flatten(value, path.empty() ? key : path + "." + key, out);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) flatten(json[i], fmt::format("{}.{}", path, i), out);
  } else if (json.is_number()) {
    out.push_back({path, json.get<double>()});
  } else if (json.is_null()) {
    out.push_back({path, std::nullopt});
  }
}

/// Figures of members that a run has only with late frames or with a capture.
std::vector<std::string> names_of_some_runs() {
  std::vector<std::string> names = {"capture.frames", "capture.left_out", "capture.bytes"};
  for (std::size_t i = 0; i < simulation::kWorstFrames; ++i) {
    for (const char* member :
         {"frame", "late_ms", "release_delay_ms", "stage_ms", "piece.ms", "piece.body_a", "piece.body_b"})
      names.push_back(fmt::format("worst_frames.{}.{}", i, member));
  }
  return names;
}

}  // namespace

std::string run_json(const RunDocument& document) {
  return document_json(document).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<NamedFigure> named_figures(const RunDocument& document) {
  std::vector<NamedFigure> figures;
  flatten(document_json(document), "", figures);
  const auto named = [&](std::string_view name) { return std::ranges::find(figures, name, &NamedFigure::name); };
  for (const std::string& name : names_of_some_runs()) {
    if (named(name) == figures.end()) figures.push_back({name, std::nullopt});
  }
  if (const auto rate = named("misses.rate"); rate != figures.end()) {
    const std::optional<double> value = rate->value;
    figures.push_back({"miss_rate", value});
  }
  return figures;
}

}  // namespace poise::io
