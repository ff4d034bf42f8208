# SPDX-License-Identifier: MIT
"""What is refused, and what its exception says."""
import math
import os
import pathlib
import pickle
import shutil
import subprocess
import sys

import numpy
import pytest

import poise
from conftest import falling_ball

PACKAGE = pathlib.Path(poise.__file__).absolute().parent
WORLD, BALL = falling_ball()
MATERIAL = WORLD.add_material()
SPHERE = poise.Shape.sphere(0.5)


def body(**fields):
    return lambda: WORLD.add_body(SPHERE, MATERIAL, **fields)


REFUSED = [
    (body(mass_kg=-1), "mass_kg", "-1", "must be > 0"),
    (body(position_m=(0, 0, math.nan)), "position_m", "nan", "finite"),
    (body(position_m=(0, 0)), "position_m", "(0, 0)", "must be three numbers"),
    (body(position_m="abc"), "position_m", "'abc'", "must be three numbers"),
    (body(velocity_mps=(0, "x", 0)), "velocity_mps", "x", "must be three numbers"),
    (body(orientation_wxyz=(1, 0, 0)), "orientation_wxyz", "(1, 0, 0)", "must be four numbers"),
    (body(orientation_wxyz=(0, 0, 0, 0)), "orientation_wxyz|orientation", "0", ""),
    (body(motion="dynamc"), "motion", "dynamc", "must be one of static, kinematic, dynamic"),
    (body(group=-1), "group", "-1", "must be a whole number"),
    (body(collides_with=2**32), "collides_with", "4294967296", "must be a whole number"),
    (body(importance=-2), "importance", "-2", "must be in"),
    (body(user_data=1.5), "user_data", "1.5", "must be a whole number"),
    (lambda: WORLD.add_material(restitution=2), "restitution", "2", "must be in [0, 1]"),
    (lambda: WORLD.set_importance(BALL, 1e9), "importance", "1000000000", "must be in"),
    (lambda: WORLD.apply_force(BALL, (math.inf, 0, 0), (0, 0, 0)), "force_n", "inf", "finite"),
    (lambda: WORLD.step(dt_s=0), "dt_s", "0", "must be > 0"),
    (lambda: WORLD.step(host_work_s=-1), "host_work_s", "-1", "must be >= 0"),
    (lambda: WORLD.step(host_work_s="much"), "host_work_s", "much", "must be 'learn' or seconds"),
    (lambda: WORLD.step(max_level=7), "max_level", "7", "must be a whole number in [0, 6]"),
    (lambda: WORLD.set_settings(threads=3), "threads", "3", "must stay"),
    (lambda: WORLD.set_settings(alpha=2), "alpha", "2", "must be in"),
    (lambda: poise.Budget.work(-1), "units", "-1", "must be a whole number"),
    (lambda: poise.Budget.within(math.nan), "seconds", "nan", "must be a number of seconds"),
    (lambda: poise.Shape.sphere(0), "radius_m", "0", "must be > 0"),
    (lambda: poise.Shape.plane((0, 0, 0)), "normal", "0", ""),
    (lambda: poise.Shape.box((1, 0, 1)), "half_extents_m", "(1, 0, 1)", "each must be > 0"),
    (lambda: poise.Shape.mesh([[0, 0, 0]], [[0, 1, 2]]), "triangles[0]", "1", "must be in [0, 1)"),
    (lambda: poise.Shape.mesh([[0, 0, 0]], [[0, 0, 0]], depth=9), "depth", "9", "must be a whole number in [0, 6]"),
    (lambda: poise.Policy("percept"), "kind", "percept", "must be one of perceptual"),
    (lambda: poise.Policy(size=-1), "policy.size", "-1", "must be in"),
    (lambda: poise.Policy(cue=3), "cue", "3", "must be a function"),
    (lambda: poise.World(threads=300), "threads", "300", "must be in [0, 256]"),
    (lambda: poise.World(executor="cuda"), "executor", "cuda", "must be one of tbb, threads, serial"),
    (lambda: poise.World(gravity_mps2=(0, 0, 1e12)), "gravity_mps2", "1000000000000", "within"),
    (lambda: poise.View((0, 0, 0), (0, 0, 0)), "look_at_m - position_m", "0", "direction"),
    (lambda: poise.View((0, 0, 0), (0, 0, 1)), "up", "1", "parallel"),
    (lambda: poise.View((0, 0, 0), (1, 0, 0), vertical_fov_rad=4), "vertical_fov_rad", "4", "must be in"),
    (lambda: WORLD.cast_ray((0, 0, 0), (0, 0, 0)), "direction", "0", ""),
    (lambda: poise.SceneRun("jack"), "scene", "jack", "must be a path or one of"),
    (lambda: poise.SceneRun("jacks", bodies=-1), "bodies", "-1", "must be a whole number"),
]


@pytest.mark.parametrize("call, field, value, rule", REFUSED, ids=[row[1] + "=" + row[2] for row in REFUSED])
def test_wrong_values_name_field_value_and_rule(call, field, value, rule):
    before = len(WORLD), WORLD.state_hash()
    with pytest.raises(poise.Error) as refused:
        call()
    error = refused.value
    assert error.kind == "bad_input"
    assert error.field in field.split("|"), str(error)
    assert value in error.value and rule in str(error)
    assert (len(WORLD), WORLD.state_hash()) == before, "a refused call must change nothing"


@pytest.mark.parametrize("call, words", [
    (lambda: WORLD.add_body(SPHERE), "add_body"),
    (lambda: WORLD.add_body(SPHERE, MATERIAL, colour="red"), "add_body"),
    (lambda: WORLD.step(0.004), "poise.Budget.within"),
    (lambda: poise.World(gravity=(0, 0, 1)), "has no 'gravity'; it has .*gravity_mps2"),
    (lambda: poise.World(3), "poise.Settings"),
    (lambda: poise.World(sleeping="yes"), "sleeping = 'yes' is of a wrong type"),
    (lambda: poise.Policy(size="large"), "size = 'large' is of a wrong type"),
    (lambda: WORLD.step(view=3), "view must be a poise.View or None, not 3"),
    (lambda: WORLD.step(attend_body=3), "attend_body must be a poise.BodyId or None, not 3"),
    (lambda: WORLD.step(host_work_s=None), "host_work_s must be seconds or 'learn', not None"),
    (lambda: WORLD.cast_ray((0, 0, 0), (0, 0, 1), ignore=3), "ignore must be a poise.BodyId"),
    (lambda: WORLD.closest_point((0, 0, 0), body=3), "body must be a poise.BodyId"),
    (lambda: poise.Policy(weight=1), "has no 'weight'"),
    (lambda: WORLD.set_settings(policy=3), "poise.Policy or the name of a kind"),
    (lambda: poise.SceneRun("jacks", colour=1), "has no 'colour'"),
])
def test_wrong_types_and_names_raise_type_errors_that_help(call, words):
    with pytest.raises(TypeError, match=words):
        call()


def test_where_one_of_many_bodies_is_refused_none_is_added():
    before = len(WORLD), WORLD.state_hash()
    positions = numpy.zeros((3, 3))
    positions[:, 0] = (10, 20, math.inf)
    with pytest.raises(poise.Error) as refused:
        WORLD.add_bodies(SPHERE, MATERIAL, positions)
    assert refused.value.field == "bodies[2].position_m"
    assert WORLD.add_bodies(SPHERE, MATERIAL, []) == []
    for wrong in (numpy.zeros((3, 2)), numpy.zeros(3), "abc", None):
        with pytest.raises(poise.Error, match=r"position_m, must be an array of shape \(n, 3\)"):
            WORLD.add_bodies(SPHERE, MATERIAL, wrong)
    for wrong, said in (([[0, 1.5, 2]], "triangles, must be whole numbers"), ([["a", "b", "c"]], "must be whole numbers")):
        with pytest.raises(poise.Error, match=said):
            poise.Shape.mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], wrong)
    with pytest.raises(poise.Error, match=r"bodies\[1\].user_data = -1, must be >= 0"):
        WORLD.add_bodies(SPHERE, MATERIAL, numpy.zeros((2, 3)), user_data=[1, -1])
    with pytest.raises(poise.Error, match=r"velocity_mps, must have as many rows \(1\) as position_m \(2\)"):
        WORLD.add_bodies(SPHERE, MATERIAL, numpy.zeros((2, 3)), velocity_mps=[[0, 0, 0]])
    assert (len(WORLD), WORLD.state_hash()) == before


def test_shapes_and_materials_in_use_stay():
    world, ball = falling_ball()
    shape, material = poise.Shape.sphere(0.2), world.add_material()
    body_of_it = world.add_body(shape, material)
    for remove in (lambda: world.remove_shape(shape), lambda: world.remove_material(material)):
        with pytest.raises(poise.Error, match="1 bod"):
            remove()
    world.remove_body(body_of_it)
    world.remove_shape(shape)
    world.remove_material(material)
    with pytest.raises(poise.Error, match="shape"):
        world.remove_shape(shape)


def test_errors_of_files_name_the_file(tmp_path):
    scene = tmp_path / "bad.json"
    scene.write_text('{"schema": "poise.scene/1", "dt_s": -1}')
    with pytest.raises(poise.Error) as refused:
        poise.SceneRun(scene)
    assert str(scene) in str(refused.value)
    for call in (lambda: poise.SceneRun(tmp_path / "none.json"), lambda: poise.Shape.from_file(tmp_path / "none.obj"),
                 lambda: poise.Replay(tmp_path / "none.poise"), lambda: poise.Policy.from_file(tmp_path / "none.json")):
        with pytest.raises(poise.Error, match="none"):
            call()


def test_an_error_takes_the_message_apart_and_can_be_pickled():
    error = pickle.loads(pickle.dumps(poise.Error("pile.json: bodies[3].mass_kg = -1, must be > 0", "capacity_full")))
    assert (error.where, error.field, error.value, error.rule, error.kind) == (
        "pile.json", "bodies[3].mass_kg", "-1", "must be > 0", "capacity_full")
    plain = poise.Error("nothing is said of any field")
    assert (plain.where, plain.field, plain.value, plain.rule) == (None, None, None, None)


def import_error(line, path):
    """What Python says of an import that fails."""
    done = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(path), "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 1
    return done.stderr.splitlines()[-1]


def test_without_numpy_it_is_said_what_to_install():
    said = import_error("import sys; sys.modules['numpy'] = None; import poise", PACKAGE.parent)
    assert said == ("ImportError: poise needs NumPy, which %s has not; "
                    "Debian's package is python3-numpy, for /usr/bin/python3" % sys.executable)


def test_another_python_is_told_for_which_one_it_was_built(tmp_path):
    (tmp_path / "poise").mkdir()
    for file in PACKAGE.glob("*.py"):
        shutil.copy(file, tmp_path / "poise")
    (tmp_path / "poise" / "_core.cpython-38-other.so").touch()
    said = import_error("import poise", tmp_path)
    assert said == "ImportError: poise is not built for %s, Python %d.%d (built: _core.cpython-38-other.so)" % (
        sys.executable, sys.version_info[0], sys.version_info[1])
