"""Light and floor, by day and by night."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from app.motion.clip import AnimationChannel
from app.motion.colours import Rgb
from app.picture.drawing import Drawing
from app.picture.picture import Picture
from llsrbm.arrays import Array


@dataclass(frozen=True)
class Look:
    """Colours and strengths of one time of the day."""

    sky: Rgb  # sky, ground: colours of the light from above and from below
    ground: Rgb
    sky_light: float  # its strength
    key: Rgb  # key, key_light: colour and strength of the lamp that gives the robot its shape
    key_light: float
    fill_light: float  # strength of the lamp that lightens the other side
    floor: Rgb  # colour of the tiles
    joints: Rgb  # joints, tiles: colours of the lines of 0.1 m and of 0.5 m
    tiles: Rgb
    lines: Rgb  # colour of the lines where there are no tiles
    backdrop: Rgb  # about what is behind the floor
    shadow: float  # how dark a shadow is, 0 to 1


# The backdrop behind both is in static/camera.js; the floor fades into it.
DAY = Look(
    sky=(255, 255, 255),
    ground=(214, 208, 200),
    sky_light=3.1,
    key=(255, 247, 236),
    key_light=3.2,
    fill_light=1.5,
    floor=(188, 198, 208),
    joints=(172, 183, 195),
    tiles=(128, 143, 160),
    lines=(118, 135, 153),
    backdrop=(179, 193, 206),
    shadow=0.34,
)
NIGHT = Look(
    sky=(176, 196, 232),
    ground=(104, 106, 122),
    sky_light=2.6,
    key=(255, 240, 220),
    key_light=3.0,
    fill_light=1.8,
    floor=(58, 70, 86),
    joints=(72, 85, 102),
    tiles=(112, 126, 145),
    lines=(108, 122, 141),
    backdrop=(51, 65, 82),
    shadow=0.6,
)

_KEY, _FILL = (1.6, -2.4, 4.2), (-3.0, 2.0, 2.0)  # m; directions in which the lamps are
_FADE = 9.0  # m from the camera at which the floor ends
_TILE = 0.5  # m
_TILES = 6  # on either side of the start, where there is no graphics processor
_PIECES = 4  # of a line, each with colours of its own


def configure_world(server: viser.ViserServer) -> None:
    """Put out viser's own light for all tabs.

    A browser without a graphics processor takes 4 s to start and a quarter of the frame rate with
    an environment map and shadows; three lamps do.
    """
    server.scene.configure_environment_map(None)
    server.scene.configure_default_lights(enabled=False)
    # A narrow view: a wide one draws what is near too large. The page's script frames the robot
    # as soon as there is one.
    server.initial_camera.fov = 0.66  # rad
    server.initial_camera.position = (1.7, -2.6, 1.35)
    server.initial_camera.look_at = (0.05, 0.0, 0.4)


class Lighting(Drawing):
    """Lamps and floor of a tab; with a graphics processor the main lamp casts shadows.

    Without one a floor of filled tiles, which is shaded everywhere, takes a third of the time of
    every frame, and a third lamp a tenth: there the floor is its lines alone, on the backdrop.
    """

    parts = frozenset({"planned", "night", "fine"})
    needs_motion = False

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._sky = scene.add_light_hemisphere(
            "/lamps/sky", sky_color=DAY.sky, ground_color=DAY.ground, intensity=DAY.sky_light
        )
        self._key = scene.add_light_directional(
            "/lamps/key", color=DAY.key, position=_KEY, intensity=DAY.key_light
        )
        self._fill = scene.add_light_directional(
            "/lamps/fill", position=_FILL, intensity=DAY.fill_light
        )
        self._floor = scene.add_grid(
            "/ground",
            infinite_grid=True,
            cell_size=0.1,
            cell_color=DAY.joints,
            cell_thickness=0.6,
            section_size=0.5,
            section_color=DAY.tiles,
            fade_distance=_FADE,
            fade_strength=1.4,
            plane_color=DAY.floor,
            plane_opacity=1.0,
            shadow_opacity=0.0,
            visible=False,
        )
        self._points, self._nearness = _tiles()
        self._lines = scene.add_line_segments(
            "/floor", self._points, self._faded(DAY), thickness=1.2, thickness_units="screen"
        )

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        look = NIGHT if picture.night else DAY
        self._sky.sky_color, self._sky.ground_color = look.sky, look.ground
        self._sky.intensity = look.sky_light
        self._key.color, self._key.intensity = look.key, look.key_light
        self._key.cast_shadow = picture.fine
        self._fill.intensity = look.fill_light
        self._fill.visible = self._floor.visible = picture.fine
        self._lines.visible = not picture.fine
        self._lines.colors = self._faded(look)
        self._lines.position = (0.0, 0.0, picture.ground)
        self._floor.plane_color = look.floor
        self._floor.cell_color, self._floor.section_color = look.joints, look.tiles
        self._floor.shadow_opacity = look.shadow if picture.fine else 0.0
        self._floor.position = (0.0, 0.0, picture.ground)
        return ()

    def show(self, *, visible: bool) -> None:
        """Light and floor stay."""

    def _faded(self, look: Look) -> NDArray[np.uint8]:
        """Colours of the lines' ends: farther away, more like the backdrop."""
        near, far = np.array(look.lines), np.array(look.backdrop)
        mixed = far + self._nearness[..., None] * (near - far)
        # viser takes the colours of lines' ends for proportional to light.
        return np.round(255 * (mixed / 255) ** 2.2).astype(np.uint8)


def _tiles() -> tuple[Array, Array]:
    """Lines between tiles in pieces: their ends (N, 2, 3) m, and how near these are, 1 to 0."""
    across = np.arange(-_TILES, _TILES + 1) * _TILE
    along = np.linspace(-_TILES * _TILE, _TILES * _TILE, _PIECES + 1)
    place, start = (side.ravel() for side in np.meshgrid(across, along[:-1]))
    end = start + along[1] - along[0]
    flat = np.zeros_like(place)
    one = np.stack([np.stack([start, place, flat], 1), np.stack([end, place, flat], 1)], axis=1)
    points = np.concatenate([one, one[..., [1, 0, 2]]])
    share = np.linalg.norm(points, axis=2) / (_TILES * _TILE)
    return points, np.clip(1.0 - share**2, 0.0, 1.0)
