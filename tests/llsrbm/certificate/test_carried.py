"""The certificate in files: what is written is read back."""

import json
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.certificate import Certificate, Finding, stated
from llsrbm.errors import FileFormatError
from llsrbm.motion.sampling import resample
from llsrbm.motion.trajectory import description
from tests.llsrbm.formats.jumps import planned, simulated

FINDINGS = (
    Finding("friction", 0.578, 0.5, "", "RL", 0.38, True, 1.01),
    Finding("slip", 0.012, 0.01, "m", "RL", 0.4, False, 0.01),
    Finding("dynamics", None, None, "N", "", None, None, why="pushes act beside the contacts"),
)
KNOWN = Certificate(FINDINGS)


@pytest.fixture(params=[planned, simulated])
def carrying(request):
    return replace(request.param("go2"), certificate=KNOWN.as_dict())


def test_native_files_give_the_same_back(carrying, tmp_path):
    path = tmp_path / "motion.npz"
    carrying.save(path)
    assert stated(llsrbm.load(path)) == KNOWN
    assert stated(carrying).holds is False
    # It is there already: nothing is computed.
    assert llsrbm.certified(carrying) is carrying


@pytest.mark.parametrize(
    ("findings", "holds"),
    [(FINDINGS[:1], True), (FINDINGS[:2], False), (FINDINGS[::2], False), ((), False)],
    ids=["all hold", "one is broken", "one is not known", "nothing is checked"],
)
def test_a_plan_is_certified_where_all_checks_are_known_to_hold(findings, holds):
    plan = replace(planned("go2"), certificate=Certificate(findings).as_dict())
    assert plan.certified is holds
    assert not replace(plan, certificate=None).certified


def test_exports_carry_it(carrying, tmp_path):
    path = tmp_path / "motion.npz"
    llsrbm.export(carrying, path, "motion-npz")
    meta = json.loads(str(np.load(path)["meta"]))
    assert meta["certificate"] == KNOWN.as_dict()
    path = tmp_path / "motion.csv"
    llsrbm.export(carrying, path, "unitree-csv")
    beside = json.loads((tmp_path / "motion.csv.meta.json").read_text())
    assert beside["certificate"] == KNOWN.as_dict()


def test_another_motion_does_not_carry_it(carrying):
    assert resample(carrying, carrying.time[::2]).certificate is None
    assert "certificate" not in description(resample(carrying, carrying.time[::2]))


def test_what_is_no_certificate_is_refused(carrying, tmp_path):
    path = tmp_path / "motion.npz"
    carrying.save(path)
    arrays = dict(np.load(path))
    meta = json.loads(str(arrays["meta"]))
    for wrong in ({"worst": 1.0}, {**FINDINGS[1].as_dict(), "worst": "much"}):
        meta["certificate"] = {"slip": wrong}
        np.savez(path, **{**arrays, "meta": np.array(json.dumps(meta))})
        with pytest.raises(FileFormatError, match=r"certificate\.slip"):
            llsrbm.load(path)


def test_a_plan_gets_its_own(tmp_path):
    plan = planned("go2")
    path = tmp_path / "plan.npz"
    llsrbm.certified(plan).save(path)
    assert stated(llsrbm.load(path)).as_dict() == llsrbm.certify(plan).as_dict()
    failed = replace(plan, report=replace(plan.report, status="not-converged"))
    assert llsrbm.certified(failed) is failed
