import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from app.motion.clip import AnimationChannel, Clip, Track
from tests.app.page_script import decoded

RNG = np.random.default_rng(5)


def attitudes(frames):
    wxyz = RNG.normal(size=(frames, 4))
    return wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)


def test_a_browser_reads_what_was_there():
    plan = AnimationChannel(
        np.linspace(0, 1.3, 7),
        (
            Track(("/a", "/b"), RNG.normal(size=(7, 3)), attitudes(7), RNG.normal(size=(7, 3))),
            Track(("/c",), RNG.normal(size=(7, 3))),
        ),
    )
    rollout = AnimationChannel(
        np.linspace(0, 2.3, 4),
        (
            Track(("/d",), RNG.normal(size=(4, 3)), scale=np.zeros((4, 3))),
            Track(("/e",), RNG.normal(size=(4, 3)), attitudes(4)),
        ),
    )
    header, blob = Clip((plan, rollout), 2.3).encoded
    strands, end = decoded(header, blob)
    assert end == 2.3
    for (time, nodes), strand in zip(strands, (plan, rollout), strict=True):
        assert time == pytest.approx(strand.time, abs=1e-6)
        assert list(nodes) == [name for track in strand.tracks for name in track.nodes]
        for track in strand.tracks:
            for name in track.nodes:
                position, wxyz, scale = nodes[name]
                assert position == pytest.approx(track.position, abs=1e-6)
                assert (wxyz is None, scale is None) == (track.wxyz is None, track.scale is None)
                if wxyz is not None:
                    # The same attitude on either side.
                    assert np.abs(np.sum(wxyz * track.wxyz, axis=1)) == pytest.approx(1, abs=1e-6)
                if scale is not None:
                    assert scale == pytest.approx(track.scale, abs=1e-6)


def test_nothing_to_play_is_encoded_too():
    header, blob = Clip((), 0.0).encoded
    assert decoded(header, blob) == ([], 0.0)


SOME = arrays(float, st.tuples(st.integers(1, 12), st.just(4)), elements=st.floats(-1, 1)).filter(
    lambda values: (np.linalg.norm(values, axis=1) > 0.1).all()
)


@given(SOME)
def test_neighbouring_quaternions_can_be_mixed(values):
    """None is farther than 90 degrees, on the sphere of quaternions, from the one before."""
    wxyz = values / np.linalg.norm(values, axis=1, keepdims=True)
    strand = AnimationChannel(
        np.arange(len(wxyz)), (Track(("/a",), np.zeros((len(wxyz), 3)), wxyz),)
    )
    header, blob = Clip((strand,), 1.0).encoded
    (((_, nodes),), _) = decoded(header, blob)
    sent = nodes["/a"][1].astype(float)
    assert (np.sum(sent[1:] * sent[:-1], axis=1) >= -1e-6).all()
    assert np.minimum(np.abs(sent - wxyz), np.abs(sent + wxyz)).max() < 1e-6
