"""What a tab writes and reads: designs, and motions in the formats that there are."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import viser

from app.panel import Panel, Uploaded
from app.upload import uploaded_design
from llsrbm.design import Design, dump_design, file_name
from llsrbm.errors import Error
from llsrbm.formats import export
from llsrbm.formats import file_name as exported_name
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout


class Files:
    """One tab's; what cannot be done is said on its panel."""

    def __init__(self, client: viser.ClientHandle, panel: Panel) -> None:
        """Nothing happens yet.

        Args:
            client: the tab.
            panel: has the format, and says what went wrong.
        """
        self._client = client
        self._panel = panel

    def opened(self, file: Uploaded) -> Design | None:
        """The design in a file that was opened, or None."""
        try:
            return uploaded_design(file.name, file.content)
        except Error as error:
            self._panel.notify("Not opened", str(error))
            return None

    def save(self, design: Design) -> None:
        """Send a design, with the scenario that the panel has."""
        scenario, _ = self._panel.simulation.read(design.scenario)
        content = dump_design(replace(design, scenario=scenario)).encode()
        self._client.send_file_download(file_name(design), content, save_immediately=True)

    def export(self, shown: Plan | Rollout | None) -> None:
        """Send a motion in the format that is chosen."""
        if shown is None:
            self._panel.notify("Nothing to export", "There is no plan yet.")
            return
        name, complaints = self._panel.read_format()
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
        try:
            file, content = exported(shown, name)
        except Error as error:
            self._panel.notify("Not exported", str(error))
            return
        self._client.send_file_download(file, content, save_immediately=True)


def exported(trajectory: Plan | Rollout, format_name: str) -> tuple[str, bytes]:
    """File name and content.

    Raises:
        llsrbm.errors.Error: the format cannot hold it.
    """
    name = exported_name(trajectory, [format_name])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        export(trajectory, path, format=format_name)
        return name, path.read_bytes()
