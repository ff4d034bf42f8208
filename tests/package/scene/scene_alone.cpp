// SPDX-License-Identifier: MIT
// A program that reads a mesh and a scene and steps it.
#include <poise/assets/mesh_file.h>
#include <poise/scene/scene.h>

#include <utility>

int main() {
  if (!poise::read_mesh(SCENES "/meshes/jack.obj", {})) return 1;
  const poise::Result<poise::Scene> scene = poise::read_scene(SCENES "/two-body.json");
  if (!scene) return 2;
  poise::Result<poise::SceneRun> run = poise::SceneRun::create(scene.value(), {});
  if (!run) return 3;
  poise::StepInput input;
  input.dt_s = scene.value().dt_s;
  input.budget = poise::Budget::unlimited();
  return run.value().world().step(input).bodies > 0 ? 0 : 4;
}
