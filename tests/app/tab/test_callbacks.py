"""The session's rule: what viser calls on its event loop only puts into the inbox."""

import inspect
import threading
from enum import Enum
from types import SimpleNamespace

import viser

from tests.app.waits import wait_until

EVENT = '{"kind": "certificate"}'  # as a page's script sends it


def own_values(thing, found):
    """(object, attribute) -> value, of everything of the page's own that hangs on a thing."""
    if id(thing) in found or isinstance(thing, Enum | type):
        return
    if isinstance(thing, dict | list | tuple | set | frozenset):
        found[id(thing)] = thing, [*thing.items()] if isinstance(thing, dict) else [*thing]
        for each in [*thing.values()] if isinstance(thing, dict) else thing:
            own_values(each, found)
    elif type(thing).__module__.startswith("app.") and hasattr(thing, "__dict__"):
        found[id(thing)] = thing, dict(vars(thing))
        for value in vars(thing).values():
            own_values(value, found)


def snapshot(session):
    found = {}
    for thing in (session._rendering, session._outside.link, session.state):
        own_values(thing, found)
    return found


def callbacks(session):
    """(control, callback) of all controls, and of what can be dragged in the picture."""
    client = session._client
    controls = [*client.gui._gui_input_handle_from_uuid.values()]
    dragged = [*client.scene._handle_from_transform_controls_name.values()]
    pairs = [(each, each._impl.update_cb) for each in controls]
    pairs += [(each, each._impl_aux.update_cb) for each in dragged]
    return [(each, callback) for each, found in pairs for callback in found]


def test_callbacks_only_put(session, monkeypatch):
    wait_until(lambda: session.state.page, "the page's greeting")
    session.close()  # nobody takes what is put
    assert session.join(5)
    put, sent, here = [], [], threading.get_ident()

    def collect(found):  # what the page's own events lead to comes from the server's thread
        return lambda each: found.append(each) if threading.get_ident() == here else None

    monkeypatch.setattr(session._inbox, "_queue", SimpleNamespace(put=collect(put)))
    monkeypatch.setattr(session._client._websock_connection, "queue_message", collect(sent))
    found = callbacks(session)
    assert len(found) > 80
    before = snapshot(session)
    for control, callback in found:
        if isinstance(control, viser.GuiUploadButtonHandle):
            control._impl.value = viser.UploadedFile("a.json", b"{}")
        elif control is session._outside.link._field:
            control._impl.value = EVENT
        assert inspect.iscoroutinefunction(callback), control  # in order, on the event loop
        event = SimpleNamespace(client_id=0, target=control, phase="update")
        try:
            callback(event).send(None)
        except StopIteration:
            continue  # it waits for nothing
        raise AssertionError(control)
    assert len(put) == len(found)
    after = snapshot(session)
    changed = [
        f"{type(thing).__name__}: {values} became {after[key][1]}"
        for key, (thing, values) in before.items()
        if after[key][1] != values
    ]
    assert not changed
    assert not sent
