"""Shards of a sweep on a Dask cluster: sent with their files, and back as they are finished."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
import tempfile
import tomllib
from asyncio import CancelledError
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import ClusterError, ResonanceError
from ..experiments.experiment import Experiment
from ..experiments.validation import validated
from ..plan.inputs import Input, folder_name, gather
from ..results.run import versions
from ..text import cut, listed
from . import dataset
from .dataset import Outcome
from .shards import simulated

if TYPE_CHECKING:
    from distributed import Client, Future

WAIT = 15
"""How long a scheduler, and the first worker, are waited for [s]."""

AHEAD = 4
"""Shards that are given to the cluster for each thread of it."""

Shard = Sequence[Experiment]


class File(NamedTuple):
    """A file that experiments name, or one that such a file refers to."""

    path: str
    """Where it was sent from."""
    content: bytes


class Cluster:
    """Workers that simulate shards, as `connected` finds them."""

    def __init__(self, client: Client, address: str) -> None:
        self._client, self._address = client, address
        self._packer = _Packer(client)

    @property
    def threads(self) -> int:
        """How many shards its workers simulate at a time."""
        return _threads(self._client)

    def spread(
        self, shards: Mapping[str, Shard], *, predict: bool = False
    ) -> Iterator[tuple[str, list[Outcome]]]:
        """What comes of shards, as they are finished, each with its name.

        Args:
            shards: by their names, which say all that they depend on.
            predict: as of `simulated`.

        Raises:
            ClusterError: the cluster is lost, or a worker failed.
        """
        from distributed import as_completed
        from distributed.client import FutureCancelledError

        client, waiting = self._client, iter(shards.items())

        def submitted(most: int) -> list[Future]:
            how = {"predict": predict}
            return [
                client.submit(work, *self._packer.packed(shard), versions(), **how, key=name)
                for name, shard in islice(waiting, most)
            ]

        try:
            done = as_completed(submitted(AHEAD * _threads(client)), loop=client.loop)
            for future in done:
                yield future.key, _outcomes(future)
                done.update(submitted(1))
        except (OSError, TimeoutError, CancelledError, FutureCancelledError) as error:
            raise ClusterError(
                f"--dask {self._address}: the scheduler was lost, {type(error).__name__}; finished "
                "shards are kept, and the same command goes on"
            ) from None


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """A Dask cluster as long as it is used.

    Args:
        address: of a scheduler, or local:N for N workers of this machine.

    Raises:
        ClusterError: it cannot be reached, or has workers of another version.
    """
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise ClusterError("--dask needs Dask: pip install 'resonance-mj[sweep]'") from None
    with _client(address) as client:
        _same_versions(client)
        yield Cluster(client, address)


def spread(
    shards: Mapping[str, Shard], address: str, *, predict: bool
) -> Iterator[tuple[str, list[Outcome]]]:
    """`Cluster.spread` on a cluster of its own; arguments as there and of `connected`."""
    with connected(address) as cluster:
        yield from cluster.spread(shards, predict=predict)


def work(
    texts: list[str], files: dict[str, File], wanted: dict[str, str], *, predict: bool
) -> bytes:
    """What a worker makes of a shard.

    Args:
        texts: the experiments, with names in `files` as their paths.
        files: their files, by names.
        wanted: versions that the worker must have.
        predict: as of `simulated`.

    Returns:
        The outcomes as a shard's file.
    """
    if versions() != wanted:
        raise ClusterError(f"a worker has other versions: {_differences(wanted, versions())}")
    with tempfile.TemporaryDirectory(prefix="resonance-mj-") as folder:
        for name, file in files.items():
            path = Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(file.content)
        experiments = []
        for text in texts:
            values = tomllib.loads(text)
            named = values.pop("files")
            one = validated(Experiment, values, "an experiment of the sweep")
            experiments.append(
                one.replace({key: str(Path(folder, name)) for key, name in named.items()})
            )
        made = dataset.written(simulated(experiments, threads=1, predict=predict))
    for name, file in files.items():  # what is said of a file names the one that was sent
        here = json.dumps(str(Path(folder, name)))[1:-1]
        made = made.replace(here.encode(), json.dumps(file.path)[1:-1].encode())
    return made


class _Packer:
    """Makes parcels of shards: files that several name are read and sent once."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._inputs: dict[tuple[object, ...], tuple[Input, ...]] = {}
        self._sent: dict[tuple[str, ...], Future] = {}

    def packed(self, shard: Shard) -> tuple[list[str], Future | dict[str, File]]:
        """Experiments as texts that name files by what they are called in the parcel; and these."""
        texts: list[str] = []
        files: dict[str, Path] = {}
        for experiment in shard:
            inputs = self._gathered(experiment)
            within = folder_name(inputs)
            names = [f"{within}/{PurePosixPath(one.name)}" for one in inputs]
            files |= {name: one.path for name, one in zip(names, inputs, strict=True)}
            keys = {one.key: name for name, one in zip(names, inputs, strict=True) if one.key}
            lines = (f"{json.dumps(key)} = {json.dumps(name)}\n" for key, name in keys.items())
            texts.append(f"{experiment.to_toml()}\n[files]\n{''.join(lines)}")
        key = tuple(files)
        if files and key not in self._sent:
            read = {name: File(str(path), path.read_bytes()) for name, path in files.items()}
            self._sent[key] = self._client.scatter(read, broadcast=True)
        return texts, self._sent.get(key, {})

    def _gathered(self, experiment: Experiment) -> tuple[Input, ...]:
        robot, law = experiment.robot, experiment.law.kind
        key = robot.mjcf, robot.packages, law, *(motion.file for motion in experiment.motion)
        if key not in self._inputs:
            try:
                self._inputs[key] = gather(experiment)
            except (ResonanceError, OSError):  # said of the run, where it is simulated
                self._inputs[key] = ()
        return self._inputs[key]


def _outcomes(future: Future) -> list[Outcome]:
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    try:
        return dataset.parsed(future.result())
    except KilledWorker as error:
        raise ClusterError(
            f"a shard ended {error.allowed_failures + 1} workers that tried it: is there memory "
            "for it? finished shards are kept, and the same command goes on"
        ) from None
    except (ResonanceError, OSError, TimeoutError, FutureCancelledError):
        raise
    except Exception as error:
        raise ClusterError(f"a worker failed: {type(error).__name__}: {error}") from None


@contextmanager
def _client(address: str) -> Iterator[Client]:
    """A client of a scheduler, or of one on this machine with workers of its own."""
    from distributed import Client, LocalCluster

    with ExitStack() as stack:
        stack.enter_context(_silent())
        place, _, count = address.partition(":")
        if place == "local":
            if not (count.isdecimal() and 0 < int(count) <= 1024):
                raise ClusterError(
                    f"--dask {cut(address, 80)}: local:N with N from 1 to 1024 is valid"
                )
            scheduler = stack.enter_context(
                LocalCluster(
                    n_workers=0, processes=True, dashboard_address="127.0.0.1:0", silence_logs=50
                )
            )
            url = scheduler.scheduler_address
            for _ in range(int(count)):
                stack.callback(end_worker, begin_worker(url))
        else:
            url = address
        try:
            client = stack.enter_context(Client(url, timeout=WAIT, set_as_default=False))
            client.wait_for_workers(int(count) if place == "local" else 1, timeout=4 * WAIT)
        except (OSError, TimeoutError, ValueError) as error:
            raise ClusterError(
                f"--dask {cut(address, 80)}: no scheduler with workers answers there: "
                f"{cut(str(error) or type(error).__name__, 200)}; the address is like tcp://host:8786"
            ) from None
        yield client


@contextmanager
def _silent() -> Iterator[None]:
    """Keep Dask's own words from the screen: what goes wrong is said in one line."""
    every = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    before = {name: logging.getLogger(name).level for name in ("distributed", *every)}
    for name in before:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def begin_worker(url: str) -> subprocess.Popen[bytes]:
    """A worker of one thread, which ends with its scheduler, or with its process."""
    command = [sys.executable, "-P", "-m", "distributed.cli.dask_worker", url, "--nthreads", "1"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    folder = ["--local-directory", tempfile.gettempdir(), "--death-timeout", str(WAIT)]
    return subprocess.Popen([*command, *folder, "--no-dashboard"], **quiet)  # type: ignore[call-overload]


def end_worker(process: subprocess.Popen[bytes]) -> None:
    """End a worker, and wait for it."""
    process.terminate()
    try:
        process.wait(WAIT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _threads(client: Client) -> int:
    return (
        sum(one["nthreads"] for one in client.scheduler_info(n_workers=-1)["workers"].values()) or 1
    )


def _same_versions(client: Client) -> None:
    """Refuse workers of other versions than this process's."""
    wanted = versions()
    try:
        found: dict[str, Any] = client.run(versions)
    except Exception as error:
        raise ClusterError(
            f"the workers cannot run resonance-mj: {type(error).__name__}: {cut(str(error), 200)}"
        ) from None
    for name, has in found.items():
        if has != wanted:
            raise ClusterError(f"worker {name} has other versions: {_differences(wanted, has)}")


def _differences(wanted: Mapping[str, str], has: Mapping[str, str]) -> str:
    names = [name for name in wanted if wanted[name] != has.get(name)]
    return listed([f"{name} {has.get(name, 'none')} in place of {wanted[name]}" for name in names])
