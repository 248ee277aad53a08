"""The formats that there are; adding one is one module and one line here."""

from __future__ import annotations

from llsrbm.errors import InputError
from llsrbm.formats.base import Format
from llsrbm.formats.csv_table import CSV
from llsrbm.formats.design_file import DESIGN
from llsrbm.formats.gif import GIF
from llsrbm.formats.gmr_pkl import GMR_PKL
from llsrbm.formats.html_replay import HTML
from llsrbm.formats.mcap_log import MCAP
from llsrbm.formats.mimickit_pkl import MIMICKIT_PKL
from llsrbm.formats.motion_imitation_json import MOTION_IMITATION_JSON
from llsrbm.formats.motion_npz import MOTION_NPZ
from llsrbm.formats.mp4 import MP4
from llsrbm.formats.mujoco_folder import MUJOCO
from llsrbm.formats.npz import NPZ
from llsrbm.formats.rerun_log import RRD
from llsrbm.formats.unitree_csv import UNITREE_CSV

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
    if name not in FORMATS:
        raise InputError(f'no format "{name}"; the formats are {", ".join(FORMATS)}')
    return FORMATS[name]
