// SPDX-License-Identifier: MIT
#include "scene/generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace poise {
namespace io {
namespace {

using geometry::Random;

/// Saturates: three counts of up to 10^7 would overflow, and anything above the limit is refused anyway.
std::uint64_t product_of(std::span<const std::uint64_t> counts) {
  std::uint64_t product = 1;
  for (const std::uint64_t n : counts) product = std::min(product * n, kMaxSceneBodies + 1);
  return product;
}

std::uint64_t own_count(const SceneGenerator& generator) {
  if (const auto* stream = std::get_if<StreamGenerator>(&generator)) return stream->total;
  const auto& grid = std::get<GridGenerator>(generator);
  if (grid.in_tray) return grid.bodies;
  const std::uint64_t blocks = grid.blocks ? product_of(grid.blocks->count) : 1;
  return std::min(blocks * product_of(grid.count), kMaxSceneBodies + 1);
}

/// Largest distance from a grid point to any point of its body: the largest bounding radius plus the jitter.
double reach_m(const GridGenerator& grid, std::span<const double> radius_m) {
  double largest_m = 0;
  for (const std::size_t shape : grid.kind.shapes) largest_m = std::max(largest_m, radius_m[shape]);
  return largest_m + grid.jitter_m;
}

struct Layout {
  std::uint64_t nx = 1, ny = 1;
  Vec3 first_m = Vec3::Zero();
  std::uint64_t in_block = kMaxSceneBodies;  // bodies of each block; without blocks all are in one
  std::uint64_t blocks_x = 1;
  std::array<double, 2> block_spacing_m{0, 0};
};

Result<Layout> layout_of(const GridGenerator& grid, std::size_t number, const Scene& scene,
                         const ExpandOptions& options) {
  if (!grid.in_tray) {
    Layout layout{grid.count[0], grid.count[1], grid.origin_m};
    if (grid.blocks) {
      layout.in_block = product_of(grid.count);
      layout.blocks_x = grid.blocks->count[0];
      layout.block_spacing_m = grid.blocks->spacing_m;
    }
    return layout;
  }
  const double reach = reach_m(grid, options.radius_m);
  const double room_m = options.tray_side_m - 2 * reach;
  if (!(room_m >= 0)) {
    return bad_input(
        fmt::format("{}: generators[{}].grid.in_tray: a tray of side {:g} m is too small for a body of radius {:g} m "
                    "with jitter {:g} m",
                    scene.source, number, options.tray_side_m, reach - grid.jitter_m, grid.jitter_m));
  }
  const double across = std::min(std::floor(room_m / grid.spacing_m), static_cast<double>(kMaxSceneBodies)) + 1;
  const double first = -0.5 * (across - 1) * grid.spacing_m;
  const auto n = static_cast<std::uint64_t>(across);
  return Layout{n, n, {first, first, grid.bottom_m + reach}};
}

void expand_grid(const GridGenerator& grid, const Layout& layout, std::uint64_t bodies, std::uint64_t seed,
                 std::vector<GeneratedBody>& out) {
  for (std::uint64_t k = 0; k < bodies; ++k) {
    Random random = Random::of(seed, k);
    GeneratedBody body = draw_body(grid.kind, k, random);
    const std::uint64_t block = k / layout.in_block;
    const std::uint64_t i = k % layout.in_block;
    const Vec3 corner_m(static_cast<double>(block % layout.blocks_x) * layout.block_spacing_m[0],
                        static_cast<double>(block / layout.blocks_x) * layout.block_spacing_m[1], 0);
    const Vec3 cell(static_cast<double>(i % layout.nx), static_cast<double>(i / layout.nx % layout.ny),
                    static_cast<double>(i / layout.nx / layout.ny));
    Vec3 jitter = Vec3::Zero();
    if (grid.jitter_m > 0) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) jitter[axis] = grid.jitter_m * random.symmetric();
    }
    body.center_m = layout.first_m + grid.spacing_m * cell + jitter + corner_m;
    body.is_static = grid.is_static;
    out.push_back(body);
  }
}

void expand_stream(const StreamGenerator& stream, std::uint64_t bodies, std::uint64_t seed,
                   std::vector<GeneratedBody>& out) {
  const double step_s = bodies > 0 ? (stream.to_s - stream.from_s) / static_cast<double>(bodies) : 0;
  for (std::uint64_t k = 0; k < bodies; ++k) {
    Random random = Random::of(seed, k);
    GeneratedBody body = draw_body(stream.kind, k, random);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double low = stream.region_min_m[axis];
      body.center_m[axis] = low + (stream.region_max_m[axis] - low) * random.unit();
    }
    body.streamed = true;
    body.due_s = stream.from_s + static_cast<double>(k) * step_s;
    if (stream.life_s) body.leaves_s = body.due_s + *stream.life_s;
    out.push_back(body);
  }
}

}  // namespace

GeneratedBody draw_body(const GeneratedKind& kind, std::uint64_t index, Random& random) {
  GeneratedBody body;
  body.kind = &kind;
  const std::uint64_t pick = kind.mix_by_seed ? random.below(kind.shapes.size()) : index % kind.shapes.size();
  body.shape = kind.shapes[pick];
  if (kind.random_orientation) body.orientation = random.rotation();
  body.velocity_mps = kind.velocity_mps;
  if (kind.speed_mps > 0) body.velocity_mps += kind.speed_mps * random.direction();
  if (kind.spin_radps > 0) body.angular_velocity_radps = kind.spin_radps * random.direction();
  return body;
}

BodyDefinition definition_of(const GeneratedBody& body, const Shape& shape) {
  BodyDefinition definition;
  definition.position_m = body.center_m - body.orientation * shape.origin_offset_m;
  definition.orientation = body.orientation;
  if (body.is_static) definition.motion = MotionType::Static;
  definition.velocity_mps = body.velocity_mps;
  definition.angular_velocity_radps = body.angular_velocity_radps;
  definition.group = body.kind->group;
  definition.collides_with = body.kind->collides_with;
  definition.importance = body.kind->importance;
  return definition;
}

std::vector<std::uint64_t> share_bodies(std::span<const std::uint64_t> own, std::uint64_t total) {
  const std::uint64_t sum = std::accumulate(own.begin(), own.end(), std::uint64_t{0});
  std::vector<std::uint64_t> shares(own.size());
  if (sum == 0) return shares;
  std::uint64_t given = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    shares[i] = own[i] * total / sum;
    given += shares[i];
  }
  for (std::size_t i = 0; i < own.size() && given < total; ++i, ++given) ++shares[i];
  return shares;
}

double tray_side_m(const Scene& scene, std::uint64_t generated, std::span<const double> radius_m) {
  if (!scene.tray) return 0;
  if (scene.tray->side_m > 0) return scene.tray->side_m;
  double side_m = scene.tray->side_per_sqrt_body_m * std::sqrt(static_cast<double>(generated));
  for (const SceneGenerator& generator : scene.generators) {
    const auto* grid = std::get_if<GridGenerator>(&generator);
    if (grid != nullptr && grid->in_tray) side_m = std::max(side_m, 2 * reach_m(*grid, radius_m));
  }
  return side_m;
}

std::vector<std::uint64_t> generated_counts(const Scene& scene, std::optional<std::uint64_t> bodies) {
  std::vector<std::uint64_t> counts;
  for (const SceneGenerator& generator : scene.generators) counts.push_back(own_count(generator));
  return bodies ? share_bodies(counts, *bodies) : counts;
}

Result<std::vector<GeneratedBody>> expand_generators(const Scene& scene, const ExpandOptions& options) {
  const std::vector<std::uint64_t> counts = generated_counts(scene, options.bodies);
  std::vector<GeneratedBody> start;
  std::vector<GeneratedBody> streamed;
  for (std::size_t i = 0; i < scene.generators.size(); ++i) {
    if (const auto* grid = std::get_if<GridGenerator>(&scene.generators[i])) {
      const Result<Layout> layout = layout_of(*grid, i, scene, options);
      if (!layout) return layout.error();
      expand_grid(*grid, layout.value(), counts[i], Random::of(options.seed, i).next() ^ grid->kind.seed, start);
    } else {
      const auto& stream = std::get<StreamGenerator>(scene.generators[i]);
      expand_stream(stream, counts[i], Random::of(options.seed, i).next() ^ stream.kind.seed, streamed);
    }
  }
  std::stable_sort(streamed.begin(), streamed.end(),
                   [](const GeneratedBody& a, const GeneratedBody& b) { return a.due_s < b.due_s; });
  start.insert(start.end(), streamed.begin(), streamed.end());
  return start;
}

std::uint64_t most_at_once(std::span<const GeneratedBody> bodies) {
  std::vector<double> come_s, leave_s;
  for (const GeneratedBody& body : bodies) {
    come_s.push_back(body.streamed ? body.due_s : -std::numeric_limits<double>::infinity());
    leave_s.push_back(body.leaves_s);
  }
  std::sort(come_s.begin(), come_s.end());
  std::sort(leave_s.begin(), leave_s.end());
  std::size_t most = 0, left = 0;
  for (std::size_t come = 0; come < come_s.size(); ++come) {
    while (leave_s[left] <= come_s[come]) ++left;
    most = std::max(most, come + 1 - left);
  }
  return most;
}

}  // namespace io

std::uint64_t generated_body_count(const Scene& scene) {
  std::uint64_t sum = 0;
  for (const SceneGenerator& generator : scene.generators) sum += io::own_count(generator);
  return sum;
}

}  // namespace poise
