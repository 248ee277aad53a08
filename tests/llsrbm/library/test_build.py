"""Builds: until there are motions enough, and on from where one was cut off."""

import json
import time
from dataclasses import replace

import pytest

from llsrbm.certified_nearest import is_unlikely
from llsrbm.errors import InputError
from llsrbm.library.attempt import (
    FAILED,
    KEPT,
    NONE_LIKE_IT,
    NOT_PLANNED,
    NOT_STRICT,
    THERE,
    Attempt,
    NotStrict,
    Request,
    attempt,
    judged,
)
from llsrbm.library.build import Build, on_workers, read_requests
from llsrbm.library.card import Simulated
from llsrbm.library.draws import Draw
from llsrbm.library.file import StoredMotion
from llsrbm.library.mirror import image_of
from tests.llsrbm.library.shipped_motions import card, library, plan


def motion_for(request):
    """A motion that says it is of a request."""
    kept = library().stored(card().name)
    changed = {"request": request.jump, "drawn": request.number, "robot": request.jump.robot}
    return StoredMotion(kept.card.model_copy(update=changed), kept.numbers)


class Runner:
    """Every third request fails; ends after some."""

    def __init__(self, most=1000):
        self.most, self.taken = most, []

    def __call__(self, requests, seeds):
        for request in requests:
            if len(self.taken) == self.most:
                return
            self.taken.append(request.number)
            if request.number % 3 == 2:
                yield Attempt(request, FAILED, why="every third")
            else:
                yield Attempt(request, KEPT, motion_for(request))


def built(folder, count, runner):
    build = Build(folder)
    counts = build.run(build.draws(["go2"], count), 0, runner, lambda _: None)
    build.close()
    return build, counts


def test_it_ends_when_there_are_enough(tmp_path):
    build, counts = built(tmp_path, 4, runner := Runner())
    assert counts == {KEPT: 4, FAILED: 1}
    assert runner.taken == [0, 1, 2, 3, 4]
    assert build.kept("go2") == 4
    lines = (tmp_path / "journal.jsonl").read_text().splitlines()
    assert [json.loads(line)["status"] for line in lines].count(FAILED) == 1


def test_a_build_that_was_cut_off_goes_on(tmp_path):
    built(tmp_path, 4, Runner(most=3))
    # As if it was killed after a motion was written and within its line.
    journal = tmp_path / "journal.jsonl"
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text(lines[0] + lines[2][:10])
    build, _ = built(tmp_path, 4, runner := Runner())
    assert runner.taken == [2, 3, 4]  # 0 is in the journal, 1 among the motions
    assert build.kept("go2") == 4
    numbers = [
        json.loads(line)["draw"] for line in journal.read_text().splitlines() if line[-1] == "}"
    ]
    assert numbers == [0, 2, 3, 4]
    build.library.packed()
    build, counts = built(tmp_path, 6, runner := Runner())
    assert runner.taken == [5, 6, 7]
    assert counts[KEPT] == 2


def test_one_process_at_a_time_builds_in_a_folder(tmp_path):
    build = Build(tmp_path)
    with pytest.raises(InputError, match="another process builds in it"):
        Build(tmp_path)
    build.close()
    Build(tmp_path).close()


def every_third(request, seeds, limit):
    (found,) = Runner()(iter([request]), seeds)
    return found


def test_workers_of_a_cluster_do_the_same(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr("llsrbm.library.build.run_attempt", every_third)
    with distributed.Client(processes=False, n_workers=2, dashboard_address=None) as client:
        build, counts = built(tmp_path, 4, on_workers(client))
    assert build.kept("go2") >= 4
    assert counts[KEPT] <= 4 + 4  # two more a worker were under way
    assert counts[FAILED] >= 1


def test_images_are_tried_once_where_there_is_another(tmp_path):
    build, _ = built(tmp_path, 4, Runner())
    build = Build(tmp_path)
    wanted = list(build.images(["go2"]))
    moved = [each for each in build.library.cards if image_of(each) != each.request]
    assert [each.original.card.name for each in wanted] == sorted(each.name for each in moved)
    assert list(build.images(["anymal"])) == []

    def none(requests, seeds):
        for request in requests:
            yield Attempt(request, FAILED)

    build.run(iter(wanted), 0, none, lambda _: None)
    build.close()
    assert list(Build(tmp_path).images(["go2"])) == []


def test_a_robot_of_which_nothing_comes_is_given_up(tmp_path):
    def none(requests, seeds):
        for request in requests:
            yield Attempt(request, FAILED)

    _, counts = built(tmp_path, 3, none)
    assert counts == {FAILED: 12}


def test_a_request_that_is_there_already_is_noted(tmp_path):
    build = Build(tmp_path)
    path = tmp_path / "requests.json"
    path.write_text(json.dumps([{"robot": "go2", "forward": 0.25}] * 2))

    def kept(requests, seeds):
        for request in requests:
            yield Attempt(request, KEPT, motion_for(request))

    counts = build.run(iter(read_requests(path)), 0, kept, lambda _: None)
    assert counts == {KEPT: 1, THERE: 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", "expected a list of requests"),
        ("[3]", "request 1: expected an object"),
        ('[{"far": 1}]', 'request 1: no field "far"'),
        ('[{}, {"forward": "x"}]', "request 2: forward: expected a finite number"),
        ("[", "not a JSON file"),
    ],
)
def test_requests_that_are_none(tmp_path, text, message):
    path = tmp_path / "requests.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_requests(path)


def test_requests_as_plans_state_them(tmp_path):
    path = tmp_path / "requests.json"
    of = plan().jump
    path.write_text(json.dumps([of.as_dict() | {"limits": {"friction": 0.4}}]))
    (found,) = read_requests(path)
    assert found.jump == of
    assert dict(found.tuning.limits) == {"friction": 0.4}


def test_a_motion_that_is_not_strict_is_not_kept(monkeypatch):
    monkeypatch.setattr("llsrbm.library.attempt.simulated", lambda *_: Simulated(2, 2, 1))
    with pytest.raises(NotStrict, match="simulation 2 of 3 did not land strictly"):
        judged(plan(), 3)
    monkeypatch.setattr("llsrbm.library.attempt.simulated", lambda *_: Simulated(3, 3, 3))
    assert judged(plan(), 3).card.simulated == Simulated(3, 3, 3)
    assert NOT_STRICT != FAILED
    assert replace(Simulated(), seeds=0).all_strict is False


def test_what_a_table_has_next_to_none_of_is_not_tried():
    """To look for a plan of this one of ANYmal's takes as long as three motions do."""
    request = Request.drawn(Draw("anymal", 12))
    assert is_unlikely(request.jump, request.tuning)
    began = time.process_time()
    found = attempt(request, 0)
    assert (found.status, found.why) == (NOT_PLANNED, NONE_LIKE_IT)
    assert time.process_time() - began < 3.0
