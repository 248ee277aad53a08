"""An overlay's nodes in the world, as a page draws them."""

import io

import trimesh
from scipy.spatial.transform import Rotation

from app.picture.scene import Scene
from tests.app.picture.recorded import RecordedClient, track_of


class DrawnOverlay:
    """Attributes: clip; nodes: the overlay's own that move."""

    def __init__(self, picture, root):
        self.client = RecordedClient()
        self.clip = Scene(self.client).draw(picture)
        seen = self.client.scene.seen()
        self.nodes = sorted(
            {
                name
                for strand in self.clip.channels
                for track in strand.tracks
                for name in track.nodes
                if name.startswith(f"{root}/") and name in seen
            }
        )

    def size(self, node):
        """(F, 3) factors."""
        return track_of(self.clip, node)[1].scale

    def vertices(self, node, frame):
        """(V, 3) m of a node's mesh, world frame."""
        _, track = track_of(self.clip, node)
        points = self.mesh(node).vertices
        points = points * (1.0 if track.scale is None else track.scale[frame])
        if track.wxyz is not None:
            points = Rotation.from_quat(track.wxyz[frame], scalar_first=True).apply(points)
        return points + track.position[frame]

    def mesh(self, node):
        content = self.client.scene.nodes[node].glb_data
        return trimesh.load(io.BytesIO(content), file_type="glb", force="mesh")
