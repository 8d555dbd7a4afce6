"""``python -m tools.bench.peer KIND …``: the same image tower as somebody else would run it, as a probe.

Each with the defaults that its users meet, but one thread.
"""

import sys
from collections.abc import Callable

from tools.models.probe import serve


def onnx(graph: str, height: int, width: int) -> Callable[[int], object]:
    """An ONNX graph with ONNX Runtime's own settings."""
    import numpy as np
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"])
    picture = np.random.default_rng(0).normal(size=(1, 3, height, width)).astype(np.float32)
    return lambda _: session.run(None, {"image": picture})


def torch(height: int, width: int) -> Callable[[int], object]:
    """PyTorch, eager, in inference mode. Random weights: speed and memory do not depend on them."""
    import torch
    from efficientnet_lite_pytorch import EfficientNet

    from tools.train.image_tower import Head, ImageTower, Neck, Trunk

    torch.set_num_threads(1)
    torch.manual_seed(0)
    regions = ((0.0, 1.0), (0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0))
    head = Head(torch.nn.Linear(1280, 1000), torch.randn(1000, 384), 0.5)
    tower = ImageTower(Trunk(EfficientNet.from_name("efficientnet-lite0")), Neck(), head, regions).eval()
    picture = torch.randn(1, 3, height, width)

    def run(_):
        with torch.inference_mode():
            return tower(picture)

    return run


def main() -> None:
    kind, *arguments = sys.argv[1:]
    if kind == "onnx":
        serve(onnx(arguments[0], *map(int, arguments[1:])))
    else:
        serve(torch(*map(int, arguments)))


if __name__ == "__main__":
    main()
