"""The formats that there are; adding one is one module and one line here."""

from __future__ import annotations

from llsrbm.formats.base import Format
from llsrbm.formats.design_file import DESIGN
from llsrbm.formats.logs.mcap_log import MCAP
from llsrbm.formats.logs.rerun_log import RRD
from llsrbm.formats.mujoco.folder import MUJOCO
from llsrbm.formats.pictures.gif import GIF
from llsrbm.formats.pictures.html_replay import HTML
from llsrbm.formats.pictures.mp4 import MP4
from llsrbm.formats.references.gmr_pkl import GMR_PKL
from llsrbm.formats.references.mimickit_pkl import MIMICKIT_PKL
from llsrbm.formats.references.motion_imitation_json import MOTION_IMITATION_JSON
from llsrbm.formats.references.motion_npz import MOTION_NPZ
from llsrbm.formats.references.unitree_csv import UNITREE_CSV
from llsrbm.formats.tables.csv_table import CSV
from llsrbm.formats.tables.npz import NPZ
from llsrbm.request.messages import look_up

# In the order in which they are listed and offered.
FORMATS: dict[str, Format] = {
    format_.name: format_
    for format_ in (
        NPZ,
        CSV,
        UNITREE_CSV,
        MOTION_NPZ,
        MIMICKIT_PKL,
        GMR_PKL,
        MOTION_IMITATION_JSON,
        MUJOCO,
        MCAP,
        RRD,
        HTML,
        MP4,
        GIF,
        DESIGN,
    )
}


def find(name: str) -> Format:
    """The format of that name.

    Raises:
        InputError: there is none.
    """
    return look_up("format", name, FORMATS)
