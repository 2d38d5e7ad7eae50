"""The package: types, threads, forked processes, documents, examples."""

from __future__ import annotations

import ast
import builtins
import doctest
import importlib
import multiprocessing
import os
import re
import subprocess
import sys
import textwrap
import threading
import time
import warnings
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from conftest import random_poses, rock

import hullmap

PACKAGE = Path(hullmap.__file__).parent
PROJECT = Path(__file__).parent.parent
ROOT = PROJECT.parent.parent


def modules():
    return sorted(PACKAGE.rglob("*.py"))


def test_the_tests_run_from_the_wheel():
    assert "site-packages" in PACKAGE.parts, f"hullmap is imported from {PACKAGE}"
    assert (PACKAGE / "py.typed").exists() and (PACKAGE / "_hullmap.pyi").exists()


def test_the_wheel_holds_all_licences():
    files = {path.name: path for path in metadata.files("hullmap") or [] if "licenses" in path.parts}
    assert {"LICENSE-MIT", "LICENSE-APACHE", "LICENSES-OF-DEPENDENCIES.txt"} <= set(files)
    assert {"CITATION.cff", "SECURITY.md"} <= set(files)
    text = files["LICENSES-OF-DEPENDENCIES.txt"].read_text()
    headings = dict(re.findall(r"^==== (\S+) \S+: (.+)$", text, re.MULTILINE))
    # Some that are surely compiled in, and as many as such a library has.
    assert {"pyo3", "numpy", "rkyv", "glam", "rayon", "clap"} <= set(headings) and len(headings) > 50
    assert all(re.search("MIT|Apache|BSD|Zlib|ISC|Unicode|Unlicense|CC0", licence) for licence in headings.values())
    assert "Permission is hereby granted" in text
    assert "Its files are not in the registry" not in text and "hullmap-format" not in headings
    declared = metadata.metadata("hullmap").get_all("License-File") or []
    assert any(name.endswith("LICENSES-OF-DEPENDENCIES.txt") for name in declared), declared


def test_a_star_import_shadows_no_builtin():
    imported: dict[str, object] = {}
    exec("from hullmap import *", imported)
    assert "bake" in imported and not set(imported) & set(dir(builtins))
    assert callable(hullmap.open)


def test_examples_in_docstrings_run():
    count = 0
    for path in modules():
        folders = path.relative_to(PACKAGE.parent).with_suffix("").parts
        name = ".".join(folders).removesuffix(".__init__")
        if path.stem == "__main__":
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hullmap.BakeWarning)
            result = doctest.testmod(importlib.import_module(name), verbose=False)
        assert result.failed == 0, name
        count += result.attempted
    assert count > 60


@pytest.mark.parametrize("path", [PROJECT / "README.md", ROOT / "docs" / "python.md"], ids=lambda path: str(path.relative_to(ROOT)))
def test_examples_in_documents_run(path, tmp_path, monkeypatch):
    if not path.exists():
        pytest.skip(f"{path} is not beside the tests")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    text = path.read_text(encoding="utf-8")
    found = re.findall(r"^( *)```python\n(.*?)^ *```", text, re.DOTALL | re.MULTILINE)
    blocks = [textwrap.dedent(block) for _, block in found]
    assert blocks, path
    names: dict[str, object] = {}
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    for number, block in enumerate(blocks):
        for peer in ("matplotlib", "scipy"):
            if peer in block:
                pytest.importorskip(peer)
        if ">>>" in block:
            test = parser.get_doctest(block, names, f"{path.name}[{number}]", str(path), 0)
            assert runner.run(test, clear_globs=False).failed == 0, block
            names.update(test.globs)
        else:
            exec(compile(block, f"{path.name}[{number}]", "exec"), names)


def test_every_public_name_is_documented():
    for name in hullmap.__all__:
        thing = getattr(hullmap, name)
        assert name.startswith("__") or thing.__doc__, name
    for cls in (hullmap.Shape, hullmap.ConvexShape, hullmap.Hull, hullmap.Pack, hullmap.Lists):
        for name, member in vars(cls).items():
            if not name.startswith("_") and (callable(member) or isinstance(member, property)):
                assert member.__doc__, f"{cls.__name__}.{name}"


def test_the_stub_has_the_names_of_the_module():
    tree = ast.parse((PACKAGE / "_hullmap.pyi").read_text())
    stub = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    native = {name for name in dir(hullmap._hullmap) if not name.startswith("_")}
    constants = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}
    assert set(stub) | {name for name in constants if not name.startswith("_")} == native
    for name, node in stub.items():
        thing = getattr(hullmap._hullmap, name)
        if isinstance(node, ast.ClassDef) and not issubclass(thing, Exception):
            members = {own.name for own in node.body if isinstance(own, ast.FunctionDef)}
            fields = {own.target.id for own in node.body if isinstance(own, ast.AnnAssign)}
            assert {own for own in vars(thing) if not own.startswith("_")} == {own for own in members | fields if not own.startswith("_")}


def test_the_code_is_that_of_python_3_9():
    for path in modules():
        ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 9))


def test_types_are_strict(tmp_path):
    pytest.importorskip("mypy")
    user = tmp_path / "user.py"
    user.write_text(
        "import numpy as np\nimport hullmap\n"
        "pack: hullmap.Pack = hullmap.bake(np.zeros((4, 3)), max_vertices=8)\n"
        "gap = pack[0].distance(hullmap.Sphere(1.0), hullmap.poses([1, 2, 3]))\n"
        "reveal_type(gap.distance)\nreveal_type(pack['a'].vertices)\n"
    )
    words = [sys.executable, "-m", "mypy", "--strict", "--no-incremental", "--cache-dir", os.devnull]
    run = subprocess.run([*words, str(user)], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "float64" in run.stdout and re.search("float32|32Bit", run.stdout)
    run = subprocess.run([*words, "--ignore-missing-imports", "-p", "hullmap"], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 0, run.stdout + run.stderr


def accepted(options: dict[str, object]) -> str:
    """Values that the command's table accepts in place of a wrong option."""
    with pytest.raises(hullmap.BakeError) as caught:
        hullmap.bake([[0, 0, 0]], **options)
    return str(caught.value)


def annotation(expected: str) -> str:
    """The type of the values that the command's table describes so."""
    expected, unit, _ = expected.removesuffix(", or none").partition(", the same with ")
    words = [f'"{word}"' for word in re.split(", | or ", expected.removeprefix("one of "))]
    if expected.startswith("one of "):
        return f"Literal[{', '.join(words)}]"
    if expected.startswith("true, false or "):
        return "Union[bool, Literal[\"cover\"]]"
    if expected == "true or false":
        return "bool"
    if expected.startswith("a whole number"):
        return "int"
    assert expected == "a finite number above 0", expected
    return "Union[float, str]" if unit else "float"


def test_keywords_of_bakes_are_those_of_the_command():
    """The table of the command, as its messages show it, against the types."""
    listed = accepted({"?": 1}).removeprefix("unknown option ?: the options are ").split(", ")
    expected = {}
    for key in listed:
        prefix = f"invalid value ? of option {key}: expected "
        text = accepted({key: "?"})
        assert text.startswith(prefix), text
        expected[key] = f"Optional[{annotation(text.removeprefix(prefix))}]"
    tree = ast.parse((PACKAGE / "_options.py").read_text(encoding="utf-8"))
    body = next(node for node in tree.body if isinstance(node, ast.ClassDef)).body
    typed = {node.target.id: ast.unparse(node.annotation).replace("'", '"') for node in body if isinstance(node, ast.AnnAssign)}
    assert typed == expected
    # Each has a text that an editor shows.
    documented = [isinstance(after, ast.Expr) for node, after in zip(body, body[1:]) if isinstance(node, ast.AnnAssign)]
    assert len(documented) == len(typed) and all(documented)


def test_types_let_a_misspelt_option_pass(tmp_path):
    pytest.importorskip("mypy")
    calls = {
        "hullmap.bake(points, max_vertices=4, max_error='1%', index='compact', decompose=True)": None,
        "hullmap.bake(points, **options)": None,
        "hullmap.bake(points, max_vertexes=4)": 'Unexpected keyword argument "max_vertexes" for "bake"',
        "hullmap.bake_file('a.obj', max_vertexes=4)": 'Unexpected keyword argument "max_vertexes" for "bake_file"',
        "hullmap.bake_parts([(points, None)], indx='tree')": 'Unexpected keyword argument "indx" for "bake_parts"',
        "hullmap.from_trimesh(None, max_parts='many')": 'Argument "max_parts" to "from_trimesh" has incompatible type',
        "hullmap.bake(points, index='oak')": 'Argument "index" to "bake" has incompatible type',
        "hullmap.bake(points, max_vertices=2.5)": 'Argument "max_vertices" to "bake" has incompatible type',
    }
    user = tmp_path / "user.py"
    lines = ["import numpy as np, hullmap", "points = np.zeros((4, 3))", "options: hullmap.BakeOptions = {'max_parts': 8}", *calls]
    user.write_text("\n".join(lines) + "\n")
    words = [sys.executable, "-m", "mypy", "--strict", "--no-incremental", "--cache-dir", os.devnull, str(user)]
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    for line, error in enumerate(calls.values(), start=4):
        found = [text for text in run.stdout.splitlines() if text.startswith(f"user.py:{line}: error")]
        assert len(found) == (error is not None) and all(error in text for text in found), run.stdout


def test_the_global_lock_is_released(large):
    """Another thread counts while a query runs in this one."""
    poses = random_poses(200_000, 1, 2.5)
    count, done = 0, threading.Event()

    def tick():
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    before, start = count, time.monotonic()
    large.contact(large, poses, threads=1)
    ticks, seconds = count - before, time.monotonic() - start
    done.set()
    thread.join()
    assert seconds > 0.05 and ticks > 5


def test_threads_share_a_hull(large):
    poses = random_poses(20_000, 2, 2.5)
    expected = large.distance(large, poses).distance
    answers = [None] * 4

    def query(index):
        answers[index] = large.distance(large, poses).distance

    threads = [threading.Thread(target=query, args=(index,)) for index in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(answer, expected) for answer in answers)


def _in_child(hull, poses):
    return hull.distance(hull, poses).distance.sum()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_forked_children_have_threads_of_their_own(large):
    poses = random_poses(5000, 3, 2.5)
    expected = _in_child(large, poses)
    context = multiprocessing.get_context("fork")
    with context.Pool(2) as pool:
        answers = pool.starmap_async(_in_child, [(large, poses)] * 4).get(timeout=60)
    assert answers == [expected] * 4


def test_memory_is_freed():
    resource = pytest.importorskip("resource")
    hull = hullmap.bake(rock(200, 1))[0]
    poses = random_poses(100_000, 1, 2.5)

    def run():
        for _ in range(10):
            hull.contact(hull, poses)
            hullmap.bake(rock(2000, 1))[0].vertices.sum()

    run()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    run()
    run()
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert after - before < 40_000, f"{after - before} KB more"


@pytest.mark.parametrize("script", ["plots.py", "motion.py", "decomposition.py", "colliders.py"])
def test_examples_run(script, tmp_path):
    if script != "motion.py":
        pytest.importorskip("matplotlib")
    path = PROJECT / "examples" / script
    if not path.exists():
        pytest.skip(f"{path} is not beside the tests")
    if script in ("decomposition.py", "colliders.py") and not (PROJECT.parents[1] / "tests" / "meshes").exists():
        pytest.skip("the meshes are in the repository alone")
    run = subprocess.run([sys.executable, str(path), str(tmp_path)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert list(tmp_path.glob("*.png")) or list(tmp_path.glob("*.svg"))
    if script == "decomposition.py":
        # The README describes the picture with the numbers in it.
        readme = (PROJECT.parents[1] / "README.md").read_text(encoding="utf-8")
        assert run.stdout.splitlines()[1] in readme
