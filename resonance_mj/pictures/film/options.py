"""How a video looks: size, camera, background and what is drawn into it."""

from dataclasses import dataclass

from ...errors import PictureError

LEAST = 100
"""Columns of a run's part [pixels]."""
GAP = 4
"""Columns between runs side by side [pixels]."""
FASTEST = 720.0
"""Speed of a camera that goes around the arm [degrees/s]."""
BACKGROUNDS = ("sky", "white", "dark", "transparent")


@dataclass(frozen=True)
class RenderOptions:
    """How a video looks.

    Attributes:
        size: width and height of the picture [pixels].
        camera: a camera's name in the model, "azimuth,elevation,distance" [degrees, degrees, m],
            or None for one that frames the motion.
        follow: whether the camera goes with the tool.
        orbit: how fast the camera goes around the arm [degrees per second of the run].
        background: one of `BACKGROUNDS`.
        path: draw the desired path.
        trail: draw where the tool was in the last half cycle.
        springs: draw the joints' springs and equilibria.
        motors: draw the motors' torque.
        plots: draw torque² and stiffness below the scene.
        head_up: write time, cycle, reduction and tracking error above it.
        legend: say at its foot what the overlays mean.

    Raises:
        PictureError: a value is not valid.
    """

    size: tuple[int, int] = (1280, 720)
    camera: str | None = None
    follow: bool = False
    orbit: float = 0.0
    background: str = "sky"
    path: bool = True
    trail: bool = True
    springs: bool = True
    motors: bool = True
    plots: bool = True
    head_up: bool = True
    legend: bool = True

    def __post_init__(self) -> None:
        if self.background not in BACKGROUNDS:
            raise PictureError(
                f"background {self.background!r} is unknown; there are {', '.join(BACKGROUNDS)}"
            )
        if not all(160 <= pixels <= 8192 for pixels in self.size):
            raise PictureError(
                f"size {self.size[0]}x{self.size[1]}: width and height must be between 160 and 8192"
            )
        _ = self.view  # which says what is wrong with it
        if self.follow and self.camera is not None and self.view is None:
            raise PictureError(f"camera {self.camera!r} of the model cannot follow the tool")
        if not abs(self.orbit) <= FASTEST:
            raise PictureError(f"orbit {self.orbit:g}: give -{FASTEST:g} to {FASTEST:g} degrees/s")
        if self.orbit and self.camera is not None and self.view is None:
            raise PictureError(f"camera {self.camera!r} of the model cannot go around the arm")

    @property
    def channels(self) -> int:
        """Of a picture: 3 for RGB, 4 with alpha."""
        return 4 if self.background == "transparent" else 3

    @property
    def ink(self) -> str:
        """Colour of text and lines."""
        return "#F2F2F2" if self.background == "dark" else "#1A1A1A"

    @property
    def paper(self) -> str:
        """Colour behind the plots."""
        return "#16181C" if self.background == "dark" else "#FFFFFF"

    @property
    def view(self) -> tuple[float, float, float] | None:
        """Azimuth and elevation [degrees] and distance [m] of a free camera."""
        try:
            azimuth, elevation, distance = map(float, (self.camera or "").split(","))
        except ValueError:
            return None
        if not (max(abs(azimuth), abs(elevation)) <= 360 and 1e-3 <= distance <= 1e6):
            raise PictureError(
                f"camera {self.camera}: angles must be between -360 and 360 degrees, and the "
                "distance between 0.001 and 1e6 m"
            )
        return azimuth, elevation, distance

    @property
    def plots_height(self) -> int:
        """Rows of the picture that the plots take."""
        return round(0.27 * self.size[1]) // 2 * 2 if self.plots else 0

    def columns(self, runs: int) -> list[tuple[int, int]]:
        """First and last column, exclusive, of each run's part; there is a gap between them."""
        width = self.size[0] + GAP
        if width // runs - GAP < LEAST:
            raise PictureError(
                f"{runs} runs side by side in a picture {self.size[0]} pixels wide have only "
                f"{max(width // runs - GAP, 0)} columns each: {LEAST} are needed"
            )
        return [(i * width // runs, (i + 1) * width // runs - GAP) for i in range(runs)]
