"""Many pairs in one call, against one call for each pair."""

from __future__ import annotations

import pickle
import time

import numpy as np
import pytest
from conftest import CUBE, matrices, random_poses, rock

import hullmap
from hullmap import ArrayError, PoseError, ShapeError

QUERIES = ("intersects", "distance", "contact", "manifold")


@pytest.fixture(scope="module")
def shapes():
    """Hulls of two packs, and primitives."""
    stones = hullmap.bake_parts([(rock(40 + 30 * seed, seed), None) for seed in range(4)])
    return [*stones, hullmap.bake(rock(90, 9))[0], hullmap.Sphere(0.5), hullmap.Box([0.6, 0.5, 0.4]), hullmap.Capsule(0.4, 0.3)]


@pytest.fixture(scope="module")
def pairs(shapes):
    return hullmap.Pairs(shapes, *np.triu_indices(len(shapes), 1))


def hits_of(answer):
    return answer.distance == 0 if isinstance(answer, hullmap.Distance) else answer.hit


def columns(answer):
    return {name: np.asarray(value) for name, value in vars(answer).items()}


def assert_same(found, expected, **tolerance):
    for name, column in columns(expected).items():
        if tolerance and column.dtype.kind == "f":
            assert np.allclose(columns(found)[name], column, equal_nan=True, **tolerance), name
        elif not tolerance or name == "hit":
            assert np.array_equal(columns(found)[name], column, equal_nan=column.dtype.kind == "f"), name


def one_by_one(pairs, query, b_in_a, *more, **settings):
    """The slow twin: a call for each pair."""
    for at, (a, b) in enumerate(zip(pairs.a, pairs.b)):
        own = [column[at] for column in more]
        yield getattr(pairs.shapes[a], query)(pairs.shapes[b], b_in_a[at], *own, **settings)


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("threads", [1, 2, None])
def test_pairs_have_the_bits_of_single_calls(pairs, query, threads):
    b_in_a = random_poses(len(pairs), 2, 2.2)
    found = getattr(pairs, query)(b_in_a, threads=threads)
    for at, alone in enumerate(one_by_one(pairs, query, b_in_a)):
        assert_same(found[at], alone)
    hits = hits_of(found)
    assert 0.3 < hits.mean() < 0.9 and len(found[hits]) == hits.sum()


def test_casts_of_pairs_have_the_bits_of_single_calls(pairs):
    b_in_a, ways = random_poses(len(pairs), 3, 4.0), -random_poses(len(pairs), 4, 2.0)[:, :3]
    found = pairs.cast(b_in_a, ways)
    for at, alone in enumerate(one_by_one(pairs, "cast", b_in_a, ways)):
        assert_same(found[at], alone)
    assert 0.1 < found.hit.mean() < 0.9
    same = pairs.cast(b_in_a, ways[0])
    assert_same(same, pairs.cast(b_in_a, np.tile(ways[0], (len(pairs), 1))))


def test_pairs_take_packs_and_planes(shapes):
    union = hullmap.bake_parts([(CUBE, None), (CUBE + [4, 0, 0], None)])
    floor = hullmap.HalfSpace([0, 0, 1], 0.0)
    pairs = hullmap.Pairs([union, floor, *shapes], [0, 0, 1, 1, 2], [2, 0, 0, 7, 0])
    b_in_a = random_poses(5, 5, 2.0)
    for query in ("intersects", "distance", "contact", "manifolds"):
        found = getattr(pairs, query)(b_in_a)
        for at, alone in enumerate(one_by_one(pairs, query, b_in_a)):
            assert_same(found[at], alone)
    with pytest.raises(ShapeError, match="pair 0: manifold takes convex shapes, found a pack"):
        pairs.manifold(b_in_a)
    with pytest.raises(ShapeError, match="pair 1: distance: two half-spaces have no query"):
        hullmap.Pairs([union, floor], [0, 1], [0, 1]).distance(hullmap.poses([0, 0, 0]))
    # A pack in place of the list stands for its hulls.
    assert len(hullmap.Pairs(union, [0], [1]).shapes) == 2


def test_poses_may_be_those_of_the_shapes(pairs, shapes):
    in_world = random_poses(3 * len(shapes), 6, 2.5).reshape(3, len(shapes), 7)
    b_in_a = hullmap.relative(in_world[:, pairs.a], in_world[:, pairs.b])
    expected = pairs.contact(b_in_a)
    assert expected.shape == (3, len(pairs)) and 0.1 < expected.hit.mean() < 0.9
    assert_same(pairs.contact(in_world=in_world), expected, atol=1e-12)
    assert_same(pairs.contact(in_world=matrices(in_world)), expected, atol=1e-9)
    both = pairs.contact(a_in_world=in_world[:, pairs.a], b_in_world=in_world[:, pairs.b])
    assert_same(both, pairs.contact(in_world=in_world))
    for moment in range(3):
        assert_same(pairs.contact(in_world=in_world[moment]), pairs.contact(in_world=in_world)[moment])
    # One pose for all pairs, and one for each moment.
    assert_same(pairs.distance(b_in_a[0, 0]), pairs.distance(np.tile(b_in_a[0, 0], (len(pairs), 1))))
    assert pairs.distance(b_in_a[:, :1]).shape == (3, len(pairs))
    assert_same(pairs.distance(a_in_world=hullmap.poses([0, 0, 0]), b_in_world=b_in_a), pairs.distance(b_in_a))


@pytest.mark.parametrize("query", QUERIES)
def test_a_motion_gives_the_same_answers_on_any_number_of_threads(shapes, query):
    """A motion has the same answers as its single poses within rounding error, and one call for all
    steps has the same answers as one call for each step."""
    steps = np.linspace(0, 1, 40)[:, None]
    start, way = random_poses(len(shapes), 7, 2.0), np.random.default_rng(8).normal(size=(len(shapes), 3))
    path = np.tile(start, (len(steps), 1, 1))
    path[..., :3] += 0.5 * steps[:, None] * way
    # Enough pairs for several threads.
    members = tuple(np.tile(index, 3) for index in np.triu_indices(len(shapes), 1))
    moving = [getattr(hullmap.Pairs(shapes, *members), query)(in_world=path, coherent=True, threads=n) for n in (1, 2)]
    assert_same(*moving)
    pairs = hullmap.Pairs(shapes, *members)
    for step, poses in enumerate(path):
        assert_same(getattr(pairs, query)(in_world=poses, coherent=True), moving[0][step])
    plain = getattr(pairs, query)(in_world=path)
    assert (hits_of(moving[0]) == hits_of(plain)).all() and 0.1 < hits_of(plain).mean() < 0.9
    for name in {"distance", "depth"} & set(columns(plain)) if query != "manifold" else ():
        assert np.allclose(columns(moving[0])[name], columns(plain)[name], rtol=3e-5, atol=1e-9)
    if query == "distance":
        assert moving[0].support_calls.mean() < 0.8 * plain.support_calls.mean()


def test_pairs_are_a_hundred_times_as_fast_as_calls(pairs):
    """258 pairs cost 258 calls."""
    many = hullmap.Pairs(pairs.shapes, np.resize(pairs.a, 258), np.resize(pairs.b, 258))
    b_in_a = random_poses(258, 9, 3.0)

    def seconds(work):
        start = time.perf_counter()
        work()
        return time.perf_counter() - start

    together = min(seconds(lambda: many.intersects(b_in_a, threads=1)) for _ in range(5))
    alone = min(seconds(lambda: list(one_by_one(many, "intersects", b_in_a, threads=1))) for _ in range(3))
    # It is 40 times in a quiet release build.
    assert alone > 8 * together, (alone, together)


def test_wrong_pairs_are_rejected(shapes, pairs):
    for a, b, words in (
        ([0, 9], [1, 1], r"a\[1\]: index 9 is out of range: there are 8 shapes, counted from 0"),
        ([0, 1], [1, 8], r"b\[1\]: index 8 is out of range"),
        ([0], [-1], "b: index -1 is out of range: shapes are counted from 0"),
        ([0.5], [1], "a: expected whole numbers, found float64"),
        ([True], [1], "a: expected whole numbers, found bool"),
        ([0, 1, 2], [1, 2], "pass one index of each for each pair"),
        ([[0]], [1], r"expected one axis, found the shape \(1, 1\): ravel them"),
    ):
        with pytest.raises(ArrayError, match=words):
            hullmap.Pairs(shapes, a, b)
    with pytest.raises(ArrayError, match="expected a shape of hullmap, found ndarray"):
        hullmap.Pairs([CUBE], [0], [0])
    poses = random_poses(len(pairs), 1, 2)
    with pytest.raises(ArrayError, match="pass b_in_a, or both a_in_world and b_in_world, or in_world"):
        pairs.distance()
    with pytest.raises(ArrayError, match="pass b_in_a, or both"):
        pairs.distance(poses, in_world=poses)
    with pytest.raises(ArrayError, match=r"one pose for each of the 28 pairs in the last axis.* found poses of the shape \(3,\)"):
        pairs.distance(poses[:3])
    with pytest.raises(ArrayError, match=r"in_world: expected one pose for each of the 8 shapes.* found poses of the shape \(28,\)"):
        pairs.distance(in_world=poses)
    with pytest.raises(ArrayError, match=r"velocity: expected rows of the shape \(28,\), or one for all, found \(3,\)"):
        pairs.cast(poses, np.ones((3, 3)))
    poses[[5, 20], 3] = np.nan
    with pytest.raises(PoseError, match=r"b_in_a\[5\]: rotation must be finite"):
        pairs.distance(poses)
    with pytest.raises(PoseError, match=r"in_world\[5\]: rotation must be finite"):
        pairs.distance(in_world=poses[: len(shapes)])
    for coherent in (False, True):
        with pytest.raises(PoseError, match=r"b_in_a\[5\]"):
            pairs.distance(poses, coherent=coherent)


def test_no_pairs_give_empty_answers(shapes):
    none = hullmap.Pairs(shapes, [], [])
    at = random_poses(2 * len(shapes), 1, 2).reshape(2, len(shapes), 7)
    assert none.contact(in_world=at).depth.shape == (2, 0) and len(none) == 0
    assert none.distance(np.zeros((0, 7)), coherent=True).distance.shape == (0,)
    assert hullmap.Pairs([], [], []).intersects(hullmap.poses([0, 0, 0])).hit.shape == (0,)


def test_pairs_can_be_pickled(pairs):
    again, poses = pickle.loads(pickle.dumps(pairs)), random_poses(len(pairs), 1, 2)
    assert_same(again.contact(poses), pairs.contact(poses))
    assert repr(again) == "<28 pairs of 8 shapes>"
