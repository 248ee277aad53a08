"""What one tab opens and saves: files go to the pool's processes and come back, beside all else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import viser

from app.compute.opened_file import OpenedFile
from app.compute.pool import WorkerPool
from app.compute.protocol import (
    Cancelled,
    Exported,
    ExportMotion,
    Failed,
    Opened,
    OpenFile,
    Progress,
    Report,
)
from app.panel.export_controls import PLAN
from app.panel.panel import Panel, Uploaded
from llsrbm.design import Design, dump_design, file_name
from llsrbm.formats import FORMATS
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout


@dataclass(frozen=True)
class FileReport:
    """What the pool reports of a file.

    Attributes:
        report: the pool's.
    """

    report: Report


class Files:
    """One tab's; for one thread. What cannot be done is said on its panel.

    The pool takes opening and saving for tabs of their own, so that they neither wait for the tab's
    plans nor take their place.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        panel: Panel,
        pool: WorkerPool,
        listener: Callable[[FileReport], None],
    ) -> None:
        """Nothing happens yet.

        Args:
            client: the tab.
            panel: says what is to be saved, and what went wrong.
            pool: reads and writes.
            listener: called from the pool's thread with what `hear` shall hear.
        """
        self._client = client
        self._panel = panel
        self._pool = pool
        self._listener = listener
        self._opening, self._saving = _lanes(client.client_id)
        self._opened_job = self._saved_job = 0  # the newest; 0 when nothing is awaited
        self._saved = ""  # what is being saved
        self._note: viser.NotificationHandle | None = None

    def open(self, file: Uploaded, robot: str) -> None:
        """Have a file read; `hear` returns what it holds.

        Args:
            file: as it came.
            robot: whose motion it is, where the file does not say.
        """
        fps = None
        if file.name.lower().endswith(".csv"):  # the others say their own
            fps = self._panel.designs.read_rate()
            self._panel.designs.show_rate()
        task = OpenFile(file.name, file.content, robot, fps)
        self._opened_job = self._submit(self._opening, task)

    def save(self, design: Design) -> None:
        """Send a design, with the scenario that the panel has."""
        scenario, _ = self._panel.simulation.read(design.scenario)
        content = dump_design(replace(design, scenario=scenario)).encode()
        self._client.send_file_download(file_name(design), content, save_immediately=True)

    def export(self, plan: Plan | None, rollout: Rollout | None) -> None:
        """Have what is chosen of the motion that is shown written, and send it."""
        choice, complaints = self._panel.export.read()
        if complaints:
            self._panel.notify("Corrected", "; ".join(complaints))
        shown = plan if rollout is None or choice.of == PLAN else rollout
        if shown is None:
            self._panel.notify("Nothing to export", "There is no plan yet.")
            return
        for name in choice.formats:
            extra = FORMATS[name].extra
            if extra is not None and extra.missing:
                self._panel.notify(
                    "Not exported",
                    f'format "{name}" needs packages that are not installed; expected pip install '
                    f'"llsrbm[{extra.name}]"',
                )
                return
        self._saved = ", ".join(choice.formats)
        task = ExportMotion(shown, choice.formats, choice.zipped, choice.options)
        self._saved_job = self._submit(self._saving, task)
        self._panel.show_exporting(f"Exporting {self._saved} ...")

    def cancel(self) -> None:
        """Give up what is being saved."""
        self._pool.cancel(self._saving)

    def hear(self, report: Report) -> OpenedFile | None:
        """Take what the pool reports; a file that was opened and is still wanted, or None."""
        if report.job == self._opened_job:
            return self._hear_of_opening(report)
        if report.job == self._saved_job:
            self._hear_of_saving(report)
        return None

    def _hear_of_opening(self, report: Report) -> OpenedFile | None:
        if isinstance(report, Progress):
            # That it is being opened goes without saying: it takes a tenth of a second.
            if self._note is None and not report.text.startswith("opening"):
                self._note = self._client.add_notification(
                    "Opening", report.text, loading=True, with_close_button=False
                )
            return None
        self._opened_job = 0
        if self._note is not None:
            self._note.remove()
            self._note = None
        if isinstance(report, Opened):
            return report.file
        if isinstance(report, Failed):
            self._panel.notify("Not opened", report.message)
            self._panel.designs.tell(f"Not opened: {report.message}")
        return None

    def _hear_of_saving(self, report: Report) -> None:
        if isinstance(report, Progress):
            waits = f" ({report.text})" if report.text.startswith("waiting") else ""
            self._panel.show_exporting(f"Exporting {self._saved}{waits} ...")
            return
        self._saved_job = 0
        self._panel.show_exporting(None)
        match report:
            case Exported(name=name, content=content):
                self._client.send_file_download(name, content, save_immediately=True)
            case Failed(message=message):
                self._panel.notify("Not exported", message)
            case Cancelled():
                self._panel.notify("Not exported", f"Stopped: {self._saved}")

    def _submit(self, lane: tuple[int, str], task: OpenFile | ExportMotion) -> int:
        return self._pool.submit(lane, task, lambda report: self._listener(FileReport(report)))


def forget_files(pool: WorkerPool, tab: int) -> None:
    """Give up what a tab opens and saves: it has gone. From any thread."""
    for lane in _lanes(tab):
        pool.forget(lane)


def _lanes(tab: int) -> tuple[tuple[int, str], tuple[int, str]]:
    """The pool's names for a tab that opens, and for one that saves."""
    return (tab, "opens"), (tab, "saves")
