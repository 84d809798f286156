"""Frames become a file, one after the other, by the ffmpeg of imageio-ffmpeg."""

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple

from ...errors import OutputError, PictureError
from ...files import replacing


class Format(NamedTuple):
    """How ffmpeg is asked to encode."""

    codec: str
    pixels: str
    options: tuple[str, ...]


PALETTE = "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=bayer"
FORMATS = {
    ".mp4": Format(
        "libx264",
        "yuv420p",
        ("-preset", "veryfast", "-crf", "20", "-movflags", "+faststart"),
    ),
    ".gif": Format("gif", "pal8", ("-filter_complex", PALETTE, "-loop", "0")),
    ".webp": Format(
        "libwebp_anim", "bgra", ("-quality", "75", "-compression_level", "2", "-loop", "0")
    ),
}


def check(path: Path, transparent: bool) -> None:
    """See that a video can be written under this name.

    Raises:
        PictureError: the name ends in no known format, or in one that cannot be transparent.
    """
    if path.suffix.lower() not in FORMATS:
        raise PictureError(
            f"{path}: unknown format {path.suffix!r}; the name must end in {', '.join(FORMATS)}"
        )
    if transparent and path.suffix.lower() != ".webp":
        raise PictureError(f"{path}: only .webp can be transparent")


@contextmanager
def encoder(
    path: Path, size: tuple[int, int], fps: float, channels: int
) -> Iterator[Callable[[memoryview], object]]:
    """A function that takes the next frame's pixels; the file is there when the block succeeds.

    Args:
        path: name of the video; its ending is the format.
        size: width and height [pixels].
        fps: frames per second.
        channels: 3 for RGB, 4 for RGBA.

    Raises:
        OutputError: the file cannot be written.
    """
    import imageio_ffmpeg

    suffix, sent = path.suffix.lower(), 0
    codec, pixels, options = FORMATS[suffix]
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, f"video{suffix}")
        writer = imageio_ffmpeg.write_frames(
            str(made),
            size,
            fps=fps,
            codec=codec,
            pix_fmt_in="rgb24" if channels == 3 else "rgba",
            pix_fmt_out=pixels,
            quality=None,
            macro_block_size=1,
            ffmpeg_log_level="quiet",
            output_params=list(options),
        )

        def encode(frame: memoryview) -> None:
            nonlocal sent
            try:
                writer.send(frame)
            except OSError:
                raise _unfinished(path, made, sent) from None
            sent += 1

        with closing(writer):
            writer.send(None)
            yield encode
        # imageio-ffmpeg does not tell how ffmpeg ended: what it has made tells.
        there = _frames(made)
        if not there or (there != sent and suffix != ".webp"):
            raise _unfinished(path, made, sent)
        with replacing(path) as beside:
            shutil.copyfile(made, beside)


def still(path: Path, frame: int) -> bytes:
    """A frame of a video as a JPEG file's bytes: what stands for the video before it plays.

    Args:
        path: the video.
        frame: its number, from 0.
    """
    import imageio.v3 as iio

    picture = iio.imread(path, index=frame, plugin="FFMPEG")
    return iio.imwrite("<bytes>", picture, extension=".jpg", quality=90)


def _frames(video: Path) -> int:
    """How many frames a video has, of .webp how many different ones in a row; 0 of no video."""
    import imageio.v3 as iio
    import imageio_ffmpeg

    try:
        if video.suffix == ".mp4":
            return imageio_ffmpeg.count_frames_and_secs(str(video))[0]
        return sum(1 for _ in iio.imiter(video, plugin="pillow"))
    except (OSError, RuntimeError):
        return 0


def _unfinished(path: Path, made: Path, sent: int) -> OutputError:
    return OutputError(
        f"{path}: cannot be written: ffmpeg stopped after {sent} frames in the temporary folder "
        f"{made.parent.parent}: make room there, or set TMPDIR to another folder"
    )
