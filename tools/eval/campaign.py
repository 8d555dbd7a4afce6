"""Many homes, each mapped once and asked many questions; spread over processes, and resumed where it stopped."""

import json
import random
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, fields
from hashlib import sha256
from multiprocessing import get_context
from pathlib import Path

from edge.missions.map_home import HomeMapped
from firmware_sim.home import load_home
from models.manifest import DEFAULT, Manifest, resolve
from tools.eval.child import in_child
from tools.eval.episode import Episode, ask
from tools.eval.tour import Tour, map_home, nouns


@dataclass(frozen=True, slots=True)
class Plan:
    """What is asked in each home."""

    methods: tuple[str, ...] = ("vlpg-nav",)
    encoder: str = DEFAULT  # a model's name, or "oracle"
    objects: int | None = None  # so many of those that the tour had in view, drawn by lot; None: all of the home
    disturbances: tuple[str, ...] = ()  # each question is asked as it is, and once with each of these
    truths: tuple[str, ...] = ()  # VLPG-Nav is asked once more with each of these parts replaced by the truth
    search: bool = False  # VLPG-Nav looks even for what does not seem to be in its memory
    seed: int = 0  # of every source of noise


@dataclass(frozen=True, slots=True)
class HomeResult:
    """All episodes in one home."""

    home: str
    mapped: HomeMapped
    memory: int  # bytes of the VLPG in RAM: vectors, poses, spare room
    dense: int  # bytes of a VLMaps grid of the same home
    episodes: list[Episode]


VLMAPS_CELL = 512 * 4  # bytes: a float32 vector of 512 in every cell of 0.05 m (Huang et al. 2023)


def run_home(home: str, plan: Plan) -> HomeResult:
    """Map one home; each question of each method then starts from the end of that tour."""
    import cv2

    cv2.setNumThreads(1)  # a fork does not carry OpenCV's threads along
    tour = map_home(home, plan.encoder, plan.seed)
    asked = chosen(tour, plan)
    episodes = [
        in_child(ask, tour, method, noun, disturbance, plan.search, plan.seed)
        for noun in asked
        for disturbance in ("", *plan.disturbances)
        for method in plan.methods
    ]
    for truth in plan.truths:
        told = map_home(home, plan.encoder, plan.seed, truth)
        episodes += [in_child(ask, told, "vlpg-nav", noun, "", plan.search, plan.seed) for noun in asked]
    grid = tour.robot.grid
    return HomeResult(
        home=tour.world.house.name,
        mapped=tour.mapped,
        memory=tour.robot.memory.nbytes,
        dense=int((~grid.unknown).sum()) * VLMAPS_CELL,  # cells that anything is known of, not the box around them
        episodes=[episode for episode in episodes if episode is not None],
    )


def chosen(tour: Tour, plan: Plan) -> list[str]:
    """The names to ask for; the same for every encoder and method as long as the tour saw the same."""
    everything = nouns(tour.world.house)
    if plan.objects is None:
        return everything
    seen = [noun for noun in everything if noun in tour.in_view]
    return sorted(random.Random(tour.world.house.name).sample(seen, min(plan.objects, len(seen))))


def run_homes(
    homes: list[str], plan: Plan, jobs: int, folder: Path | None = None, cluster: str | None = None
) -> Iterator[HomeResult]:
    """Results as they come, from ``jobs`` processes or from the Ray ``cluster`` at that address.

    With a ``folder`` each is kept there, and what is there already is not run again.
    """
    todo = []
    for home in homes:
        file = folder and folder / _file(home, plan)
        if file and file.exists():
            yield load(file)
        else:
            todo.append((home, file))
    for result, file in _on_ray(todo, plan, cluster) if cluster else _here(todo, plan, jobs):
        if file:
            save(result, file)
        yield result


def _here(todo, plan: Plan, jobs: int):
    # Fresh processes rather than forks: each home forks its own children, and should start with one thread.
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        files = {pool.submit(run_home, home, plan): file for home, file in todo}
        try:
            for future in as_completed(files):
                yield future.result(), files[future]
        except BaseException:  # Ctrl-C, or a home that failed: the others, not begun yet, need not be waited for
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _on_ray(todo, plan: Plan, address: str):
    import ray  # late: an extra of its own

    ray.init(address=address, log_to_driver=False)
    # Ray's workers have threads, and a fork would copy their locks: each home gets a process of its own there.
    task = ray.remote(num_cpus=1)(lambda home: next(_here([(home, None)], plan, 1))[0])
    files = {task.remote(home): file for home, file in todo}
    while files:
        (done, *_), _ = ray.wait(list(files))
        yield ray.get(done), files.pop(done)


def save(result: HomeResult, file: Path) -> None:
    """Written whole or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_suffix(".part")
    partial.write_text(json.dumps(asdict(result), indent=1))
    partial.rename(file)


def load(file: Path) -> HomeResult:
    """What ``save`` wrote."""
    return _result(json.loads(file.read_text()))


def write(results: list[HomeResult], file: Path) -> None:
    """All results in one file."""
    file.write_text(json.dumps([asdict(result) for result in results], indent=1))


def read(file: Path) -> list[HomeResult]:
    """What ``write`` wrote. Raises OSError, or ValueError when the file holds something else."""
    try:
        return [_result(raw) for raw in json.loads(file.read_text())]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{file} does not hold the episodes of an evaluation ({error})") from None


def _result(raw: dict) -> HomeResult:
    raw["mapped"], raw["episodes"] = HomeMapped(**raw["mapped"]), [Episode(**e) for e in raw["episodes"]]
    return HomeResult(**raw)


def _file(home: str, plan: Plan) -> str:
    """A name that tells plans, encoders and states of a home apart, so that one folder serves several.

    Raises HouseError when there is no such home.
    """
    manifest = None if plan.encoder == "oracle" else Manifest.load(resolve(plan.encoder))
    encoder = manifest and (manifest.digest, manifest.confidence)
    asked = plan, encoder, load_home(home).to_dict(), [field.name for field in fields(Episode)]
    code = sha256(repr(asked).encode()).hexdigest()[:8]
    return f"{Path(home).stem.replace(':', '-')}.{Path(plan.encoder).name}.{code}.json"
