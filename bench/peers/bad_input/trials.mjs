// SPDX-License-Identifier: MIT
// What other engines do with bad input (docs/reliability.md): `node trials.mjs ENGINE TRIAL` runs one trial as main.cpp
// does for the engines of Debian; `node trials.mjs PROGRAM` runs all of them, one a process, and prints the table.
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const kStep = 1 / 60;
const kCorners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1 ? 4 : -4, i & 2 ? 4 : -4, i & 4 ? 0 : -2]);
const kTriangles = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6],
  [0, 6, 2], [1, 3, 7], [1, 7, 5]].map(([a, b, c]) => [a, c, b]);  // turned to the inside

class Refused extends Error {}
const version = (name) => JSON.parse(readFileSync(new URL(`node_modules/${name}/package.json`, import.meta.url))).version;

async function jolt(insideOut) {
  const J = await (await import('jolt-physics/wasm-compat')).default();
  const settings = new J.JoltSettings();
  const pairs = new J.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(0, 1);
  pairs.EnableCollision(1, 1);
  const layers = new J.BroadPhaseLayerInterfaceTable(2, 2);
  for (const i of [0, 1]) layers.MapObjectToBroadPhaseLayer(i, new J.BroadPhaseLayer(i));
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  const system = new J.JoltInterface(settings);
  system.GetPhysicsSystem().SetGravity(new J.Vec3(0, 0, -9.81));
  const world = system.GetPhysicsSystem().GetBodyInterface();
  const bodies = [];
  const made = (shapeSettings) => {
    const result = shapeSettings.Create();
    if (result.HasError()) throw new Refused(result.GetError().c_str());
    return result.Get();
  };
  const add = (shape, position, q, mass) => {
    const moves = mass !== null;
    const body = new J.BodyCreationSettings(shape, new J.RVec3(...position), new J.Quat(q[1], q[2], q[3], q[0]),
      moves ? J.EMotionType_Dynamic : J.EMotionType_Static, moves ? 1 : 0);
    if (moves) {
      body.mOverrideMassProperties = J.EOverrideMassProperties_CalculateInertia;
      body.mMassPropertiesOverride.mMass = mass;
      body.mAllowSleeping = false;
      body.mFriction = 0.5;
    }
    const created = world.CreateBody(body);
    world.AddBody(created.GetID(), J.EActivation_Activate);
    if (moves) bodies.push(created.GetID());
  };
  const still = [1, 0, 0, 0];
  if (insideOut) {
    const list = new J.TriangleList();
    list.resize(kTriangles.length);
    kTriangles.forEach((corners, i) => corners.forEach((corner, k) =>
      list.at(i).set_mV(k, new J.Float3(...kCorners[corner]))));
    add(made(new J.MeshShapeSettings(list)), [0, 0, 0], still, null);
  } else {
    add(new J.BoxShape(new J.Vec3(50, 50, 1)), [0, 0, -1], still, null);
  }
  return {
    version: `Jolt (jolt-physics ${version('jolt-physics')})`,
    add: (b) => add(b.box ? new J.BoxShape(new J.Vec3(0.25, 0.25, 0.25)) : new J.SphereShape(0.25), b.position, b.q, b.mass),
    addDegenerate: () => {
      const hull = new J.ConvexHullShapeSettings();
      for (let i = 0; i < 8; ++i) hull.mPoints.push_back(new J.Vec3(0, 0, 0));
      add(made(hull), [0, 0, 2], still, 1);
    },
    setVelocity: (i, v) => world.SetLinearVelocity(bodies[i], new J.Vec3(...v)),
    step: (dt) => system.Step(dt, 1),
    positions: () => bodies.map((id) => {
      const at = world.GetPosition(id);
      return [at.GetX(), at.GetY(), at.GetZ()];
    }),
  };
}

async function physx(insideOut) {
  // The package is made for browsers, so this looks like one while it is loaded.
  const factory = (await import('physx-js-webidl')).default;
  const wasmBinary = readFileSync(new URL('node_modules/physx-js-webidl/physx-js-webidl.wasm', import.meta.url));
  const node = globalThis.process;
  globalThis.window = globalThis;
  globalThis.process = undefined;
  const P = await factory({ wasmBinary }).finally(() => { globalThis.process = node; });
  const foundation = P.CreateFoundation(P.PHYSICS_VERSION, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback());
  const scale = new P.PxTolerancesScale();
  const physics = P.CreatePhysics(P.PHYSICS_VERSION, foundation, scale);
  const description = new P.PxSceneDesc(scale);
  description.set_gravity(new P.PxVec3(0, 0, -9.81));
  description.set_cpuDispatcher(P.DefaultCpuDispatcherCreate(0));
  description.set_filterShader(P.DefaultFilterShader());
  const scene = physics.createScene(description);
  const material = physics.createMaterial(0.5, 0.5, 0);
  const flags = new P.PxShapeFlags(P.PxShapeFlagEnum.eSIMULATION_SHAPE);
  const bodies = [];
  const add = (geometry, position, q, mass) => {
    const shape = physics.createShape(geometry, material, true, flags);
    if (!shape || shape.ptr === 0) throw new Refused('createShape: null');
    shape.setSimulationFilterData(new P.PxFilterData(1, 1, 0, 0));
    const pose = new P.PxTransform(new P.PxVec3(...position), new P.PxQuat(q[1], q[2], q[3], q[0]));
    const body = mass === null ? physics.createRigidStatic(pose) : physics.createRigidDynamic(pose);
    if (!body || body.ptr === 0) throw new Refused('createRigidDynamic: null');
    body.attachShape(shape);
    if (mass !== null && !P.PxRigidBodyExt.prototype.setMassAndUpdateInertia(body, mass))
      throw new Refused('setMassAndUpdateInertia: false');
    if (mass !== null) body.setSleepThreshold(0);
    scene.addActor(body);
    if (mass !== null) bodies.push(body);
  };
  const points = (corners) => {
    const array = new P.PxArray_PxVec3(corners.length);
    corners.forEach((corner, i) => array.set(i, new P.PxVec3(...corner)));
    return array;
  };
  const cooking = new P.PxCookingParams(scale);
  if (insideOut) {
    const description = new P.PxTriangleMeshDesc();
    const corners = points(kCorners);
    const indices = new P.PxArray_PxU32(36);
    kTriangles.flat().forEach((corner, i) => indices.set(i, corner));
    description.points.count = 8;
    description.points.stride = 12;
    description.points.data = corners.begin();
    description.triangles.count = 12;
    description.triangles.stride = 12;
    description.triangles.data = indices.begin();
    const mesh = P.CreateTriangleMesh(cooking, description);
    if (!mesh || mesh.ptr === 0) throw new Refused('CreateTriangleMesh: null');
    add(new P.PxTriangleMeshGeometry(mesh), [0, 0, 0], [1, 0, 0, 0], null);
  } else {
    add(new P.PxBoxGeometry(50, 50, 1), [0, 0, -1], [1, 0, 0, 0], null);
  }
  return {
    version: `PhysX 5.6.1 (physx-js-webidl ${version('physx-js-webidl')})`,
    add: (b) => add(b.box ? new P.PxBoxGeometry(0.25, 0.25, 0.25) : new P.PxSphereGeometry(0.25), b.position, b.q, b.mass),
    addDegenerate: () => {
      const description = new P.PxConvexMeshDesc();
      const corners = points(Array(8).fill([0, 0, 0]));
      description.flags = new P.PxConvexFlags(P.PxConvexFlagEnum.eCOMPUTE_CONVEX);
      description.points.count = 8;
      description.points.stride = 12;
      description.points.data = corners.begin();
      const mesh = P.CreateConvexMesh(cooking, description);
      if (!mesh || mesh.ptr === 0) throw new Refused('CreateConvexMesh: null');
      add(new P.PxConvexMeshGeometry(mesh), [0, 0, 2], [1, 0, 0, 0], 1);
    },
    setVelocity: (i, v) => bodies[i].setLinearVelocity(new P.PxVec3(...v)),
    step: (dt) => {
      if (!scene.simulate(dt)) throw new Refused('simulate: false');
      scene.fetchResults(true);
    },
    positions: () => bodies.map((body) => {
      const at = body.getGlobalPose().p;
      return [at.x, at.y, at.z];
    }),
  };
}

/// All bodies are in the model that is compiled at the first step, so those that come later begin with the others.
async function mujoco(insideOut) {
  const M = await (await import('@mujoco/mujoco')).default();
  let xml = '';
  let count = 0;
  let assets = '';
  let model = null;
  let data = null;
  const ground = insideOut
    ? '<geom type="mesh" mesh="ground"/>' : '<geom type="plane" size="50 50 1"/>';
  if (insideOut)
    assets += `<mesh name="ground" vertex="${kCorners.flat().join(' ')}" face="${kTriangles.flat().join(' ')}"/>`;
  const compile = () => {
    if (model) return;
    const text = `<mujoco><option timestep="${kStep}" gravity="0 0 -9.81"/><asset>${assets}</asset><worldbody>${ground}${xml}</worldbody></mujoco>`;
    try {
      model = M.MjModel.from_xml_string(text);
    } catch (error) {
      throw new Refused(`at load: ${typeof error === 'number' ? 'an exception' : error.message}`);
    }
    if (!model) throw new Refused('at load');
    data = new M.MjData(model);
  };
  const body = (position, q, geom) => {
    xml += `<body pos="${position.join(' ')}" quat="${q.join(' ')}"><freejoint/>${geom}</body>`;
    ++count;
  };
  return {
    version: `MuJoCo (@mujoco/mujoco ${version('@mujoco/mujoco')})`,
    late: true,
    add: (b) => {
      const size = b.box ? 'type="box" size="0.25 0.25 0.25"' : 'type="sphere" size="0.25"';
      body(b.position, b.q, `<geom ${size} mass="${b.mass === Infinity ? 'inf' : b.mass}" friction="0.5 0.005 0.0001"/>`);
    },
    addDegenerate: () => {
      assets += `<mesh name="point" vertex="${Array(24).fill(0).join(' ')}"/>`;
      body([0, 0, 2], [1, 0, 0, 0], '<geom type="mesh" mesh="point" mass="1"/>');
    },
    setVelocity: (i, v) => {
      compile();
      v.forEach((value, k) => { data.qvel[6 * i + k] = value; });
    },
    step: (dt) => {
      compile();
      model.opt.timestep = dt;
      M.mj_step(model, data);
    },
    positions: () => {
      compile();
      return Array.from({ length: count }, (_, i) => [0, 1, 2].map((k) => data.qpos[7 * i + k]));
    },
  };
}

const kStill = [1, 0, 0, 0];
const ball = (mass, position) => ({ mass, position, q: kStill, box: false });
function heap(engine, later) {
  for (let i = 0; i < 27; ++i)
    engine.add(ball(1, [0.5 * (i % 3 - 1), 0.5 * (Math.floor(i / 3) % 3 - 1), 0.25 + 0.5 * Math.floor(i / 9)]));
  if (engine.late) later?.();
  steps(engine, 30);
  if (!engine.late) later?.();
}
function steps(engine, count, dt = kStep) {
  for (let i = 0; i < count; ++i) engine.step(dt);
}
const dropped = (mass, q = kStill, box = false) => (engine) => {
  heap(engine, () => engine.add({ mass, position: [0.1, 0.05, 2.5], q, box }));
  steps(engine, 120);
};
const longStep = (dt) => (engine) => {
  heap(engine);
  steps(engine, 1, dt);
  steps(engine, 30);
};

// As in main.cpp.
const kTrials = {
  'nan-velocity': (engine) => {
    heap(engine);
    engine.setVelocity(13, [NaN, NaN, NaN]);
    steps(engine, 90);
  },
  'zero-mass': dropped(0),
  'infinite-mass': dropped(Infinity),
  'mass-1e30': dropped(1e30),
  'zero-quaternion': dropped(1, [0, 0, 0, 0], true),
  'dt-1000': longStep(1000),
  'dt-1e9': longStep(1e9),
  'gram-under-tonne': (engine) => {
    engine.add(ball(0.001, [0, 0, 0.25]));
    engine.add(ball(1000, [0, 0, 0.75]));
    steps(engine, 120);
  },
  'inverted-mesh': (engine) => {
    engine.add(ball(1, [0.3, 0.2, 1]));
    steps(engine, 120);
  },
  'degenerate-mesh': (engine) => {
    heap(engine, () => engine.addDegenerate());
    steps(engine, 120);
  },
};

async function runOne(name, trial) {
  const engine = await { Jolt: jolt, PhysX: physx, MuJoCo: mujoco }[name](trial === 'inverted-mesh');
  try {
    kTrials[trial](engine);
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    console.log(`${engine.version}\trefused: ${error.message}`);
    return;
  }
  const positions = engine.positions();
  const lost = positions.filter((at) => !at.every(Number.isFinite)).length;
  const lowest = Math.min(...positions.slice(0, -1).map((at) => at[2]).filter((z) => !Number.isNaN(z)));
  console.log([engine.version, positions.length, lost, positions.at(-1)[2].toPrecision(3), lowest.toPrecision(3)].join('\t'));
}

/// What a trial came to, in words.
function outcome(run) {
  const line = run.stdout.split('\n').find((text) => text.includes('\t'));
  const fault = (run.stderr + run.stdout).split('\n').find((text) => /error|assert|abort/i.test(text));
  if (run.error?.code === 'ETIMEDOUT') return { text: 'does not end in 30 s' };
  if (run.signal || run.status !== 0 || !line) return { text: `ends the program (${fault ? fault.trim().slice(0, 90) : run.signal ?? run.status})` };
  const [engine, bodies, lost, height, lowest] = line.split('\t');
  if (lost === undefined) return { engine, text: bodies };
  const told = `${Number(lost) > 0 ? `${lost} of ${bodies} bodies NaN` : 'finite'}; the last at z = ${height}`;
  return { engine, text: Number.isFinite(Number(lowest)) ? `${told}, the lowest other at ${lowest}` : told };
}

function runAll(program) {
  const engines = ['Poise', 'Bullet', 'ODE', 'Jolt', 'MuJoCo', 'PhysX'];
  const versions = {};
  const rows = Object.keys(kTrials).map((trial) => engines.map((engine) => {
    const native = ['Poise', 'Bullet', 'ODE'].includes(engine);
    const words = native ? [program, engine, trial] : [process.execPath, fileURLToPath(import.meta.url), engine, trial];
    const run = spawnSync(words[0], words.slice(1), { encoding: 'utf8', timeout: 30000 });
    const { engine: told, text } = outcome(run);
    versions[engine] ??= told;
    return text;
  }));
  console.log(`| input | ${engines.map((engine) => versions[engine] ?? engine).join(' | ')} |`);
  console.log(`|${'---|'.repeat(engines.length + 1)}`);
  Object.keys(kTrials).forEach((trial, i) => console.log(`| ${trial} | ${rows[i].join(' | ')} |`));
}

if (process.argv.length === 4) {
  await runOne(process.argv[2], process.argv[3]);
} else {
  runAll(process.argv[2]);
}
