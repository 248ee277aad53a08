import logging
import os

import pytest

from llsrbm import cache


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.ENVIRONMENT_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_environment_overrides_the_directory(own_cache, monkeypatch):
    path = cache.cache_path("solvers", b"key", ".casadi")
    assert path.parent == own_cache / "solvers"
    assert path.suffix == ".casadi"
    monkeypatch.delenv(cache.ENVIRONMENT_VARIABLE)
    assert cache.cache_directory().name == "llsrbm"


def test_an_entry_is_computed_once():
    calls = []

    def compute() -> bytes:
        calls.append(1)
        return b"result"

    assert cache.cached_bytes("kind", b"key", ".bin", compute) == b"result"
    assert cache.cached_bytes("kind", b"key", ".bin", compute) == b"result"
    assert cache.cached_bytes("kind", b"other key", ".bin", compute) == b"result"
    assert len(calls) == 2


@pytest.mark.parametrize("damage", [lambda b: b[:-1], lambda b: b"", bytes.swapcase])
def test_a_damaged_entry_is_computed_anew_with_a_warning(damage, caplog):
    cache.cached_bytes("kind", b"key", ".bin", lambda: b"a result")
    path = cache.cache_path("kind", b"key", ".bin")
    path.write_bytes(damage(path.read_bytes()))
    with caplog.at_level(logging.WARNING):
        assert cache.cached_bytes("kind", b"key", ".bin", lambda: b"again") == b"again"
    assert "damaged" in caplog.text
    assert cache.read_checked(path) == b"again"


def test_a_directory_that_cannot_be_written_is_a_warning(own_cache, caplog):
    own_cache.write_text("a file where the directory should be")
    with caplog.at_level(logging.WARNING):
        assert cache.cached_bytes("kind", b"key", ".bin", lambda: b"result") == b"result"
    assert "cannot be written" in caplog.text


def test_a_key_tells_its_parts_apart(tmp_path):
    file = tmp_path / "file"
    file.write_bytes(b"content")
    assert cache.content_key("ab", "c") != cache.content_key("a", "bc")
    assert cache.content_key(file) == cache.content_key(b"content") == cache.content_key("content")
    file.write_bytes(b"changed")
    assert cache.content_key(file) != cache.content_key(b"content")


def test_what_a_killed_process_had_begun_to_write_is_removed(own_cache):
    path = cache.cache_path("kind", b"key", ".bin")
    path.parent.mkdir(parents=True)
    old, new = (path.with_name(f"{path.name}{name}.tmp") for name in ("old", "new"))
    for begun in (old, new):
        begun.write_bytes(b"half")
    os.utime(old, (0, 0))
    cache.write_checked(path, b"all")
    assert [old.exists(), new.exists()] == [False, True]


def test_of_each_kind_the_entries_used_last_are_kept(own_cache):
    keys = [bytes([k]) for k in range(cache.KEPT + 2)]
    for age, key in enumerate(keys):
        cache.cached_bytes("kind", key, ".bin", lambda key=key: key)
        path = cache.cache_path("kind", key, ".bin")
        os.utime(path, (1000 + age, 1000 + age))
        cache.cached_bytes("kind", keys[0], ".bin", lambda: keys[0])
    kept = {path.name for path in (own_cache / "kind").iterdir()}
    assert len(kept) == cache.KEPT
    assert cache.cache_path("kind", keys[0], ".bin").name in kept
    assert cache.cache_path("kind", keys[-1], ".bin").name in kept
    assert cache.cache_path("kind", keys[1], ".bin").name not in kept
