"""Frames become a file, one after the other, by the ffmpeg that comes with imageio-ffmpeg."""

import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...errors import OutputError, PictureError
from ...files import replacing

H264 = (
    *("-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-pix_fmt", "yuv420p"),
    *("-movflags", "+faststart"),
)
GIF = (
    "-filter_complex",
    "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=bayer",
    *("-loop", "0"),
)
WEBP = ("-c:v", "libwebp_anim", "-quality", "75", "-compression_level", "2", "-loop", "0")
FORMATS = {".mp4": H264, ".gif": GIF, ".webp": WEBP}


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

    # A process of our own: imageio's writer drops what ffmpeg says and the status it ends with, so
    # that a disk that is full near the end would be a success.
    command = [
        *(imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-y"),
        *("-f", "rawvideo", "-pix_fmt", "rgb24" if channels == 3 else "rgba"),
        *("-s", f"{size[0]}x{size[1]}", "-r", f"{fps:g}", "-i", "pipe:0"),
        *FORMATS[path.suffix.lower()],
    ]
    with replacing(path) as beside, tempfile.TemporaryFile() as errors:
        # A session of its own: an interrupt reaches this process, which then stops ffmpeg.
        process = subprocess.Popen(
            [*command, str(beside)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,
        )
        assert process.stdin is not None
        try:
            yield process.stdin.write
            process.stdin.close()
            status = process.wait()
        except BrokenPipeError:
            status = process.wait()
        finally:
            process.kill()
            process.wait()
            with suppress(BrokenPipeError):
                process.stdin.close()
        if status:
            errors.seek(0)
            said = errors.read().decode(errors="replace").strip().splitlines()
            reason = said[0].rpartition("] ")[2] if said else f"ffmpeg ended with status {status}"
            raise OutputError(f"{path}: cannot be written: {reason}")


def still(path: Path, seconds: float) -> bytes:
    """A frame of a video as a JPEG file's bytes: what stands for the video before it plays.

    Args:
        path: the video.
        seconds: which of its frames: the one that is shown at this time.

    Raises:
        PictureError: there is no frame at this time.
    """
    import imageio_ffmpeg

    command = [
        *(imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error"),
        *("-ss", f"{seconds:.3f}", "-i", str(path), "-frames:v", "1"),
        *("-f", "image2pipe", "-c:v", "mjpeg", "-q:v", "4", "pipe:1"),
    ]
    picture = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True).stdout
    if not picture:
        raise PictureError(f"{path}: has no frame at {seconds:g} s")
    return picture
