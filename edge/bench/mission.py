"""``python -m edge.bench.mission RECORDING MODEL board|host FOLDER``: the robot's missions in a process of their own.

All that the robot process has is there: towers, a store in FOLDER, a Zenoh session, and a node on it that nobody asks.
Only the base is a recording. With ``host`` there is no text tower: what the prompts mean was answered by a host before.
"""

import sys
from pathlib import Path

import cv2

from edge.bench import vlmaps
from edge.bench.recording import Recording, RecordingError
from edge.bench.replay import Replay
from edge.bench.report import STEP
from edge.bench.stopwatch import Stopwatch
from edge.bench.subject import begin, tell
from edge.link.offload import OffloadedEncoder
from edge.link.session import LinkConfig, open_session
from edge.localization.localizer import Localizer
from edge.mapping.coverage import CameraCoverage
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.prompts import PromptMemory
from edge.memory.store import Vlpg
from edge.missions import motion
from edge.missions.find_object import FindObject
from edge.missions.map_home import MapHome
from edge.node import Missions, Node
from edge.perception.encoder import Encoder
from edge.perception.text import TextTower
from edge.planning.local_search import LocalSearch
from edge.planning.mpepc import Mpepc
from edge.process import give_back_what_loading_took
from edge.robot import Robot
from models.manifest import Manifest, resolve

STAGES = (
    (Localizer, "update", "localize"),
    (OccupancyGrid, "integrate_scan", "map a scan"),
    (OccupancyGrid, "integrate_depth", "map a depth image"),
    (CameraCoverage, "integrate", "map what was looked at"),
    (Encoder, "encode_image", "encode a picture"),
    (Encoder, "saliency", "Grad-CAM"),
    (OffloadedEncoder, "encode_text", "encode two prompts"),
    (Vlpg, "add", "offer a view to the memory"),
    (FindObject, "recall", "recall and rank viewpoints"),
    (motion, "plan", "plan a way"),
    (Mpepc, "step", "control"),
    (LocalSearch, "next_pose", "choose a view nearby"),
)


def answered(recording: Recording, encoder: Encoder, path: Path) -> Path:
    """A file that remembers what the recorded prompts mean, as one whose host was asked for them once."""

    def look_up(prompts):
        try:
            return [recording.prompts[prompt] for prompt in prompts]
        except KeyError as error:
            raise RecordingError(f"the recording does not say what {error} means; make a new one") from None

    memory = PromptMemory(look_up, encoder.digest, encoder.dim, path)
    memory.encode(list(recording.prompts))
    memory.close()
    return path


def main() -> None:
    file, model, text, folder = sys.argv[1:]
    begin()
    cv2.setNumThreads(1)
    recording, manifest = Recording(Path(file)), Manifest.load(resolve(model))
    images, watch = Encoder(manifest, text=False), Stopwatch()
    with (
        Vlpg.open(Path(folder) / "home.vlpg", images.name, images.digest, images.dim) as memory,
        open_session(LinkConfig(listen=("tcp/127.0.0.1:0",), multicast_scouting=False)) as session,
    ):
        if text == "host":
            prompts = answered(recording, images, Path(folder) / "prompts.db")
            encoder = OffloadedEncoder(session, images, "host", TextTower(manifest), prompts)
        else:
            encoder = OffloadedEncoder(session, images, "never", TextTower(manifest))
        for stage in STAGES:
            watch.watch(*stage)
        node = Node(session, Robot(encoder, memory), Missions(MapHome, FindObject), mapped=True)
        replay = Replay(recording, node.robot)
        watch.watch(replay, "step", STEP)
        give_back_what_loading_took()
        for _ in replay.run():
            pass
        sizes = {
            "memory of the home": memory.nbytes,
            "a VLMaps grid of it instead": vlmaps.nbytes(replay.robot.grid),
            "a thousand such nodes, with pictures and scans, disk": 1000 * memory.disk / len(memory),
        }
        tell(watch.read(), {name: size / 1e6 for name, size in sizes.items()})


if __name__ == "__main__":
    main()
