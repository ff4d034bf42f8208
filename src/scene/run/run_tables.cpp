// SPDX-License-Identifier: MIT
#include "scene/run/run_tables.h"
#include "scene/run/milliseconds.h"

#include <fmt/format.h>

#include <iterator>
#include <optional>
#include <string_view>

namespace poise::io {
namespace {

/// One pass over the columns writes header and rows, so that both always have the same columns.
class FrameRow {
 public:
  FrameRow(bool header, std::string& out) : header_(header), out_(out) {}
  template <class T>
  void column(std::string_view name, const T& value) {
    if (!first_) out_ += ',';
    first_ = false;
    if (header_) {
      out_ += name;
    } else {
      fmt::format_to(std::back_inserter(out_), "{}", value);
    }
  }
  /// A missing value gives an empty cell.
  template <class T>
  void column(std::string_view name, const std::optional<T>& value) {
    if (value) {
      column(name, *value);
    } else {
      column(name, std::string_view());
    }
  }
  void end() { out_ += '\n'; }

 private:
  bool header_;
  bool first_ = true;
  std::string& out_;
};

const char* status_name(StepStatus status) {
  switch (status) {
    case StepStatus::Done:
      return "done";
    case StepStatus::RefusedTimeStep:
      return "refused_time_step";
    case StepStatus::RefusedView:
      return "refused_view";
    case StepStatus::RefusedHostWork:
      return "refused_host_work";
    case StepStatus::RefusedReplay:
      return "refused_replay";
    case StepStatus::ReplayDiffers:
      return "replay_differs";
  }
  return "done";
}

void time_columns(const FrameReport& r, FrameRow& row) {
  row.column("total_ms", ms(r.times.total));
  row.column("predict_ms", ms(r.times.predict));
  row.column("broad_phase_ms", ms(r.times.broad_phase));
  row.column("coarse_ms", ms(r.times.coarse));
  row.column("refine_ms", ms(r.times.refine));
  row.column("manifolds_ms", ms(r.times.manifolds));
  row.column("solve_ms", ms(r.times.solve));
  row.column("integrate_ms", ms(r.times.integrate));
  row.column("publish_ms", ms(r.times.publish));
  row.column("budget_ms", ms(r.budget));
  row.column("reserve_at_cut_ms", ms(r.reserve_at_cut));
  row.column("tail_forecast_ms", ms(r.tail_forecast));
  row.column("tail_optional_ms", ms(r.tail_optional));
  row.column("tail_actual_ms", ms(r.tail_actual));
  row.column("planning_ms", ms(r.planning));
  row.column("ranking_ms", ms(r.ranking));
  row.column("pairs_ranked", r.pairs_ranked);
  row.column("refine_available_ms", ms(r.refine_available));
  row.column("host_reserved_ms", ms(r.host_reserved));
  row.column("lateness_ms", ms(r.lateness));
  row.column("off_cpu_ms", ms(r.off_cpu));
  row.column("waited_ms", ms(r.waited));
  row.column("longest_job_ms", ms(r.longest_job));
  row.column("longest_overrun_ms", ms(r.longest_overrun));
  row.column("overrun_off_cpu_ms", ms(r.overrun_off_cpu));
  row.column("cut_margin", r.cut_margin);
  row.column("mandatory_ms", ms(r.mandatory));
  row.column("mandatory_forecast_ms", ms(r.mandatory_forecast));
  row.column("infeasible_forecast", r.infeasible_forecast ? 1 : 0);
  row.column("degraded_substeps", r.degraded.substeps);
  row.column("degraded_point_iterations", r.degraded.point_iterations);
  row.column("degraded_crowded_partners", r.degraded.crowded_partners);
  row.column("pairs_reused", r.degraded.pairs_reused);
  row.column("bodies_held", r.degraded.bodies_held);
  row.column("bodies_paused", r.degraded.bodies_paused);
  row.column("unfinished", r.unfinished ? 1 : 0);
  row.column("host_actual_ms", ms(r.host_actual));
  row.column("tail_beyond_clip", r.tail_beyond_clip ? 1 : 0);
  row.column("tail_bodies", r.tail_work.bodies);
  row.column("tail_contacts", r.tail_work.contacts);
  row.column("tail_pairs", r.tail_work.candidate_pairs);
  row.column("tail_sphere_contacts", r.tail_work.sphere_contacts);
  row.column("tail_point_iterations", r.tail_work.point_iterations);
  row.column("tail_coarse_contacts", r.tail_work.coarse_contacts);
  row.column("tail_held_pairs", r.tail_work.held_pairs);
  row.column("tail_held_found", r.tail_work.held_found);
}

void work_columns(const FrameReport& r, FrameRow& row) {
  row.column("bodies", r.bodies);
  row.column("candidate_pairs", r.candidate_pairs);
  row.column("coarse_pairs", r.coarse_pairs);
  row.column("contact_pairs", r.contact_pairs);
  row.column("point_iterations", r.point_iterations);
  row.column("work_mandatory", r.work_mandatory);
  row.column("work_refine", r.work_refine);
  row.column("jobs_done", r.jobs_done);
  row.column("jobs_discarded", r.jobs_discarded);
  row.column("jobs_abandoned", r.jobs_abandoned);
  row.column("pairs_separated", r.pairs_separated);
  row.column("cached_separations", r.cached_separations);
  row.column("cached_contacts", r.cached_contacts);
  row.column("pairs_left", r.pairs_left);
  for (std::size_t level = 0; level <= kMaxTreeDepth; ++level) {
    row.column(fmt::format("level_{}", level), r.level_histogram[level]);
  }
  row.column("polygons", r.level_histogram[kPolygonBin]);
  row.column("swept_pairs", r.swept_pairs);
  row.column("swept_hits", r.swept_hits);
  row.column("swept_cut", r.swept_cut);
  row.column("pairs_discarded", r.pairs_discarded);
  row.column("fronts_full", r.fronts_full);
  row.column("colors_full", r.colors_full);
  row.column("degenerate", r.degenerate);
  row.column("out_of_range", r.out_of_range);
  row.column("asleep", r.asleep);
  row.column("fell_asleep", r.fell_asleep);
  row.column("woken", r.woken);
  row.column("kinetic_j", r.kinetic_j);
  row.column("potential_j", r.potential_j);
  // Not momentum_x_ns: beside columns in ms that would read as nanoseconds.
  row.column("momentum_x_kgmps", r.momentum_ns.x());
  row.column("momentum_y_kgmps", r.momentum_ns.y());
  row.column("momentum_z_kgmps", r.momentum_ns.z());
}

void reference_columns(const std::optional<ReferenceFigures>& reference, FrameRow& row) {
  // Cells of a member; empty in a frame without a reference.
  const auto member = [&](std::string_view name, auto ReferenceFigures::*which) {
    row.column(name, reference ? std::optional((*reference).*which) : std::nullopt);
  };
  const auto number = [&](std::string_view name, std::optional<double> ReferenceFigures::*which, double factor = 1) {
    std::optional<double> value = reference ? (*reference).*which : std::nullopt;
    if (value) *value *= factor;
    row.column(name, value);
  };
  constexpr double kMmPerM = 1000;
  number("reference_e_mps", &ReferenceFigures::e_mps);
  number("reference_e_rel", &ReferenceFigures::e_rel);
  number("reference_e_seen_mps", &ReferenceFigures::e_seen_mps);
  number("reference_change_mps", &ReferenceFigures::change_mps);
  member("reference_bodies_touched", &ReferenceFigures::bodies_touched);
  member("reference_run_contacts", &ReferenceFigures::run_contacts);
  member("reference_contacts", &ReferenceFigures::reference_contacts);
  member("reference_false_contacts", &ReferenceFigures::false_contacts);
  member("reference_missed_contacts", &ReferenceFigures::missed_contacts);
  member("reference_contacts_apart", &ReferenceFigures::contacts_apart);
  number("reference_gap_mean_mm", &ReferenceFigures::gap_mean_m, kMmPerM);
  number("reference_gap_max_mm", &ReferenceFigures::gap_max_m, kMmPerM);
  number("reference_gap_mean_px", &ReferenceFigures::gap_mean_px);
  number("reference_gap_max_px", &ReferenceFigures::gap_max_px);
  row.column("reference_converged", reference ? std::optional(reference->converged ? 1 : 0) : std::nullopt);
  member("reference_iterations", &ReferenceFigures::iterations);
  member("reference_pairs_not_finest", &ReferenceFigures::pairs_not_finest);
  row.column("reference_time_ms", reference ? std::optional(ms(reference->time)) : std::nullopt);
}

void frame_row(const simulation::RunFrame& frame, double time_s, bool header, std::string& out) {
  const FrameReport& r = frame.report;
  FrameRow row(header, out);
  row.column("frame", r.frame);
  row.column("time_s", time_s);
  row.column("warm_up", frame.warm_up ? 1 : 0);
  row.column("status", status_name(r.status));
  row.column("miss", r.lateness.count() > 0 ? 1 : 0);
  row.column("cause", simulation::cause_name(r.cause));
  row.column("releases_skipped", frame.releases_skipped);
  row.column("release_delay_ms", ms(r.release_delay));
  time_columns(r, row);
  work_columns(r, row);
  reference_columns(r.reference, row);
  row.end();
}

}  // namespace

std::string states_header() {
  return "frame,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_mps,vy_mps,vz_mps,wx_radps,wy_radps,wz_radps\n";
}

std::string bodies_header() { return "body,name,motion,shape,file,material,mass_kg\n"; }

void append_body(const Scene& scene, const RunBody& body, double mass_kg, std::string& out) {
  const auto cell = [](const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
  };
  const bool named = body.number < scene.bodies.size();
  const char* const motion = body.motion == MotionType::Static      ? "static"
                             : body.motion == MotionType::Kinematic ? "kinematic"
                                                                    : "dynamic";
  std::string name, file;
  // The tray and what generators make are in no list of the scene.
  const bool has_shape = body.shape < scene.shapes.size();
  if (has_shape) {
    name = scene.shapes[body.shape].name;
    if (const auto* mesh = std::get_if<MeshSource>(&scene.shapes[body.shape].source)) file = mesh->file.string();
    if (const auto* tree = std::get_if<TreeSource>(&scene.shapes[body.shape].source))
      file = (tree->mesh.empty() ? tree->file : tree->mesh).string();
  }
  const std::string material = body.material < scene.materials.size() ? scene.materials[body.material].name : "";
  fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{},{:.17g}\n", body.number,
                 named ? cell(scene.bodies[body.number].name) : "", motion, cell(name), cell(file), cell(material),
                 mass_kg);
}

void append_states(std::uint64_t frame, double time_s, std::span<const NumberedState> states, std::string& out) {
  const auto end = std::back_inserter(out);
  const std::string prefix = fmt::format("{},{:.17g},", frame, time_s);
  for (const auto& [body, s] : states) {
    fmt::format_to(end, "{}{}", prefix, body);
    for (const double value :
         {s.position_m.x(), s.position_m.y(), s.position_m.z(), s.orientation.w(), s.orientation.x(), s.orientation.y(),
          s.orientation.z(), s.velocity_mps.x(), s.velocity_mps.y(), s.velocity_mps.z(), s.angular_velocity_radps.x(),
          s.angular_velocity_radps.y(), s.angular_velocity_radps.z()}) {
      fmt::format_to(end, ",{:.17g}", value);
    }
    out += '\n';
  }
}

std::string frames_header() {
  std::string out;
  frame_row({}, 0, true, out);
  return out;
}

void append_frame(const simulation::RunFrame& frame, double time_s, std::string& out) {
  frame_row(frame, time_s, false, out);
}

}  // namespace poise::io
