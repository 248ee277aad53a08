"""A library's folder: motions are added, named, joined, opened; what is wrong is said."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.errors import FileFormatError, InputError
from llsrbm.library import Library
from llsrbm.library.card import Simulated, kind_of
from llsrbm.library.file import StoredMotion
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from tests.llsrbm.library.shipped_motions import card, library, plan


@pytest.fixture
def own(tmp_path):
    return Library(tmp_path / "own")


def another(**changes):
    """A motion of another request, for what looks at names alone."""
    kept = library().stored(card().name)
    request = replace(kept.card.request, **changes)
    return StoredMotion(kept.card.model_copy(update={"request": request}), kept.numbers)


def test_a_plan_is_added_once_and_found_by_whoever_opens_the_folder(own):
    found = own.add(plan(), Simulated(2, 2, 1))
    assert found.name == "go2-together-0001"
    assert found.simulated == Simulated(2, 2, 1)
    assert found.certified
    with pytest.raises(InputError, match=r"^go2-together-0001 is the motion of that request"):
        own.add(plan())
    again = Library(own.folder)
    assert [each.name for each in again.cards] == [found.name]
    assert again.open(found.name).certified


def test_numbers_go_on_and_stay_when_files_are_joined(own):
    for forward in (0.1, 0.2, 0.3):
        own.put(another(forward=forward))
    names = [each.name for each in own.cards]
    assert names == [f"go2-together-000{k}" for k in (1, 2, 3)]
    assert len(own.files) == 3
    own.packed()
    assert [path.name for path in own.files] == ["go2.npz"]
    assert [each.name for each in own.cards] == names
    assert own.put(another(forward=0.4)).name == "go2-together-0004"
    own.packed()
    assert len(Library(own.folder).cards) == 4


def test_many_motions_of_a_robot_are_several_files(own, monkeypatch):
    monkeypatch.setattr("llsrbm.library.file.MOST", 2)
    for forward in (0.1, 0.2, 0.3):
        own.put(another(forward=forward))
    own.packed()
    assert [path.name for path in own.files] == ["go2-2.npz", "go2.npz"]
    assert len(Library(own.folder).cards) == 3
    own.packed()  # and again
    assert len(Library(own.folder).cards) == 3


def test_requests_that_differ_by_less_than_a_millimetre_are_one(own):
    own.put(another(forward=0.1))
    with pytest.raises(InputError, match="expected another one"):
        own.put(another(forward=0.1002))
    own.put(another(forward=0.102))


def test_a_motion_whose_certificate_does_not_hold_is_refused(own):
    heavy = replace(plan(), contact_force=2 * plan().contact_force)
    with pytest.raises(InputError, match=r"certificate does not hold \(.*dynamics"):
        own.add(heavy)


@pytest.mark.parametrize(
    ("jump", "kind"),
    [
        (Jump(forward=0.3), "together"),
        (Jump(twist=2.5), "pirouette"),
        (Jump(twist=-2.5, forward=0.2), "together"),
        (Jump(type="flip", pitch=-2 * np.pi), "back-flip"),
        (Jump(type="flip", pitch=2 * np.pi), "front-flip"),
        (Jump(route=(Landing(0.1), Landing(0.2))), "route"),
        (Jump(type="over-gap", gap=0.2), "over-gap"),
        (Jump(type="somewhere/My Type.toml"), "my-type"),
    ],
)
def test_kinds_are_what_people_call_them(jump, kind):
    assert kind_of(jump) == kind


def test_names_that_are_not_there(own):
    with pytest.raises(InputError, match=r"no motion .go2-together-9999.; did you mean"):
        library().open("go2-together-9999")
    with pytest.raises(InputError, match="no library is there; expected one that was built"):
        own.open("go2-together-0001")


def test_a_damaged_file_is_named(own):
    own.add(plan())
    (path,) = own.files
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(FileFormatError, match=str(path)):
        _ = Library(own.folder).cards


def test_a_plan_that_is_no_library_file_is_named(own):
    own.folder.mkdir()
    plan().save(own.folder / "plan.npz")
    with pytest.raises(FileFormatError, match=r'plan\.npz: schema "llsrbm\.plan/2"; expected'):
        _ = own.cards


def test_other_joints_by_now_are_said(own, monkeypatch):
    own.add(plan())
    again = Library(own.folder)
    path, meta, of = again._where["go2-together-0001"]
    again._where["go2-together-0001"] = path, meta.model_copy(update={"joint_names": ["a"]}), of
    with pytest.raises(FileFormatError, match="with the joints a; expected FL_hip_joint"):
        again.open("go2-together-0001")
