import pytest

from llsrbm.planning.solve import explanation


@pytest.fixture(autouse=True)
def _time_to_explain(monkeypatch):
    """Explanations end by the clock, which on a busy machine would decide what they find."""
    monkeypatch.setattr(explanation, "EXPLANATION_TIME", 600.0)
