"""A process that draws pictures with MuJoCo's renderer, without a screen.

    python -m llsrbm.formats.pictures.process FILM

A process of its own, because how MuJoCo reaches OpenGL is settled when it is first imported, and an
OpenGL driver that crashes takes its process along. Pictures go to stdout, one after the other.
`llsrbm.formats.pictures.video` starts it and says what a film is.
"""

import pickle
import sys
from pathlib import Path

NO_OPENGL = 3  # exit status


def main(path: str) -> int:
    """Draw a film; the exit status is `NO_OPENGL` where there is none."""
    try:
        drawn_by = _drawn_by()
    # Whatever a driver or its absence leads to: PyOpenGL's errors, attributes of None.
    except Exception as error:  # noqa: BLE001
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return NO_OPENGL
    from llsrbm.formats.pictures.rendering import draw_film

    film = pickle.loads(Path(path).read_bytes())  # noqa: S301  our parent process wrote it
    draw_film(film, drawn_by, sys.stdout.buffer.write)
    sys.stdout.buffer.flush()
    return 0


def _drawn_by() -> str:
    """Name of what OpenGL draws with; importing MuJoCo fails where its OpenGL is not."""
    import mujoco

    context = mujoco.GLContext(8, 8)
    context.make_current()
    from OpenGL import GL  # once MuJoCo has chosen the platform

    name = bytes(GL.glGetString(GL.GL_RENDERER)).decode(errors="replace")
    context.free()
    return name


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
