"""Do the same thing many times, here or on an executor, and say how far it is.

Any `concurrent.futures.Executor` will do: a pool of threads or processes, or that of
a Dask cluster, ``client.get_executor()``.  Results come in the order of the jobs.
"""

from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")
Progress = bool | Callable[[int, int], object]  # of what is done, and of all


def in_order(
    function: Callable[[Job], Result],
    jobs: Sequence[Job],
    executor: Executor | None = None,
) -> Generator[Result]:
    """Yield function(job) for each job, in order; the first failure ends it all."""
    if executor is None:
        yield from map(function, jobs)
        return
    if not hasattr(executor, "submit"):
        raise ValueError(
            "executor must be a concurrent.futures.Executor, such as a "
            f"ProcessPoolExecutor or a Dask client's get_executor(), got {executor!r}"
        )
    try:
        yield from executor.map(function, jobs)
    except BrokenExecutor as error:
        raise BrokenExecutor(
            "a worker died and took its pool along, so nothing was counted. Start a "
            "new pool (with fewer workers, if memory ran out) and call again: the "
            "result will be the same. A Dask cluster replaces workers that die."
        ) from error


@contextmanager
def reporting(
    progress: Progress, total: int, unit: str
) -> Iterator[Callable[[int], object]]:
    """Yield report(done), which tells `progress` how many of `total` are done.

    `progress` is False for nobody, True for a bar of tqdm's, or a function of
    (done, total).
    """
    if progress is False or progress is None:
        yield lambda done: None
    elif callable(progress):
        yield lambda done: progress(done, total)
    elif progress is not True:
        raise ValueError(
            f"progress must be True, False or a function, got {progress!r}"
        )
    else:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            raise ImportError(
                "progress=True draws its bar with tqdm, which is not installed: "
                "pip install 'luenberger[cluster]', or give a function of (done, total)"
            ) from None
        with tqdm(total=total, unit=unit) as bar:
            yield lambda done: bar.update(done - bar.n)
