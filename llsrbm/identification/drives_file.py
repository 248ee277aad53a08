"""Identified drives as the table [drives] of a robot file."""

from pathlib import Path

from llsrbm.errors import InputError
from llsrbm.files.atomic import staged
from llsrbm.identification.fit import NAMES, Identified


def drives_table(found: Identified) -> str:
    """TOML, with standard errors and the log's name in comments."""
    lines = [
        f"# By `llsrbm identify` from {found.log.name}, for a robot file's [drives];",
        "# numbers of joints go before those of their limbs.",
        "# kg m2, Nm, Nm s/rad (kg, N, N s/m of joints that slide), s; +- standard errors.",
        *(f"# Not in the log: {name}, {why}." for name, why in found.undetermined.items()),
        "[drives]",
        f"delay = {max(found.delay, 0.0):.6f}  # +- {found.delay_error:.6f}",
        "",
        "[drives.known]",
        *(f'{name} = "measured"' for name in (*NAMES, "delay")),
        "",
        "[drives.joints]",
    ]
    for joint, drive in found.joints.items():
        numbers = ", ".join(f"{name} = {getattr(drive, name):.6g}" for name in NAMES)
        errors = ", ".join(f"{getattr(drive, f'{name}_error'):.2g}" for name in NAMES)
        lines.append(f"{joint} = {{ {numbers} }}  # +- {errors}")
    return "\n".join(lines) + "\n"


def check_place(path: Path) -> None:
    """Raise `InputError` unless a file of that name can be written as a new one."""
    if path.suffix != ".toml" or not path.parent.is_dir():
        raise InputError(f"--out {path}: expected a name that ends in .toml, in a folder that is")
    if path.exists():
        raise InputError(f"--out {path}: there is such a file; expected a new one")


def write_drives(found: Identified, path: Path) -> None:
    """Write the table as a new file. Raises `InputError`: there is one, or it cannot be written."""
    check_place(path)
    with staged(path) as draft:
        draft.write_text(drives_table(found), encoding="utf-8")
